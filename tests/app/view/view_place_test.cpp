// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/view_place.h"

#include <catch2/catch.hpp>

#include "app/view/live_view.h"
#include "tests/app/view/view_client.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::view_place_test {
namespace {

using test::input_error_text;
using test::http::status;

constexpr const char* kToken = "0123456789abcdef-._~";

TEST_CASE("a place is a port, on this computer unless an address is given") {
    CHECK(to_text(parse_view_place("8080")) == "127.0.0.1:8080");
    CHECK(to_text(parse_view_place("0")) == "127.0.0.1:0");
    CHECK(to_text(parse_view_place("0.0.0.0:65535")) == "0.0.0.0:65535");
    CHECK(to_text(parse_view_place("[::1]:80")) == "[::1]:80");
    for (const char* const text : {"", ":", "x", "65536", "-1", "80 ", "8080x", "1.2.3:80", "host:80", "::1:80", "::1",
                                   "[127.0.0.1:80", "0.0.0.0:", "0.0.0.0", "[]:80"}) {
        CHECK(input_error_text([&] { (void)parse_view_place(text); }).find("must be [ADDRESS:]PORT") !=
              std::string::npos);
    }
}

TEST_CASE("loopback is known in both families") {
    CHECK(is_loopback("127.0.0.1"));
    CHECK(is_loopback("127.8.9.1"));
    CHECK(is_loopback("::1"));
    CHECK_FALSE(is_loopback("0.0.0.0"));
    CHECK_FALSE(is_loopback("::"));
    CHECK_FALSE(is_loopback("192.168.1.5"));
    CHECK_FALSE(is_loopback("localhost"));
}

TEST_CASE("only names of this computer are its own, whatever leads here") {
    for (const char* const host : {"localhost", "localhost:9000", "127.0.0.1:80", "[::1]:80", "[::1]", "127.0.0.1"}) {
        CHECK(is_own_name(host));
    }
    for (const char* const host : {"", "localhost.example:80", "127.0.0.1.example", "rebound.example:8080",
                                   "192.168.1.5:80", "localhost:80:evil.example", "[::2]:80"}) {
        CHECK_FALSE(is_own_name(host));
    }
}

TEST_CASE("a query has the token or has not") {
    CHECK(has_token("/live?token=0123456789abcdef-._~", kToken));
    CHECK(has_token("/?a=b&token=0123456789abcdef-._~&c", kToken));
    for (const char* const target :
         {"/live", "/live?", "/live?token", "/live?token=", "/live?token=0123456789abcdef-._",
          "/live?&&=", "/live?token=0123456789abcdef-._~x", "/live?nottoken=0123456789abcdef-._~",
          "/token=0123456789abcdef-._~", "/live?token=0123456789ABCDEF-._~", "/live?token=%30123456789abcdef-._~"}) {
        CHECK_FALSE(has_token(target, kToken));
    }
    CHECK(path_of("/live?token=x") == "/live");
    CHECK(path_of("/") == "/");
}

TEST_CASE("a token is a line of harmless characters, long enough not to be guessed") {
    const test::TempDir dir;
    CHECK(read_view_token(dir.write("good", std::string(kToken) + "\nmore\n")) == kToken);
    CHECK(read_view_token(dir.write("bare", kToken)) == kToken);
    for (const std::string& text : {std::string("0123456789abcde\n"), std::string(257, 'a'),
                                    std::string("0123456789 abcdef\n"), std::string("0123456789abcdef&x\n")}) {
        const std::string said = input_error_text([&] { (void)read_view_token(dir.write("bad", text)); });
        CHECK(said.find("16 to 256") != std::string::npos);
        CHECK(said.find(text.substr(0, 12)) == std::string::npos);
    }
    CHECK(input_error_text([&] { (void)read_view_token(dir.file("none")); }).find("no token") != std::string::npos);
    CHECK(input_error_text([&] { (void)read_view_token(dir.write("empty", "")); }).find("no token") !=
          std::string::npos);
}

TEST_CASE("others may look only with a token") {
    const ViewOptions open_to_all = test::view_options("", "", {"0.0.0.0", 0});
    CHECK(input_error_text([&] { LiveView{open_to_all}; }).find("--view-token") != std::string::npos);
    LiveView view(test::view_options("", kToken, {"0.0.0.0", 0}));
    const auto connect = [&](const std::string& target, const std::string& origin, const std::string& protocols) {
        return test::ViewClient(view, {.target = target, .origin = origin, .protocols = protocols});
    };
    const std::string with_token = std::string("?token=") + kToken;
    for (const char* const protocols : {"", "foxglove.websocket.v1"}) {
        CHECK_THROWS(connect("/live", "", protocols));
        CHECK_THROWS(connect("/live?token=0123456789abcdef-._x", "", protocols));
        CHECK_NOTHROW(connect("/live" + with_token, "", protocols));
        CHECK_NOTHROW(connect("/live" + with_token, "https://my.viewer.example", protocols));
    }
    CHECK_NOTHROW(connect("/" + with_token, "", "foxglove.websocket.v1"));
    // The page shows nothing by itself, and a vehicle may have any name.
    CHECK(test::get(view, "/", "vehicle.local:8080").result() == status::ok);
    CHECK(test::get(view, "/live" + with_token, "vehicle.local").result() == status::not_found);
}

TEST_CASE("on this computer alone, a name that was made to lead here is refused") {
    LiveView view({});
    const std::string port = ":" + std::to_string(view.place().port);
    CHECK(test::get(view, "/", "localhost" + port).result() == status::ok);
    CHECK(test::get(view, "/", "rebound.example" + port).result() == status::forbidden);
    // Its page has its own name as origin, which equals the Host.
    CHECK_THROWS(
        test::ViewClient(view, {.target = "/live", .origin = "http://rebound.example" + port, .protocols = ""}));
}

TEST_CASE("on this computer a token is asked for all the same if there is one") {
    LiveView view(test::view_options("", kToken));
    CHECK_THROWS(test::ViewClient(view));
    CHECK_NOTHROW(
        test::ViewClient(view, {.target = std::string("/live?token=") + kToken, .origin = "", .protocols = ""}));
}

}  // namespace
}  // namespace facet::view_place_test
