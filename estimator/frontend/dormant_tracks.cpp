// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/dormant_tracks.h"

#include <algorithm>

namespace facet {
namespace {

/// Shifts may differ by this much from their median: parallax that the predicted pose gets wrong (px).
constexpr double kShiftSpread = 3.0;
/// With fewer points found the median is not reliable.
constexpr std::size_t kEnoughForMedian = 4;
/// Without a median a point must be this near its prediction (px).
constexpr double kSureShift = 2.0;

}  // namespace

const LandmarkPrediction* find_prediction(std::span<const LandmarkPrediction> predictions, LandmarkId id) {
    const auto at = std::lower_bound(predictions.begin(), predictions.end(), id,
                                     [](const LandmarkPrediction& p, LandmarkId i) { return p.landmark < i; });
    return at != predictions.end() && at->landmark == id ? &*at : nullptr;
}

void DormantTracks::configure(const StereoRig& rig) {
    q_C_B_ = rig.T_B_C0.q.conjugate();
    clear();
}

void DormantTracks::add(const Track& track, const Eigen::Quaterniond& q_B0_B, FeatureEngine& engine) {
    if (dormant_.size() == dormant_.capacity()) {
        forget_oldest(engine);
    }
    dormant_.push_back({track, q_B0_B});
}

bool DormantTracks::forget_oldest(FeatureEngine& engine) {
    if (dormant_.empty()) {
        return false;
    }
    engine.stop(dormant_.front().track);
    erase(0);
    return true;
}

void DormantTracks::forget_unknown(std::span<const LandmarkPrediction> predictions, FeatureEngine& engine) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < dormant_.size(); ++i) {
        if (find_prediction(predictions, dormant_[i].track.id) != nullptr) {
            dormant_[kept++] = dormant_[i];
        } else {
            engine.stop(dormant_[i].track);
        }
    }
    dormant_.resize(kept);
}

void DormantTracks::leave_keyframe() {
    for (Dormant& d : dormant_) {
        d.track.in_keyframe = false;
        d.track.has_depth = false;
    }
}

double DormantTracks::median_shift(int axis) {
    values_.clear();
    for (const Found& f : found_) {
        values_.push_back(f.shift(axis));
    }
    const auto middle = values_.begin() + static_cast<std::ptrdiff_t>(values_.size() / 2);
    std::nth_element(values_.begin(), middle, values_.end());
    return *middle;
}

void DormantTracks::recall(const ImagePyramid& image, std::span<const LandmarkPrediction> predictions,
                           const Eigen::Quaterniond& q_B0_B, int most, FeatureEngine& engine, TrackList& tracks) {
    found_.clear();
    for (std::size_t i = 0; i < dormant_.size(); ++i) {
        const LandmarkPrediction* prediction = find_prediction(predictions, dormant_[i].track.id);
        if (prediction == nullptr || !prediction->in_view) {
            continue;
        }
        Found found{i, dormant_[i].track, {}};
        const Eigen::Quaterniond q_C_Cl = q_C_B_ * q_B0_B.conjugate() * dormant_[i].q_B0_B * q_C_B_.conjugate();
        if (ok(engine.find_again(image, *prediction, q_C_Cl, found.track, found.shift)) &&
            found.shift.norm() < FrontendConfig::kRecallRadius_px) {
            found_.push_back(found);
        }
    }
    const bool enough = found_.size() >= kEnoughForMedian;
    const Eigen::Vector2d usual =
        enough ? Eigen::Vector2d(median_shift(0), median_shift(1)) : Eigen::Vector2d(Eigen::Vector2d::Zero());
    for (std::size_t k = found_.size(); k-- > 0;) {
        const Found& found = found_[k];
        if ((found.shift - usual).norm() < (enough ? kShiftSpread : kSureShift) &&
            static_cast<int>(tracks.size()) < most) {
            tracks.push_back(found.track);
            erase(found.index);
        }
    }
}

}  // namespace facet
