// SPDX-License-Identifier: BSD-2-Clause
// The live view from a browser's side, and that no browser holds up whoever offers frames.
#include "app/view/live_view.h"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/app/view/view_client.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::live_view_test {
namespace {

namespace http = boost::beast::http;
using Client = test::ViewClient;
using Clock = std::chrono::steady_clock;
using test::get;
using test::state_at;
using test::with_faces;

test::ViewClientOptions from(const std::string& origin) {
    return {.target = "/live", .origin = origin, .protocols = ""};
}

TEST_CASE("the page is there for browsers on this computer, and for no one else's page") {
    const test::TempDir dir;
    LiveView view(test::view_options(dir.write("page.html", "<p>hello")));
    const std::string own = "127.0.0.1:" + std::to_string(view.place().port);
    const auto page = get(view, "/", own);
    CHECK(page.result() == http::status::ok);
    CHECK(page.body() == "<p>hello");
    CHECK(get(view, "/etc/passwd", own).result() == http::status::not_found);
    CHECK(get(view, "/", "elsewhere.example:80").result() == http::status::forbidden);
    CHECK_THROWS(Client(view, from("http://elsewhere.example")));
    CHECK_NOTHROW(Client(view, from("http://" + own)));
    // The server counts after its answer has left.
    CHECK(test::comes_true([&] { return view.account().viewers == 1; }));
}

TEST_CASE("a browser gets the camera, the newest frame and the mesh, also if it comes late") {
    LiveView view({});
    Client early(view);
    CHECK(nlohmann::json::parse(early.read())["camera"]["q"] == std::vector<double>{0, 0, 0, 1});
    view.offer(state_at(0), with_faces(2));
    const std::string mesh = early.read();
    CHECK(early.is_binary());
    REQUIRE(mesh.size() == 4 + 80);
    CHECK(mesh.substr(0, 4) == std::string(4, '\0'));
    CHECK(mesh.substr(4 + 36, 4) == std::string("\5\0\0\0", 4));
    const auto frame = nlohmann::json::parse(early.read());
    CHECK(frame["t"] == 0.0);
    CHECK(frame["p"] == std::vector<double>{0, 2, 3});
    CHECK(frame["state"] == "TRACKING");
    Client late(view);
    late.read();
    CHECK(late.read() == mesh);
    view.offer(state_at(3));
    CHECK(nlohmann::json::parse(late.read())["t"] == Approx(0.15));
}

TEST_CASE("pictures are requested while someone looks, five a second with landmarks and two without") {
    LiveView view({});
    CHECK_FALSE(view.wants_picture(Timestamp{0}, true));
    auto client = std::make_unique<Client>(view);
    client->read();
    const auto wanted_within_2s = [&view](Timestamp stamp, bool has_points, bool expected) {
        return test::comes_true([&] { return view.wants_picture(stamp, has_points) == expected; });
    };
    REQUIRE(wanted_within_2s(Timestamp{0}, false, true));
    ViewState state = state_at(0);
    state.has_pose = false;
    const auto fill = [](ViewPicture& picture) {
        picture = {.width = 2, .height = 1, .pixels = {7, 200}, .points = {{{1.5F, 0.0F}, 3.0F, 4}}};
    };
    view.offer(state, {.mesh = {}, .picture = fill, .calibration = {}});
    CHECK_FALSE(view.wants_picture(state.stamp + Duration{190'000'000}, true));
    CHECK(view.wants_picture(state.stamp + Duration{200'000'000}, true));
    CHECK_FALSE(view.wants_picture(state.stamp + Duration{490'000'000}, false));
    CHECK(view.wants_picture(state.stamp + Duration{500'000'000}, false));
    CHECK_FALSE(nlohmann::json::parse(client->read()).contains("p"));
    const std::string picture = client->read();
    REQUIRE(picture.size() == 16 + 16 + 2);
    CHECK(picture.substr(0, 16) == std::string("\1\0\0\0\2\0\0\0\1\0\0\0\1\0\0\0", 16));
    CHECK(picture.substr(16, 4) == std::string("\0\0\xc0\x3f", 4));  // 1.5
    CHECK(picture.substr(28) == std::string("\4\0\0\0\7\xc8", 6));
    client.reset();
    CHECK(wanted_within_2s(state.stamp + Duration{900'000'000}, true, false));
}

TEST_CASE("browsers that read nothing, or vanish, hold up nobody and lose old messages only") {
    LiveView view({});
    Client stalled(view, {.target = "/live", .origin = "", .protocols = "", .receive_buffer = 4096});
    auto vanishing = std::make_unique<Client>(view);
    Client good(view);
    good.read();
    Clock::duration longest{};
    for (int frame = 0; frame < 80; ++frame) {
        const auto begin = Clock::now();
        view.offer(state_at(frame), with_faces(LiveView::kMaxFaces + 5));
        longest = std::max(longest, Clock::now() - begin);
        if (frame == 20) {
            vanishing.reset();
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(15));
    }
    // 26 MB went to the good one; the stalled one's socket holds a few of them, and the rest was replaced.
    CHECK(std::chrono::duration<double>(longest).count() < 0.25);
    const ViewAccount account = view.account();
    CHECK(account.offered == 80);
    CHECK(account.skipped < 8);
    CHECK(account.replaced > 10);
    view.offer(state_at(100));
    double newest = 0.0;
    for (int messages = 0; messages < 400 && newest < 5.0 - 1e-6; ++messages) {
        const std::string message = good.read();
        newest = good.is_binary() ? newest : nlohmann::json::parse(message)["t"].get<double>();
    }
    CHECK(newest == Approx(5.0));
}

/// Connections that send half a request and no more.
class HalfOpen {
public:
    HalfOpen(const LiveView& view, int count, const std::string& address = "127.0.0.1") {
        for (int i = 0; i < count; ++i) {
            sockets_.emplace_back(io_);
            sockets_.back().open(test::asio::ip::tcp::v4());
            sockets_.back().bind({test::asio::ip::make_address(address), 0});
            sockets_.back().connect(test::place_of(view));
            test::asio::write(sockets_.back(), test::asio::buffer(std::string("GET / HTTP/1.1\r\nHost: ")));
        }
    }

private:
    test::asio::io_context io_;
    std::vector<test::asio::ip::tcp::socket> sockets_;
};

TEST_CASE("who has not shown the token locks nobody out, from one address or from many") {
    const std::string token = "0123456789abcdef";
    LiveView view(test::view_options("", token));
    const HalfOpen from_one(view, 40, "127.0.0.1");
    std::vector<std::unique_ptr<HalfOpen>> from_many;
    for (int i = 2; i < 40; ++i) {
        from_many.push_back(std::make_unique<HalfOpen>(view, 1, "127.0.0." + std::to_string(i)));
    }
    CHECK(test::get(view, "/", "localhost").result() == test::http::status::ok);
    std::vector<std::unique_ptr<Client>> operators;
    test::ViewClientOptions shown;
    shown.target = "/live?token=" + token;
    for (std::size_t i = 0; i < LiveView::kMaxViewers; ++i) {
        operators.push_back(std::make_unique<Client>(view, shown));
        CHECK(nlohmann::json::parse(operators.back()->read()).is_object());
    }
    // The places are for those who have been let in, and no more than there are.
    CHECK_THROWS(Client(view, shown));
    operators.pop_back();
    CHECK(test::comes_true([&] {
        try {
            Client(view, shown).read();
            return true;
        } catch (const std::exception&) {
            return false;
        }
    }));
}

double processor_time_s() {
    rusage used{};
    REQUIRE(::getrusage(RUSAGE_SELF, &used) == 0);
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

TEST_CASE("without descriptors for more connections the view waits, and does not keep a core busy") {
    LiveView view({});
    test::asio::io_context io;
    test::asio::ip::tcp::socket client(io);
    client.open(test::asio::ip::tcp::v4());
    const int next = ::dup(0);  // the lowest that is free
    ::close(next);
    rlimit before{};
    REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
    const rlimit none_left{static_cast<rlim_t>(next), before.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &none_left) == 0);
    client.connect(test::place_of(view));  // the kernel takes it, and the view cannot
    const double begin_s = processor_time_s();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const double used_s = processor_time_s() - begin_s;
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &before) == 0);
    CHECK(used_s < 0.2);
    test::asio::write(client, test::asio::buffer(std::string("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")));
    std::array<char, 12> answer{};
    test::asio::read(client, test::asio::buffer(answer));
    CHECK(std::string(answer.data(), answer.size()) == "HTTP/1.1 200");
}

TEST_CASE("a WebSocket whose other end answers no ping gives its place back") {
    ViewOptions options = test::view_options("");
    options.idle = std::chrono::milliseconds(300);
    LiveView view(options);
    std::vector<std::unique_ptr<Client>> silent;
    for (std::size_t i = 0; i < LiveView::kMaxViewers; ++i) {
        silent.push_back(std::make_unique<Client>(view));  // reads nothing, and so answers nothing
    }
    CHECK_THROWS(Client(view));
    CHECK(test::comes_true([&] {
        try {
            Client(view).read();
            return true;
        } catch (const std::exception&) {
            return false;
        }
    }));
}

TEST_CASE("a port in use and a page that is not there are refused") {
    LiveView view({});
    const ViewOptions taken = test::view_options("", "", view.place());
    CHECK(test::input_error_text([&] { LiveView{taken}; }).find("in use") != std::string::npos);
    const ViewOptions pageless = test::view_options("/none.html");
    CHECK(test::input_error_text([&] { LiveView{pageless}; }) == "/none.html: cannot be read");
}

}  // namespace
}  // namespace facet::live_view_test
