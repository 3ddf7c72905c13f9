// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/service_notifier.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <charconv>
#include <cstddef>
#include <cstring>

namespace facet {
namespace {

std::optional<std::int64_t> parse(const std::string& text) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool good = error == std::errc{} && end == text.data() + text.size();
    return good ? std::optional<std::int64_t>(value) : std::nullopt;
}

}  // namespace

ServiceNotifier::ServiceNotifier(KernelIo& io, const Clock& clock, const std::string& socket,
                                 const std::string& watchdog_us, const std::string& watchdog_pid, int own_pid)
    : io_(io), clock_(clock), next_feed_(clock.now()) {
    sockaddr_un address{};
    if (socket.empty() || socket.size() >= sizeof address.sun_path) {
        return;
    }
    if (const auto us = parse(watchdog_us); us && *us > 0 && (watchdog_pid.empty() || parse(watchdog_pid) == own_pid)) {
        watchdog_ = Duration{*us * 1000};
    }
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, socket.data(), socket.size());
    if (address.sun_path[0] == '@') {
        address.sun_path[0] = '\0';
    }
    fd_ = io_.socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    // An abstract name has no terminating zero: its length counts.
    const std::size_t size = offsetof(sockaddr_un, sun_path) + socket.size() + (socket[0] == '@' ? 0 : 1);
    if (fd_ >= 0 && io_.connect(fd_, &address, size) < 0) {
        (void)io_.close(fd_);
        fd_ = -1;
    }
}

ServiceNotifier::~ServiceNotifier() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
}

void ServiceNotifier::send(const std::string& text) {
    if (fd_ >= 0) {
        (void)io_.write(fd_, text.data(), text.size());
    }
}

void ServiceNotifier::feed() {
    if (!watchdog_ || clock_.now() < next_feed_) {
        return;
    }
    next_feed_ = clock_.now() + Duration{watchdog_->ns / 4};
    send("WATCHDOG=1");
}

}  // namespace facet
