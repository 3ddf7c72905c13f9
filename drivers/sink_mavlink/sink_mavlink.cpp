// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sink_mavlink/sink_mavlink.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace facet {

SinkMavlink::SinkMavlink(KernelIo& io, const Clock& clock, SinkMavlinkOptions options)
    : io_(io), clock_(clock), options_(std::move(options)) {}

Status SinkMavlink::open(std::string& problem) {
    close();
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(options_.udp_port);
    if (inet_pton(AF_INET, options_.udp_host.c_str(), &address.sin_addr) != 1 || options_.udp_port == 0) {
        problem = "mavlink: '" + options_.udp_host + ":" + std::to_string(options_.udp_port) +
                  "' is no IPv4 address and port";
        return Status::kInvalidArgument;
    }
    fd_ = io_.socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    const int result = fd_ < 0 ? fd_ : io_.connect(fd_, &address, sizeof address);
    if (result < 0) {
        problem = "mavlink: " + options_.udp_host + ": " + std::strerror(-result);
        close();
        return Status::kIo;
    }
    next_heartbeat_ = clock_.now();
    return Status::kOk;
}

void SinkMavlink::close() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
    fd_ = -1;
}

Status SinkMavlink::write() {
    const std::int64_t result = fd_ < 0 ? -EBADF : io_.write(fd_, frame_.data(), frame_.size());
    if (result == static_cast<std::int64_t>(frame_.size())) {
        ++sent_;
        return Status::kOk;
    }
    ++dropped_;
    return result == -EAGAIN || result == -ENOBUFS ? Status::kFull : Status::kIo;
}

Status SinkMavlink::send(const Odometry& odometry) {
    if (clock_.now() >= next_heartbeat_) {
        next_heartbeat_ = clock_.now() + options_.heartbeat_period;
        encode_heartbeat(options_.address, sequence_++, frame_);
        (void)write();  // counted; the odometry's own status tells
    }
    FACET_TRY(encode_odometry(odometry, options_.address, sequence_, frame_));
    ++sequence_;
    return write();
}

}  // namespace facet
