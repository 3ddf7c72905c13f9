// SPDX-License-Identifier: BSD-2-Clause
// A V4L2 capture node: negotiation, buffers, streaming.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "drivers/camera_v4l2/unpack.h"
#include "drivers/camera_v4l2/v4l2_memory.h"
#include "platform/port/kernel_io.h"

struct v4l2_format;

namespace facet {

struct V4l2CaptureOptions {
    std::string device = "/dev/video0";
    int width = 0;  ///< of both views, where an image holds two
    int height = 0;
    PixelFormat format = PixelFormat::kGrey;
    int buffers = 4;   ///< 2 to 8; the driver may give more or fewer
    std::string heap;  ///< DMA heap that they are of, such as /dev/dma_heap/linux,cma; empty: the driver's own memory
    /// Of the formats that the node has in this size and at this rate, the best: `format`, else one of 8 bits or more
    /// without loss, else MJPG. Behind a media controller it is always `format`.
    bool any_format = false;
    bool has_two_views = false;  ///< the image holds both, so that interleaved formats may be chosen
    double rate_hz = 0.0;        ///< that a camera without a trigger is set to; 0: as it is
};

/// One filled buffer.
struct V4l2Buffer {
    std::uint32_t index = 0;
    std::uint32_t sequence = 0;
    Timestamp stamp;
    bool error = false;              ///< marked bad by the driver: do not use the content
    bool start_of_exposure = false;  ///< the stamp is of the start of exposure; else of the end of frame
    bool monotonic = true;           ///< the stamp is from the monotonic clock; else from an unknown one
    std::span<const std::uint8_t> bytes;
};

/// The V4L2 streaming protocol (kernel documentation "Streaming I/O"), with the single-planar or the
/// multi-planar API, whichever the node has. Thread-bound. Heap on failure.
class V4l2Capture {
public:
    static constexpr std::uint32_t kMaxBuffers = V4l2Memory::kMaxBuffers;

    explicit V4l2Capture(KernelIo& io) : io_(io), memory_(io) {}
    ~V4l2Capture() { close(); }
    V4l2Capture(const V4l2Capture&) = delete;
    V4l2Capture& operator=(const V4l2Capture&) = delete;

    /// Opens, negotiates exactly the size and format asked for, maps and queues the buffers.
    /// @return kNotFound if there is no such node, kInvalidArgument if it cannot do what is asked, kIo otherwise;
    ///         closed on failure
    Status prepare(const V4l2CaptureOptions& options, std::string& problem);
    /// Starts streaming. After prepare(). @return kIo or kNotFound; closed then
    Status start(std::string& problem);
    /// Of the open node, -1 if there is none.
    int descriptor() const { return fd_; }
    void close();
    bool is_open() const { return fd_ >= 0; }

    /// @param timeout  zero: do not wait
    /// @return kNotReady after the timeout; kIo if the node fails or is gone: close it.
    Status dequeue(Duration timeout, V4l2Buffer& buffer, std::string& problem);
    Status queue(std::uint32_t index, std::string& problem);

    std::size_t stride() const { return stride_; }
    /// What was negotiated.
    PixelFormat format() const { return format_; }
    /// What a good buffer holds at least.
    std::size_t least_bytes(int width, int height) const;
    /// What the driver makes of the rate, if that is another one; empty if all is well.
    const std::string& warning() const { return warning_; }

private:
    Status fail(std::string_view what, int result, std::string& problem);
    Status negotiate(const V4l2CaptureOptions& options, std::string& problem);
    void describe_format(PixelFormat format, const V4l2CaptureOptions& options, v4l2_format& description) const;
    bool is_given(const v4l2_format& given, PixelFormat format, const V4l2CaptureOptions& options) const;
    bool reaches(PixelFormat format, const V4l2CaptureOptions& options);
    PixelFormat choose(const V4l2CaptureOptions& options);
    void set_rate(const V4l2CaptureOptions& options);
    Status acquire_buffers(const V4l2CaptureOptions& options, std::string& problem);
    std::uint32_t type() const;

    KernelIo& io_;
    std::string device_;
    int fd_ = -1;
    bool multiplanar_ = false;
    bool streaming_ = false;
    std::size_t stride_ = 0;
    PixelFormat format_ = PixelFormat::kGrey;
    std::string warning_;
    std::size_t image_bytes_ = 0;  ///< of a buffer
    V4l2Memory memory_;
};

}  // namespace facet
