// SPDX-License-Identifier: BSD-2-Clause
// A kernel with a V4L2 capture node that behaves as the streaming protocol says and can be unplugged, and a DMA heap.
#pragma once

#include <linux/dma-buf.h>
#include <linux/dma-heap.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include <cstring>
#include <deque>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

class FakeCamera final : public FakeKernel {
public:
    static constexpr int kFd = 9;
    static constexpr int kControlsFd = 10;
    static constexpr int kHeapFd = 11;
    static constexpr int kDmabufFd = 20;  ///< of the heap's first allocation

    explicit FakeCamera(ManualClock& clock) : clock_(clock) {}

    bool multiplanar = false;
    bool present = true;
    std::uint32_t more_capabilities = 0;
    std::function<int()> on_stream = [] { return 0; };  ///< 0, or what STREAMON answers
    bool one_by_one = true;                             ///< "none ready" after each frame taken
    std::uint32_t width = 8;
    std::uint32_t height = 4;
    std::uint32_t stride = 8;
    std::uint32_t format = V4L2_PIX_FMT_GREY;
    /// What the node has besides: `format` becomes whichever is set. Empty: `format` alone, whatever is asked for.
    struct Mode {
        std::uint32_t format;
        std::uint32_t width;
        std::uint32_t stride;
        double most_hz;
    };
    std::vector<Mode> modes;
    double rate_hz = 0.0;   ///< as set; 0: not yet
    double most_hz = 60.0;  ///< more is refused and becomes this
    bool has_rate = true;
    std::uint32_t max_buffers = 8;
    std::uint32_t plane_offset = 0;
    std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    std::int64_t exposure = 100;
    std::string controls_at = "/dev/video0";  ///< the node that has the controls
    int set_while_streaming = 0;              ///< controls
    int asked_while_streaming = 0;            ///< for controls
    bool asked_for_cached = false;            ///< buffers
    bool takes_dmabuf = true;
    int heap_room = 8;      ///< allocations that the heap can give
    int dmabufs_open = 0;   ///< allocations in use
    int synchronised = 0;   ///< beginnings and ends of reading a buffer of the heap
    int controls_open = 0;  ///< nodes open for their controls only
    int opened = 0;
    int mapped = 0;
    bool streaming = false;
    int starved = 0;  ///< frames the camera could not store because no buffer was queued

    std::int64_t stamp_error_ns = 0;

    /// A frame whose every pixel is `value`, or marked as an error, or cut. It is there once its stamp has passed.
    void expose(std::uint8_t value, std::int64_t stamp_ns, std::uint32_t extra_flags = 0, std::uint32_t cut = 0) {
        clock_.sleep_until({stamp_ns});
        stamp_ns += stamp_error_ns;
        const std::uint32_t sequence = next_sequence++;
        if (!streaming || queued_.empty()) {
            ++starved;
            return;
        }
        const std::uint32_t index = queued_.front();
        queued_.pop_front();
        REQUIRE(reading_.count(index) == 0);
        std::fill(memory_[index].begin(), memory_[index].end(), value);
        filled_.push_back({index, sequence, stamp_ns, flags | extra_flags, plane_offset + stride * height - cut});
    }
    /// A frame of these bytes.
    void expose_bytes(const std::vector<std::uint8_t>& bytes, std::int64_t stamp_ns) {
        expose(0, stamp_ns);
        REQUIRE_FALSE(filled_.empty());
        Filled& frame = filled_.back();
        REQUIRE(bytes.size() <= memory_[frame.index].size());
        std::copy(bytes.begin(), bytes.end(), memory_[frame.index].begin());
        frame.bytes = static_cast<std::uint32_t>(bytes.size());
    }
    std::uint32_t next_sequence = 0;

