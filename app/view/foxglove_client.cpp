// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/foxglove_client.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

namespace facet {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using nlohmann::json;

constexpr std::array kProtocols{"foxglove.websocket.v1", "foxglove.sdk.v1"};
/// The desktop's pages are files.
constexpr std::array kOrigins{"https://app.foxglove.dev", "https://studio.foxglove.dev", "file://"};
/// First bytes of binary messages to the client.
constexpr std::uint8_t kMessageData = 1;
constexpr std::uint8_t kTimeData = 2;
constexpr int kWarning = 1;  ///< level of a status

/// Large, and of interest only if new.
bool is_bulky(std::size_t lane) {
    const auto topic = static_cast<FoxgloveTopic>(lane);
    return topic == FoxgloveTopic::kPath || topic == FoxgloveTopic::kMesh || topic == FoxgloveTopic::kPlanes ||
           topic == FoxgloveTopic::kImage;
}

/// Little-endian.
template <class Unsigned>
void put(std::span<std::uint8_t> to, Unsigned value) {
    for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
        to[i] = static_cast<std::uint8_t>(value >> (8U * i));
    }
}

std::uint64_t time_of(Timestamp stamp) { return static_cast<std::uint64_t>(std::max<std::int64_t>(stamp.ns, 0)); }

/// A member that is an unsigned number of 32 bits.
std::optional<std::uint32_t> number_in(const json& object, const char* name) {
    if (!object.is_object() || !object.contains(name) || !object[name].is_number_unsigned()) {
        return std::nullopt;
    }
    const auto value = object[name].get<std::uint64_t>();
    return value <= UINT32_MAX ? std::optional(static_cast<std::uint32_t>(value)) : std::nullopt;
}

}  // namespace

std::string FoxgloveClient::protocol_of(const Request& request) {
    http::token_list offered{request[http::field::sec_websocket_protocol]};
    for (const char* const protocol : kProtocols) {
        if (offered.exists(protocol)) {
            return protocol;
        }
    }
    return "";
}

bool FoxgloveClient::is_foxglove(beast::string_view origin) {
    return std::ranges::any_of(kOrigins, [&](const char* known) { return origin == known; });
}

FoxgloveClient::FoxgloveClient(Stream stream, Request request, FoxgloveSource& source)
    : source_(source), stream_(std::move(stream)), request_(std::move(request)), sender_(stream_, [this] { end(); }) {}

FoxgloveClient::~FoxgloveClient() { end(); }

void FoxgloveClient::start() {
    stream_.set_option(
        websocket::stream_base::decorator([protocol = protocol_of(request_)](websocket::response_type& response) {
            response.set(http::field::sec_websocket_protocol, protocol);
        }));
    stream_.read_message_max(kMaxFromClient);
    stream_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
        if (error) {
            return;
        }
        self->is_open_ = true;
        self->source_.count_client();
        self->say(self->source_.greeting());
        self->say(self->source_.channels());
        self->listen();
    });
}

void FoxgloveClient::listen() {
    stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
        if (error) {
            self->end();
            return;
        }
        if (self->stream_.got_text()) {
            self->answer(beast::buffers_to_string(self->buffer_.data()));
        } else {
            self->complain("binary messages are not taken");
        }
        self->buffer_.consume(self->buffer_.size());
        self->listen();
    });
}

void FoxgloveClient::answer(const std::string& text) {
    const json message = json::parse(text, nullptr, false);
    if (!message.is_object() || !message.contains("op") || !message["op"].is_string()) {
        complain("not a message of the protocol: no JSON object with an op");
        return;
    }
    const auto op = message["op"].get<std::string>();
    const char* const list = op == "subscribe" ? "subscriptions" : "subscriptionIds";
    if (op != "subscribe" && op != "unsubscribe") {
        complain("only subscribe and unsubscribe are served");
    } else if (!message.contains(list) || !message[list].is_array()) {
        complain(op + " needs a list of " + list);
    } else {
        for (const json& entry : message[list]) {
            op == "subscribe" ? subscribe(entry) : unsubscribe(entry);
        }
    }
}

void FoxgloveClient::subscribe(const json& wanted) {
    const std::optional<std::uint32_t> id = number_in(wanted, "id");
    const std::optional<std::uint32_t> channel = number_in(wanted, "channelId");
    if (!id || !channel || *channel < 1 || *channel > kFoxgloveTopics) {
        complain("a subscription needs an id and the channelId of a channel that is advertised");
        return;
    }
    const std::size_t topic = *channel - 1;
    if (subscriptions_[topic] || std::ranges::find(subscriptions_, id) != subscriptions_.end()) {
        complain("there is a subscription to this channel, or with this id, already");
        return;
    }
    subscriptions_[topic] = id;
    source_.count_subscription(static_cast<FoxgloveTopic>(topic), 1);
    if (const SharedFoxgloveMessage newest = source_.newest(static_cast<FoxgloveTopic>(topic))) {
        push(newest);
    }
}

void FoxgloveClient::unsubscribe(const json& id) {
    if (id.is_number_unsigned()) {
        for (std::size_t topic = 0; topic < kFoxgloveTopics; ++topic) {
            if (subscriptions_[topic] && *subscriptions_[topic] == id.get<std::uint64_t>()) {
                subscriptions_[topic].reset();
                source_.count_subscription(static_cast<FoxgloveTopic>(topic), -1);
                sender_.drop(topic);
                return;
            }
        }
    }
    complain("there is no such subscription");
}

void FoxgloveClient::say(std::string text) {
    if (sender_.waiting(kText) < kDeep) {
        enqueue({.lane = kText, .is_binary = false, .body = std::make_shared<const std::string>(std::move(text))});
    }
}

void FoxgloveClient::complain(const std::string& text) {
    say(json{{"op", "status"}, {"level", kWarning}, {"message", text}}.dump());
}

void FoxgloveClient::push(const SharedFoxgloveMessage& message) {
    const auto lane = static_cast<std::size_t>(message->topic);
    if (!is_open_ || !subscriptions_[lane]) {
        return;
    }
    BoundedSender::Message waiting{
        .lane = lane, .head_size = BoundedSender::kMaxHead, .body = {message, &message->body}};
    const std::span<std::uint8_t> head(waiting.head);
    head[0] = kMessageData;
    put(head.subspan(1), *subscriptions_[lane]);
    put(head.subspan(5), time_of(message->stamp));
    enqueue(std::move(waiting));
}

void FoxgloveClient::push_time(Timestamp now) {
    BoundedSender::Message waiting{.lane = kTime, .head_size = 9};
    const std::span<std::uint8_t> head(waiting.head);
    head[0] = kTimeData;
    put(head.subspan(1), time_of(now));
    enqueue(std::move(waiting));
}

std::size_t FoxgloveClient::depth_of(std::size_t lane) { return lane == kTime || is_bulky(lane) ? 1 : kDeep; }

void FoxgloveClient::enqueue(BoundedSender::Message message) {
    const std::size_t lane = message.lane;
    if (is_open_ && sender_.put(std::move(message), depth_of(lane), shared_from_this()) && lane != kTime) {
        source_.count_replaced();
    }
}

void FoxgloveClient::end() {
    is_open_ = false;
    sender_.drop_all();
    for (std::size_t topic = 0; topic < kFoxgloveTopics; ++topic) {
        if (subscriptions_[topic]) {
            subscriptions_[topic].reset();
            source_.count_subscription(static_cast<FoxgloveTopic>(topic), -1);
        }
    }
}

}  // namespace facet
