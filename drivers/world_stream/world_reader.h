// SPDX-License-Identifier: BSD-2-Clause
// The planner's end of the world stream. Needs the standard library and POSIX only.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/world_stream/world_message.h"

namespace facet {

/// Puts messages together from bytes as they come, cut anywhere, and keeps the state that they describe. Thread-bound.
/// Heap in the constructor only.
class WorldDecoder {
public:
    WorldDecoder();
    /// @return kOk if the state is newer now; kNotReady if no message has applied; kCorrupt: these bytes are no such
    /// stream, or belong to another version, and nothing more is taken from it
    Status add(std::span<const std::uint8_t> bytes);

    const WorldState& state() const { return state_; }
    /// Keyframes whose own state was never seen here: the reader, or the stream's thread, was too slow.
    std::uint64_t missed() const { return missed_; }
    /// Whole messages that did not apply to the state: after one, the next snapshot is waited for.
    std::uint64_t out_of_order() const { return out_of_order_; }

private:
    WorldState state_;
    std::vector<std::uint8_t> message_;  ///< what has come of it
    bool is_corrupt_ = false;
    std::uint64_t missed_ = 0;
    std::uint64_t out_of_order_ = 0;
};

/// Reads from the socket of `facet run --stream PATH`. Usage:
///   WorldReader reader;
///   if (ok(reader.open(path))) while (...) { const Status s = reader.wait(100); if (ok(s)) use(reader.state()); ... }
/// Thread-bound.
class WorldReader {
public:
    WorldReader() = default;
    ~WorldReader() { close(); }
    WorldReader(const WorldReader&) = delete;
    WorldReader& operator=(const WorldReader&) = delete;

    /// Restarts with no state. @return kIo if nobody listens there; kInvalidArgument if the path is too long
    Status open(const std::string& path);
    void close();
    /// Takes what has come, or waits for it. @return kOk if the state is newer now; kNotReady if it is not;
    /// kEndOfStream if the other end has closed; kCorrupt, kIo: close, and open again
    Status wait(int timeout_ms);

    const WorldState& state() const { return decoder_.state(); }
    std::uint64_t missed() const { return decoder_.missed(); }

private:
    int socket_ = -1;
    WorldDecoder decoder_;
};

}  // namespace facet
