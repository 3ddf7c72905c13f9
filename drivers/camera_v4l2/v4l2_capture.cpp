// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/v4l2_capture.h"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "drivers/camera_v4l2/media_graph.h"

namespace facet {
namespace {

/// The less a driver has to send for 8 bits of grey, the better; JPEG last, for its losses.
constexpr std::array kBestFirst{PixelFormat::kGrey, PixelFormat::kY8i, PixelFormat::kNv12, PixelFormat::kYuyv,
                                PixelFormat::kUyvy, PixelFormat::kY10, PixelFormat::kY12,  PixelFormat::kY16,
                                PixelFormat::kY12i, PixelFormat::kMjpg};
constexpr std::uint32_t kMostIntervals = 64;
constexpr double kRateSlack = 0.05;

double seconds_of(const v4l2_fract& fraction) {
    return fraction.denominator == 0
               ? 0.0
               : static_cast<double>(fraction.numerator) / static_cast<double>(fraction.denominator);
}

/// Drivers count pairs of pixels of two views.
std::uint32_t node_width(PixelFormat format, const V4l2CaptureOptions& options) {
    return static_cast<std::uint32_t>(is_interleaved(format) ? options.width / 2 : options.width);
}

/// What lies before a node that does not set its sensor itself. @param can  its capabilities
Status set_up_way(KernelIo& io, int fd, std::uint32_t can, const V4l2CaptureOptions& options, std::string& problem) {
    if ((can & V4L2_CAP_IO_MC) == 0) {
        return Status::kOk;
    }
    const auto height = static_cast<std::uint32_t>(options.height);
    return MediaGraph(io).set_up(fd, {node_width(options.format, options), height, options.format}, problem);
}

}  // namespace

std::uint32_t V4l2Capture::type() const {
    return multiplanar_ ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

Status V4l2Capture::fail(std::string_view what, int result, std::string& problem) {
    problem = device_ + ": " + std::string(what);
    if (result != 0) {
        problem += std::string(": ") + std::strerror(-result);
    }
    return result == -ENOENT || result == -ENODEV || result == -ENXIO ? Status::kNotFound : Status::kIo;
}

Status V4l2Capture::prepare(const V4l2CaptureOptions& options, std::string& problem) {
    close();
    device_ = options.device;
    fd_ = io_.open(device_.c_str(), O_RDWR | O_NONBLOCK);
    if (fd_ < 0) {
        return fail("cannot be opened", fd_, problem);
    }
    Status status = negotiate(options, problem);
    status = ok(status) ? acquire_buffers(options, problem) : status;
    if (!ok(status)) {
        close();
    }
    return status;
}

Status V4l2Capture::start(std::string& problem) {
    int stream_type = static_cast<int>(type());
    const int result = io_.ioctl(fd_, VIDIOC_STREAMON, &stream_type);
    streaming_ = result >= 0;
    if (streaming_) {
        return Status::kOk;
    }
    // What the drivers of bridges answer when they have looked at the way from the sensor.
    const bool is_way = result == -EPIPE || result == -ENOLINK;
    const Status status =
        fail(is_way ? "streaming does not start, because the formats or links between sensor and node do "
                      "not fit (media-ctl --print-topology shows them)"
                    : "streaming does not start",
             result, problem);
    close();
    return status;
}

Status V4l2Capture::negotiate(const V4l2CaptureOptions& options, std::string& problem) {
    v4l2_capability capability{};
    int result = io_.ioctl(fd_, VIDIOC_QUERYCAP, &capability);
    if (result < 0) {
        const Status failed = fail("not a video device", result, problem);
        return result == -ENOTTY ? Status::kInvalidArgument : failed;
    }
    const std::uint32_t can =
        (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
    multiplanar_ = (can & V4L2_CAP_VIDEO_CAPTURE) == 0 && (can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0;
    if ((can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) == 0 || (can & V4L2_CAP_STREAMING) == 0) {
        (void)fail("not a capture device with streaming I/O", 0, problem);
        return Status::kInvalidArgument;
    }
    std::string words;
    if (const Status status = set_up_way(io_, fd_, can, options, words); !ok(status)) {
        (void)fail(words, 0, problem);
        return status;
    }
    const bool is_choice = options.any_format && (can & V4L2_CAP_IO_MC) == 0;
    format_ = is_choice ? choose(options) : options.format;
    v4l2_format format{};
    describe_format(format_, options, format);
    result = io_.ioctl(fd_, VIDIOC_S_FMT, &format);
    if (result < 0) {
        return fail("size and format refused", result, problem);
    }
    if (!is_given(format, format_, options)) {
        const v4l2_pix_format_mplane& many = format.fmt.pix_mp;
        const v4l2_pix_format& one = format.fmt.pix;
        const std::uint32_t got = multiplanar_ ? many.pixelformat : one.pixelformat;
        (void)fail("gives " + std::to_string(multiplanar_ ? many.width : one.width) + "x" +
                       std::to_string(multiplanar_ ? many.height : one.height) + " " +
                       std::string(reinterpret_cast<const char*>(&got), 4) +
                       " instead of the size and format requested",
                   0, problem);
        return Status::kInvalidArgument;
    }
    stride_ = multiplanar_ ? format.fmt.pix_mp.plane_fmt[0].bytesperline : format.fmt.pix.bytesperline;
    stride_ = std::max(stride_, row_bytes(format_, options.width));
    image_bytes_ = multiplanar_ ? format.fmt.pix_mp.plane_fmt[0].sizeimage : format.fmt.pix.sizeimage;
    image_bytes_ = std::max(image_bytes_, least_bytes(options.width, options.height));
    set_rate(options);
    return Status::kOk;
}

std::size_t V4l2Capture::least_bytes(int width, int height) const {
    constexpr std::size_t kLeastJpeg = 4;  // its first and last marker
    return format_ == PixelFormat::kMjpg ? kLeastJpeg
                                         : stride_ * static_cast<std::size_t>(height - 1) + row_bytes(format_, width);
}

void V4l2Capture::describe_format(PixelFormat format, const V4l2CaptureOptions& options,
                                  v4l2_format& description) const {
    description = {};
    description.type = type();
    const std::uint32_t width = node_width(format, options);
    const auto height = static_cast<std::uint32_t>(options.height);
    if (multiplanar_) {
        description.fmt.pix_mp.width = width;
        description.fmt.pix_mp.height = height;
        description.fmt.pix_mp.pixelformat = fourcc(format);
        description.fmt.pix_mp.field = V4L2_FIELD_NONE;
        description.fmt.pix_mp.num_planes = 1;
    } else {
        description.fmt.pix.width = width;
        description.fmt.pix.height = height;
        description.fmt.pix.pixelformat = fourcc(format);
        description.fmt.pix.field = V4L2_FIELD_NONE;
    }
}

bool V4l2Capture::is_given(const v4l2_format& given, PixelFormat format, const V4l2CaptureOptions& options) const {
    const v4l2_pix_format_mplane& many = given.fmt.pix_mp;
    const v4l2_pix_format& one = given.fmt.pix;
    return (multiplanar_ ? many.width : one.width) == node_width(format, options) &&
           (multiplanar_ ? many.height : one.height) == static_cast<std::uint32_t>(options.height) &&
           (multiplanar_ ? many.pixelformat : one.pixelformat) == fourcc(format) &&
           (!multiplanar_ || many.num_planes == 1);
}

/// Whether the node says that it can send this format at the rate; true if it says nothing.
bool V4l2Capture::reaches(PixelFormat format, const V4l2CaptureOptions& options) {
    v4l2_frmivalenum interval{};
    interval.pixel_format = fourcc(format);
    interval.width = node_width(format, options);
    interval.height = static_cast<std::uint32_t>(options.height);
    bool is_said = false;
    for (; interval.index < kMostIntervals && io_.ioctl(fd_, VIDIOC_ENUM_FRAMEINTERVALS, &interval) >= 0;
         ++interval.index) {
        is_said = true;
        const v4l2_fract& least =
            interval.type == V4L2_FRMIVAL_TYPE_DISCRETE ? interval.discrete : interval.stepwise.min;
        if (seconds_of(least) * options.rate_hz < 1.0 + kRateSlack) {
            return true;
        }
    }
    return !is_said || options.rate_hz == 0.0;
}

PixelFormat V4l2Capture::choose(const V4l2CaptureOptions& options) {
    const auto has = [&](PixelFormat format) {
        v4l2_format tried{};
        describe_format(format, options, tried);
        return io_.ioctl(fd_, VIDIOC_TRY_FMT, &tried) >= 0 && is_given(tried, format, options);
    };
    if (has(options.format) && reaches(options.format, options)) {
        return options.format;
    }
    for (const PixelFormat format : kBestFirst) {
        if ((options.has_two_views || !is_interleaved(format)) && has(format) && reaches(format, options)) {
            return format;
        }
    }
    for (const PixelFormat format : kBestFirst) {  // at whatever rate there is, which the dry run tells
        if ((options.has_two_views || !is_interleaved(format)) && has(format)) {
            return format;
        }
    }
    return options.format;
}

/// Drivers that cannot have it set say so, and stay as they are; one that takes another rate tells it.
void V4l2Capture::set_rate(const V4l2CaptureOptions& options) {
    warning_.clear();
    if (options.rate_hz == 0.0) {
        return;
    }
    constexpr double kUnit = 1000.0;
    v4l2_streamparm parameters{};
    parameters.type = type();
    parameters.parm.capture.timeperframe = {static_cast<std::uint32_t>(kUnit),
                                            static_cast<std::uint32_t>(std::lround(kUnit * options.rate_hz))};
    if (io_.ioctl(fd_, VIDIOC_S_PARM, &parameters) < 0) {
        return;
    }
    const double period_s = seconds_of(parameters.parm.capture.timeperframe);
    if (period_s > 0.0 && std::abs(period_s * options.rate_hz - 1.0) > kRateSlack) {
        warning_ = device_ + ": takes " + std::to_string(std::lround(1.0 / period_s)) +
                   " frames a second instead of cameras.rate_hz";
    }
}

Status V4l2Capture::acquire_buffers(const V4l2CaptureOptions& options, std::string& problem) {
    std::string what;
    const int result = memory_.acquire({fd_, type(), options.buffers, image_bytes_, options.heap.c_str()}, what);
    if (result < 0) {
        return fail(what, result, problem);
    }
    for (std::uint32_t i = 0; i < memory_.count(); ++i) {
        FACET_TRY(queue(i, problem));
    }
    return Status::kOk;
}

void V4l2Capture::close() {
    if (fd_ < 0) {
        return;
    }
    if (streaming_) {
        int stream_type = static_cast<int>(type());
        (void)io_.ioctl(fd_, VIDIOC_STREAMOFF, &stream_type);
        streaming_ = false;
    }
    memory_.release();
    (void)io_.close(fd_);
    fd_ = -1;
}

Status V4l2Capture::queue(std::uint32_t index, std::string& problem) {
    (void)memory_.end_reading(index);  // nothing was written: whatever it says, the buffer can go back
    v4l2_buffer buffer{};
    v4l2_plane plane{};
    memory_.describe(index, buffer, plane);
    const int result = io_.ioctl(fd_, VIDIOC_QBUF, &buffer);
    return result < 0 ? fail("does not accept a buffer back", result, problem) : Status::kOk;
}

Status V4l2Capture::dequeue(Duration timeout, V4l2Buffer& buffer, std::string& problem) {
    const int ready = io_.wait_readable(fd_, timeout);
    if (ready == 0) {
        return Status::kNotReady;
    }
    v4l2_buffer raw{};
    v4l2_plane plane{};
    memory_.describe(kMaxBuffers, raw, plane);  // of no buffer: which one it is comes back
    int result = ready < 0 ? ready : io_.ioctl(fd_, VIDIOC_DQBUF, &raw);
    if (result == -EAGAIN) {
        return Status::kNotReady;
    }
    result = result < 0 || raw.index < memory_.count() ? result : -EINVAL;
    result = result < 0 ? result : memory_.begin_reading(raw.index);
    if (result < 0) {
        (void)fail("delivers no frames", result, problem);
        return Status::kIo;
    }
    const std::size_t used = multiplanar_ ? plane.bytesused : raw.bytesused;
    const std::size_t offset = multiplanar_ ? plane.data_offset : 0;
    buffer.index = raw.index;
    buffer.sequence = raw.sequence;
    buffer.stamp = {static_cast<std::int64_t>(raw.timestamp.tv_sec) * 1'000'000'000 + raw.timestamp.tv_usec * 1000};
    buffer.error = (raw.flags & V4L2_BUF_FLAG_ERROR) != 0;
    buffer.start_of_exposure = (raw.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    buffer.monotonic = (raw.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    const std::span<std::uint8_t> all = memory_.bytes(raw.index);
    const std::span<std::uint8_t> whole = all.first(std::min(used, all.size()));
    buffer.bytes = whole.subspan(std::min(offset, whole.size()));
    return Status::kOk;
}

}  // namespace facet
