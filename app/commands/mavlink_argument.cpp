// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/mavlink_argument.h"

#include <charconv>
#include <string_view>

#include "app/support/input_error.h"

namespace facet {
namespace {

/// What follows the last colon, as a number of [low, high].
int number_after_colon(const std::string& text, std::size_t colon, int low, int high) {
    int value = 0;
    const char* const begin = text.data() + colon + 1;
    const char* const end = text.data() + text.size();
    if (const auto [at, error] = std::from_chars(begin, end, value);
        error != std::errc{} || at != end || value < low || value > high) {
        throw InputError("--mavlink " + text + ": '" + std::string(begin, end) + "' is not a number from " +
                         std::to_string(low) + " to " + std::to_string(high));
    }
    return value;
}

MavlinkChannelOptions parse_channel(const std::string& text) {
    constexpr std::string_view kUdp = "udp:";
    constexpr std::string_view kSerial = "serial:";
    MavlinkChannelOptions channel;
    const std::size_t colon = text.rfind(':');
    if (text.starts_with(kUdp) && colon > kUdp.size()) {
        channel.udp_host = text.substr(kUdp.size(), colon - kUdp.size());
        channel.udp_port = static_cast<std::uint16_t>(number_after_colon(text, colon, 1, 65535));
    } else if (text.starts_with(kSerial) && text.size() > kSerial.size()) {
        channel.serial = text.substr(kSerial.size(), colon < kSerial.size() ? text.npos : colon - kSerial.size());
        if (colon >= kSerial.size()) {
            channel.baud = number_after_colon(text, colon, 1200, 4'000'000);
        }
    } else {
        throw InputError("--mavlink " + text + ": must be udp:HOST:PORT or serial:DEVICE[:BAUD]");
    }
    return channel;
}

}  // namespace

std::unique_ptr<MavlinkLink> open_mavlink(const std::string& text, KernelIo& io, const Clock& clock) {
    if (text.empty()) {
        return nullptr;
    }
    MavlinkOptions options;
    options.channel = parse_channel(text);
    options.time = MavlinkTime::kStamps;
    auto link = std::make_unique<MavlinkLink>(io, clock, options);
    if (std::string problem; !ok(link->open(problem))) {
        throw InputError("--mavlink " + text + ": " + problem);
    }
    return link;
}

}  // namespace facet
