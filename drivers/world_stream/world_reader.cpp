// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/world_stream/world_reader.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace facet {

WorldDecoder::WorldDecoder() { message_.reserve(kWorldHeaderBytes + kMaxWorldPayload); }

Status WorldDecoder::add(std::span<const std::uint8_t> bytes) {
    bool any = false;
    while (!bytes.empty() && !is_corrupt_) {
        std::size_t whole = kWorldHeaderBytes;
        if (message_.size() >= kWorldHeaderBytes) {
            std::size_t payload = 0;
            is_corrupt_ = !ok(world_payload_bytes(message_, payload));
            whole += payload;
        }
        const std::size_t part = is_corrupt_ ? 0 : std::min(bytes.size(), whole - message_.size());
        message_.insert(message_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(part));
        bytes = bytes.subspan(part);
        if (part == 0 || whole == kWorldHeaderBytes || message_.size() < whole) {
            continue;
        }
        const std::uint64_t before = state_.sequence;
        const Status status = apply_world(message_, state_);
        message_.clear();
        is_corrupt_ = status == Status::kCorrupt;
        out_of_order_ += status == Status::kOutOfOrder ? 1 : 0;
        if (ok(status)) {
            missed_ += before == 0 ? 0 : state_.sequence - before - 1;
            any = true;
        }
    }
    return is_corrupt_ ? Status::kCorrupt : any ? Status::kOk : Status::kNotReady;
}

Status WorldReader::open(const std::string& path) {
    close();
    decoder_ = WorldDecoder();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof(address.sun_path)) {
        return Status::kInvalidArgument;
    }
    std::copy(path.begin(), path.end(), std::begin(address.sun_path));
    socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (socket_ < 0 || ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
        close();
        return Status::kIo;
    }
    return Status::kOk;
}

void WorldReader::close() {
    if (socket_ >= 0) {
        (void)::close(socket_);
        socket_ = -1;
    }
}

Status WorldReader::wait(int timeout_ms) {
    Status status = Status::kNotReady;
    constexpr int kMaxReads = 64;  // of 64 kB: a writer that never pauses does not keep the caller here
    for (int i = 0; i < kMaxReads; ++i) {
        pollfd ready{socket_, POLLIN, 0};
        const int count = ::poll(&ready, 1, i == 0 ? timeout_ms : 0);
        if (count < 0 && errno != EINTR) {
            return Status::kIo;
        }
        if (count <= 0) {
            return status;
        }
        std::array<std::uint8_t, 65536> bytes{};
        const ssize_t got = ::recv(socket_, bytes.data(), bytes.size(), 0);
        if (got <= 0) {
            return ok(status) ? status : got == 0 ? Status::kEndOfStream : Status::kIo;
        }
        const Status added = decoder_.add(std::span(bytes).first(static_cast<std::size_t>(got)));
        if (added == Status::kCorrupt) {
            return added;
        }
        status = ok(added) ? added : status;
    }
    return status;
}

}  // namespace facet
