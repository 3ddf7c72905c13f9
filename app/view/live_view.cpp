// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/live_view.h"

#include <fmt/core.h>

#include <algorithm>
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
#include "app/view/view_messages.h"

namespace facet {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;

constexpr std::chrono::milliseconds kTick{30};
constexpr std::chrono::milliseconds kPause{100};  // after connections that could not be accepted
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

}  // namespace

class LiveView::Server {
public:
    explicit Server(const ViewOptions& options) : acceptor_(io_), timer_(io_), pause_(io_) {
        source_.page = read_page(options.page);
        source_.token = options.token;
        source_.idle = options.idle;
        source_.places = kMaxViewers;
        source_.hello = hello_message(options.rig);
        listen(options.place);
        for (ViewSnapshot* snapshot : {&inbox_, &taken_}) {
            snapshot->states.reserve(kMaxStates);
            reserve_most(snapshot->mesh);
            reserve_most(snapshot->picture);
        }
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

    bool wants_picture(Timestamp stamp, bool has_points) const {
        const bool is_watched = source_.watching > 0 || source_.foxglove.wants(FoxgloveTopic::kImage);
        return is_watched &&
               (!last_picture_ || stamp - *last_picture_ >= (has_points ? kPicturePeriod : kPointlessAfter));
    }
    bool wants_calibration() const { return source_.foxglove.wants(FoxgloveTopic::kCalibration); }

    void offer(const ViewState& state, const Fillers& fillers) {
        ++offered_;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock.owns_lock()) {
            ++skipped_;
            return;
        }
        begin_ = begin_ ? begin_ : state.stamp;
        inbox_.begin = *begin_;
        if (inbox_.states.size() < kMaxStates) {
            inbox_.states.push_back(state);
        } else {
            ++skipped_;
            inbox_.states.back() = state;
        }
        if (fillers.mesh) {
            refill(fillers.mesh, inbox_.mesh);
            inbox_.mesh_stamp = state.stamp;
        }
        if (fillers.picture) {
            refill(fillers.picture, inbox_.picture);
            inbox_.picture_stamp = state.stamp;
            last_picture_ = state.stamp;
        }
        if (fillers.calibration) {
            fillers.calibration(inbox_.calibration);
            inbox_.calibration_stamp = state.stamp;
        }
    }

    SurfaceSink& surface() { return source_.surface; }
    const ViewPlace& place() const { return place_; }
    ViewAccount account() const {
        return {offered_, skipped_, source_.replaced + source_.foxglove.replaced(), source_.viewers,
                source_.foxglove.seen()};
    }

private:
    void listen(const ViewPlace& wanted) {
        if (source_.token.empty() && !is_loopback(wanted.address)) {
            throw InputError(
                fmt::format("--view {}: others could look along: give a --view-token, or leave the address "
                            "out to listen on this computer alone",
                            to_text(wanted)));
        }
        boost::system::error_code error;
        const Tcp::endpoint place(asio::ip::make_address(wanted.address, error), wanted.port);
        acceptor_.open(place.protocol(), error);
        acceptor_.set_option(Tcp::acceptor::reuse_address(true), error);
        acceptor_.bind(place, error);
        if (!error) {
            acceptor_.listen(asio::socket_base::max_listen_connections, error);
        }
        if (error) {
            throw InputError(fmt::format("--view {}: {}", to_text(wanted), error.message()));
        }
        place_ = {wanted.address, acceptor_.local_endpoint().port()};
    }

    void accept() {
        acceptor_.async_accept([this](boost::system::error_code error, Tcp::socket socket) {
            std::erase_if(viewers_, [](const std::weak_ptr<Viewer>& viewer) { return viewer.expired(); });
            if (!error) {
                const auto viewer = std::make_shared<Viewer>(std::move(socket), source_);
                make_room_for(viewer->address());
                viewers_.push_back(viewer);
                viewer->start();
                accept();
            } else {
                accept_later();
            }
        });
    }

    /// As when there are no more descriptors: whoever waits goes on waiting, and this thread does not spin.
    void accept_later() {
        pause_.expires_after(kPause);
        pause_.async_wait([this](boost::system::error_code error) {
            if (!error) {
                accept();
            }
        });
    }

    void make_room_for(const asio::ip::address& address) {
        std::vector<std::shared_ptr<Viewer>> strangers;  // the one that has waited longest first
        for (const std::weak_ptr<Viewer>& known : viewers_) {
            if (auto viewer = known.lock(); viewer && viewer->is_stranger()) {
                strangers.push_back(std::move(viewer));
            }
        }
        const auto is_neighbour = [&](const std::shared_ptr<Viewer>& viewer) { return viewer->address() == address; };
        if (std::ranges::count_if(strangers, is_neighbour) >= static_cast<std::ptrdiff_t>(kMaxOfAddress)) {
            (*std::ranges::find_if(strangers, is_neighbour))->turn_away();
        } else if (strangers.size() >= kMaxStrangers) {
            strangers.front()->turn_away();
        }
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
                inbox_.clear();
            }
            pass_on();
            for (const std::weak_ptr<Viewer>& known : viewers_) {
                if (const auto viewer = known.lock()) {
                    viewer->push_surface();
                }
            }
            tick();
        });
    }

    void pass_on() {
        if (taken_.states.empty()) {
            return;
        }
        const SharedMessage frame = frame_message(taken_.states.back(), taken_.begin);
        const SharedMessage mesh = taken_.mesh_stamp ? mesh_message(taken_.mesh.faces) : nullptr;
        const SharedMessage picture = taken_.picture_stamp ? picture_message(taken_.picture) : nullptr;
        source_.newest_mesh = mesh ? mesh : source_.newest_mesh;
        for (const std::weak_ptr<Viewer>& known : viewers_) {
            if (const auto viewer = known.lock()) {
                viewer->push(frame, mesh, picture);
            }
        }
        source_.foxglove.take(taken_);
    }

    ViewSource source_;  // outlives the viewers, which io_ owns
    asio::io_context io_{1};
    Tcp::acceptor acceptor_;
    asio::steady_timer timer_;
    asio::steady_timer pause_;
    std::vector<std::weak_ptr<Viewer>> viewers_;
    std::optional<Timestamp> begin_;         ///< of the thread that offers
    std::optional<Timestamp> last_picture_;  ///< the same
    ViewSnapshot taken_;
    std::mutex mutex_;  ///< of inbox_
    ViewSnapshot inbox_;
    std::atomic<std::uint64_t> offered_{0};
    std::atomic<std::uint64_t> skipped_{0};
    ViewPlace place_;
    std::thread thread_;
};

LiveView::LiveView(const ViewOptions& options) : server_(std::make_unique<Server>(options)) {}
LiveView::~LiveView() = default;
bool LiveView::wants_picture(Timestamp stamp, bool has_points) const {
    return server_->wants_picture(stamp, has_points);
}
bool LiveView::wants_calibration() const { return server_->wants_calibration(); }
void LiveView::offer(const ViewState& state, const Fillers& fillers) { server_->offer(state, fillers); }
SurfaceSink& LiveView::surface() { return server_->surface(); }
const ViewPlace& LiveView::place() const { return server_->place(); }
ViewAccount LiveView::account() const { return server_->account(); }

}  // namespace facet
