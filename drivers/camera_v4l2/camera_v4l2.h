// SPDX-License-Identifier: BSD-2-Clause
// A camera on a V4L2 node.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/camera_v4l2/v4l2_capture.h"
#include "drivers/common/outage.h"
#include "drivers/common/retry_gate.h"
#include "platform/port/camera_source.h"

namespace facet {

/// What the buffer stamps of a camera are of.
enum class StampSource : std::uint8_t {
    kAsFlagged,        ///< what the buffer's flags say (the default of drivers is end of frame)
    kStartOfExposure,  ///< the flags are known to be wrong
    kEndOfFrame,
    kMidExposure,  ///< the stamps are right already, as of a replayed log
};

struct CameraControl {
    std::string name;  ///< as v4l2-ctl lists it
    std::int64_t value = 0;
};

struct CameraV4l2Options {
    V4l2CaptureOptions capture;
    int significant_bits = 0;  ///< of Y16; see RawImage
    std::vector<CameraControl> controls;
    Duration exposure;  ///< as set; for the midpoint. Zero if unknown
    Duration readout;   ///< first to last row, and on to the stamp; for end-of-frame stamps
    StampSource stamp_source = StampSource::kAsFlagged;
    Duration retry_period = Duration::from_seconds(0.5);
};

/// Counters beyond those of every source.
struct CameraV4l2Counters {
    std::uint64_t error_buffers = 0;  ///< buffers that the driver marked as bad
    std::uint64_t short_buffers = 0;  ///< buffers with fewer bytes than an image
    std::uint64_t superseded = 0;     ///< good frames dropped because a newer one was there already
    std::uint64_t no_slot = 0;        ///< good frames dropped because the caller held all slots
    std::uint64_t not_monotonic = 0;  ///< buffers whose stamp is not of the monotonic clock: used as they are
};

/// Latest-frame source: each next() takes all buffers that are ready, gives the newest good one, unpacked to 8 bits
/// into a slot of its own, and returns every buffer to the driver at once, so that capture never stalls on a slow
/// consumer. Exposure midpoint: start + exposure / 2, or end of frame - readout - exposure / 2. A node that vanishes or
/// fails is reopened every retry period with all its settings. Thread-bound. Heap in the constructor, in start() and
/// for problem texts.
class CameraV4l2 final : public CameraSource {
public:
    /// Images under way: four that wait in a synchroniser, one in work, one arriving. More than a synchroniser holds,
    /// so that it drops its oldest before the camera has to drop its newest.
    static constexpr std::size_t kSlots = 6;

    /// Borrowed: io and clock (monotonic), which must outlive the camera.
    CameraV4l2(KernelIo& io, const Clock& clock, CameraV4l2Options options);

    Status start() override;
    void stop() override;
    Status next(Duration timeout, CameraFrame& frame) override;
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return outage_.problem; }
    const CameraV4l2Counters& camera_counters() const { return camera_counters_; }

private:
    Status open();
    Status fail(std::string problem);
    Status take_all(Duration timeout, V4l2Buffer& newest);
    bool is_good(const V4l2Buffer& buffer);
    void follow_sequence(std::uint32_t sequence);
    Timestamp midpoint(const V4l2Buffer& buffer) const;
    Status deliver(const V4l2Buffer& buffer, CameraFrame& frame);

    const Clock& clock_;
    CameraV4l2Options options_;
    V4l2Capture capture_;
    RetryGate retry_;
    std::size_t image_bytes_ = 0;
    std::unique_ptr<std::uint8_t[]> pixels_;  ///< kSlots images
    SlotLender<kSlots> slots_;
    SourceCounters counters_;
    CameraV4l2Counters camera_counters_;
    Outage outage_;
    std::uint32_t sequence_ = 0;
    bool any_sequence_ = false;
    Timestamp last_stamp_;
    bool any_delivered_ = false;
    bool started_ = false;
};

}  // namespace facet
