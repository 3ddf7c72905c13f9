// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/v4l2_capture.h"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/camera_v4l2/media_graph.h"

namespace facet {
namespace {

/// What lies before a node that does not set its sensor itself. @param can  its capabilities
Status set_up_way(KernelIo& io, int fd, std::uint32_t can, const V4l2CaptureOptions& options, std::string& problem) {
    if ((can & V4L2_CAP_IO_MC) == 0) {
        return Status::kOk;
    }
    const auto width = static_cast<std::uint32_t>(options.width);
    const auto height = static_cast<std::uint32_t>(options.height);
    return MediaGraph(io).set_up(fd, {width, height, options.format}, problem);
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
    v4l2_format format{};
    format.type = type();
    const auto width = static_cast<std::uint32_t>(options.width);
    const auto height = static_cast<std::uint32_t>(options.height);
    if (multiplanar_) {
        format.fmt.pix_mp.width = width;
        format.fmt.pix_mp.height = height;
        format.fmt.pix_mp.pixelformat = fourcc(options.format);
        format.fmt.pix_mp.field = V4L2_FIELD_NONE;
        format.fmt.pix_mp.num_planes = 1;
    } else {
        format.fmt.pix.width = width;
        format.fmt.pix.height = height;
        format.fmt.pix.pixelformat = fourcc(options.format);
        format.fmt.pix.field = V4L2_FIELD_NONE;
    }
    result = io_.ioctl(fd_, VIDIOC_S_FMT, &format);
    if (result < 0) {
        return fail("size and format refused", result, problem);
    }
    const v4l2_pix_format_mplane& many = format.fmt.pix_mp;
    const v4l2_pix_format& one = format.fmt.pix;
    const std::uint32_t got_width = multiplanar_ ? many.width : one.width;
    const std::uint32_t got_height = multiplanar_ ? many.height : one.height;
    const std::uint32_t got_format = multiplanar_ ? many.pixelformat : one.pixelformat;
    if (got_width != width || got_height != height || got_format != fourcc(options.format) ||
        (multiplanar_ && many.num_planes != 1)) {
        (void)fail("gives " + std::to_string(got_width) + "x" + std::to_string(got_height) + " " +
                       std::string(reinterpret_cast<const char*>(&got_format), 4) +
                       " instead of the size and format requested",
                   0, problem);
        return Status::kInvalidArgument;
    }
    stride_ = multiplanar_ ? many.plane_fmt[0].bytesperline : one.bytesperline;
    stride_ = std::max(stride_, row_bytes(options.format, options.width));
    image_bytes_ = multiplanar_ ? many.plane_fmt[0].sizeimage : one.sizeimage;
    image_bytes_ = std::max(image_bytes_, stride_ * static_cast<std::size_t>(options.height));
    return Status::kOk;
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
