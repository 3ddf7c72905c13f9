// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/v4l2_memory.h"

#include <fcntl.h>
#include <linux/dma-buf.h>
#include <linux/dma-heap.h>

#include <algorithm>
#include <cerrno>

namespace facet {

int V4l2Memory::acquire(const Request& request, std::string& what) {
    release();
    fd_ = request.fd;
    type_ = request.type;
    bytes_ = request.bytes;
    const bool own = *request.heap == '\0';
    memory_ = own ? V4L2_MEMORY_MMAP : V4L2_MEMORY_DMABUF;
    int heap = -1;
    if (!own) {
        heap = io_.open(request.heap, O_RDWR);
        if (heap < 0) {
            what = std::string(request.heap) + " cannot be opened";
            return heap;
        }
    }
    int result = request_buffers(request, what);
    const std::uint32_t wanted = result < 0 ? 0 : static_cast<std::uint32_t>(result);
    for (std::uint32_t i = 0; i < wanted && result >= 0; ++i) {
        result = own ? map_own(i, what) : allocate(heap, i, what);
        count_ = result < 0 ? count_ : i + 1;
    }
    if (heap >= 0) {
        (void)io_.close(heap);
    }
    if (result < 0) {
        release();
        return result;
    }
    return 0;
}

/// @return how many there are, or -errno
int V4l2Memory::request_buffers(const Request& request, std::string& what) {
    v4l2_requestbuffers wanted{};
    wanted.count = static_cast<std::uint32_t>(std::clamp(request.buffers, 2, static_cast<int>(kMaxBuffers)));
    wanted.type = type_;
    wanted.memory = memory_;
    // Cached where the driver can (it clears the flag if not): on ARM uncached memory is read at a tenth of the speed.
    wanted.flags = memory_ == V4L2_MEMORY_MMAP ? V4L2_MEMORY_FLAG_NON_COHERENT : 0;
    const int result = io_.ioctl(fd_, VIDIOC_REQBUFS, &wanted);
    if (result < 0 || wanted.count < 2) {
        what = memory_ == V4L2_MEMORY_MMAP ? "provides no buffers" : "takes no buffers of a heap";
        return result < 0 ? result : -ENOMEM;
    }
    return static_cast<int>(std::min(wanted.count, kMaxBuffers));
}

int V4l2Memory::map_own(std::uint32_t index, std::string& what) {
    v4l2_buffer buffer{};
    v4l2_plane plane{};
    describe(index, buffer, plane);
    int result = io_.ioctl(fd_, VIDIOC_QUERYBUF, &buffer);
    if (result < 0) {
        what = "does not describe its buffers";
        return result;
    }
    const std::size_t length = is_multiplanar() ? plane.length : buffer.length;
    void* address = nullptr;
    result = io_.map(fd_, length, is_multiplanar() ? plane.m.mem_offset : buffer.m.offset, address);
    if (result < 0) {
        what = "buffers cannot be mapped";
        return result;
    }
    mapped_[index] = {static_cast<std::uint8_t*>(address), length};
    return 0;
}

int V4l2Memory::allocate(int heap, std::uint32_t index, std::string& what) {
    dma_heap_allocation_data allocation{};
    allocation.len = bytes_;
    allocation.fd_flags = O_RDWR | O_CLOEXEC;
    int result = io_.ioctl(heap, DMA_HEAP_IOCTL_ALLOC, &allocation);
    if (result < 0) {
        what = "the heap gives no memory";
        return result;
    }
    const int dmabuf = static_cast<int>(allocation.fd);
    void* address = nullptr;
    result = io_.map(dmabuf, bytes_, 0, address);
    if (result < 0) {
        what = "memory of the heap cannot be mapped";
        (void)io_.close(dmabuf);
        return result;
    }
    dmabuf_[index] = dmabuf;
    is_read_[index] = false;
    mapped_[index] = {static_cast<std::uint8_t*>(address), bytes_};
    return 0;
}

void V4l2Memory::release() {
    for (std::uint32_t i = 0; i < count_; ++i) {
        (void)end_reading(i);
        (void)io_.unmap(mapped_[i].data(), mapped_[i].size());
        if (memory_ == V4L2_MEMORY_DMABUF) {
            (void)io_.close(dmabuf_[i]);
        }
    }
    count_ = 0;
}

void V4l2Memory::describe(std::uint32_t index, v4l2_buffer& buffer, v4l2_plane& plane) const {
    buffer.type = type_;
    buffer.memory = memory_;
    buffer.index = index;
    const bool is_heaps = memory_ == V4L2_MEMORY_DMABUF && index < count_;
    if (is_multiplanar()) {
        buffer.m.planes = &plane;
        buffer.length = 1;
        if (is_heaps) {
            plane.m.fd = dmabuf_[index];
            plane.length = static_cast<std::uint32_t>(bytes_);
        }
    } else if (is_heaps) {
        buffer.m.fd = dmabuf_[index];
        buffer.length = static_cast<std::uint32_t>(bytes_);
    }
}

int V4l2Memory::begin_reading(std::uint32_t index) {
    const int result = synchronise(index, DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ);
    is_read_[index] = result >= 0;
    return result;
}

int V4l2Memory::end_reading(std::uint32_t index) {
    if (!is_read_[index]) {
        return 0;
    }
    is_read_[index] = false;
    return synchronise(index, DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ);
}

int V4l2Memory::synchronise(std::uint32_t index, std::uint64_t flags) {
    if (memory_ != V4L2_MEMORY_DMABUF) {
        return 0;
    }
    int result = -EAGAIN;
    for (int attempt = 0; attempt < 3 && result == -EAGAIN; ++attempt) {  // which its documentation asks for
        dma_buf_sync sync{flags};
        result = io_.ioctl(dmabuf_[index], DMA_BUF_IOCTL_SYNC, &sync);
    }
    return result == -EAGAIN ? -EIO : result;
}

}  // namespace facet
