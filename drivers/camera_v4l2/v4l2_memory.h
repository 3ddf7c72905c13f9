// SPDX-License-Identifier: BSD-2-Clause
// The memory of a V4L2 node's buffers.
#pragma once

#include <linux/videodev2.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// The buffers of one capture node, either the driver's own (MMAP; cached where it offers that) or of a DMA heap
/// (DMABUF), whose memory the processor reads through its cache whatever the driver's is like. Linux documentation,
/// "Streaming I/O" and "DMA-BUF heaps". Thread-bound. Heap for problem texts only.
class V4l2Memory {
public:
    static constexpr std::uint32_t kMaxBuffers = 8;

    struct Request {
        int fd = -1;  ///< the open node
        std::uint32_t type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        int buffers = 4;        ///< requested
        std::size_t bytes = 0;  ///< of an image, as the driver has negotiated them
        const char* heap = "";  ///< such as /dev/dma_heap/system; empty: the driver's own memory
    };

    explicit V4l2Memory(KernelIo& io) : io_(io) {}
    ~V4l2Memory() { release(); }
    V4l2Memory(const V4l2Memory&) = delete;
    V4l2Memory& operator=(const V4l2Memory&) = delete;

    /// Asks the driver for buffers and maps them. The node must be released before it is closed.
    /// @param what  on failure, in words
    /// @return 0, or -errno with nothing acquired
    int acquire(const Request& request, std::string& what);
    void release();

    std::uint32_t count() const { return count_; }
    std::span<std::uint8_t> bytes(std::uint32_t index) const { return mapped_[index]; }

    /// Fills in what QBUF and DQBUF want to know. @param plane  for the multi-planar API; must live as long as buffer
    void describe(std::uint32_t index, v4l2_buffer& buffer, v4l2_plane& plane) const;

    /// Brackets what the processor reads: cache and memory are in step in between. No-ops for the driver's own memory,
    /// for which DQBUF and QBUF do it. @return 0 or -errno
    int begin_reading(std::uint32_t index);
    int end_reading(std::uint32_t index);

private:
    bool is_multiplanar() const { return type_ == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }
    int request_buffers(const Request& request, std::string& what);
    int map_own(std::uint32_t index, std::string& what);
    int allocate(int heap, std::uint32_t index, std::string& what);
    int synchronise(std::uint32_t index, std::uint64_t flags);

    KernelIo& io_;
    int fd_ = -1;
    std::uint32_t type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    std::uint32_t memory_ = V4L2_MEMORY_MMAP;
    std::size_t bytes_ = 0;
    std::uint32_t count_ = 0;  ///< those that are mapped
    std::array<std::span<std::uint8_t>, kMaxBuffers> mapped_{};
    std::array<int, kMaxBuffers> dmabuf_{};
    std::array<bool, kMaxBuffers> is_read_{};
};

}  // namespace facet
