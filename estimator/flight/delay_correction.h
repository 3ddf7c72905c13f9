// SPDX-License-Identifier: BSD-2-Clause
// Whether image stamps are late by more than the window can follow.
#pragma once

#include <optional>

#include "estimator/imu/delay_search.h"

namespace facet {

/// Compares turns between images with the gyroscope's while the delay of image stamps is in question, and says once
/// whether the estimator must restart with another delay. The window estimates what remains on top of it. About
/// 130 kB. Thread-bound. No heap.
class DelayCorrection {
public:
    void reset() {
        search_.reset();
        is_settled_ = false;
        found_s_ = 0.0;
        proposed_s_.reset();
    }

    /// Of image stamps, found by the search or by a start in motion (s).
    double found_s() const { return found_s_; }
    /// A start in motion has found that the delay is wrong. @param off  by how much @param delay_s  believed now
    /// @return whether it is wrong by enough, and for certain: accept() then gives it
    bool propose(const ImageDelay& off, double delay_s);
    /// Accepts what has been proposed; the search goes on from there. @param delay_s  believed now
    /// @return as step()
    std::optional<double> accept(double delay_s);

    /// The delay is in question, it has been corrected far or nothing is sure yet, and turns between images can answer.
    /// @param offset_s, sigma_s  the window's on top of found_s(), and the prior's standard deviation
    /// @param has_depths  from stereo matches. Flow of unknown depth is taken for turns, and a turn seen too large that
    ///                    dies away looks like an early one. With one camera the start in motion finds the delay.
    bool is_open(double offset_s, double sigma_s, bool is_tracking, bool has_depths) const;
    /// As DelaySearch::add().
    void add(Timestamp begin, Timestamp end, const Eigen::Vector3d& turn_B) { search_.add(begin, end, turn_B); }
    /// There may be turns enough for step().
    bool is_ready() const { return !is_settled_ && search_.is_ready(); }

    /// @param imu        with the readings as read
    /// @param delay_s    believed now, the window's share included
    /// @param claimed_s  its standard deviation; 0 if the estimate is not to be used
    /// @return by what it is wrong, if the estimator must restart with found_s()
    std::optional<double> step(const ImuBuffer& imu, double delay_s, double claimed_s);

private:
    DelaySearch search_;
    bool is_settled_ = false;
    double found_s_ = 0.0;
    std::optional<double> proposed_s_;
};

}  // namespace facet
