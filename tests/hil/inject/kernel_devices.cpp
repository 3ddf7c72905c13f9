// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/kernel_devices.h"

#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/videodev2.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace facet::hil {
namespace {

Descriptor open_file(const std::string& path, int flags) { return {::open(path.c_str(), flags | O_CLOEXEC), path}; }

}  // namespace

Descriptor::Descriptor(int fd, std::string name) : fd_(fd), name_(std::move(name)) { check(fd, "cannot be opened"); }

Descriptor::Descriptor(Descriptor&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), name_(std::move(other.name_)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    std::swap(name_, other.name_);
    return *this;
}

Descriptor::~Descriptor() {
    if (fd_ >= 0) {
        ::close(fd_);
    }
}

int Descriptor::check(int result, const char* what) const {
    if (result < 0) {
        throw std::system_error(errno, std::generic_category(), name_ + ": " + what);
    }
    return result;
}

VideoOutput::VideoOutput(const std::string& device, int width, int height, PixelFormat pixels)
    : fd_(open_file(device, O_RDWR)) {
    struct stat status {};
    fd_.check(::fstat(fd_.get(), &status), "cannot be examined");
    device_number_ = status.st_rdev;
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = static_cast<std::uint32_t>(width);
    format.fmt.pix.height = static_cast<std::uint32_t>(height);
    format.fmt.pix.pixelformat = fourcc(pixels);
    format.fmt.pix.field = V4L2_FIELD_NONE;
    fd_.check(::ioctl(fd_.get(), VIDIOC_S_FMT, &format), "format refused");
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.memory = V4L2_MEMORY_MMAP;
    fd_.check(::ioctl(fd_.get(), VIDIOC_REQBUFS, &request), "gives no buffers");
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    fd_.check(::ioctl(fd_.get(), VIDIOC_STREAMON, &type), "does not stream");
    for (std::uint32_t i = 0; i < kBuffers; ++i) {
        v4l2_buffer buffer{};
        buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
        buffer.memory = V4L2_MEMORY_MMAP;
        buffer.index = i;
        fd_.check(::ioctl(fd_.get(), VIDIOC_QUERYBUF, &buffer), "does not describe its buffers");
        void* const memory = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_.get(),
                                    static_cast<off_t>(buffer.m.offset));
        fd_.check(memory == MAP_FAILED ? -1 : 0, "cannot be mapped");
        buffers_[i] = {static_cast<std::uint8_t*>(memory), buffer.length};
    }
}

VideoOutput::~VideoOutput() {
    for (const std::span<std::uint8_t> buffer : buffers_) {
        ::munmap(buffer.data(), buffer.size());
    }
}

void VideoOutput::send(const OutgoingFrame& frame) {
    // Round robin: the device would offer the buffer that was sent last, which may still be read.
    const std::span<std::uint8_t> memory = buffers_[next_];
    const std::size_t size = std::min(frame.bytes.size(), memory.size());
    std::copy_n(frame.bytes.begin(), size, memory.begin());
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = next_;
    buffer.bytesused = static_cast<std::uint32_t>(size);
    buffer.field = V4L2_FIELD_NONE;
    buffer.sequence = frame.sequence;
    buffer.flags = frame.error ? V4L2_BUF_FLAG_ERROR : 0U;
    buffer.timestamp.tv_sec = frame.stamp.ns / 1'000'000'000;
    buffer.timestamp.tv_usec = frame.stamp.ns % 1'000'000'000 / 1000;
    fd_.check(::ioctl(fd_.get(), VIDIOC_QBUF, &buffer), "does not take a frame");
    next_ = (next_ + 1) % kBuffers;
}

void VideoOutput::set_connected(bool connected) {
    const std::string name = fd_.name().substr(fd_.name().rfind('/') + 1);
    const Descriptor file = open_file("/sys/class/video4linux/" + name + "/connected", O_WRONLY);
    file.check(static_cast<int>(::write(file.get(), connected ? "1" : "0", 1)), "cannot be written");
}

void VideoOutput::unplug() {
    fd_.check(::unlink(fd_.name().c_str()), "node cannot be removed");
    set_connected(false);
}

