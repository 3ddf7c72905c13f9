// SPDX-License-Identifier: BSD-2-Clause
// A line for the log, from a thread that must not write it itself.
#pragma once

#include <fmt/core.h>

#include <array>
#include <string>
#include <string_view>

#include "platform/base/spsc_queue.h"

namespace facet {

/// Longer texts are cut. No heap.
struct RunEvent {
    std::array<char, 32> kind{};
    std::array<char, 224> text{};

    template <class... Args>
    static RunEvent make(std::string_view kind, fmt::format_string<Args...> format, Args&&... args) {
        RunEvent event;
        fmt::format_to_n(event.kind.data(), event.kind.size() - 1, "{}", kind);
        fmt::format_to_n(event.text.data(), event.text.size() - 1, format, std::forward<Args>(args)...);
        return event;
    }
};

/// From one thread to the one that writes the log. When full, the event is lost and counted.
using EventQueue = SpscQueue<RunEvent, 64>;

}  // namespace facet
