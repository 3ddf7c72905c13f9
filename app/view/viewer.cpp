// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/viewer.h"

#include <chrono>
#include <utility>

namespace facet {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;

constexpr std::chrono::seconds kRequestTime{10};
constexpr std::uint32_t kMaxHeader = 8192;
constexpr std::size_t kMaxFromBrowser = 1024;

/// Whether a request to connect comes from a page of this server, or from none: other pages' scripts could read along
/// otherwise.
bool is_own_page(beast::string_view origin, beast::string_view host) {
    return origin.empty() || origin == "http://" + std::string(host);
}

/// Names under which a browser on this computer reaches the server: another name that leads here is someone's trick.
bool is_own_name(beast::string_view host) {
    const beast::string_view name = host.substr(0, host.rfind(':'));
    return name == "127.0.0.1" || name == "localhost";
}

}  // namespace

Viewer::Viewer(asio::ip::tcp::socket socket, ViewSource& source) : source_(source), stream_(std::move(socket)) {}

Viewer::~Viewer() { end_live(); }

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

void Viewer::answer() {
    const FoxgloveClient::Request& request = parser_->get();
    const beast::string_view host = request[http::field::host];
    const beast::string_view origin = request[http::field::origin];
    const bool is_foxglove = websocket::is_upgrade(request) && !FoxgloveClient::protocol_of(request).empty();
    if (!is_own_name(host) || !(is_own_page(origin, host) || (is_foxglove && FoxgloveClient::is_foxglove(origin)))) {
        reply(http::status::forbidden, "text/plain", "only pages of this server on this computer, and Foxglove\n");
    } else if (is_foxglove) {
        stream_.next_layer().expires_never();
        source_.foxglove.adopt(std::move(stream_), parser_->release());
    } else if (request.target() == "/live" && websocket::is_upgrade(request)) {
        begin_live();
    } else if (request.target() == "/" && request.method() == http::verb::get) {
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
    stream_.next_layer().expires_never();
    stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    stream_.read_message_max(kMaxFromBrowser);
    stream_.async_accept(parser_->get(), [self = shared_from_this()](beast::error_code error) {
        if (error) {
            return;
        }
        ++self->source_.viewers;
        ++self->source_.watching;
        self->is_live_ = true;
        self->waiting_hello_ = self->source_.hello;
        self->waiting_mesh_ = self->source_.newest_mesh;
        self->send();
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
    const auto replace = [this](SharedMessage& waiting, const SharedMessage& newer) {
        source_.replaced += newer && waiting ? 1U : 0U;
        waiting = newer ? newer : waiting;
    };
    replace(waiting_frame_, frame);
    replace(waiting_mesh_, mesh);
    replace(waiting_picture_, picture);
    if (!under_way_) {
        send();
    }
}

void Viewer::send() {
    // The mesh before the frame that brought it, the picture last.
    for (SharedMessage* waiting : {&waiting_hello_, &waiting_mesh_, &waiting_frame_, &waiting_picture_}) {
        under_way_ = under_way_ ? under_way_ : std::exchange(*waiting, nullptr);
    }
    if (!under_way_ || !is_live_) {
        return;
    }
    stream_.binary(under_way_->is_binary);
    stream_.async_write(asio::buffer(under_way_->body),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                            self->under_way_ = nullptr;
                            if (error) {
                                self->end_live();
                            } else {
                                self->send();
                            }
                        });
}

}  // namespace facet
