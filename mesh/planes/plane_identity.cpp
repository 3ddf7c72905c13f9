// SPDX-License-Identifier: BSD-2-Clause
// Decides which planes are the same one, and which get an id.
#include <algorithm>
#include <cmath>

#include "mesh/planes/plane_finder.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

// A plane is reported once it has been found at this many keyframes.
constexpr int kConfirmKeyframes = 2;
// Two planes farther apart than this at their landmarks are never merged (m).
constexpr double kSameDistance_m = 0.06;
// Two planes whose normals differ by more than this are never merged (deg).
constexpr double kSameAngle_deg = 5.0;
constexpr double kEqualSigmas = 3.0;    // of the difference of two planes
constexpr double kEqualFloor = 0.015;   // m: difference at each other's landmarks that is allowed in any case
constexpr double kEqualTurn = 1.0;      // deg, likewise
constexpr double kDriftPerLoss = 2e-3;  // m a keyframe, of a plane that is not seen

SeenPlane as_seen(const TrackedPlane& plane) {
    return {plane.id, plane.proposed, plane.kind, plane.fit, plane.reach, plane.from};
}

}  // namespace

/// Equal by normal and distance at the place of each other's landmarks.
bool PlaneFinder::may_be_same(const TrackedPlane& a, PlaneKind kind, const PlaneFit& fit) const {
    if (!may_be_one(a.kind, kind)) {
        return false;
    }
    const double drift = kDriftPerLoss * a.lost;
    const auto turn_variance = [](const PlaneFit& f) {
        return f.sigma_along_rad * f.sigma_along_rad + f.sigma_across_rad * f.sigma_across_rad;
    };
    const double turn_sigma = std::sqrt(turn_variance(a.fit) + turn_variance(fit));
    const double turn = std::min(kRadPerDeg * kSameAngle_deg, kRadPerDeg * kEqualTurn + kEqualSigmas * turn_sigma);
    if (a.fit.normal_W.dot(fit.normal_W) < std::cos(turn)) {
        return false;
    }
    const auto is_near = [&](const PlaneFit& plane, const PlaneFit& other) {
        const double sigma = std::hypot(plane.sigma_at(other.centroid_W), other.sigma_m, drift);
        return std::abs(plane.residual(other.centroid_W)) <=
               std::min(kSameDistance_m, kEqualFloor + kEqualSigmas * sigma);
    };
    return is_near(a.fit, fit) && is_near(fit, a.fit);
}

/// Whether one plane fits the landmarks of both. If the estimator has the known plane among its variables, others are
/// held on that, wherever their own surface is: they have to lie on it as it is. If one has none any more, their
/// surfaces have to be beside each other: elsewhere there may be another plane like it.
bool PlaneFinder::is_one(const TrackedPlane& known, std::span<const std::uint16_t> a, std::span<const std::uint16_t> b,
                         const PlaneFit& start) {
    if (known.is_held && b.size() >= static_cast<std::size_t>(kMinFitPoints)) {
        PlaneFit fit = known.fit;
        return ok(describe_plane(evidence_.points(), b, config_.surface_sigma_m, fit, PlaneBend::kLeave)) &&
               fit.chi2 <= kKeepSlack * PlaneLimits::kMaxChi2;
    }
    if (a.empty() || b.empty()) {
        PlaneReach reach;
        reach.extend(start);
        return a.size() + b.size() > 0 && known.reach.distance(reach) <= PlaneReach::kBeside_m;
    }
    points_.clear();
    for (const auto part : {a, b}) {
        for (const std::uint16_t p : part) {
            static_cast<void>(points_.try_push_back(p));
        }
    }
    PlaneFit fit = start;
    return ok(fit_plane(evidence_.points(), {points_.data(), points_.size()}, config_.surface_sigma_m, fit)) &&
           fit.chi2 <= kKeepSlack * PlaneLimits::kMaxChi2 && fit.bend_m <= kKeepSlack * PlaneLimits::kMaxBend_m;
}

/// Merges the younger of two equal planes into the older one.
bool PlaneFinder::merge(TrackedPlane& older, const TrackedPlane& younger) {
    if (!may_be_same(older, younger.kind, younger.fit)) {
        return false;
    }
    evidence_.collect_owned(older.serial, support_.points);
    evidence_.collect_owned(younger.serial, others_);
    if (!is_one(older, {support_.points.data(), support_.points.size()}, {others_.data(), others_.size()},
                younger.fit)) {
        return false;
    }
    if (younger.is_held && !older.is_held) {  // the estimator does not have to begin anew, nor to forgive the older one
        older.proposed = younger.proposed;
        older.kind = younger.kind;
        older.is_held = true;
        older.fit = younger.fit;
    }
    evidence_.hand_over(younger.serial, older.serial);
    memory_.forget(older.id);
    memory_.forget(younger.id);
    if (younger.id.valid()) {  // it may have been told the id of the older one while that was out of sight
        if (older.id.valid()) {
            note_merge(older.id, younger.id);
        }
        older.id = older.id.valid() ? std::min(older.id, younger.id) : younger.id;
    }
    older.reach.extend(younger.reach);
    if (older.lost > younger.lost) {
        older.fit = older.is_held ? older.fit : younger.fit;
        older.from = younger.from;
        older.lost = younger.lost;
        older.doubts = 0;
    }
    if (older.id.valid() && older.lost > PlaneLimits::kLeaveKeyframes + 1) {
        memory_.keep(as_seen(older));
    }
    older.landmarks += younger.landmarks;
    older.area_m2 += younger.area_m2;
    return true;
}

void PlaneFinder::note_merge(PlaneId a, PlaneId b) {
    ++counters_.merged;
    static_cast<void>(merges_.try_push_back({std::max(a, b), std::min(a, b)}));
}

