// SPDX-License-Identifier: BSD-2-Clause
// A raw SocketCAN socket with kernel time stamps.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/common/can_frame.h"
#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

struct ifreq;

namespace facet {

struct CanSocketOptions {
    std::string interface = "can0";
    bool fd = false;               ///< take CAN FD frames too
    bool fd_if_there = false;      ///< the same where the interface is set up for them, else classic ones only
    bool receives = true;          ///< false: of what arrives only error frames
    bool hardware_stamps = false;  ///< use the controller's stamps where a frame has one
};

/// Receives and sends frames; classic and FD. Time stamps come from SO_TIMESTAMPING
/// (Documentation/networking/timestamping.rst): software stamps are CLOCK_REALTIME at the interrupt, hardware ones the
/// controller's clock. Thread-bound. Heap in open on failure only.
class CanSocket {
public:
    explicit CanSocket(KernelIo& io) : io_(io) {}
    ~CanSocket() { close(); }
    CanSocket(const CanSocket&) = delete;
    CanSocket& operator=(const CanSocket&) = delete;

    /// @param filters  at most 32; error frames always pass
    /// @return kNotFound if there is no such interface, kIo otherwise; `problem` has the words. Closed then.
    Status open(const CanSocketOptions& options, std::span<const CanFilter> filters, std::string& problem);
    void close();
    bool is_open() const { return fd_ >= 0; }

    /// @param timeout  zero: do not wait
    /// @return kNotReady after the timeout; kCorrupt for a frame of impossible size; kIo if the interface is down or
    ///         gone (error() has the errno).
    Status receive(Duration timeout, CanFrame& frame);

    /// Never waits.
    /// @return kFull if the queue of the socket or of the interface is full: not sent; kInvalidArgument for an FD frame
    ///         where they are not taken; kIo if the interface is down or gone (error() has the errno).
    Status send(const CanFrame& frame);

    /// Whether FD frames are taken, since open.
    bool is_fd() const { return is_fd_; }
    /// Frames the kernel dropped because the socket was full, since open.
    std::uint32_t overflows() const { return overflows_; }
    int error() const { return error_; }

private:
    bool takes_fd(ifreq interface) const;
    Status fail(const char* what, int result, std::string& problem);
    Status set_up(const CanSocketOptions& options, std::span<const CanFilter> filters, std::string& problem);

    KernelIo& io_;
    int fd_ = -1;
    int error_ = 0;
    bool hardware_stamps_ = false;
    bool is_fd_ = false;
    std::string interface_;
    std::uint32_t overflows_ = 0;
};

}  // namespace facet
