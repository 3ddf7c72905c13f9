// SPDX-License-Identifier: BSD-2-Clause
// The program's end of the world stream: a thread that writes to whoever has connected.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/world_stream/world_message.h"
#include "platform/base/status.h"

namespace facet {

/// Who may connect to the socket.
struct WorldAccess {
    std::string group;             ///< of the socket; empty: the program's
    std::optional<unsigned> mode;  ///< such as 0660: those who may write may connect; none: as the umask has it
};

/// Serves up to kMaxReaders on a local stream socket. Each gets a snapshot when it connects, and then what changes. Who
/// has not yet taken the last message when the next one is there misses that one, and gets a snapshot as soon as it has
/// taken what was begun. If this thread is late itself, it goes on with the newest state. The publishing side copies
/// nothing and never waits: three states are passed round without a lock. next() and publish() belong to one thread,
/// open() and close() to their owner's, outside of the time in which anything is published. Heap in the constructor and
/// in open() only.
class WorldServer {
public:
    static constexpr int kMaxReaders = 4;  ///< more are turned away

    WorldServer() = default;
    ~WorldServer() { close(); }
    WorldServer(const WorldServer&) = delete;
    WorldServer& operator=(const WorldServer&) = delete;

    /// Listens and starts the thread. A socket that is left there of a program that has ended is replaced.
    /// @return kInvalidArgument if the path is too long; kFull if somebody listens there already; kNotFound if there
    ///         is no such group; kIo, also if the socket cannot be given to the group
    Status open(const std::string& path, const WorldAccess& access = {});
    /// Sends the newest state to readers that take it within half a second, then ends. Removes the socket.
    void close();

    /// Where the next state is to be written: all but its sequence. It holds an older one. No heap.
    WorldState& next() { return slots_[writing_]; }
    /// Passes it on. No heap, no wait.
    void publish();

    /// Messages not sent because a reader was too slow. Thread-safe.
    std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

private:
    struct Reader {
        int socket = -1;
        std::vector<std::uint8_t> message;
        std::size_t sent = 0;  ///< bytes of it
        bool needs_snapshot = true;
        bool is_busy() const { return sent < message.size(); }
    };

    void serve();
    void accept_reader();
    void send_newest();
    void flush(Reader& reader);
    void part_with(Reader& reader);
    void listen_to(Reader& reader);
    bool is_busy() const;

    static constexpr unsigned kFresh = 4;  ///< flag in middle_: not yet taken

    std::string path_;
    int listener_ = -1;
    int event_ = -1;
    std::thread thread_;
    std::atomic<bool> stopping_{false};
    std::atomic<std::uint64_t> dropped_{0};
    std::array<WorldState, 3> slots_;
    unsigned writing_ = 0;  ///< of the publishing thread
    std::atomic<unsigned> middle_{1};
    unsigned reading_ = 2;               ///< of the serving thread
    std::uint64_t sequence_ = 0;         ///< of the publishing thread
    WorldState sent_;                    ///< of the serving thread
    std::vector<std::uint8_t> message_;  ///< of the serving thread
    std::array<Reader, kMaxReaders> readers_;
};

}  // namespace facet
