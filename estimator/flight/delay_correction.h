// SPDX-License-Identifier: BSD-2-Clause
// Whether image stamps are late by more than the window can follow.
#pragma once

#include <cstdint>
#include <optional>

#include "estimator/imu/delay_search.h"

namespace facet {

/// Compares turns between images with the gyroscope's while the delay of image stamps is in question, and says whether
/// the estimator must restart with another delay. The window estimates what remains on top of it. Before the first
/// estimate few turns are enough, and a start waits while they contradict the delay. About 130 kB. Thread-bound. No
/// heap.
class DelayCorrection {
public:
    /// @param turn_sigma_rad  as DelaySearch::configure()
    void configure(double turn_sigma_rad) {
        search_.configure(turn_sigma_rad);
        is_settled_ = false;
        found_s_ = 0.0;
        proposed_s_.reset();
        corrections_ = 0;
        doubt_ = Doubt::kNone;
        doubted_since_.reset();
    }

    /// Of image stamps, found by the search or by a start in motion (s).
    double found_s() const { return found_s_; }
    /// The delay believed is off by this: from a start in motion, or from the search.
    /// @param delay_s  believed now, the window's share included
    /// @param claimed_s  its standard deviation; 0 if the estimate is not to be used
    /// @return whether it is wrong by enough, and for certain: accept() then gives it
    bool propose(const ImageDelay& off, double delay_s, double claimed_s = 0.0);
    /// Accepts what has been proposed; the search goes on from there. @param delay_s  believed now
    /// @return by what it is wrong, if the estimator must restart with found_s()
    std::optional<double> accept(double delay_s);

    /// The delay is in question, it has been corrected far or nothing is sure yet, and turns between images can answer.
    /// @param offset_s, sigma_s  the window's on top of found_s(), and the prior's standard deviation
    /// @param has_depths  from stereo matches. Flow of unknown depth is taken for turns, and a turn seen too large that
    ///                    dies away looks like an early one. With one camera the start in motion finds the delay.
    bool is_open(double offset_s, double sigma_s, bool is_tracking, bool has_depths) const;
    /// As DelaySearch::add().
    void add(Timestamp begin, Timestamp end, const Eigen::Vector3d& turn_B) { search_.add(begin, end, turn_B); }

    /// Examines the turns so far, and may propose another delay.
    /// @param imu    with the readings as read
    /// @param delay_s, claimed_s  as of propose()
    /// @param now    stamp of the newest image
    /// @param is_new  few turns are enough, else a second's are needed
    void step(const ImuBuffer& imu, double delay_s, double claimed_s, Timestamp now, bool is_new);
    /// There is nothing to examine.
    void skip() { doubt_ = Doubt::kNone; }
    /// Turns contradict the delay, and the true one is yet to be found: a start had better wait. Ends by itself.
    bool is_in_doubt() const { return doubt_ != Doubt::kNone || proposed_s_; }

private:
    enum class Doubt : std::uint8_t {
        kNone,
        kMisfit,  ///< the turns do not fit the delay
        kBetter,  ///< another one fits far better
    };
    Doubt doubt(const DelayFit& fit, double delay_s) const;

    DelaySearch search_;
    bool is_settled_ = false;
    double found_s_ = 0.0;
    std::optional<double> proposed_s_;
    int corrections_ = 0;  ///< by the search
    Doubt doubt_ = Doubt::kNone;
    std::optional<Timestamp> doubted_since_;
};

}  // namespace facet
