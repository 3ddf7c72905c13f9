// SPDX-License-Identifier: BSD-2-Clause
// A kernel with one CAN interface whose frames a test writes.
#pragma once

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <cstring>
#include <ctime>
#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "drivers/common/can_frame.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

/// Filters frames and stamps them as SocketCAN does. Waiting moves the clock.
class FakeCanBus final : public FakeKernel {
public:
    static constexpr int kFd = 7;

    explicit FakeCanBus(ManualClock& clock) : clock_(clock) {}

    void push(const CanFrame& frame) {
        if (!frame.error && !passes(frame)) {
            ++filtered_out;
            return;
        }
        if (is_open && up) {
            queue_.push_back(frame);
        }
    }

    std::string interface = "can0";
    bool present = true;
    bool up = true;
    bool stamps = true;
    bool hardware_stamps = false;
    bool odd_size = false;  ///< the next frame arrives truncated
    std::uint32_t overflows = 0;
    bool takes_fd = false;                                       ///< the interface is set up for CAN FD
    std::size_t room = std::numeric_limits<std::size_t>::max();  ///< frames that the queue takes before it is full

    bool is_open = false;
    bool fd_enabled = false;
    int stamping_flags = 0;
    int filtered_out = 0;
    int opened = 0;
    std::vector<CanFrame> sent;

    int socket(int domain, int, int protocol) override {
        if (domain != PF_CAN || protocol != CAN_RAW) {
            return -EAFNOSUPPORT;
        }
        is_open = true;
        ++opened;
        return kFd;
    }
    int close(int fd) override {
        is_open = is_open && fd != kFd;
        queue_.clear();
        return 0;
    }
    int ioctl(int, unsigned long request, void* argument) override {
        auto& interface_request = *static_cast<ifreq*>(argument);
        if (request == SIOCGIFMTU) {
            interface_request.ifr_mtu = takes_fd ? CANFD_MTU : CAN_MTU;
            return 0;
        }
        if (request != SIOCGIFINDEX || !present || interface != static_cast<char*>(interface_request.ifr_name)) {
            return -ENODEV;
        }
        interface_request.ifr_ifindex = 3;
        return 0;
    }
    int set_option(int, int level, int name, const void* value, std::size_t size) override {
        if (level == SOL_CAN_RAW && name == CAN_RAW_FILTER) {
            filters_.resize(size / sizeof(can_filter));
            if (size > 0) {
                std::memcpy(filters_.data(), value, size);
            }
            is_deaf_ = size == 0;
        } else if (level == SOL_CAN_RAW && name == CAN_RAW_FD_FRAMES) {
            fd_enabled = true;
        } else if (level == SOL_SOCKET && name == SO_TIMESTAMPING) {
            std::memcpy(&stamping_flags, value, sizeof stamping_flags);
        }
        return 0;
    }
    int bind(int, const void* address, std::size_t) override {
        sockaddr_can can{};
        std::memcpy(&can, address, sizeof can);
        return can.can_ifindex == 3 ? 0 : -EINVAL;
    }
    int wait_readable(int fd, Duration timeout) override {
        if (fd != kFd || !is_open) {
            return -EBADF;
        }
        if (!queue_.empty() || !up) {
            return 1;
        }
        clock_.advance(timeout);
        return 0;
    }
    std::int64_t write(int fd, const void* buffer, std::size_t size) override {
        if (fd != kFd || !is_open) {
            return -EBADF;
        }
        if (!up) {
            return -ENETDOWN;
        }
        if (size != CAN_MTU && (size != CANFD_MTU || !fd_enabled)) {
            return -EINVAL;
        }
        if (room == 0) {
            return -ENOBUFS;
        }
        --room;
        canfd_frame raw{};
        std::memcpy(&raw, buffer, size);
        CanFrame frame;
        frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
        frame.id = raw.can_id & CAN_EFF_MASK;
        frame.fd = size == CANFD_MTU;
        frame.bit_rate_switch = (raw.flags & CANFD_BRS) != 0;
        frame.length = raw.len;
        std::memcpy(frame.bytes.data(), raw.data, raw.len);
        sent.push_back(frame);
        return static_cast<std::int64_t>(size);
    }
    std::int64_t receive(int, ::msghdr& message) override {
        if (!up) {
            return -ENETDOWN;
        }
        if (queue_.empty()) {
            return -EAGAIN;
        }
        const CanFrame frame = queue_.front();
        queue_.pop_front();
        canfd_frame raw{};
        raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.error ? CAN_ERR_FLAG : 0U);
        raw.len = frame.length;
        std::memcpy(raw.data, frame.bytes.data(), frame.length);
        std::memcpy(message.msg_iov[0].iov_base, &raw, sizeof raw);
        add_control(message, frame);
        const std::int64_t size = frame.fd ? CANFD_MTU : CAN_MTU;
        const std::int64_t cut = odd_size ? 3 : 0;
        odd_size = false;
        return size - cut;
    }

private:
    bool passes(const CanFrame& frame) const {
        const std::uint32_t id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U);
        for (const can_filter& filter : filters_) {
            if ((id & filter.can_mask) == (filter.can_id & filter.can_mask)) {
                return true;
            }
        }
        return filters_.empty() && !is_deaf_;
    }
    void add_control(::msghdr& message, const CanFrame& frame) const {
        cmsghdr* header = CMSG_FIRSTHDR(&message);
        if (stamps) {
            std::array<timespec, 3> ts{};
            ts[0] = {static_cast<std::time_t>(frame.stamp.ns / 1'000'000'000),
                     static_cast<long>(frame.stamp.ns % 1'000'000'000)};
            if (hardware_stamps) {
                ts[2] = {42, static_cast<long>(frame.stamp.ns % 1'000'000'000)};
            }
            header->cmsg_level = SOL_SOCKET;
            header->cmsg_type = SO_TIMESTAMPING;
            header->cmsg_len = CMSG_LEN(sizeof ts);
            std::memcpy(CMSG_DATA(header), ts.data(), sizeof ts);
            header = CMSG_NXTHDR(&message, header);
        }
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SO_RXQ_OVFL;
        header->cmsg_len = CMSG_LEN(sizeof overflows);
        std::memcpy(CMSG_DATA(header), &overflows, sizeof overflows);
        message.msg_controllen = (stamps ? CMSG_SPACE(sizeof(timespec) * 3) : 0) + CMSG_SPACE(sizeof overflows);
    }

    ManualClock& clock_;
    std::deque<CanFrame> queue_;
    std::vector<can_filter> filters_;
    bool is_deaf_ = false;  ///< an empty list of filters was set
};

inline CanFrame make_frame(std::uint32_t id, bool extended, std::initializer_list<int> bytes,
                           std::int64_t stamp_ns = 0) {
    CanFrame frame;
    frame.id = id;
    frame.extended = extended;
    for (const int byte : bytes) {
        frame.bytes[frame.length++] = static_cast<std::uint8_t>(byte);
    }
    frame.stamp.ns = stamp_ns;
    return frame;
}

}  // namespace facet::test
