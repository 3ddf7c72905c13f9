// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/consistency.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <optional>

#include "app/lab/eval/pose_difference.h"
#include "app/support/text_file.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Pair {
    GroundTruthState truth;
    const UncertainState* estimate;
};

std::vector<Pair> pair_up(std::span<const GroundTruthState> truth, std::span<const UncertainState> estimate,
                          Duration max_gap) {
    std::vector<Pair> pairs;
    for (const UncertainState& state : estimate) {
        if (const std::optional<GroundTruthState> at = interpolate(truth, state.stamp, max_gap)) {
            pairs.push_back({*at, &state});
        }
    }
    return pairs;
}

/// The earliest pair whose place is claimed as well as anyone's; the first one if none has a usable claim.
const Pair* best_placed(const std::vector<Pair>& pairs) {
    const Pair* best = pairs.empty() ? nullptr : &pairs.front();
    double least_m2 = std::numeric_limits<double>::infinity();
    for (const Pair& pair : pairs) {
        const Vector3d variance = pair.estimate->covariance.diagonal().segment<3>(3);
        if ((variance.array() > 0.0).all() && variance.sum() < least_m2) {
            least_m2 = variance.sum();
            best = &pair;
        }
    }
    return best;
}

/// T_E_W from the true world W to the estimate's world E: a turn about z and a shift, exact at this pair.
Se3 gauge(const GroundTruthState& truth, const UncertainState& estimate) {
    const double yaw = nearest_yaw((estimate.T_W_B.q * truth.q_W_B.conjugate()).toRotationMatrix());
    const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    return {q, estimate.T_W_B.p - q * truth.p_W_B};
}

double nees(const ClaimPart& part, const ClaimedError& sample, const ClaimMatrix& covariance) {
    const Eigen::VectorXd e = sample.error.segment(part.begin, part.size);
    const Eigen::MatrixXd P = covariance.block(part.begin, part.begin, part.size, part.size);
    if (!e.allFinite() || !P.allFinite()) {
        return kNan;
    }
    // Scaled to unit diagonal: radians and metres differ by orders of magnitude.
    const Eigen::VectorXd scale = sample.sigma.segment(part.begin, part.size);
    if (!(scale.minCoeff() > 0.0)) {
        return kNan;
    }
    const Eigen::VectorXd inverse = scale.cwiseInverse();
    const Eigen::LLT<Eigen::MatrixXd> llt(inverse.asDiagonal() * P * inverse.asDiagonal());
    if (llt.info() != Eigen::Success) {
        return kNan;
    }
    return llt.matrixL().solve(inverse.cwiseProduct(e)).squaredNorm();
}

ClaimedError compare(const GroundTruthState& truth, const UncertainState& estimate, const Se3& T_E_W) {
    ClaimedError sample;
    sample.stamp = estimate.stamp;
    const PoseDifference pose = pose_difference(estimate.T_W_B, T_E_W * Se3{truth.q_W_B, truth.p_W_B});
    sample.error.segment<3>(0) = pose.theta;
    sample.error.segment<3>(3) = pose.p;
    sample.error.segment<3>(6).setConstant(kNan);
    if (truth.has_motion) {
        sample.error.segment<3>(6) = T_E_W.q * truth.v_W_B - estimate.v_W_B;
    }
    sample.sigma = estimate.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        sample.nees[k] = nees(kClaimParts[k], sample, estimate.covariance);
    }
    return sample;
}

NeesStatistics statistics(std::size_t k, std::span<const ClaimedError> samples) {
    const ClaimPart& part = kClaimParts[k];
    const ChiSquareBand band = chi_square_band(part.size);
    NeesStatistics s;
    std::size_t inside = 0;
    std::size_t above = 0;
    std::size_t components = 0;
    for (const ClaimedError& sample : samples) {
        const double value = sample.nees[k];
        if (std::isnan(value)) {
            continue;
        }
        ++s.count;
        s.mean += value;
        inside += value >= band.low && value <= band.high ? 1 : 0;
        above += value > band.high ? 1 : 0;
        for (int i = part.begin; i < part.begin + part.size; ++i) {
            components += std::abs(sample.error[i]) <= 3.0 * sample.sigma[i] ? 1 : 0;
        }
    }
    const double weight = s.count > 0 ? 1.0 / static_cast<double>(s.count) : 0.0;
    s.mean *= weight;
    s.inside_95 = weight * static_cast<double>(inside);
    s.above_95 = weight * static_cast<double>(above);
    s.within_3_sigma = weight * static_cast<double>(components) / part.size;
    return s;
}

}  // namespace

ChiSquareBand chi_square_band(int dof) {
    FACET_ASSERT(dof == 3 || dof == 6);
    return dof == 3 ? ChiSquareBand{0.215795, 9.348404} : ChiSquareBand{1.237344, 14.449375};
}

Consistency evaluate_consistency(std::span<const GroundTruthState> truth, std::span<const UncertainState> estimate,
                                 Duration max_gap) {
    Consistency result;
    const std::vector<Pair> pairs = pair_up(truth, estimate, max_gap);
    const Pair* const best = best_placed(pairs);
    if (best == nullptr) {
        return result;
    }
    result.gauge_stamp = best->estimate->stamp;
    const Se3 T_E_W = gauge(best->truth, *best->estimate);
    for (const Pair& pair : pairs) {
        if (&pair != best) {
            result.samples.push_back(compare(pair.truth, *pair.estimate, T_E_W));
            result.unusable += std::isnan(result.samples.back().nees[0]) ? 1 : 0;
        }
    }
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        result.parts[k] = statistics(k, result.samples);
    }
    return result;
}

void write_errors(const Consistency& consistency, const std::string& path) {
    TextFile file(path);
    file.write("stamp_ns");
    for (const char* group : {"error", "sigma"}) {
        for (const char* part : {"theta", "p", "v"}) {
            for (const char axis : {'x', 'y', 'z'}) {
                file.print(",{}_{}_{}", group, part, axis);
            }
        }
    }
    for (const ClaimPart& part : kClaimParts) {
        file.print(",nees_{}", part.name);
    }
    file.write("\n");
    for (const ClaimedError& sample : consistency.samples) {
        file.print("{}", sample.stamp.ns);
        for (const double value : sample.error) {
            file.print(",{:.9g}", value);
        }
        for (const double value : sample.sigma) {
            file.print(",{:.9g}", value);
        }
        for (const double value : sample.nees) {
            file.print(",{:.9g}", value);
        }
        file.write("\n");
    }
    file.close();
}

}  // namespace facet
