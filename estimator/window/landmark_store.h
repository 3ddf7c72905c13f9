// SPDX-License-Identifier: BSD-2-Clause
// The window's landmarks with their observations: fixed capacity, found by id.
#pragma once

#include <array>
#include <boost/container/static_vector.hpp>
#include <cstdint>

#include "estimator/factors/stereo_factor.h"
#include "estimator/geometry/inverse_depth.h"
#include "estimator/values/capacity.h"
#include "platform/base/typed_id.h"

namespace facet {

/// A sighting of a landmark by one keyframe of the window.
struct LandmarkObservation {
    int keyframe = 0;                                          ///< index in the window, 0 = oldest
    StereoMeasurement measurement;                             ///< corrected for what is known of the lenses
    Eigen::Vector2d given_left_xy = Eigen::Vector2d::Zero();   ///< with the lens as given
    Eigen::Vector2d given_right_xy = Eigen::Vector2d::Zero();  ///< likewise
    LensJacobian d_left_d_lens = LensJacobian::Zero();
    LensJacobian d_right_d_lens = LensJacobian::Zero();
};

/// What a linearization finds of a landmark.
struct LandmarkFit {
    InverseDepthPoint point;     ///< chart: left camera of the first observation's keyframe
    double cost = 0.0;           ///< robust
    double squared_error = 0.0;  ///< whitened squared residual
    double plane_chi2 = 0.0;     ///< squared height above its plane, in variances, if it were not held on it
};

/// A tracked point. Its position is not part of the state: it is computed again from the poses at each linearization.
struct Landmark : LandmarkFit {
    LandmarkId id;
    boost::container::static_vector<LandmarkObservation, kMaxKeyframes> observations;  ///< ascending keyframes
    bool has_point = false;         ///< point is a usable first guess
    bool is_active = false;         ///< takes part in the current optimization
    int plane = kNoPlane;           ///< index of the window's plane that it lies on
    int proposed_plane = kNoPlane;  ///< likewise, of the plane that the mesh sees it on
    int plane_misfits = 0;          ///< number of times it left a plane because it did not fit
    bool is_projected = false;      ///< has projection factors as published (PublishedWeights), not structureless ones

    static constexpr int kNoPlane = -1;
};

/// Landmarks by increasing id. When full, a new landmark is rejected: make_room() first. Iteration is in order of ids,
/// so results do not depend on storage.
/// Thread-bound. No heap.
class LandmarkStore {
public:
    LandmarkStore();

    void clear();
    int size() const { return static_cast<int>(order_.size()); }
    /// The i-th landmark in order of ids.
    Landmark& operator[](int i) { return slots_[order_[static_cast<std::size_t>(i)].slot]; }
    const Landmark& operator[](int i) const { return slots_[order_[static_cast<std::size_t>(i)].slot]; }

    /// Landmark of this id, or nullptr.
    Landmark* find(LandmarkId id);

    /// Finds or inserts. @return nullptr if full.
    Landmark* find_or_insert(LandmarkId id);

    /// Makes room for so many new landmarks, as far as those whose track ended before keyframe `newest` leave any: the
    /// ones with the fewest observations go first, which say the least, and of these the oldest.
    /// @return how many have gone
    int make_room(int wanted, int newest);

    /// Removes every landmark for which predicate(landmark) holds.
    template <class Predicate>
    void remove_if(Predicate predicate) {
        std::size_t kept = 0;
        for (const Entry entry : order_) {
            if (predicate(slots_[entry.slot])) {
                free_.push_back(entry.slot);
            } else {
                order_[kept++] = entry;
            }
        }
        order_.resize(kept);
    }

private:
    struct Entry {
        LandmarkId id;
        std::uint16_t slot;
    };
    std::array<Landmark, kMaxLandmarks> slots_;
    boost::container::static_vector<Entry, kMaxLandmarks> order_;
    boost::container::static_vector<std::uint16_t, kMaxLandmarks> free_;
};

}  // namespace facet
