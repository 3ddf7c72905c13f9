// SPDX-License-Identifier: BSD-2-Clause
// One client of Foxglove's WebSocket protocol.
#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/foxglove/schemas.h"
#include "app/view/bounded_sender.h"
#include "platform/base/timestamp.h"

namespace facet {

/// A message of a topic, made once for all clients.
struct FoxgloveMessage {
    FoxgloveTopic topic = FoxgloveTopic::kPose;
    Timestamp stamp;
    std::string body;
};
using SharedFoxgloveMessage = std::shared_ptr<const FoxgloveMessage>;

/// What a client needs of the hub, which outlives it.
class FoxgloveSource {
public:
    virtual const std::string& greeting() const = 0;  ///< the protocol's serverInfo
    virtual const std::string& channels() const = 0;  ///< its advertise: channel n + 1 is topic n
    /// What a new subscriber is given at once; null: nothing.
    virtual SharedFoxgloveMessage newest(FoxgloveTopic topic) = 0;
    virtual void count_subscription(FoxgloveTopic topic, int change) = 0;
    virtual void count_replaced() = 0;
    virtual void count_client() = 0;

protected:
    ~FoxgloveSource() = default;
};

/// Speaks foxglove.websocket.v1, or foxglove.sdk.v1, which is the same as far as this server goes: serverInfo,
/// advertise, subscribe, unsubscribe, message data, time and status. One message is under way; of each topic kDeep
/// small messages wait, or the newest large one, and what is older is replaced. Lives as long as its connection. Bound
/// to the server's thread. Heap.
class FoxgloveClient : public std::enable_shared_from_this<FoxgloveClient> {
public:
    using Stream = BoundedSender::Stream;
    using Request = boost::beast::http::request<boost::beast::http::empty_body>;
    static constexpr std::size_t kDeep = 64;
    static constexpr std::size_t kMaxFromClient = 65'536;  ///< bytes of a message

    /// The protocol that a request asks for, "" if none of ours.
    static std::string protocol_of(const Request& request);
    /// Whether a page's origin is Foxglove's, in the web or on the desktop.
    static bool is_foxglove(boost::beast::string_view origin);

    /// @param stream  with its timeouts set
    FoxgloveClient(Stream stream, Request request, FoxgloveSource& source);
    ~FoxgloveClient();
    FoxgloveClient(const FoxgloveClient&) = delete;
    FoxgloveClient& operator=(const FoxgloveClient&) = delete;
    void start();

    /// If the client has subscribed to its topic.
    void push(const SharedFoxgloveMessage& message);
    /// The time that the client takes for now.
    void push_time(Timestamp now);

private:
    /// What replaces what: messages of one topic, the time, and texts, of which the newest are left out instead.
    static constexpr std::size_t kTime = kFoxgloveTopics;
    static constexpr std::size_t kText = kFoxgloveTopics + 1;

    static std::size_t depth_of(std::size_t lane);

    void listen();
    void answer(const std::string& text);
    void subscribe(const nlohmann::json& wanted);
    void unsubscribe(const nlohmann::json& id);
    void say(std::string text);
    void complain(const std::string& text);
    void enqueue(BoundedSender::Message message);
    void end();

    FoxgloveSource& source_;
    Stream stream_;
    Request request_;
    boost::beast::flat_buffer buffer_;
    bool is_open_ = false;
    std::array<std::optional<std::uint32_t>, kFoxgloveTopics> subscriptions_{};  ///< their ids, which the client chose
    BoundedSender sender_;
};

}  // namespace facet
