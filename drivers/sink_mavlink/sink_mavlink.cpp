// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sink_mavlink/sink_mavlink.h"

#include <arpa/inet.h>
#include <asm/ioctls.h>
#include <asm/termbits.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace facet {

SinkMavlink::SinkMavlink(KernelIo& io, const Clock& clock, SinkMavlinkOptions options)
    : io_(io), clock_(clock), options_(std::move(options)), retry_(options_.retry_period) {}

std::string SinkMavlink::name() const {
    return options_.serial.empty() ? options_.udp_host + ":" + std::to_string(options_.udp_port) : options_.serial;
}

Status SinkMavlink::open(std::string& problem) {
    close();
    const Status status = options_.serial.empty() ? open_udp(problem) : open_serial(problem);
    if (!ok(status)) {
        close();
        return status;
    }
    next_heartbeat_ = clock_.now();
    return Status::kOk;
}

Status SinkMavlink::open_udp(std::string& problem) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(options_.udp_port);
    if (inet_pton(AF_INET, options_.udp_host.c_str(), &address.sin_addr) != 1 || options_.udp_port == 0) {
        problem = "mavlink: '" + name() + "' is not an IPv4 address and port";
        return Status::kInvalidArgument;
    }
    fd_ = io_.socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    const int result = fd_ < 0 ? fd_ : io_.connect(fd_, &address, sizeof address);
    if (result < 0) {
        problem = "mavlink: " + options_.udp_host + ": " + std::strerror(-result);
        return Status::kIo;
    }
    return Status::kOk;
}

Status SinkMavlink::open_serial(std::string& problem) {
    fd_ = io_.open(options_.serial.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    if (fd_ < 0) {
        problem = "mavlink: " + options_.serial + ": cannot be opened: " + std::strerror(-fd_);
        return fd_ == -ENOENT || fd_ == -ENODEV || fd_ == -ENXIO ? Status::kNotFound : Status::kIo;
    }
    // termios2 accepts any baud rate as a number. Raw mode: bytes are sent unchanged.
    termios2 line{};
    int result = io_.ioctl(fd_, TCGETS2, &line);
    if (result >= 0) {
        line.c_iflag = IGNBRK | IGNPAR;
        line.c_oflag = 0;
        line.c_lflag = 0;
        line.c_cflag = static_cast<tcflag_t>(CS8 | CREAD | CLOCAL | BOTHER);
        line.c_ispeed = line.c_ospeed = static_cast<speed_t>(options_.baud);
        result = io_.ioctl(fd_, TCSETS2, &line);
    }
    if (result < 0) {
        problem = "mavlink: " + options_.serial + ": " +
                  (result == -ENOTTY ? std::string("not a serial line") : std::string(std::strerror(-result)));
        return result == -ENOTTY ? Status::kInvalidArgument : Status::kIo;
    }
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
    if (result >= 0 || result == -EAGAIN || result == -ENOBUFS) {
        return Status::kFull;
    }
    if (!options_.serial.empty() && fd_ >= 0) {
        close();  // unplugged
        retry_.close(clock_.now());
    }
    return Status::kIo;
}

Status SinkMavlink::send(const Odometry& odometry) {
    if (fd_ < 0 && !options_.serial.empty() && retry_.pass(clock_.now())) {
        std::string unused;
        (void)open(unused);  // if it fails, so does the write below, which is counted
    }
    if (clock_.now() >= next_heartbeat_) {
        next_heartbeat_ = clock_.now() + options_.heartbeat_period;
        encode_heartbeat(options_.address, sequence_++, frame_);
        (void)write();  // a failure is counted, and shows in the odometry's own status
    }
    FACET_TRY(encode_odometry(odometry, options_.address, sequence_, frame_));
    ++sequence_;
    return write();
}

}  // namespace facet
