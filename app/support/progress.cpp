// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/progress.h"

#include <fmt/core.h>
#include <unistd.h>
#include <cmath>

#include <algorithm>
#include <cstdio>

#include "app/support/console.h"

namespace facet {
namespace {

constexpr std::size_t kBarWidth = 30;
constexpr auto kRedraw = std::chrono::milliseconds(100);

std::string minutes(double seconds) {
    const auto s = std::lround(seconds);
    return fmt::format("{}:{:02}", s / 60, s % 60);
}

}  // namespace

Progress::Progress(std::string label, std::string unit, std::size_t total, double quiet_s)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      total_(std::max<std::size_t>(total, 1)),
      quiet_s_(quiet_s),
      terminal_(isatty(STDERR_FILENO) != 0),
      begin_(Clock::now()),
      last_draw_(begin_ - kRedraw) {}

double Progress::elapsed_s() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

/// How much is done, how fast and how long the rest takes.
std::string Progress::state() const {
    const double rate = static_cast<double>(done_) / std::max(elapsed_s(), 1e-6);
    const std::string left = minutes(static_cast<double>(total_ - done_) / std::max(rate, 1e-6)) + " left";
    return unit_.empty() ? left : fmt::format("{}/{} {} {:.1f}/s, {}", done_, total_, unit_, rate, left);
}

void Progress::update(std::size_t done) {
    done_ = std::min(done, total_);
    if (elapsed_s() < quiet_s_) {
        return;
    }
    if (terminal_) {
        if (Clock::now() - last_draw_ >= kRedraw || done_ == total_) {
            draw_bar();
        }
        return;
    }
    const std::size_t percent = 100 * done_ / total_;
    if (percent >= next_line_percent_) {
        next_line_percent_ = percent / 10 * 10 + 10;
        print_err("{} {:3}% {}\n", label_, percent, state());
    }
}

void Progress::draw_bar() {
    last_draw_ = Clock::now();
    drawn_ = true;
    const std::size_t filled = kBarWidth * done_ / total_;
    print_err("\r\x1b[K{} [{}{}] {}", label_, std::string(filled, '#'), std::string(kBarWidth - filled, '.'), state());
    std::fflush(stderr);
}

void Progress::clear_bar() {
    if (drawn_) {
        print_err("\r\x1b[K");
        drawn_ = false;
    }
}

void Progress::note(const std::string& line) {
    clear_bar();
    print_err("{}\n", printable(line));
}

void Progress::finish() {
    clear_bar();
    const double seconds = elapsed_s();
    if (seconds < quiet_s_) {
        return;
    }
    if (unit_.empty()) {
        print_err("{}: done in {:.1f} s\n", label_, seconds);
        return;
    }
    print_err("{}: {} {} in {:.1f} s ({:.1f}/s)\n", label_, done_, unit_, seconds,
              static_cast<double>(done_) / std::max(seconds, 1e-6));
}

}  // namespace facet
