// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/live_command.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "app/commands/run_guarded.h"
#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {

void PulseStarter::begin(std::vector<std::string> refusals, bool is_in_flight) {
    try {
        if (PulseOutput* const pulses = hardware_.pulses()) {
            refusals.push_back(pulses->start(vehicle_.realtime.trigger));
        }
    } catch (const InputError& e) {
        if (!is_in_flight) {
            throw;
        }
        refusals.push_back(fmt::format("{}; begun without it in flight", e.what()));
        is_awaited_ = true;
        retry_.close(clock_.now());
    }
    for (const std::string& refusal : refusals) {
        if (!refusal.empty()) {
            print_err("warning: {}\n", refusal);
        }
    }
}

void PulseStarter::tick() {
    if (!is_awaited_ || !retry_.pass(clock_.now())) {
        return;
    }
    try {
        (void)hardware_.pulses()->start(vehicle_.realtime.trigger);
        is_awaited_ = false;
        print_err("trigger_output: works\n");
    } catch (const InputError&) {
        // Reported already; tried again.
    }
}

void end_pulses(Hardware& hardware) {
    PulseOutput* const pulses = hardware.pulses();
    if (pulses == nullptr) {
        return;
    }
    pulses->stop();
    if (!pulses->problem().empty() || pulses->skipped() > 0) {
        print_err("warning: {} trigger pulses skipped. {}\n", pulses->skipped(), pulses->problem());
    }
}

void wait_live(Clock& clock, const std::atomic<bool>& stop, double duration_s, const std::function<bool()>& tick) {
    const Timestamp begin = clock.now();
    for (bool goes_on = true; goes_on && !stop.load();) {
        if (duration_s > 0.0 && (clock.now() - begin).seconds() >= duration_s) {
            return;
        }
        clock.sleep(kLiveTick);
        goes_on = tick();
    }
}

int exit_code_for(const std::string& problem) {
    if (problem.empty()) {
        return kExitDone;
    }
    print_error(problem.c_str());
    return kExitFailed;
}

LogForm parse_log_form(const std::string& text) {
    const auto* const name = std::ranges::find(kLogFormNames, text);
    if (name == kLogFormNames.end()) {
        throw InputError(fmt::format("--format {}: must be one of: {}", text, fmt::join(kLogFormNames, ", ")));
    }
    return static_cast<LogForm>(name - kLogFormNames.begin());
}

void require_duration(double duration_s) {
    if (duration_s < 0.0) {
        throw InputError("--duration must not be negative");
    }
}

}  // namespace facet
