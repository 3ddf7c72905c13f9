// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/world_stream/world_server.h"

#include <grp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <optional>

namespace facet {
namespace {

void close_socket(int& socket) {
    if (socket >= 0) {
        (void)::close(socket);
        socket = -1;
    }
}

/// Whether a socket is there on which nobody accepts connections. To connect to a file is refused in the same way.
bool is_left_over(const sockaddr_un& address) {
    struct stat info {};
    if (::lstat(address.sun_path, &info) != 0 || !S_ISSOCK(info.st_mode)) {
        return false;
    }
    int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool is_refused =
        ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 && errno == ECONNREFUSED;
    close_socket(probe);
    return is_refused;
}

/// Number of a group of /etc/group. Not by getgrnam(), which asks whatever else the system names, by libraries that a
/// program linked statically must not load.
std::optional<gid_t> find_group(const std::string& name) {
    std::FILE* const file = std::fopen("/etc/group", "re");
    if (file == nullptr) {
        return std::nullopt;
    }
    std::optional<gid_t> number;
    for (const ::group* entry = nullptr; !number && (entry = ::fgetgrent(file)) != nullptr;) {
        number = name == entry->gr_name ? std::optional(entry->gr_gid) : std::nullopt;
    }
    (void)std::fclose(file);
    return number;
}

}  // namespace

Status WorldServer::open(const std::string& path, const WorldAccess& access) {
    const std::optional<gid_t> owner = access.group.empty() ? std::nullopt : find_group(access.group);
    if (!owner && !access.group.empty()) {
        return Status::kNotFound;
    }
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof(address.sun_path)) {
        return Status::kInvalidArgument;
    }
    std::copy(path.begin(), path.end(), std::begin(address.sun_path));
    const auto* const any_address = reinterpret_cast<const sockaddr*>(&address);
    listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    event_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (access.mode) {  // never wider than it is to be, not even for a moment
        (void)::fchmod(listener_, *access.mode);
    }
    int bound = ::bind(listener_, any_address, sizeof(address));
    if (bound != 0 && errno == EADDRINUSE) {
        if (!is_left_over(address)) {
            close();
            return Status::kFull;
        }
        (void)::unlink(path.c_str());
        bound = ::bind(listener_, any_address, sizeof(address));
    }
    if (bound == 0 && ((owner && ::chown(path.c_str(), static_cast<uid_t>(-1), *owner) != 0) ||
                       (access.mode && ::chmod(path.c_str(), *access.mode) != 0))) {
        (void)::unlink(path.c_str());
        bound = -1;
    }
    if (bound != 0 || event_ < 0 || ::listen(listener_, kMaxReaders) != 0) {
        close();
        return Status::kIo;
    }
    path_ = path;
    message_.reserve(kWorldHeaderBytes + kMaxWorldPayload);
    for (WorldState& state : slots_) {
        state.planes.reserve(kWorldPlanes);
    }
    sent_.planes.reserve(kWorldPlanes);
    for (Reader& reader : readers_) {
        reader.message.reserve(kWorldHeaderBytes + kMaxWorldPayload);
    }
    sequence_ = sent_.sequence = 0;
    writing_ = 0;
    middle_.store(1);
    reading_ = 2;
    stopping_.store(false);
    thread_ = std::thread([this] { serve(); });
    return Status::kOk;
}

void WorldServer::close() {
    if (thread_.joinable()) {
        stopping_.store(true, std::memory_order_release);
        (void)::eventfd_write(event_, 1);
        thread_.join();
        (void)::unlink(path_.c_str());
    }
    for (Reader& reader : readers_) {
        part_with(reader);
    }
    close_socket(listener_);
    close_socket(event_);
}

void WorldServer::publish() {
    slots_[writing_].sequence = ++sequence_;
    writing_ = middle_.exchange(writing_ | kFresh, std::memory_order_acq_rel) & ~kFresh;
    (void)::eventfd_write(event_, 1);
}

