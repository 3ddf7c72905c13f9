// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/live_view.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "app/support/input_error.h"
#include "app/view/viewer.h"

namespace facet {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

constexpr std::chrono::milliseconds kTick{30};
constexpr const char* kNoPage =
    "<!DOCTYPE html><title>facet</title><p>No page was given: <code>scripts/report --live page.html</code> makes one, "
    "<code>--view-page page.html</code> shows it.";

std::string read_page(const std::string& path) {
    if (path.empty()) {
        return kNoPage;
    }
    std::ifstream file(path, std::ios::binary);
    std::string page{std::istreambuf_iterator<char>(file), {}};
    if (!file || page.empty()) {
        throw InputError(path + ": cannot be read");
    }
    return page;
}

SharedMessage text_message(std::string body) {
    return std::make_shared<const ViewMessage>(ViewMessage{false, std::move(body)});
}

/// The left camera: pose on the body, half of its field of view as tangents.
SharedMessage hello_of(const StereoRig& rig) {
    const CameraIntrinsics& k = rig.left.intrinsics();
    const Se3& T = rig.T_B_C0;
    const double fx = k.fx > 0.0 ? k.fx : 1.0;
    const double fy = k.fy > 0.0 ? k.fy : 1.0;
    return text_message(fmt::format(R"({{"camera":{{"p":[{},{},{}],"q":[{},{},{},{}],"x":{},"y":{}}}}})", T.p.x(),
                                    T.p.y(), T.p.z(), T.q.x(), T.q.y(), T.q.z(), T.q.w(), k.cx / fx, k.cy / fy));
}

SharedMessage frame_message(const ViewState& s, Timestamp begin) {
    const Eigen::Vector3d& p = s.T_W_B.p;
    const Eigen::Quaterniond& q = s.T_W_B.q;
    return text_message(
        fmt::format(R"({{"t":{:.4f},"p":[{:.4f},{:.4f},{:.4f}],"q":[{:.6f},{:.6f},{:.6f},{:.6f}],"state":"{}",)"
                    R"("quality":{},"tracked":{},"ms":{:.2f},"keyframe":{}}})",
                    (s.stamp - begin).seconds(), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w(), s.state, s.quality,
                    s.tracked, s.total_ms, s.is_keyframe));
}

void append_word(std::string& body, std::uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) {
        body.push_back(static_cast<char>((word >> shift) & 0xffU));
    }
}

/// For each face nine float32 and an int32, little-endian.
SharedMessage mesh_message(const std::vector<ViewFace>& faces) {
    auto message = std::make_shared<ViewMessage>();
    message->is_binary = true;
    message->body.reserve(40 * faces.size());
    for (const ViewFace& face : faces) {
        for (const Eigen::Vector3f& p : face.p_W) {
            for (int k = 0; k < 3; ++k) {
                append_word(message->body, std::bit_cast<std::uint32_t>(p[k]));
            }
        }
        append_word(message->body, static_cast<std::uint32_t>(face.plane));
    }
    return message;
}

}  // namespace

class LiveView::Server {
public:
    explicit Server(const ViewOptions& options) : acceptor_(io_), timer_(io_) {
        source_.page = read_page(options.page);
        source_.hello = hello_of(options.rig);
        listen(options.port);
        inbox_.faces.reserve(kMaxFaces);
        taken_.faces.reserve(kMaxFaces);
        accept();
        tick();
        thread_ = std::thread([this] { io_.run(); });
    }
    ~Server() {
        io_.stop();
        thread_.join();
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    void offer(const ViewState& state, const FillFaces& fill) {
        ++offered_;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock.owns_lock()) {
            ++skipped_;
            return;
        }
        begin_ = begin_ ? begin_ : state.stamp;
        inbox_.state = state;
        inbox_.begin = *begin_;
        if (fill) {
            inbox_.faces.clear();
            fill(inbox_.faces);
            inbox_.faces.resize(std::min(inbox_.faces.size(), kMaxFaces));
            inbox_.has_mesh = true;
        }
    }

    std::uint16_t port() const { return port_; }
    ViewAccount account() const { return {offered_, skipped_, source_.replaced, source_.viewers}; }

private:
    struct Snapshot {
        std::optional<ViewState> state;
        Timestamp begin;  ///< of the first frame that was taken
        std::vector<ViewFace> faces;
        bool has_mesh = false;
    };

    void listen(std::uint16_t port) {
        boost::system::error_code error;
        const Tcp::endpoint place(asio::ip::address_v4::loopback(), port);
        acceptor_.open(place.protocol(), error);
        acceptor_.set_option(Tcp::acceptor::reuse_address(true), error);
        acceptor_.bind(place, error);
        if (!error) {
            acceptor_.listen(asio::socket_base::max_listen_connections, error);
        }
        if (error) {
            throw InputError(fmt::format("--view {}: {}", port, error.message()));
        }
        port_ = acceptor_.local_endpoint().port();
    }

    void accept() {
        acceptor_.async_accept([this](boost::system::error_code error, Tcp::socket socket) {
            std::erase_if(viewers_, [](const std::weak_ptr<Viewer>& viewer) { return viewer.expired(); });
            if (!error && viewers_.size() < kMaxViewers) {
                const auto viewer = std::make_shared<Viewer>(std::move(socket), source_);
                viewers_.push_back(viewer);
                viewer->start();
            }
            accept();
        });
    }

    /// Takes what was offered; the lock is held for an exchange of two buffers.
    void tick() {
        timer_.expires_after(kTick);
        timer_.async_wait([this](boost::system::error_code error) {
            if (error) {
                return;
            }
            {
                const std::lock_guard lock(mutex_);
                std::swap(inbox_, taken_);
                inbox_.state.reset();
                inbox_.has_mesh = false;
            }
            pass_on();
            tick();
        });
    }

    void pass_on() {
        if (!taken_.state) {
            return;
        }
        const SharedMessage frame = frame_message(*taken_.state, taken_.begin);
        const SharedMessage mesh = taken_.has_mesh ? mesh_message(taken_.faces) : nullptr;
        source_.newest_mesh = mesh ? mesh : source_.newest_mesh;
        for (const std::weak_ptr<Viewer>& known : viewers_) {
            if (const auto viewer = known.lock()) {
                viewer->push(frame, mesh);
            }
        }
    }

    ViewSource source_;  // outlives the viewers, which io_ owns
    asio::io_context io_{1};
    Tcp::acceptor acceptor_;
    asio::steady_timer timer_;
    std::vector<std::weak_ptr<Viewer>> viewers_;
    std::optional<Timestamp> begin_;  ///< of the thread that offers
    Snapshot taken_;
    std::mutex mutex_;  ///< of inbox_
    Snapshot inbox_;
    std::atomic<std::uint64_t> offered_{0};
    std::atomic<std::uint64_t> skipped_{0};
    std::uint16_t port_ = 0;
    std::thread thread_;
};

LiveView::LiveView(const ViewOptions& options) : server_(std::make_unique<Server>(options)) {}
LiveView::~LiveView() = default;
void LiveView::offer(const ViewState& state, const FillFaces& fill) { server_->offer(state, fill); }
std::uint16_t LiveView::port() const { return server_->port(); }
ViewAccount LiveView::account() const { return server_->account(); }

}  // namespace facet
