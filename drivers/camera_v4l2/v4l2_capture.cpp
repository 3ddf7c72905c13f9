// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/v4l2_capture.h"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

namespace facet {
namespace {

/// "Exposure Time, Absolute" -> "exposure_time_absolute", as v4l2-ctl does.
std::string control_name(const char* text, std::size_t size) {
    std::string name;
    bool gap = false;
    for (std::size_t i = 0; i < size && text[i] != '\0'; ++i) {
        if (std::isalnum(static_cast<unsigned char>(text[i])) != 0) {
            if (gap && !name.empty()) {
                name += '_';
            }
            gap = false;
            name += static_cast<char>(std::tolower(static_cast<unsigned char>(text[i])));
        } else {
            gap = true;
        }
    }
    return name;
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

Status V4l2Capture::open(const V4l2CaptureOptions& options, std::string& problem) {
    close();
    device_ = options.device;
    fd_ = io_.open(device_.c_str(), O_RDWR | O_NONBLOCK);
    if (fd_ < 0) {
        return fail("cannot be opened", fd_, problem);
    }
    Status status = negotiate(options, problem);
    status = ok(status) ? map_buffers(options, problem) : status;
    if (ok(status)) {
        int stream_type = static_cast<int>(type());
        const int result = io_.ioctl(fd_, VIDIOC_STREAMON, &stream_type);
        streaming_ = result >= 0;
        status = result < 0 ? fail("streaming does not start", result, problem) : Status::kOk;
    }
    if (!ok(status)) {
        close();
    }
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
    return Status::kOk;
}

Status V4l2Capture::map_buffers(const V4l2CaptureOptions& options, std::string& problem) {
    v4l2_requestbuffers request{};
    request.count = static_cast<std::uint32_t>(std::clamp(options.buffers, 2, static_cast<int>(kMaxBuffers)));
    request.type = type();
    request.memory = V4L2_MEMORY_MMAP;
    int result = io_.ioctl(fd_, VIDIOC_REQBUFS, &request);
    if (result < 0 || request.count < 2) {
        return fail("provides no buffers", result < 0 ? result : -ENOMEM, problem);
    }
    const std::uint32_t count = std::min(request.count, kMaxBuffers);
    for (std::uint32_t i = 0; i < count; ++i) {
        v4l2_buffer buffer{};
        v4l2_plane plane{};
        buffer.type = type();
        buffer.memory = V4L2_MEMORY_MMAP;
        buffer.index = i;
        if (multiplanar_) {
            buffer.m.planes = &plane;
            buffer.length = 1;
        }
        result = io_.ioctl(fd_, VIDIOC_QUERYBUF, &buffer);
        if (result < 0) {
            return fail("does not describe its buffers", result, problem);
        }
        const std::size_t length = multiplanar_ ? plane.length : buffer.length;
        void* address = nullptr;
        result = io_.map(fd_, length, multiplanar_ ? plane.m.mem_offset : buffer.m.offset, address);
        if (result < 0) {
            return fail("buffers cannot be mapped", result, problem);
        }
        mapped_[i] = {static_cast<std::uint8_t*>(address), length};
        buffer_count_ = i + 1;
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
    for (std::uint32_t i = 0; i < buffer_count_; ++i) {
        (void)io_.unmap(mapped_[i].data(), mapped_[i].size());
    }
    buffer_count_ = 0;
    (void)io_.close(fd_);
    fd_ = -1;
}

Status V4l2Capture::queue(std::uint32_t index, std::string& problem) {
    v4l2_buffer buffer{};
    v4l2_plane plane{};
    buffer.type = type();
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    if (multiplanar_) {
        buffer.m.planes = &plane;
        buffer.length = 1;
    }
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
    raw.type = type();
    raw.memory = V4L2_MEMORY_MMAP;
    if (multiplanar_) {
        raw.m.planes = &plane;
        raw.length = 1;
    }
    const int result = ready < 0 ? ready : io_.ioctl(fd_, VIDIOC_DQBUF, &raw);
    if (result == -EAGAIN) {
        return Status::kNotReady;
    }
    if (result < 0 || raw.index >= buffer_count_) {
        (void)fail("delivers no frames", result < 0 ? result : -EINVAL, problem);
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
    const std::span<std::uint8_t> whole = mapped_[raw.index].first(std::min(used, mapped_[raw.index].size()));
    buffer.bytes = whole.subspan(std::min(offset, whole.size()));
    return Status::kOk;
}

Status V4l2Capture::set_control(std::string_view name, std::int64_t value, std::string& problem) {
    v4l2_query_ext_ctrl query{};
    for (query.id = V4L2_CTRL_FLAG_NEXT_CTRL; io_.ioctl(fd_, VIDIOC_QUERY_EXT_CTRL, &query) >= 0;
         query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
        if (control_name(query.name, sizeof query.name) != name) {
            continue;
        }
        if (value < query.minimum || value > query.maximum) {
            (void)fail("control " + std::string(name) + " must be " + std::to_string(query.minimum) + " to " +
                           std::to_string(query.maximum) + ", not " + std::to_string(value),
                       0, problem);
            return Status::kInvalidArgument;
        }
        v4l2_ext_control control{};
        control.id = query.id;
        if (query.type == V4L2_CTRL_TYPE_INTEGER64) {
            control.value64 = value;
        } else {
            control.value = static_cast<std::int32_t>(value);
        }
        v4l2_ext_controls controls{};
        controls.which = V4L2_CTRL_WHICH_CUR_VAL;
        controls.count = 1;
        controls.controls = &control;
        const int result = io_.ioctl(fd_, VIDIOC_S_EXT_CTRLS, &controls);
        return result < 0 ? fail("control " + std::string(name) + " refused", result, problem) : Status::kOk;
    }
    (void)fail("has no control " + std::string(name), 0, problem);
    return Status::kNotFound;
}

}  // namespace facet