void VideoOutput::plug() {
    set_connected(true);
    fd_.check(::mknod(fd_.name().c_str(), S_IFCHR | 0600, static_cast<dev_t>(device_number_)), "node cannot be made");
}

std::optional<ExposureControls> VideoOutput::controls() const {
    ExposureControls controls;
    v4l2_control exposure{V4L2_CID_EXPOSURE, 0};
    v4l2_control gain{V4L2_CID_ANALOGUE_GAIN, 0};
    if (::ioctl(fd_.get(), VIDIOC_G_CTRL, &exposure) < 0 || ::ioctl(fd_.get(), VIDIOC_G_CTRL, &gain) < 0) {
        fd_.check(errno == ENODEV ? 0 : -1, "does not tell its controls");
        return std::nullopt;
    }
    controls.exposure = exposure.value;
    controls.gain = gain.value;
    return controls;
}

PulseLine::PulseLine(const std::string& pull) : fd_(open_file(pull, O_WRONLY)) {}

void PulseLine::pulse() {
    for (const char* const state : {"pull-up", "pull-down"}) {
        fd_.check(static_cast<int>(::pwrite(fd_.get(), state, std::strlen(state), 0)), "cannot be pulled");
    }
}

SpiImuModel::SpiImuModel() : fd_(open_file("/dev/facet-imu", O_RDWR)) {}

void SpiImuModel::write_at(std::int64_t offset, std::span<const std::uint8_t> bytes) {
    const ssize_t written = ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    // A full FIFO loses the sample, as the chip's does.
    if (written < 0 && errno != ENOSPC) {
        fd_.check(-1, "cannot be written");
    }
}

bool SpiImuModel::makes_edges() const {
    std::uint8_t edges = 0;
    fd_.check(::pread(fd_.get(), &edges, 1, 0x3000) == 1 ? 0 : -1, "cannot be read");
    return edges != 0;
}

IioImuModel::IioImuModel() : fd_(open_file("/dev/facet-iio", O_WRONLY)) {}

void IioImuModel::measure(const std::array<std::int32_t, 6>& counts) {
    fd_.check(static_cast<int>(::write(fd_.get(), counts.data(), sizeof counts)), "cannot be written");
}

void IioImuModel::write_driver(const std::string& attribute) {
    const Descriptor file = open_file("/sys/bus/platform/drivers/facet-iio/" + attribute, O_WRONLY);
    constexpr std::string_view kDevice = "facet-iio";
    file.check(static_cast<int>(::write(file.get(), kDevice.data(), kDevice.size())), "cannot be written");
}

CanNode::CanNode(const std::string& interface)
    : interface_(interface), fd_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW), interface) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
    fd_.check(address.can_ifindex == 0 ? -1 : 0, "is not there");
    fd_.check(::bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), "cannot be bound");
}

void CanNode::send(const CanFrame& frame) {
    can_frame raw{};
    raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U);
    raw.len = frame.length;
    std::copy_n(frame.bytes.begin(), std::min<std::size_t>(frame.length, sizeof raw.data), raw.data);
    // A bus that is down takes nothing: the frame is lost.
    if (::write(fd_.get(), &raw, sizeof raw) < 0 && errno != ENETDOWN && errno != ENXIO) {
        fd_.check(-1, "does not send");
    }
}

void CanNode::send_error(std::uint32_t error_class) {
    can_frame raw{};
    raw.can_id = CAN_ERR_FLAG | error_class;
    raw.len = CAN_ERR_DLC;
    fd_.check(static_cast<int>(::write(fd_.get(), &raw, sizeof raw)), "does not send an error frame");
}

void CanNode::set_up(bool up) {
    ifreq request{};
    interface_.copy(request.ifr_name, sizeof request.ifr_name - 1);
    fd_.check(::ioctl(fd_.get(), SIOCGIFFLAGS, &request), "has no flags");
    const int flags = up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP;
    request.ifr_flags = static_cast<short>(flags);
    fd_.check(::ioctl(fd_.get(), SIOCSIFFLAGS, &request), "cannot be switched");
}

}  // namespace facet::hil
