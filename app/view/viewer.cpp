// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/viewer.h"

#include <chrono>
#include <string_view>
#include <utility>

#include "app/view/view_messages.h"
#include "app/view/view_place.h"

namespace facet {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;

constexpr std::chrono::seconds kRequestTime{10};
constexpr std::uint32_t kMaxHeader = 8192;
constexpr std::size_t kMaxFromBrowser = 1024;
constexpr std::size_t kSurfaceBytes = 256U << 10U;  // at a time: 30 ms on a line of 10 MB/s
enum Lane : std::size_t { kHello, kMesh, kFrame, kPicture, kSurface };

/// Whether a page's origin is this server, or there is no page.
bool is_own_page(beast::string_view origin, beast::string_view host) {
    return origin.empty() || origin == "http://" + std::string(host);
}

std::string_view to_std(beast::string_view text) { return {text.data(), text.size()}; }

bool asks_for_foxglove(const FoxgloveClient::Request& request) {
    return websocket::is_upgrade(request) && !FoxgloveClient::protocol_of(request).empty();
}

}  // namespace

Viewer::Viewer(asio::ip::tcp::socket socket, ViewSource& source)
    : source_(source), stream_(std::move(socket)), sender_(stream_, [this] { end_live(); }) {
    beast::error_code gone_already;
    address_ = stream_.next_layer().socket().remote_endpoint(gone_already).address();
}

Viewer::~Viewer() {
    end_live();
    source_.taken -= has_place_ ? 1 : 0;
}

void Viewer::start() {
    parser_.emplace();
    parser_->header_limit(kMaxHeader);
    stream_.next_layer().expires_after(kRequestTime);
    http::async_read(stream_.next_layer(), buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                         if (!error) {
                             self->answer();
                         }
                     });
}

/// With a token, it decides, for what knows it is no stranger's page. Without, strangers' pages could read along in a
/// browser on this computer.
bool Viewer::may_connect() const {
    const FoxgloveClient::Request& request = parser_->get();
    if (!source_.token.empty()) {
        // The page itself shows nothing; its address may keep the token behind a #, where it never leaves the browser.
        return !websocket::is_upgrade(request) || has_token(to_std(request.target()), source_.token);
    }
    const beast::string_view host = request[http::field::host];
    const beast::string_view origin = request[http::field::origin];
    return is_own_name(to_std(host)) &&
           (is_own_page(origin, host) || (asks_for_foxglove(request) && FoxgloveClient::is_foxglove(origin)));
}

void Viewer::answer() {
    const FoxgloveClient::Request& request = parser_->get();
    const std::string_view path = path_of(to_std(request.target()));
    if (!may_connect()) {
        reply(http::status::forbidden, "text/plain",
              source_.token.empty() ? "only pages of this server on this computer, and Foxglove\n"
                                    : "only with ?token= and the token\n");
    } else if (websocket::is_upgrade(request) && !source_.has_place()) {
        reply(http::status::service_unavailable, "text/plain", "all places are taken\n");
    } else if (asks_for_foxglove(request)) {
        stream_.next_layer().expires_never();
        stream_.set_option(websocket::stream_base::timeout{kRequestTime, source_.idle, true});
        source_.foxglove.adopt(std::move(stream_), parser_->release());
    } else if (path == "/live" && websocket::is_upgrade(request)) {
        begin_live();
    } else if (path == "/" && request.method() == http::verb::get) {
        reply(http::status::ok, "text/html; charset=utf-8", source_.page);
    } else {
        reply(http::status::not_found, "text/plain", "here are / and /live\n");
    }
}

void Viewer::reply(http::status status, const char* type, std::string body) {
    response_ = {status, parser_->get().version()};
    response_.set(http::field::content_type, type);
    response_.set(http::field::cache_control, "no-store");
    response_.keep_alive(false);
    response_.body() = std::move(body);
    response_.prepare_payload();
    http::async_write(stream_.next_layer(), response_, [self = shared_from_this()](beast::error_code, std::size_t) {
        beast::error_code ignored;
        self->stream_.next_layer().socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    });
}

void Viewer::begin_live() {
    has_place_ = true;
    ++source_.taken;
    stream_.next_layer().expires_never();
    stream_.set_option(websocket::stream_base::timeout{kRequestTime, source_.idle, true});
    stream_.read_message_max(kMaxFromBrowser);
    stream_.async_accept(parser_->get(), [self = shared_from_this()](beast::error_code error) {
        if (error) {
            return;
        }
        ++self->source_.viewers;
        ++self->source_.watching;
        self->is_live_ = true;
        self->send(kHello, self->source_.hello);
        self->send(kMesh, self->source_.newest_mesh);
        self->listen();
    });
}

/// Browsers say nothing of interest; reading answers their pings and learns that they close.
void Viewer::listen() {
    stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
        if (error) {
            self->end_live();
            return;
        }
        self->buffer_.consume(self->buffer_.size());
        self->listen();
    });
}

void Viewer::end_live() {
    if (std::exchange(is_live_, false)) {
        --source_.watching;
    }
}

void Viewer::push(const SharedMessage& frame, const SharedMessage& mesh, const SharedMessage& picture) {
    if (!is_live_) {
        return;
    }
    // The mesh before the frame that brought it, the picture last.
    send(kMesh, mesh);
    send(kFrame, frame);
    send(kPicture, picture);
}

void Viewer::push_surface() {
    if (!is_live_ || sender_.waiting(kSurface) > 0) {
        return;
    }
    std::string pieces;
    if (source_.surface.append_changes(surface_, kSurfaceBytes, pieces)) {
        send(kSurface, surface_message(surface_.surface, pieces));
    }
}

/// A newer message of a kind takes the place of one that still waits.
void Viewer::send(std::size_t lane, const SharedMessage& message) {
    if (message && sender_.put({.lane = lane, .is_binary = message->is_binary, .body = {message, &message->body}}, 1,
                               shared_from_this())) {
        ++source_.replaced;
    }
}

}  // namespace facet
