// SPDX-License-Identifier: BSD-2-Clause
// Messages on their way to a client that may be slow.
#pragma once

#include <array>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace facet {

/// Sends in the order of arrival, one message at a time. Of each lane a few wait; what is more replaces the oldest of
/// its lane. Bound to the server's thread. Heap.
class BoundedSender {
public:
    using Stream = boost::beast::websocket::stream<boost::beast::tcp_stream>;
    static constexpr std::size_t kMaxHead = 13;

    struct Message {
        std::size_t lane = 0;
        bool is_binary = true;
        std::array<std::uint8_t, kMaxHead> head{};  ///< before the body
        std::size_t head_size = 0;
        std::shared_ptr<const std::string> body{};  ///< may be null
    };

    /// @param stream   borrowed
    /// @param on_error  called when a message could not be sent
    BoundedSender(Stream& stream, std::function<void()> on_error) : stream_(stream), on_error_(std::move(on_error)) {}

    /// Messages of a lane that wait.
    std::size_t waiting(std::size_t lane) const;
    /// @param depth  most messages of its lane that may wait: at least one
    /// @param owner  of stream and sender, kept for as long as something is under way
    /// @return whether an older one was replaced
    bool put(Message message, std::size_t depth, const std::shared_ptr<void>& owner);
    /// Forgets what waits of a lane, or everything.
    void drop(std::size_t lane);
    void drop_all() { waiting_.clear(); }

private:
    void send(const std::shared_ptr<void>& owner);

    Stream& stream_;
    std::function<void()> on_error_;
    std::deque<Message> waiting_;
    std::optional<Message> under_way_;
};

}  // namespace facet
