// SPDX-License-Identifier: BSD-2-Clause
// One connection to the live view.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/view/bounded_sender.h"
#include "app/view/foxglove_hub.h"
#include "app/view/live_surface.h"

namespace facet {

/// What all browsers are given, made once.
struct ViewMessage {
    bool is_binary = false;
    std::string body;
};
using SharedMessage = std::shared_ptr<const ViewMessage>;

/// What a connection needs of the server; it outlives all of them.
struct ViewSource {
    std::string page;
    std::string token;          ///< empty: none is asked for
    SharedMessage hello;        ///< the first message
    SharedMessage newest_mesh;  ///< none before the first
    std::atomic<std::uint64_t> replaced{0};
    std::atomic<std::uint64_t> viewers{0};
    std::atomic<int> watching{0};      ///< viewers whose WebSocket is open
    std::chrono::milliseconds idle{};  ///< a WebSocket whose other end gives no sign of life for so long is closed
    std::size_t places = 0;            ///< of WebSockets
    std::size_t taken = 0;             ///< of these, by viewers
    LiveSurface surface;
    FoxgloveHub foxglove;

    bool has_place() { return taken + foxglove.clients() < places; }
};

/// Answers one request: the page, or a browser's WebSocket, which stays; one of Foxglove's goes to the hub. It takes
/// one of the places only once it has been let in as a WebSocket: until then it is a stranger, who can be turned away.
/// Lives as long as something is under way. Bound to the server's thread. Heap.
class Viewer : public std::enable_shared_from_this<Viewer> {
public:
    Viewer(boost::asio::ip::tcp::socket socket, ViewSource& source);
    void start();
    ~Viewer();
    bool is_stranger() const { return !has_place_; }
    const boost::asio::ip::address& address() const { return address_; }
    /// Ends the connection of a stranger.
    void turn_away() { stream_.next_layer().close(); }
    /// The newest frame, and the newest mesh and picture or null. Replaces what still waits; nothing if there is no
    /// WebSocket.
    void push(const SharedMessage& frame, const SharedMessage& mesh, const SharedMessage& picture);
    /// Some of the surface that has changed, if none waits to be sent.
    void push_surface();

private:
    bool may_connect() const;
    void answer();
    void reply(boost::beast::http::status status, const char* type, std::string body);
    void begin_live();
    void listen();
    void send(std::size_t lane, const SharedMessage& message);
    void end_live();

    ViewSource& source_;
    boost::asio::ip::address address_;  ///< of the other end
    BoundedSender::Stream stream_;
    boost::beast::flat_buffer buffer_;
    std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
    boost::beast::http::response<boost::beast::http::string_body> response_;
    bool has_place_ = false;
    bool is_live_ = false;
    LiveSurface::Position surface_;  ///< that it has been sent
    BoundedSender sender_;
};

}  // namespace facet
