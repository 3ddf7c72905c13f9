// SPDX-License-Identifier: BSD-2-Clause
// Progress of a long command on stderr: a bar on a terminal, a line every 10 % otherwise.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace facet {

/// Thread-bound. Writes to stderr only.
class Progress {
public:
    /// @param label    what is being done, e.g. "replay"
    /// @param unit     what is counted, e.g. "frames"; "" if only the share of the work is known
    /// @param quiet_s  nothing is said of what is over sooner than this (s)
    Progress(std::string label, std::string unit, std::size_t total, double quiet_s = 0.0);

    /// Reports that `done` of the total are done; cheap to call for each one.
    void update(std::size_t done);
    /// Writes a line of its own without breaking the bar.
    void note(const std::string& line);
    /// Ends the bar with the total time and rate.
    void finish();

private:
    using Clock = std::chrono::steady_clock;

    double elapsed_s() const;
    std::string state() const;
    void draw_bar();
    void clear_bar();

    std::string label_;
    std::string unit_;
    std::size_t total_;
    double quiet_s_;
    std::size_t done_ = 0;
    bool terminal_;
    bool drawn_ = false;
    std::size_t next_line_percent_ = 10;
    Clock::time_point begin_;
    Clock::time_point last_draw_;
};

}  // namespace facet