    int open(const char* path, int) override {
        if (present && std::string(path) == "/dev/v4l-subdev2") {
            ++controls_open;
            return kControlsFd;
        }
        if (std::string(path) == "/dev/dma_heap/system") {
            return kHeapFd;
        }
        ++opened;
        return present && std::string(path) == "/dev/video0" ? kFd : -ENOENT;
    }
    int close(int fd) override {
        if (fd == kControlsFd) {
            --controls_open;
            return 0;
        }
        if (fd >= kHeapFd) {
            dmabufs_open -= fd >= kDmabufFd ? 1 : 0;
            return 0;
        }
        streaming = false;
        queued_.clear();
        filled_.clear();
        next_sequence = 0;
        return 0;
    }
    int wait_readable(int, Duration timeout) override {
        if (!present) {
            return 1;
        }
        if (filled_.empty() || (one_by_one && pause_)) {
            pause_ = false;
            clock_.advance(timeout);
            return 0;
        }
        return 1;
    }
    int map(int fd, std::size_t length, std::int64_t offset, void*& address) override {
        offset = fd >= kDmabufFd ? fd - kDmabufFd : offset;
        REQUIRE(length == memory_[static_cast<std::size_t>(offset)].size());
        address = memory_[static_cast<std::size_t>(offset)].data();
        ++mapped;
        return 0;
    }
    int unmap(void*, std::size_t) override {
        --mapped;
        return 0;
    }
    int ioctl(int fd, unsigned long request, void* argument) override {
        if (request == DMA_HEAP_IOCTL_ALLOC) {
            return allocate(*static_cast<dma_heap_allocation_data*>(argument));
        }
        if (request == DMA_BUF_IOCTL_SYNC) {
            return synchronise(fd, *static_cast<dma_buf_sync*>(argument));
        }
        if (!present) {
            return -ENODEV;
        }
        const bool has_controls = (fd == kControlsFd) == (controls_at != "/dev/video0");
        if (!has_controls && (request == VIDIOC_QUERY_EXT_CTRL || request == VIDIOC_S_EXT_CTRLS)) {
            return -ENOTTY;
        }
        switch (request) {
            case VIDIOC_QUERYCAP: return query(*static_cast<v4l2_capability*>(argument));
            case VIDIOC_TRY_FMT: return try_format(*static_cast<v4l2_format*>(argument));
            case VIDIOC_ENUM_FRAMEINTERVALS: return tell_interval(*static_cast<v4l2_frmivalenum*>(argument));
            case VIDIOC_S_PARM: return set_rate(*static_cast<v4l2_streamparm*>(argument));
            case VIDIOC_S_FMT: return set_format(*static_cast<v4l2_format*>(argument));
            case VIDIOC_REQBUFS: return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
            case VIDIOC_QUERYBUF: return describe(*static_cast<v4l2_buffer*>(argument));
            case VIDIOC_QBUF: return enqueue(*static_cast<v4l2_buffer*>(argument));
            case VIDIOC_DQBUF: return dequeue(*static_cast<v4l2_buffer*>(argument));
            case VIDIOC_STREAMON: {
                const int answer = on_stream();
                streaming = answer == 0;
                return answer;
            }
            case VIDIOC_STREAMOFF: streaming = false; return 0;
            case VIDIOC_QUERY_EXT_CTRL:
                asked_while_streaming += streaming ? 1 : 0;
                return query_control(*static_cast<v4l2_query_ext_ctrl*>(argument));
            case VIDIOC_S_EXT_CTRLS: return set_control(*static_cast<v4l2_ext_controls*>(argument));
            default: return -ENOTTY;
        }
    }

private:
    struct Filled {
        std::uint32_t index;
        std::uint32_t sequence;
        std::int64_t stamp_ns;
        std::uint32_t flags;
        std::uint32_t bytes;
    };

