// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/view_place.h"

#include <fmt/core.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>
#include <charconv>
#include <fstream>

#include "app/support/input_error.h"

namespace facet {
namespace {

namespace ip = boost::asio::ip;

constexpr std::size_t kShortestToken = 16;
constexpr std::size_t kLongestToken = 256;
constexpr std::string_view kTokenIs = "token=";

bool is_token_character(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("-._~").find(c) != std::string_view::npos;
}

/// Looks at every character of the secret, whatever the first difference.
bool is_same(std::string_view given, std::string_view secret) {
    volatile unsigned difference = given.size() == secret.size() ? 0U : 1U;
    for (std::size_t i = 0; i < secret.size(); ++i) {
        const char other = i < given.size() ? given[i] : '\0';
        difference = difference | static_cast<unsigned char>(secret[i] ^ other);
    }
    return difference == 0;
}

std::string_view without_brackets(std::string_view address) {
    const bool has_brackets = address.size() > 2 && address.front() == '[' && address.back() == ']';
    return has_brackets ? address.substr(1, address.size() - 2) : address;
}

}  // namespace

ViewPlace parse_view_place(const std::string& text) {
    ViewPlace place;
    const std::size_t colon = text.rfind(':');
    const std::string_view port = std::string_view(text).substr(colon == std::string::npos ? 0 : colon + 1);
    const auto [end, port_error] = std::from_chars(port.data(), port.data() + port.size(), place.port);
    bool is_good = port_error == std::errc() && end == port.data() + port.size();
    if (colon != std::string::npos) {
        const std::string_view written = std::string_view(text).substr(0, colon);
        place.address = without_brackets(written);
        boost::system::error_code error;
        const ip::address address = ip::make_address(place.address, error);
        is_good = is_good && !error && (address.is_v4() || written.front() == '[');
    }
    if (!is_good) {
        throw InputError(
            fmt::format("--view {}: must be [ADDRESS:]PORT, for example 8080, 192.168.1.5:8080, "
                        "0.0.0.0:8080 for every interface, or [::]:8080",
                        text));
    }
    return place;
}

std::string to_text(const ViewPlace& place) {
    const bool is_v6 = place.address.find(':') != std::string::npos;
    return fmt::format("{}{}{}:{}", is_v6 ? "[" : "", place.address, is_v6 ? "]" : "", place.port);
}

bool is_loopback(const std::string& address) {
    boost::system::error_code error;
    const ip::address parsed = ip::make_address(address, error);
    return !error && parsed.is_loopback();
}

std::string read_view_token(const std::string& path) {
    std::ifstream file(path);
    std::string token;
    if (!std::getline(file, token)) {
        throw InputError(path + ": no token in its first line, or cannot be read");
    }
    if (token.size() < kShortestToken || token.size() > kLongestToken ||
        !std::ranges::all_of(token, is_token_character)) {
        throw InputError(
            fmt::format("{}: a token is {} to {} letters, digits and - . _ ~; one is made by: head -c 16 "
                        "/dev/urandom | od -An -tx1 | tr -d ' \\n'",
                        path, kShortestToken, kLongestToken));
    }
    return token;
}

bool has_token(std::string_view target, std::string_view token) {
    const std::size_t mark = target.find('?');
    std::string_view query = mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
    bool found = false;
    while (!query.empty()) {
        const std::string_view part = query.substr(0, query.find('&'));
        query.remove_prefix(std::min(part.size() + 1, query.size()));
        if (part.starts_with(kTokenIs)) {
            found = is_same(part.substr(kTokenIs.size()), token) || found;
        }
    }
    return found;
}

std::string_view path_of(std::string_view target) { return target.substr(0, target.find('?')); }

bool is_own_name(std::string_view host) {
    const std::size_t colon = host.rfind(':');
    const bool has_port = colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos;
    const std::string_view name = has_port ? host.substr(0, colon) : host;
    return name == "localhost" || is_loopback(std::string(without_brackets(name)));
}

}  // namespace facet
