// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/can_socket.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace facet {
namespace {

constexpr std::size_t kMaxFilters = 32;

/// What SO_TIMESTAMPING hands over: software, a legacy field, hardware.
struct Stamps {
    std::array<timespec, 3> ts;
};

Timestamp to_timestamp(const timespec& t) { return {static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec}; }

}  // namespace

Status CanSocket::fail(const char* what, int result, std::string& problem) {
    error_ = -result;
    problem = interface_ + ": " + what + ": " + std::strerror(-result);
    close();
    return result == -ENODEV || result == -ENXIO ? Status::kNotFound : Status::kIo;
}

Status CanSocket::open(const CanSocketOptions& options, std::span<const CanFilter> filters, std::string& problem) {
    close();
    interface_ = options.interface;
    hardware_stamps_ = options.hardware_stamps;
    overflows_ = 0;
    if (options.interface.empty() || options.interface.size() >= IFNAMSIZ || filters.size() > kMaxFilters) {
        problem = "'" + options.interface + "' is not a valid CAN interface name";
        return Status::kInvalidArgument;
    }
    const int fd = io_.socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK, CAN_RAW);
    if (fd < 0) {
        return fail("no CAN sockets in this kernel", fd, problem);
    }
    fd_ = fd;
    return set_up(options, filters, problem);
}

Status CanSocket::set_up(const CanSocketOptions& options, std::span<const CanFilter> filters, std::string& problem) {
    const auto set = [&](int level, int name, const void* value, std::size_t size) {
        return io_.set_option(fd_, level, name, value, size);
    };
    ifreq request{};
    std::memcpy(static_cast<char*>(request.ifr_name), options.interface.data(), options.interface.size());
    int result = io_.ioctl(fd_, SIOCGIFINDEX, &request);
    if (result < 0) {
        return fail("no such interface", result, problem);
    }
    is_fd_ = options.fd || (options.fd_if_there && takes_fd(request));
    const int on = 1;
    if (is_fd_) {
        result = set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
        if (result < 0) {
            return fail("CAN FD is not supported", result, problem);
        }
    }
    std::array<can_filter, kMaxFilters> kernel_filters{};
    std::transform(filters.begin(), filters.end(), kernel_filters.begin(), [](const CanFilter& f) {
        // Format and "data frame" are part of what is compared.
        return can_filter{f.value | (f.extended ? CAN_EFF_FLAG : 0U), f.mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
    });
    if (!filters.empty() || !options.receives) {  // no filter at all lets nothing pass
        result = set(SOL_CAN_RAW, CAN_RAW_FILTER, kernel_filters.data(), filters.size() * sizeof(can_filter));
        if (result < 0) {
            return fail("filter refused", result, problem);
        }
    }
    const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_TX_TIMEOUT;
    result = set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
    if (result < 0) {
        return fail("error frames cannot be enabled", result, problem);
    }
    const int stamping = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE |
                         (hardware_stamps_ ? SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE : 0);
    result = set(SOL_SOCKET, SO_TIMESTAMPING, &stamping, sizeof stamping);
    if (result < 0) {
        return fail("time stamps cannot be enabled", result, problem);
    }
    // For diagnosis only: older kernels may lack it.
    (void)set(SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = request.ifr_ifindex;
    result = io_.bind(fd_, &address, sizeof address);
    return result < 0 ? fail("cannot bind", result, problem) : Status::kOk;
}

bool CanSocket::takes_fd(ifreq interface) const {
    return io_.ioctl(fd_, SIOCGIFMTU, &interface) == 0 && interface.ifr_mtu == static_cast<int>(CANFD_MTU);
}

void CanSocket::close() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
        fd_ = -1;
    }
}

Status CanSocket::send(const CanFrame& frame) {
    if (frame.fd && !is_fd_) {
        return Status::kInvalidArgument;
    }
    canfd_frame raw{};
    raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U);
    raw.len = frame.length;
    raw.flags = frame.fd && frame.bit_rate_switch ? CANFD_BRS : 0;
    std::copy_n(frame.bytes.begin(), frame.length, static_cast<std::uint8_t*>(raw.data));
    const std::size_t size = frame.fd ? CANFD_MTU : CAN_MTU;
    const std::int64_t written = fd_ < 0 ? -EBADF : io_.write(fd_, &raw, size);
    if (written == -EAGAIN || written == -ENOBUFS) {
        return Status::kFull;
    }
    if (written < 0) {
        error_ = static_cast<int>(-written);
        return Status::kIo;
    }
    return Status::kOk;
}

Status CanSocket::receive(Duration timeout, CanFrame& frame) {
    const int ready = fd_ < 0 ? -EBADF : io_.wait_readable(fd_, timeout);
    if (ready == 0) {
        return Status::kNotReady;
    }
    canfd_frame raw{};
    iovec part{&raw, sizeof raw};
    alignas(cmsghdr) std::array<char, 256> control{};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const std::int64_t size = ready < 0 ? ready : io_.receive(fd_, message);
    if (size == -EAGAIN) {
        return Status::kNotReady;
    }
    if (size < 0) {
        error_ = static_cast<int>(-size);
        return Status::kIo;
    }
    if ((size != CAN_MTU && size != CANFD_MTU) || raw.len > (size == CAN_MTU ? CAN_MAX_DLEN : CANFD_MAX_DLEN)) {
        return Status::kCorrupt;
    }
    CanFrame received;
    received.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
    received.error = (raw.can_id & CAN_ERR_FLAG) != 0;
    received.id = raw.can_id & (received.error ? CAN_ERR_MASK : (received.extended ? CAN_EFF_MASK : CAN_SFF_MASK));
    received.fd = size == CANFD_MTU;
    received.length = raw.len;
    std::copy_n(raw.data, raw.len, received.bytes.begin());
    for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
        if (header->cmsg_level == SOL_SOCKET && header->cmsg_type == SO_TIMESTAMPING) {
            Stamps stamps{};
            std::memcpy(&stamps, CMSG_DATA(header), sizeof stamps);
            const Timestamp hardware = to_timestamp(stamps.ts[2]);
            received.stamp = hardware_stamps_ && hardware.ns != 0 ? hardware : to_timestamp(stamps.ts[0]);
        } else if (header->cmsg_level == SOL_SOCKET && header->cmsg_type == SO_RXQ_OVFL) {
            std::memcpy(&overflows_, CMSG_DATA(header), sizeof overflows_);
        }
    }
    frame = received;
    return Status::kOk;
}

}  // namespace facet