void PlaneFinder::merge_equal() {
    for (std::size_t i = 0; i < planes_.size(); ++i) {
        for (std::size_t j = i + 1; j < planes_.size();) {
            // By serial the first is older; but one with an id stays before one without.
            const bool keeps_first = planes_[i].proposed <= planes_[j].proposed;
            if (!merge(keeps_first ? planes_[i] : planes_[j], keeps_first ? planes_[j] : planes_[i])) {
                ++j;
                continue;
            }
            if (!keeps_first) {
                planes_[i] = planes_[j];
            }
            planes_.erase_at(j);
        }
    }
}

/// Where planes were found, and from where.
void PlaneFinder::note_sightings() {
    for (TrackedPlane& plane : planes_) {
        if (plane.lost > 0) {
            continue;
        }
        plane.reach.extend(plane.fit);
        plane.from = here_;
    }
}

/// A plane leaves. What was too uncertain of it to tell when it came may tell now that it is one which had left before:
/// then the two are one from here on, under the older id and, if the estimator has it still, the older variable.
void PlaneFinder::remember(TrackedPlane& plane) {
    memory_.forget(plane.id);
    SeenPlane known;
    if (ok(memory_.recall_there(as_seen(plane), known))) {
        note_merge(known.id, plane.id);
        const auto followed =
            std::find_if(planes_.begin(), planes_.end(), [&](const TrackedPlane& p) { return p.id == known.id; });
        if (followed != planes_.end()) {
            if (followed->is_held) {
                plane.proposed = followed->proposed;
                plane.kind = followed->kind;
            }
            followed->id = {};  // so that it is given up
        }
        plane.id = std::min(plane.id, known.id);
        plane.reach.extend(known.reach);
    }
    memory_.keep(as_seen(plane));
}

void PlaneFinder::retire() {
    for (TrackedPlane& plane : planes_) {
        if (plane.id.valid() && plane.lost == PlaneLimits::kLeaveKeyframes + 1 &&
            plane.doubts < PlaneLimits::kLeaveKeyframes) {
            remember(plane);
        }
    }
    for (std::size_t i = 0; i < planes_.size();) {
        const TrackedPlane& plane = planes_[i];
        const bool is_doubtful = plane.doubts >= PlaneLimits::kLeaveKeyframes;
        if (plane.id.valid() && is_doubtful) {  // its landmarks may form it again when seen from elsewhere
            memory_.keep(as_seen(plane));
        }
        const bool is_gone = plane.id.valid()
                                 ? plane.lost > PlaneLimits::kLeaveKeyframes + PlaneLimits::kForgetKeyframes
                                 : plane.lost >= kConfirmKeyframes;
        if (plane.lost == PlaneLimits::kLeaveKeyframes + 1 || is_doubtful || is_gone) {
            evidence_.release(plane.serial);
        }
        if (is_doubtful || is_gone) {
            counters_.doubted += is_doubtful && plane.id.valid() ? 1 : 0;
            counters_.forgotten += !is_doubtful && plane.id.valid() ? 1 : 0;
            planes_.erase_at(i);
        } else {
            ++i;
        }
    }
}

int PlaneFinder::confirmed() const {
    return static_cast<int>(
        std::count_if(planes_.begin(), planes_.end(), [](const TrackedPlane& p) { return p.id.valid(); }));
}

/// A place for one more plane with an id: the one lost for longest goes. @return false if none is lost
bool PlaneFinder::make_room() {
    if (confirmed() < kMaxPlanes) {
        return true;
    }
    std::size_t longest = planes_.size();
    for (std::size_t i = 0; i < planes_.size(); ++i) {
        if (planes_[i].id.valid() && planes_[i].lost > PlaneLimits::kLeaveKeyframes &&
            (longest == planes_.size() || planes_[i].lost > planes_[longest].lost)) {
            longest = i;
        }
    }
    if (longest == planes_.size()) {
        return false;
    }
    ++counters_.forgotten;
    planes_.erase_at(longest);
    return true;
}

void PlaneFinder::confirm() {
    const auto is_new = [](const TrackedPlane& p) {
        return !p.id.valid() && p.lost == 0 && p.found >= kConfirmKeyframes;
    };
    for (auto next = planes_.begin(); (next = std::find_if(planes_.begin(), planes_.end(), is_new)) != planes_.end();) {
        const PlaneSerial serial = next->serial;
        if (!make_room()) {
            ++counters_.crowded_out;
            return;
        }
        identify(serial);
        ++counters_.confirmed;
    }
}

/// Gives a new plane the numbers of the one that had left and that it is, or new ones. If that one is still followed,
/// the two are the same plane from here on.
void PlaneFinder::identify(PlaneSerial serial) {
    const auto with = [this](auto&& is_it) { return std::find_if(planes_.begin(), planes_.end(), is_it); };
    auto plane = with([=](const TrackedPlane& p) { return p.serial == serial; });
    SeenPlane known;
    if (!ok(memory_.recall(as_seen(*plane), known))) {
        plane->id = plane->proposed = PlaneId{next_id_++};
        return;
    }
    ++counters_.recalled;
    const auto followed = with([&](const TrackedPlane& p) { return p.id == known.id; });
    if (followed != planes_.end()) {
        known.proposed = followed->proposed;
        known.kind = followed->kind;
        planes_.erase_at(static_cast<std::size_t>(followed - planes_.begin()));
        plane = with([=](const TrackedPlane& p) { return p.serial == serial; });
    }
    plane->id = known.id;
    plane->proposed = known.proposed;
    plane->kind = known.kind;
    plane->reach.extend(known.reach);
}

}  // namespace facet
