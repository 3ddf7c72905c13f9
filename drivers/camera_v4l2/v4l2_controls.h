// SPDX-License-Identifier: BSD-2-Clause
// Controls of a camera by their names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// A control of a node.
struct V4l2Control {
    std::uint32_t id = 0;
    std::int64_t least = 0;
    std::int64_t most = -1;  ///< less than `least`: there is no such control
    bool is_wide = false;    ///< of 64 bits
};

/// The controls of a node: a capture node, or the sensor's own below a media controller (/dev/v4l-subdevN), where
/// exposure and gain are on Raspberry Pi and i.MX. Names are those of v4l2-ctl: lower case, blanks and dashes as
/// underscores ("exposure", "analogue_gain"). Thread-bound. Heap for texts.
class V4l2Controls {
public:
    explicit V4l2Controls(KernelIo& io) : io_(io) {}
    ~V4l2Controls() { close(); }
    V4l2Controls(const V4l2Controls&) = delete;
    V4l2Controls& operator=(const V4l2Controls&) = delete;

    /// Opens a node for its controls only.
    /// @return kNotFound if there is no such node, kIo if it cannot be opened; `problem` has the words
    Status open(const std::string& device, std::string& problem);
    /// Uses a node that somebody else has open, and closes.
    void borrow(int descriptor, const std::string& device);
    void close();

    /// Looks for one among all of them. @return kNotFound if there is none (the words name those that there are)
    Status find(std::string_view name, V4l2Control& control, std::string& problem);
    /// find() and write() by name. @return kNotFound if there is no such control, kInvalidArgument if the value is out
    ///         of range (the words give the range), kIo if it is refused
    Status set(std::string_view name, std::int64_t value, std::string& problem);
    /// One system call, no heap. @return 0 or -errno; -ERANGE if the value is out of range, also of one not found
    int write(const V4l2Control& control, std::int64_t value);

private:
    Status fail(const std::string& what, int result, std::string& problem) const;

    KernelIo& io_;
    std::string device_;
    int fd_ = -1;
    bool is_own_ = false;
};

}  // namespace facet
