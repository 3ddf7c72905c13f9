// SPDX-License-Identifier: BSD-2-Clause
// Whether the estimator's errors are as large as it says: normalised estimation error squared (NEES).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/lab/eval/uncertain_states.h"
#include "drivers/replay_asl/ground_truth.h"

namespace facet {

/// Which part of [theta p v] a figure is about.
struct ClaimPart {
    const char* name;
    int begin;
    int size;
};
inline constexpr ClaimPart kClaimParts[] = {
    {"pose", 0, 6}, {"orientation", 0, 3}, {"position", 3, 3}, {"velocity", 6, 3}};
inline constexpr std::size_t kClaimPartCount = std::size(kClaimParts);

/// Error and reported sigma at one stamp.
struct ClaimedError {
    Timestamp stamp;
    ClaimVector error;  ///< [theta p v] that turns the estimate into the truth; velocity NaN if the truth has none
    ClaimVector sigma;  ///< square roots of the reported variances
    double nees[kClaimPartCount];  ///< e' P^-1 e of the part; NaN if unknown or its P is not positive definite
};

/// NEES of one part over a run.
struct NeesStatistics {
    std::size_t count = 0;
    double mean = 0.0;            ///< of a consistent estimator: the part's size
    double inside_95 = 0.0;       ///< share between the 2.5 % and 97.5 % points of chi-square
    double above_95 = 0.0;        ///< share above the 97.5 % point: overconfident
    double within_3_sigma = 0.0;  ///< share of the part's components; of a consistent estimator: 0.997
};

struct Consistency {
    Timestamp gauge_stamp;              ///< where the two worlds were made one
    std::vector<ClaimedError> samples;  ///< without the one at gauge_stamp
    NeesStatistics parts[kClaimPartCount];
    std::size_t unusable = 0;  ///< samples with a covariance of the pose that is not positive definite
};

/// Compares reported covariances with the truth, interpolated at their stamps (not over holes longer than `max_gap`).
///
/// Gauge. Yaw and position of the world are unobservable: the estimator chooses them where its window begins, and its
/// covariance describes the errors that have been added since. So the true world is turned about z and shifted until
/// yaw and position agree at one common stamp, and only there: the first one of those with the best known position.
/// Mostly that is soon after the start. A start in motion reports its first state long after the window's beginning,
/// and that state may be wrong by centimetres, as it says; with the gauge there, every later one would be charged with
/// its error. A best fit over all stamps would remove drift that the covariance accounts for, and NEES would be far too
/// small. The gauge state's own uncertainty in yaw and position stays in the covariances although the errors no longer
/// contain it, and what it shares with its neighbours cancels. This makes NEES a little too small. Tilt is observable
/// and is not aligned.
///   e = [Log(R_est' R_true), p_true - p_est, v_true - v_est], after the gauge
/// Successive samples of one run are strongly correlated: the mean over one run scatters far more than that of
/// independent samples, so only averages over many runs can be compared with a band.
Consistency evaluate_consistency(std::span<const GroundTruthState> truth, std::span<const UncertainState> estimate,
                                 Duration max_gap = Duration::from_seconds(0.5));

/// The same comparison twice.
struct Claims {
    Consistency as_is;
    std::optional<Consistency>
        with_fit;  ///< against the truth with its fitted clock, point and axes; if those are known
};

/// Points of the chi-square distribution below which 2.5 % and 97.5 % lie. @param dof  3 or 6
struct ChiSquareBand {
    double low = 0.0;
    double high = 0.0;
};
ChiSquareBand chi_square_band(int dof);

/// Writes one row a sample: stamp_ns, nine errors, nine sigmas and four NEES ("nan" where unknown). Throws InputError.
void write_errors(const Consistency& consistency, const std::string& path);

}  // namespace facet