    int query(v4l2_capability& capability) const {
        capability.capabilities = V4L2_CAP_DEVICE_CAPS;
        capability.device_caps = V4L2_CAP_STREAMING | more_capabilities |
                                 (multiplanar ? V4L2_CAP_VIDEO_CAPTURE_MPLANE : V4L2_CAP_VIDEO_CAPTURE);
        return 0;
    }
    /// The mode asked for, or the first.
    const Mode& mode_for(const v4l2_format& wanted) const {
        for (const Mode& mode : modes) {
            if (mode.format == wanted.fmt.pix.pixelformat && mode.width == wanted.fmt.pix.width) {
                return mode;
            }
        }
        return modes.front();
    }
    int try_format(v4l2_format& wanted) const {
        if (modes.empty()) {
            return -ENOTTY;
        }
        const Mode& mode = mode_for(wanted);
        wanted.fmt.pix.pixelformat = mode.format;
        wanted.fmt.pix.width = mode.width;
        wanted.fmt.pix.height = height;
        return 0;
    }
    int tell_interval(v4l2_frmivalenum& interval) const {
        for (const Mode& mode : modes) {
            if (mode.format == interval.pixel_format && mode.width == interval.width && interval.index == 0) {
                interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
                interval.discrete = {1000, static_cast<std::uint32_t>(mode.most_hz * 1000.0)};
                return 0;
            }
        }
        return -EINVAL;
    }
    int set_rate(v4l2_streamparm& parameters) {
        if (!has_rate) {
            return -ENOTTY;
        }
        CHECK_FALSE(streaming);
        v4l2_fract& period = parameters.parm.capture.timeperframe;
        rate_hz = std::min(most_hz, static_cast<double>(period.denominator) / period.numerator);
        period = {1000, static_cast<std::uint32_t>(rate_hz * 1000.0)};
        return 0;
    }
    int set_format(v4l2_format& wanted) {
        REQUIRE(wanted.type == type());
        if (!modes.empty()) {
            const Mode& mode = mode_for(wanted);
            format = mode.format;
            width = mode.width;
            stride = mode.stride;
        }
        if (multiplanar) {
            wanted.fmt.pix_mp.width = width;
            wanted.fmt.pix_mp.height = height;
            wanted.fmt.pix_mp.pixelformat = format;
            wanted.fmt.pix_mp.num_planes = 1;
            wanted.fmt.pix_mp.plane_fmt[0].bytesperline = stride;
            wanted.fmt.pix_mp.plane_fmt[0].sizeimage = plane_offset + stride * height;
        } else {
            wanted.fmt.pix.width = width;
            wanted.fmt.pix.height = height;
            wanted.fmt.pix.pixelformat = format;
            wanted.fmt.pix.bytesperline = stride;
            wanted.fmt.pix.sizeimage = plane_offset + stride * height;
        }
        return 0;
    }
    int request_buffers(v4l2_requestbuffers& wanted) {
        if (wanted.memory == V4L2_MEMORY_DMABUF && !takes_dmabuf) {
            return -EINVAL;
        }
        memory_kind_ = wanted.memory;
        asked_for_cached = (wanted.flags & V4L2_MEMORY_FLAG_NON_COHERENT) != 0;
        wanted.flags = 0;  // as a driver without them answers
        wanted.count = std::min(wanted.count, max_buffers);
        memory_.assign(wanted.count, std::vector<std::uint8_t>(plane_offset + stride * height));
        allocated_ = 0;
        reading_.clear();
        return 0;
    }
    int allocate(dma_heap_allocation_data& wanted) {
        REQUIRE(wanted.len == memory_[0].size());
        if (dmabufs_open == heap_room) {
            return -ENOMEM;
        }
        ++dmabufs_open;
        wanted.fd = static_cast<std::uint32_t>(kDmabufFd + allocated_++);
        return 0;
    }
    int synchronise(int fd, const dma_buf_sync& sync) {
        const auto index = static_cast<std::uint32_t>(fd - kDmabufFd);
        const bool ends = (sync.flags & DMA_BUF_SYNC_END) != 0;
        REQUIRE(reading_.count(index) == (ends ? 1U : 0U));
        ends ? (void)reading_.erase(index) : (void)reading_.insert(index);
        ++synchronised;
        return 0;
    }
    int describe(v4l2_buffer& buffer) const {
        const auto length = static_cast<std::uint32_t>(memory_[buffer.index].size());
        if (multiplanar) {
            buffer.m.planes[0].length = length;
            buffer.m.planes[0].m.mem_offset = buffer.index;
        } else {
            buffer.length = length;
            buffer.m.offset = buffer.index;
        }
        return 0;
    }
    int enqueue(const v4l2_buffer& buffer) {
        REQUIRE(std::find(queued_.begin(), queued_.end(), buffer.index) == queued_.end());
        REQUIRE(buffer.memory == memory_kind_);
        if (memory_kind_ == V4L2_MEMORY_DMABUF) {
            REQUIRE(reading_.count(buffer.index) == 0);
            const int dmabuf = multiplanar ? buffer.m.planes[0].m.fd : buffer.m.fd;
            CHECK(dmabuf == kDmabufFd + static_cast<int>(buffer.index));
            CHECK((multiplanar ? buffer.m.planes[0].length : buffer.length) == memory_[buffer.index].size());
        }
        queued_.push_back(buffer.index);
        return 0;
    }
    int dequeue(v4l2_buffer& buffer) {
        if (filled_.empty()) {
            return -EAGAIN;
        }
        const Filled frame = filled_.front();
        filled_.pop_front();
        pause_ = true;
        REQUIRE(buffer.memory == memory_kind_);
        buffer.index = frame.index;
        buffer.sequence = frame.sequence;
        buffer.flags = frame.flags;
        buffer.timestamp.tv_sec = frame.stamp_ns / 1'000'000'000;
        buffer.timestamp.tv_usec = frame.stamp_ns % 1'000'000'000 / 1000;
        if (multiplanar) {
            buffer.m.planes[0].bytesused = frame.bytes;
            buffer.m.planes[0].data_offset = plane_offset;
        } else {
            buffer.bytesused = frame.bytes;
        }
        return 0;
    }
    static int query_control(v4l2_query_ext_ctrl& query) {
        const std::uint32_t after = query.id & ~static_cast<std::uint32_t>(V4L2_CTRL_FLAG_NEXT_CTRL);
        if (after >= 2) {
            return -EINVAL;
        }
        query.id = after + 1;
        query.type = V4L2_CTRL_TYPE_INTEGER;
        query.minimum = 1;
        query.maximum = 1000;
        std::strcpy(query.name, after == 0 ? "Analogue Gain" : "Exposure Time, Absolute");
        return 0;
    }
    int set_control(const v4l2_ext_controls& controls) {
        set_while_streaming += streaming ? 1 : 0;
        if (controls.controls[0].id == 2) {
            exposure = controls.controls[0].value;
        }
        return 0;
    }
    std::uint32_t type() const {
        return multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
    }

    ManualClock& clock_;
    bool pause_ = false;
    std::uint32_t memory_kind_ = V4L2_MEMORY_MMAP;
    int allocated_ = 0;
    std::set<std::uint32_t> reading_;  ///< buffers of the heap that the program has announced to read
    std::vector<std::vector<std::uint8_t>> memory_;
    std::deque<std::uint32_t> queued_;
    std::deque<Filled> filled_;
};

}  // namespace facet::test
