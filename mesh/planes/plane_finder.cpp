// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_finder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/base/angle.h"

namespace facet {
namespace {

// Of the faces with at least two corners on a plane, the least share with all three corners on it. Faces whose third
// corner is too uncertain to be on any plane do not count where the plane's faces cover two fifths of it.
constexpr double kMinCoherence = 0.55;
// Largest root mean square of the part of a plane's residuals that neighbouring points share (m).
constexpr double kMaxRoughness_m = 0.010;
// Landmarks within this distance of a candidate take part in its first fit (m).
constexpr double kSearchGate_m = 0.15;
// What the votes for a candidate, weighted areas of faces, come to at least: of the least area of a new plane.
constexpr double kMinSupport = 4.0 / 7.0;
// Least number of landmarks of a new plane, and least standard deviation of them along its shorter side (m).
constexpr int kMinLandmarks = 14;
constexpr double kMinExtent_m = 0.12;
constexpr std::size_t kMinProposed = 3;  // landmarks: fewer do not determine a plane
constexpr int kDoubtsToWithhold = 2;     // a single doubtful keyframe may be chance
constexpr double kSlantedAreas = 2.0;    // what a slanted plane needs of the area that others do: two angles more that
                                         // clutter may be flat at
constexpr double kLeastCover = 0.4;      // of a plane by its faces, where its neighbours say nothing

std::span<const std::uint16_t> on(const PlaneSupport& support) {
    return {support.points.data(), support.points.size()};
}

bool is_usable(const PlaneEstimate& e) {
    return e.id.valid() && e.normal_W.allFinite() && std::isfinite(e.distance_m) &&
           std::abs(e.normal_W.norm() - 1.0) < 1e-6;
}

}  // namespace

Status PlaneFinder::configure(const PlaneConfig& config) {
    FACET_TRY(config.validate());
    config_ = config;
    counters_ = {};
    next_serial_ = 1;
    next_id_ = 0;
    reset();
    return Status::kOk;
}

void PlaneFinder::reset() {
    planes_.clear();
    proposals_.clear();
    merges_.clear();
    evidence_.clear();
    memory_.clear();
    last_view_ = 0;
}

const PlaneProposals& PlaneFinder::update(const HorizonMesh& mesh, const KeyframeView& view) {
    if (view.number <= last_view_) {
        reset();
    }
    last_view_ = view.number;
    merges_.clear();
    here_ = {view.T_W_C0.p, view.heading_and_place};
    evidence_.take(config_, mesh, view);
    take_estimates(view.planes);
    for (TrackedPlane& plane : planes_) {
        follow(plane);
    }
    evidence_.forget_former();
    merge_equal();
    search(view.T_W_C0.p);
    note_sightings();
    retire();
    confirm();
    propose();
    evidence_.remember();
    return proposals_;
}

void PlaneFinder::take_estimates(const PlaneEstimates& estimates) {
    for (TrackedPlane& plane : planes_) {
        const auto at = std::find_if(estimates.begin(), estimates.end(), [&](const PlaneEstimate& e) {
            return is_usable(e) && e.id == plane.proposed && e.kind == plane.kind;
        });
        plane.is_held = at != estimates.end();
        if (plane.is_held) {
            plane.fit.normal_W = at->normal_W;
            plane.fit.distance_m = at->distance_m;
        }
    }
}

/// Updates a known plane at a new keyframe. Its landmarks have moved with the whole map, so the plane is first fitted
/// to all of them; then those that no longer fit leave.
void PlaneFinder::follow(TrackedPlane& plane) {
    const std::span<const PlanePoint> points = evidence_.points();
    evidence_.collect_former(plane.serial, points_);
    const std::span<const std::uint16_t> former{points_.data(), points_.size()};
    if (!plane.is_held && plane.lost == 0) {
        // If that fails the plane stays where it was.
        static_cast<void>(fit_plane(points, former, config_.surface_sigma_m, plane.fit, PlaneBend::kLeave));
    }
    plane.lost += 1;
    plane.landmarks = 0;
    plane.area_m2 = 0.0;
    if (plane.lost > PlaneLimits::kLeaveKeyframes) {
        return;  // only a candidate brings it back
    }
    evidence_.collect(plane.fit, plane.serial, join_gate(), stay_gate(), support_);
    evidence_.weigh(support_);
    PlaneFit fit = plane.fit;
    const Status fitted = plane.is_held ? describe_plane(points, on(support_), config_.surface_sigma_m, fit)
                                        : fit_plane(points, on(support_), config_.surface_sigma_m, fit);
    const Verdict verdict = ok(fitted) ? judge(plane.kind, fit, support_, kKeepSlack) : Verdict::kSmall;
    plane.doubts = verdict == Verdict::kMisshapen ? plane.doubts + 1 : 0;
    if (verdict == Verdict::kPlane) {
        plane.fit = fit;
        plane.lost = 0;
        ++plane.found;
    }
    if (verdict != Verdict::kMisshapen) {
        plane.landmarks = static_cast<int>(support_.points.size());
        plane.area_m2 = support_.area_m2;
    }
    evidence_.own(support_, plane.serial);
}

/// A slanted plane has to be told from level and upright ones once, and may then come nearer to them.
bool PlaneFinder::is_turned_as(PlaneKind kind, const PlaneFit& fit, double slack) const {
    const double limit = std::sin(slack * kRadPerDeg * PlaneLimits::kMaxTilt_deg);
    const double from_level = fit.normal_W.head<2>().norm();
    const double from_upright = std::abs(fit.normal_W.z());
    switch (kind) {
        case PlaneKind::kHorizontal: return from_level <= limit;
        case PlaneKind::kVertical: return from_upright <= limit;
        case PlaneKind::kSlanted: return slack > 1.0 || std::min(from_level, from_upright) > limit;
    }
    return false;
}

double PlaneFinder::least_area(PlaneKind kind) const {
    return (kind == PlaneKind::kSlanted ? kSlantedAreas : 1.0) * config_.min_area_m2;
}

PlaneFinder::Verdict PlaneFinder::judge(PlaneKind kind, const PlaneFit& fit, const PlaneSupport& support,
                                        double slack) const {
    if (!is_turned_as(kind, fit, slack) || fit.chi2 > slack * PlaneLimits::kMaxChi2 ||
        fit.bend_m > slack * PlaneLimits::kMaxBend_m || support.roughness_m > slack * kMaxRoughness_m) {
        return Verdict::kMisshapen;
    }
    const bool is_large = static_cast<double>(fit.points) * slack >= kMinLandmarks &&
                          support.area_m2 * slack >= least_area(kind) && fit.extent_across_m * slack >= kMinExtent_m;
    if (!is_large) {
        return Verdict::kSmall;
    }
    return is_coherent(fit, support, slack) ? Verdict::kPlane : Verdict::kMisshapen;
}

/// Far from the cameras most neighbours of a plane's landmarks are too uncertain to be on it, and so are no evidence
/// against it. Without their say its faces have to cover it: of rough ground, too, a few landmarks far apart lie in a
/// plane.
bool PlaneFinder::is_coherent(const PlaneFit& fit, const PlaneSupport& support, double slack) const {
    const double rectangle_m2 = 12.0 * fit.extent_along_m * fit.extent_across_m;  // if it were filled evenly
    const bool is_covered = slack * support.area_m2 >= kLeastCover * rectangle_m2;
    return slack * (is_covered ? support.known_coherence : support.coherence) >= kMinCoherence;
}

void PlaneFinder::search(const Eigen::Vector3d& origin_W) {
    const auto least = static_cast<float>(kMinSupport * config_.min_area_m2);
    votes_.begin(origin_W);
    evidence_.vote(votes_);
    examine(votes_.find_peaks(least));
    if (config_.find_slanted) {  // among the faces that no level or upright plane has explained
        slants_.begin(origin_W, kRadPerDeg * PlaneLimits::kMaxTilt_deg);
        evidence_.vote(slants_);
        examine(slants_.find_peaks(static_cast<float>(kSlantedAreas) * least));
    }
}

void PlaneFinder::examine(std::span<const PlanePeak> peaks) {
    int tries = 0;
    for (const PlanePeak& peak : peaks) {
        if (++tries > kMaxCandidates) {
            break;
        }
        ++counters_.candidates;
        PlaneFit fit;
        if (refine(peak, fit)) {
            adopt(peak.kind, fit);
        } else {
            ++counters_.refused;
        }
    }
}

/// Fits a candidate with gates that narrow. Most candidates are refused: what refutes them is asked in the order of its
/// cost. @return whether its landmarks, left in support_, look like a plane
bool PlaneFinder::refine(const PlanePeak& peak, PlaneFit& fit) {
    fit.normal_W = peak.normal_W;
    fit.distance_m = peak.distance_m;
    const double wide = kSearchGate_m;
    const double middle = 0.5 * (wide + PlaneLimits::kJoin_m);
    const PlaneGate none;
    const std::array<PlaneGate, 4> gates{PlaneGate{wide, 1e3}, PlaneGate{middle, 1e3}, join_gate(), join_gate()};
    for (std::size_t i = 0; i < gates.size(); ++i) {
        evidence_.collect(fit, 0, gates[i], none, support_);
        if (static_cast<int>(support_.points.size()) < kMinLandmarks) {
            return false;
        }
        if (i + 1 == gates.size()) {
            evidence_.weigh(support_);
            if (!is_supported(peak.kind, support_, 1.0)) {
                return false;
            }
        }
        if (!ok(fit_plane(evidence_.points(), on(support_), config_.surface_sigma_m, fit, PlaneBend::kLeave)) ||
            !is_turned_as(peak.kind, fit, 2.0)) {
            return false;
        }
    }
    if (judge(peak.kind, fit, support_, 1.0) != Verdict::kPlane) {
        return false;
    }
    fit.bend_m = bend_of(evidence_.points(), on(support_), config_.surface_sigma_m, fit);
    return judge(peak.kind, fit, support_, 1.0) == Verdict::kPlane;
}

/// What a plane needs of its faces, whatever its fit.
bool PlaneFinder::is_supported(PlaneKind kind, const PlaneSupport& support, double slack) const {
    return support.area_m2 * slack >= least_area(kind) && support.known_coherence * slack >= kMinCoherence &&
           support.roughness_m <= slack * kMaxRoughness_m;
}

/// A candidate that looks like a plane, its landmarks in support_: a known plane, or a new one.
void PlaneFinder::adopt(PlaneKind kind, const PlaneFit& fit) {
    for (TrackedPlane& plane : planes_) {
        if (!may_be_same(plane, kind, fit)) {
            continue;
        }
        evidence_.collect_owned(plane.serial, others_);
        if (!is_one(plane, {others_.data(), others_.size()}, on(support_), fit)) {
            continue;
        }
        evidence_.own(support_, plane.serial);
        if (plane.lost > 0) {
            counters_.found_again += plane.lost > PlaneLimits::kLeaveKeyframes && plane.id.valid() ? 1 : 0;
            memory_.forget(plane.id);
            plane.fit = plane.is_held ? plane.fit : fit;
            plane.lost = 0;
            plane.doubts = 0;
            ++plane.found;
        }
        plane.landmarks += static_cast<int>(support_.points.size());
        plane.area_m2 += support_.area_m2;
        return;
    }
    if (planes_.full()) {
        ++counters_.crowded_out;
        return;
    }
    TrackedPlane plane;
    plane.serial = next_serial_++;
    plane.kind = kind;
    plane.fit = fit;
    plane.area_m2 = support_.area_m2;
    plane.landmarks = static_cast<int>(support_.points.size());
    plane.found = 1;
    planes_.push_back(plane);
    evidence_.own(support_, plane.serial);
}

void PlaneFinder::propose() {
    proposals_.clear();
    for (TrackedPlane& plane : planes_) {
        plane.is_reported = false;
        if (!plane.id.valid() || plane.lost > PlaneLimits::kLeaveKeyframes || plane.doubts >= kDoubtsToWithhold) {
            continue;
        }
        evidence_.collect_owned(plane.serial, points_);
        if (points_.size() < kMinProposed) {
            continue;
        }
        plane.is_reported = true;
        PlaneProposal& proposal = proposals_.push_back({});
        proposal.id = plane.proposed;
        proposal.kind = plane.kind;
        proposal.normal_W = plane.fit.normal_W;
        proposal.distance_m = plane.fit.distance_m;
        evidence_.choose_spread(plane.fit, {points_.data(), points_.size()}, proposal.landmarks);
    }
    std::sort(proposals_.begin(), proposals_.end(),
              [](const PlaneProposal& a, const PlaneProposal& b) { return a.id < b.id; });
}

const TrackedPlane* PlaneFinder::find(PlaneSerial serial) const {
    const auto* const at =
        std::find_if(planes_.begin(), planes_.end(), [=](const TrackedPlane& p) { return p.serial == serial; });
    return at != planes_.end() ? at : nullptr;
}

void PlaneFinder::flatten(HorizonMesh& mesh) const {
    const auto fit_of = [&](PlaneSerial serial) -> const PlaneFit* {
        const TrackedPlane* const plane = find(serial);
        return plane != nullptr && plane->is_held ? &plane->fit : nullptr;
    };
    evidence_.for_vertices(
        fit_of, [&](VertexSlot slot, const Eigen::Vector3d& shift_W) { mesh.vertex(slot).to_plane_W = shift_W; });
}

void PlaneFinder::label(HorizonMesh& mesh) const {
    const TrackedPlane* plane = nullptr;  // neighbouring faces are mostly of one plane
    const auto fit_of = [&](PlaneSerial serial) -> const PlaneFit* {
        if (plane == nullptr || plane->serial != serial) {
            plane = find(serial);
        }
        return plane != nullptr && plane->id.valid() ? &plane->fit : nullptr;
    };
    evidence_.for_faces(fit_of, [&](FaceIndex face, PlaneSerial serial) {
        mesh.face(face).plane = serial != 0 ? plane->id : PlaneId{};
    });
}

}  // namespace facet
