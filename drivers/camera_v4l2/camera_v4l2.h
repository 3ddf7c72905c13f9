// SPDX-License-Identifier: BSD-2-Clause
// A camera on a V4L2 node.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/camera_v4l2/auto_exposure.h"
#include "drivers/camera_v4l2/v4l2_capture.h"
#include "drivers/camera_v4l2/v4l2_controls.h"
#include "drivers/common/device_life.h"
#include "drivers/common/increasing_stamps.h"
#include "drivers/common/mjpeg_decoder.h"
#include "platform/port/camera_source.h"

namespace facet {

/// The instant that a camera's buffer stamps refer to.
enum class StampSource : std::uint8_t {
    kAsFlagged,        ///< as the buffer's flags say (drivers default to end of frame)
    kStartOfExposure,  ///< whatever the flags say
    kEndOfFrame,       ///< whatever the flags say
    kMidExposure,      ///< the stamps are exposure midpoints already, as in a replayed log
};

struct CameraControl {
    std::string name;  ///< as v4l2-ctl lists it
    std::int64_t value = 0;
};

struct CameraV4l2Options {
    V4l2CaptureOptions capture;
    int significant_bits = 0;             ///< of Y16; see RawImage
    bool msb_aligned = false;             ///< of Y10, Y12 and Y16; see RawImage
    std::vector<CameraControl> controls;  ///< set before streaming starts, in this order
    std::string controls_device;          ///< the node that has them, such as /dev/v4l-subdev2; empty: the capture node
    Duration exposure;                    ///< as set in the camera; zero if unknown
    Duration readout;                     ///< from the end of exposure to the stamp; for end-of-frame stamps
    StampSource stamp_source = StampSource::kAsFlagged;
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without an image for this long the node is reopened; zero: never
};

/// Counters beyond those of every source.
struct CameraV4l2Counters {
    std::uint64_t error_buffers = 0;  ///< buffers that the driver marked as bad
    std::uint64_t short_buffers = 0;  ///< buffers with fewer bytes than an image
    std::uint64_t damaged = 0;        ///< JPEGs that cannot be decoded to the end
    std::uint64_t superseded = 0;     ///< good frames dropped because a newer one was ready
    std::uint64_t no_slot = 0;        ///< good frames dropped because the caller held all slots
    std::uint64_t stamps_refused =
        0;  ///< good frames dropped for their stamps: of the future, of long ago, not increasing
    std::uint64_t not_monotonic = 0;  ///< buffers whose stamp is flagged as of another clock; used if it can be true
    std::uint64_t exposures_set = 0;  ///< by automatic exposure
    std::uint64_t exposures_refused = 0;
};

/// Latest-frame source: each next() dequeues all buffers that are ready, delivers the newest good one, unpacked to 8
/// bits into a slot of its own, and returns every buffer to the driver at once, so that a slow consumer never stalls
/// capture. Exposure midpoint: start + exposure / 2, or end of frame - readout - exposure / 2. A node that disappears
/// or fails is reopened once every retry period with all its settings. With a SharedExposure, the two controls are set
/// whenever it decides, and each frame has the exposure time that was in force. Thread-bound. Heap in the constructor,
/// in start() and for problem texts.
class CameraV4l2 final : public CameraSource, private Reopenable {
public:
    /// Images in use: four that wait in a synchroniser, one being processed, one arriving. More than a synchroniser
    /// holds, so that it drops its oldest before the camera has to drop its newest.
    static constexpr std::size_t kSlots = 6;

    /// Borrowed: io, clock (monotonic) and the shared exposure, which must outlive the camera.
    /// @param automatic  nullptr: exposure and gain stay as they are
    /// @param camera     of the rig
    CameraV4l2(KernelIo& io, const Clock& clock, CameraV4l2Options options, SharedExposure* automatic = nullptr,
               std::size_t camera = 0);

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, CameraFrame& frame) override;
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return life_.problem(); }
    /// Controls that the camera does not have, and which it has; buffers that are slow to read.
    std::string_view warning() const override { return warning_; }
    const CameraV4l2Counters& camera_counters() const { return camera_counters_; }

private:
    Status open(std::string& problem) override;
    Status set_controls(std::string& problem);
    void close() override {
        controls_.close();
        capture_.close();
    }
    Status take(Duration timeout, CameraFrame& frame);
    Status take_all(Duration timeout, V4l2Buffer& newest);
    bool is_good(const V4l2Buffer& buffer);
    void follow_sequence(std::uint32_t sequence);
    void judge_copy(Duration took, std::size_t bytes);
    Timestamp midpoint(const V4l2Buffer& buffer, Duration exposure) const;
    Status prepare_exposure(std::string& problem);
    void note_exposure(const ExposureSetting& setting, std::uint32_t first_sequence);
    bool set_exposure(const ExposureSetting& setting, std::uint32_t first_sequence);
    void follow_exposure(const V4l2Buffer& buffer, const ImageView& image);
    Status to_grey(const V4l2Buffer& buffer, std::uint8_t* out);
    Status deliver(const V4l2Buffer& buffer, CameraFrame& frame);

    CameraV4l2Options options_;
    const Clock& clock_;
    V4l2Capture capture_;
    V4l2Controls controls_;
    V4l2Control exposure_control_;  ///< of automatic exposure
    V4l2Control gain_control_;
    std::string warning_;
    std::unique_ptr<MjpegDecoder> jpeg_;  ///< while images are JPEGs
    std::size_t image_bytes_ = 0;
    std::unique_ptr<std::uint8_t[]> pixels_;  ///< kSlots images
    SlotLender<kSlots> slots_;
    SourceCounters counters_;
    CameraV4l2Counters camera_counters_;
    DeviceLife life_;
    IncreasingStamps order_;
    std::uint32_t sequence_ = 0;
    bool any_sequence_ = false;
    SharedExposure* automatic_;
    std::size_t camera_;
    int copies_ = 0;  ///< of images, since the node was opened
    Duration fastest_copy_;
    ExposureSetting set_;  ///< by automatic exposure
    ExposureHistory exposures_;
};

}  // namespace facet