bool WorldServer::is_busy() const {
    return std::any_of(readers_.begin(), readers_.end(), [](const Reader& r) { return r.is_busy(); });
}

/// What the other end takes without waiting; if that is all, and it has missed something, a snapshot after it.
void WorldServer::flush(Reader& reader) {
    for (;;) {
        while (reader.is_busy()) {
            const ssize_t sent = ::send(reader.socket, reader.message.data() + reader.sent,
                                        reader.message.size() - reader.sent, MSG_NOSIGNAL | MSG_DONTWAIT);
            if (sent < 0) {
                if (errno != EAGAIN && errno != EINTR) {
                    part_with(reader);
                }
                return;
            }
            reader.sent += static_cast<std::size_t>(sent);
        }
        if (!reader.needs_snapshot || sent_.sequence == 0) {
            return;
        }
        reader.needs_snapshot = false;
        reader.sent = 0;
        encode_world(nullptr, sent_, reader.message);
    }
}

void WorldServer::part_with(Reader& reader) {
    close_socket(reader.socket);
    reader.message.clear();
    reader.sent = 0;
}

/// Readers have nothing to say: they take what is sent, or leave.
void WorldServer::listen_to(Reader& reader) {
    std::array<char, 256> said{};
    const ssize_t got = ::recv(reader.socket, said.data(), said.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
        part_with(reader);
    } else {
        flush(reader);
    }
}

void WorldServer::accept_reader() {
    int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0 && (errno == EMFILE || errno == ENFILE)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));  // whoever waits goes on waiting
    }
    const auto place = std::find_if(readers_.begin(), readers_.end(), [](const Reader& r) { return r.socket < 0; });
    if (socket < 0 || place == readers_.end()) {
        close_socket(socket);
        return;
    }
    place->socket = socket;
    place->needs_snapshot = true;
    flush(*place);
}

void WorldServer::send_newest() {
    if ((middle_.load(std::memory_order_acquire) & kFresh) == 0) {
        return;
    }
    reading_ = middle_.exchange(reading_, std::memory_order_acq_rel) & ~kFresh;
    const WorldState& state = slots_[reading_];
    if (sent_.sequence > 0) {
        encode_world(&sent_, state, message_);
    }
    sent_ = state;
    for (Reader& reader : readers_) {
        if (reader.socket < 0) {
            continue;
        }
        if (reader.is_busy()) {
            reader.needs_snapshot = true;
            dropped_.fetch_add(1, std::memory_order_relaxed);
        } else if (!reader.needs_snapshot) {
            reader.message = message_;
            reader.sent = 0;
        }
        flush(reader);
    }
}

void WorldServer::serve() {
    constexpr int kLastRounds = 10;
    constexpr int kLastWait_ms = 50;
    for (int rounds_left = kLastRounds; rounds_left > 0;) {
        const bool is_last = stopping_.load(std::memory_order_acquire);
        send_newest();
        if (is_last && (!is_busy() || --rounds_left == 0)) {
            return;
        }
        std::array<pollfd, kMaxReaders + 2> waits{};
        waits[0] = {listener_, POLLIN, 0};
        waits[1] = {event_, POLLIN, 0};
        for (std::size_t i = 0; i < kMaxReaders; ++i) {
            waits[i + 2] = {readers_[i].socket, static_cast<short>(readers_[i].is_busy() ? POLLOUT | POLLIN : POLLIN),
                            0};
        }
        (void)::poll(waits.data(), waits.size(), is_last ? kLastWait_ms : -1);
        eventfd_t count = 0;
        (void)::eventfd_read(event_, &count);
        for (std::size_t i = 0; i < kMaxReaders; ++i) {
            if (waits[i + 2].revents != 0 && readers_[i].socket >= 0) {
                listen_to(readers_[i]);
            }
        }
        if ((waits[0].revents & POLLIN) != 0) {
            accept_reader();
        }
    }
}

}  // namespace facet
