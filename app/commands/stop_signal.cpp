// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/stop_signal.h"

#include <csignal>

namespace facet {
namespace {

std::atomic<bool> g_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void stop(int signal) {
    g_stop.store(true);
    std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& stop_on_signals(std::initializer_list<int> signals) {
    for (const int signal : signals) {
        std::signal(signal, stop);
    }
    return g_stop;
}

}  // namespace facet
