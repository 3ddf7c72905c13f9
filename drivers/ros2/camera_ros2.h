// SPDX-License-Identifier: BSD-2-Clause
// A camera whose driver publishes on a ROS 2 topic.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/common/device_life.h"
#include "drivers/common/increasing_stamps.h"
#include "drivers/common/mjpeg_decoder.h"
#include "drivers/ros2/image_to_grey.h"
#include "drivers/ros2/ros2_node.h"
#include "platform/port/camera_source.h"

namespace facet {

struct CameraRos2Options {
    std::string topic;      ///< as ROS 2 names it; see Ros2Node::image_reader()
    int width = 0;          ///< that every image must have (px)
    int height = 0;         ///< (px)
    Duration latency;       ///< from the exposure's midpoint to the stamp of the header; subtracted from the stamps
    Ros2CameraModel model;  ///< the calibration's, to be compared with camera_info; no size: not compared
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without an image for this long the topic is subscribed to again; zero: never
};

struct CameraRos2Counters {
    std::uint64_t damaged = 0;         ///< JPEGs that cannot be decoded to the end
    std::uint64_t misfits = 0;         ///< images of another size or encoding, or with too few bytes
    std::uint64_t no_slot = 0;         ///< good images dropped because the caller held all slots
    std::uint64_t stamps_refused = 0;  ///< good images dropped for their stamps
};

/// Delivers the images of a topic in the order in which they came, as grey in a slot of its own. The stamp is that of
/// the header, less the latency. The first camera_info of the image's namespace is compared with the calibration: of
/// topics with `rect` in their name by the projection P of the rectified image, else by K; what differs stands in
/// warning(). Thread-bound. Heap in the constructor, in start(), in the middleware and for problem texts.
class CameraRos2 final : public CameraSource, private Reopenable {
public:
    /// As of a camera on V4L2: four that wait in a synchroniser, one being processed, one arriving.
    static constexpr std::size_t kSlots = 6;

    /// Borrowed: node and clock, which must outlive the camera.
    CameraRos2(Ros2Node& node, const Clock& clock, CameraRos2Options options);

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, CameraFrame& frame) override;
    ClockDomain clock() const override { return ClockDomain::kRealtime; }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }
    /// That camera_info contradicts the calibration.
    std::string_view warning() const override { return warning_; }
    const CameraRos2Counters& camera_counters() const { return camera_counters_; }

private:
    Status open(std::string& problem) override;
    void close() override;
    Status take(Duration timeout, CameraFrame& frame);
    Status deliver(const Ros2Image& image, CameraFrame& frame);
    Status decode(const Ros2Image& image, std::span<std::uint8_t> out);
    void compare_model();

    CameraRos2Options options_;
    const Clock& clock_;
    std::unique_ptr<Ros2Reader<Ros2Image>> reader_;
    std::unique_ptr<Ros2Reader<Ros2CameraModel>> info_reader_;
    std::unique_ptr<MjpegDecoder> jpeg_;  ///< once a JPEG has come
    std::size_t image_bytes_ = 0;
    std::unique_ptr<std::uint8_t[]> pixels_;  ///< kSlots images
    SlotLender<kSlots> slots_;
    SourceCounters counters_;
    CameraRos2Counters camera_counters_;
    DeviceLife life_;
    IncreasingStamps order_;
    std::uint64_t lost_before_ = 0;  ///< by readers that were closed
    std::uint32_t received_ = 0;
    bool is_compared_ = false;
    ImageFault fault_{};
    std::string warning_;
};

/// What differs between the calibration and a camera_info by more than 2 %, of the width in the case of the centre;
/// empty if nothing does. Reentrant. Heap.
std::string model_difference(const Ros2CameraModel& calibration, const Ros2CameraModel& info);

}  // namespace facet
