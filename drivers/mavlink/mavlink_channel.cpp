// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_channel.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/common/serial_line.h"

namespace facet {

MavlinkChannel::MavlinkChannel(KernelIo& io, MavlinkChannelOptions options) : io_(io), options_(std::move(options)) {}

std::string MavlinkChannel::name() const {
    return is_serial() ? options_.serial : options_.udp_host + ":" + std::to_string(options_.udp_port);
}

Status MavlinkChannel::open(std::string& problem) {
    close();
    const Status status = is_serial() ? open_serial(problem) : open_udp(problem);
    if (!ok(status)) {
        close();
    }
    return status;
}

Status MavlinkChannel::open_udp(std::string& problem) {
    sockaddr_in remote{};
    remote.sin_family = AF_INET;
    remote.sin_port = htons(options_.udp_port);
    if (inet_pton(AF_INET, options_.udp_host.c_str(), &remote.sin_addr) != 1 || options_.udp_port == 0) {
        problem = "mavlink: '" + name() + "' is not an IPv4 address and port";
        return Status::kInvalidArgument;
    }
    fd_ = io_.socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    int result = fd_;
    if (result >= 0 && options_.udp_local_port != 0) {
        sockaddr_in local{};
        local.sin_family = AF_INET;
        local.sin_port = htons(options_.udp_local_port);
        result = io_.bind(fd_, &local, sizeof local);
    }
    if (result >= 0) {
        result = io_.connect(fd_, &remote, sizeof remote);
    }
    if (result < 0) {
        problem = "mavlink: " + options_.udp_host + ": " + std::strerror(-result);
        return Status::kIo;
    }
    return Status::kOk;
}

Status MavlinkChannel::open_serial(std::string& problem) {
    const Status status = open_serial_line(io_, options_.serial, options_.baud, fd_, problem);
    problem = ok(status) ? std::move(problem) : "mavlink: " + problem;
    return status;
}

void MavlinkChannel::close() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
    fd_ = -1;
    rest_.clear();
}

/// @return bytes taken, 0 if the channel is full, or -errno
std::int64_t MavlinkChannel::try_write(std::span<const std::uint8_t> bytes) {
    const std::int64_t result = fd_ < 0 ? -EBADF : io_.write(fd_, bytes.data(), bytes.size());
    return result == -EAGAIN || result == -ENOBUFS ? 0 : result;
}

Status MavlinkChannel::flush() {
    if (rest_.empty()) {
        return Status::kOk;
    }
    const std::int64_t taken = try_write({rest_.data(), rest_.size()});
    if (taken < 0) {
        return Status::kIo;
    }
    std::copy(rest_.begin() + taken, rest_.end(), rest_.begin());
    for (std::int64_t i = 0; i < taken; ++i) {
        rest_.pop_back();
    }
    return rest_.empty() ? Status::kOk : Status::kFull;
}

Status MavlinkChannel::write(std::span<const std::uint8_t> bytes) {
    FACET_TRY(flush());
    const std::int64_t taken = try_write(bytes);
    if (taken <= 0) {
        return taken < 0 ? Status::kIo : Status::kFull;
    }
    for (const std::uint8_t byte : bytes.subspan(static_cast<std::size_t>(taken))) {
        rest_.push_back(byte);
    }
    return Status::kOk;
}

Status MavlinkChannel::read(std::span<std::uint8_t> bytes, std::size_t& size) {
    const std::int64_t result = fd_ < 0 ? -EBADF : io_.read(fd_, bytes.data(), bytes.size());
    if (result > 0) {
        size = static_cast<std::size_t>(result);
        return Status::kOk;
    }
    // Nobody may be listening at the other end yet, which a socket reports here.
    const bool is_quiet = result == -EAGAIN || (!is_serial() && (result == 0 || result == -ECONNREFUSED));
    return is_quiet ? Status::kNotReady : Status::kIo;
}

}  // namespace facet
