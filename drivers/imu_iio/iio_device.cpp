// SPDX-License-Identifier: BSD-2-Clause
// What a running device does; how it is set up is in iio_setup.cpp and iio_elements.cpp.
#include "drivers/imu_iio/iio_device.h"

#include <cerrno>

namespace facet {

void IioDevice::close() {
    if (is_running_) {
        (void)write_attribute(io_, folder_ / "buffer/enable", "0");
        is_running_ = false;
    }
    if (fd_ >= 0) {
        (void)io_.close(fd_);
        fd_ = -1;
    }
    filled_ = at_ = 0;
}

/// Reads as many scans as there are and fit.
Status IioDevice::fill() {
    at_ = filled_ = 0;
    const std::int64_t size = io_.read(fd_, bytes_.data(), kReadBytes / scan_bytes_ * scan_bytes_);
    if (size == -EAGAIN) {
        return Status::kNotReady;
    }
    if (size <= 0) {
        error_ = size == 0 ? ENODATA : static_cast<int>(-size);
        return Status::kIo;
    }
    // The kernel gives whole scans; the rest of one is of no use to anybody.
    const auto taken = static_cast<std::size_t>(size);
    filled_ = taken - taken % scan_bytes_;
    return filled_ == taken ? Status::kOk : Status::kCorrupt;
}

double IioDevice::value_of(Slot slot, std::size_t axis) const {
    const Channel& channel = channels_[slot + axis];
    const auto bytes = std::span(bytes_).subspan(at_ + channel.element.offset, channel.element.type.bytes());
    const auto raw = static_cast<double>(read_scan_value(bytes, channel.element.type));
    return (raw + channel.offset) * channel.scale;
}

Eigen::Vector3d IioDevice::vector_of(Slot slot, const Eigen::Matrix3d& mount) const {
    return mount * Eigen::Vector3d(value_of(slot, 0), value_of(slot, 1), value_of(slot, 2));
}

Status IioDevice::read(IioScan& scan) {
    if (at_ >= filled_) {
        FACET_TRY(fill());
    }
    scan = {};
    if (const Channel& stamp = channels_[kStamp]; stamp.is_enabled) {
        const auto bytes = std::span(bytes_).subspan(at_ + stamp.element.offset, stamp.element.type.bytes());
        scan.stamp_ns = read_scan_value(bytes, stamp.element.type);
    }
    if (quantities_.rate) {
        scan.rate = vector_of(kRate, rate_mount_);
    }
    if (quantities_.force) {
        scan.force = vector_of(kForce, force_mount_);
    }
    if (channels_[kTemperature].is_enabled) {
        constexpr double kMilli = 1e-3;
        scan.temperature_c = value_of(kTemperature, 0) * kMilli;
    }
    at_ += scan_bytes_;
    return Status::kOk;
}

}  // namespace facet
