// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/camera_ros2.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include "drivers/common/stamp_fault.h"

namespace facet {

std::string model_difference(const Ros2CameraModel& calibration, const Ros2CameraModel& info) {
    constexpr double kTolerance = 0.02;
    if (info.width == calibration.width && info.height == calibration.height) {
        const double width = calibration.width;
        const bool agrees = std::abs(info.fx - calibration.fx) <= kTolerance * calibration.fx &&
                            std::abs(info.fy - calibration.fy) <= kTolerance * calibration.fy &&
                            std::abs(info.cx - calibration.cx) <= kTolerance * width &&
                            std::abs(info.cy - calibration.cy) <= kTolerance * width;
        if (agrees) {
            return {};
        }
    }
    std::array<char, 240> text{};
    std::snprintf(text.data(), text.size(),
                  "camera_info has %ux%u, fx %.4g fy %.4g cx %.4g cy %.4g; the calibration %ux%u, fx %.4g fy %.4g "
                  "cx %.4g cy %.4g",
                  info.width, info.height, info.fx, info.fy, info.cx, info.cy, calibration.width, calibration.height,
                  calibration.fx, calibration.fy, calibration.cx, calibration.cy);
    return text.data();
}

CameraRos2::CameraRos2(Ros2Node& node, const Clock& clock, CameraRos2Options options)
    : options_(std::move(options)),
      clock_(clock),
      reader_(node.image_reader(options_.topic)),
      info_reader_(
          node.camera_info_reader(camera_info_topic(options_.topic), options_.topic.find("rect") != std::string::npos)),
      life_(*this, clock, options_.retry_period, counters_, options_.silence),
      order_(ClockDomain::kRealtime) {
    if (options_.width > 0 && options_.height > 0) {
        image_bytes_ = static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height);
        pixels_ = std::make_unique<std::uint8_t[]>(image_bytes_ * kSlots);
    }
}

Status CameraRos2::open(std::string& problem) {
    if (image_bytes_ == 0) {
        problem = options_.topic + ": width and height must be given";
        return Status::kInvalidArgument;
    }
    FACET_TRY(reader_->open(problem));
    return options_.model.width == 0 || is_compared_ ? Status::kOk : info_reader_->open(problem);
}

void CameraRos2::close() {
    lost_before_ += reader_->lost();
    reader_->close();
    info_reader_->close();
}

SourceCounters CameraRos2::counters() const {
    SourceCounters result = counters_;
    result.lost = lost_before_ + reader_->lost();
    return result;
}

/// The first one counts: a driver repeats it with every image.
void CameraRos2::compare_model() {
    Ros2CameraModel info;
    if (is_compared_ || !ok(info_reader_->take({}, info))) {
        return;
    }
    is_compared_ = true;
    info_reader_->close();
    if (const std::string difference = model_difference(options_.model, info); !difference.empty()) {
        warning_ = options_.topic + ": " + difference;
    }
}

Status CameraRos2::decode(const Ros2Image& image, std::span<std::uint8_t> out) {
    Status status = Status::kOk;
    if (!image.is_compressed) {
        status = to_grey(image, options_.width, options_.height, out, fault_);
        camera_counters_.misfits += ok(status) ? 0 : 1;
    } else {
        if (!jpeg_) {
            jpeg_ = std::make_unique<MjpegDecoder>(options_.width, options_.height);
        }
        status = jpeg_->decode(image.data, out);
        camera_counters_.damaged += ok(status) ? 0 : 1;
        if (!ok(status)) {
            std::snprintf(fault_.data(), fault_.size(), "compressed images are no JPEGs of %dx%d: %.90s",
                          options_.width, options_.height, jpeg_->problem());
        }
    }
    if (!ok(status)) {
        ++counters_.corrupt;
        life_.refuse(fault_.data());
    }
    return status;
}

Status CameraRos2::deliver(const Ros2Image& image, CameraFrame& frame) {
    const std::uint32_t sequence = received_++;
    const Timestamp stamp = image.stamp - options_.latency;
    const char* const fault = delivery_fault({image.stamp, stamp}, clock_, clock(), order_, counters_.discarded);
    if (fault != nullptr) {
        ++camera_counters_.stamps_refused;
        life_.refuse(fault);
        return Status::kNotReady;
    }
    SlotLease slot = slots_.take();
    if (!slot.held()) {
        ++counters_.discarded;
        ++camera_counters_.no_slot;
        life_.works();  // the camera is not to blame
        return Status::kNotReady;
    }
    std::uint8_t* const out = pixels_.get() + static_cast<std::size_t>(slot.slot()) * image_bytes_;
    FACET_TRY(decode(image, {out, image_bytes_}));
    order_.delivered(stamp);
    frame.stamp = stamp;
    frame.sequence = sequence;
    frame.image = {out, options_.width, options_.height, options_.width};
    frame.slot = std::move(slot);
    frame.exposure = {};
    return Status::kOk;
}

Status CameraRos2::take(Duration timeout, CameraFrame& frame) {
    compare_model();
    Ros2Image image;
    const Status status = reader_->take(timeout, image);
    if (status == Status::kIo) {
        return life_.fail(options_.topic + ": the middleware fails");
    }
    return ok(status) ? deliver(image, frame) : status;
}

Status CameraRos2::next(Duration timeout, CameraFrame& frame) {
    return life_.next(options_.topic, [&] { return take(timeout, frame); });
}

}  // namespace facet
