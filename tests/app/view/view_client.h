// SPDX-License-Identifier: BSD-2-Clause
// The other side of the live view: requests, WebSockets, and states to offer.
#pragma once

#include <boost/asio/connect.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "app/view/live_view.h"

namespace facet::test {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;

inline asio::ip::tcp::endpoint place_of(const LiveView& view) {
    return {asio::ip::address_v4::loopback(), view.place().port};
}

/// What the server answers to a GET.
inline http::response<http::string_body> get(const LiveView& view, const std::string& target, const std::string& host) {
    asio::io_context io;
    beast::tcp_stream stream(io);
    stream.connect(place_of(view));
    http::request<http::empty_body> request{http::verb::get, target, 11};
    request.set(http::field::host, host);
    http::write(stream, request);
    beast::flat_buffer buffer;
    http::response<http::string_body> response;
    http::read(stream, buffer, response);
    return response;
}

/// On loopback, at any port, unless a place is given.
inline ViewOptions view_options(const std::string& page, const std::string& token = "", const ViewPlace& place = {}) {
    ViewOptions options;
    options.place = place;
    options.token = token;
    options.page = page;
    return options;
}

struct ViewClientOptions {
    std::string target = "/live";
    std::string origin;      ///< none if empty
    std::string protocols;   ///< none if empty
    int receive_buffer = 0;  ///< of the socket in bytes; 0: as the system has it
};

/// A WebSocket. Throws if it is refused.
class ViewClient {
public:
    explicit ViewClient(const LiveView& view, const ViewClientOptions& options = {}) : stream_(io_) {
        stream_.next_layer().open(asio::ip::tcp::v4());
        if (options.receive_buffer > 0) {
            stream_.next_layer().set_option(asio::socket_base::receive_buffer_size(options.receive_buffer));
        }
        stream_.next_layer().connect(place_of(view));
        stream_.set_option(websocket::stream_base::decorator([options](websocket::request_type& request) {
            if (!options.origin.empty()) {
                request.set(http::field::origin, options.origin);
            }
            if (!options.protocols.empty()) {
                request.set(http::field::sec_websocket_protocol, options.protocols);
            }
        }));
        stream_.handshake(response_, "127.0.0.1:" + std::to_string(view.place().port), options.target);
    }
    std::string read() {
        beast::flat_buffer buffer;
        stream_.read(buffer);
        return beast::buffers_to_string(buffer.data());
    }
    bool is_binary() const { return stream_.got_binary(); }
    void write(const std::string& text) {
        stream_.text(true);
        stream_.write(asio::buffer(text));
    }
    /// The protocol that the server has chosen.
    std::string protocol() const { return std::string(response_[http::field::sec_websocket_protocol]); }

private:
    asio::io_context io_;
    websocket::stream<asio::ip::tcp::socket> stream_;
    websocket::response_type response_;
};

/// Frames 50 ms apart, 1 m apart along x.
inline ViewState state_at(int frame) {
    ViewState state;
    state.stamp = Timestamp{1'000'000'000 + 50'000'000LL * frame};
    state.T_W_B.p = {1.0 * frame, 2.0, 3.0};
    state.health.state = TrackingState::kTracking;
    state.health.quality = 90;
    return state;
}

inline LiveView::Fillers with_faces(std::size_t count) {
    return {.mesh =
                [count](ViewMesh& mesh) {
                    ViewFace face;
                    face.p_W = {Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(4, 5, 6), Eigen::Vector3f(7, 8, 9)};
                    face.plane = 5;
                    mesh.faces.assign(count, face);
                },
            .picture = {},
            .calibration = {}};
}

/// Whether a condition comes true within two seconds.
template <class Condition>
bool comes_true(Condition condition) {
    for (int i = 0; i < 200 && !condition(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return condition();
}

}  // namespace facet::test
