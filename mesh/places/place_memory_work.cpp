// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <cmath>

#include "mesh/places/place_memory.h"

namespace facet {
namespace {

/// Steps of the parts of the work that are done in one go.
constexpr int kMatchSteps = 6;
constexpr int kPoseSteps = 60;
constexpr std::size_t kNodesPerStep = 50;  ///< of an iteration of the graph
constexpr double kMaxMiss_px = 2.0;        ///< of a point's pixel from where the window has it
/// A place is compared with a view from up to this far from it, in units of its depth, and this much turned from it.
constexpr double kMaxDistance = 0.7;
constexpr double kMaxTurn_rad = 0.6;
/// A view is of a new place unless one is remembered from this close, in units of its depth, and turned this little.
constexpr double kNewDistance = 0.25;
constexpr double kNewTurn_rad = 0.25;
/// A recognised pose may differ from the one expected by what is known of it, at twice its sigma (99.9 % of four
/// degrees of freedom), on top of what odometry may hide; the twins of a place are further apart.
constexpr double kGate = 18.5;
constexpr double kCaution = 2.0;
constexpr double kHiddenYaw_rad = 0.01;
constexpr double kHiddenPlace_m = 0.05;
/// Stations that must agree on a correction while nothing is known of the pose, and against what is known of it.
constexpr int kAgreeing = 3;
constexpr int kAgreeingAgainst = 6;

/// How alike the outlooks of a view and a place are, least first; nothing if they are not. T_K_G: of the view in the
/// place's frame.
std::optional<double> unlikeness(const PlaceView& view, const PlaceView& place, const YawPose& T_K_G,
                                 double max_distance, double max_turn_rad) {
    const double distance = T_K_G.p.norm() / std::max(0.1, static_cast<double>(place.depth_m));
    const Eigen::Vector3d axis = T_K_G.R() * view.axis_G().cast<double>();
    const double turn = std::acos(std::clamp(axis.dot(place.axis_G().cast<double>()), -1.0, 1.0));
    if (distance > max_distance || turn > max_turn_rad) {
        return std::nullopt;
    }
    return distance / max_distance + turn / max_turn_rad;
}

}  // namespace

void PlaceMemory::advance() {
    int left = is_located_ ? kSteps : 2 * kSteps;
    while (left > 0) {
        const int steps = step();
        if (steps == 0) {
            return;
        }
        left -= steps;
    }
}

void PlaceMemory::finish() {
    while (step() > 0) {
    }
}

int PlaceMemory::step() {
    if (stage_ == Stage::kDescribe) {
        return describe();
    }
    if (stage_ == Stage::kCompare) {
        return compare();
    }
    if (!graph_.is_busy() && is_graph_stale_) {
        is_graph_stale_ = false;
        graph_.begin();
    }
    if (!graph_.is_busy()) {
        return 0;
    }
    if (graph_.advance()) {
        follow_graph();
    }
    return 1 + static_cast<int>(graph_.size() / kNodesPerStep);
}

/// One point.
int PlaceMemory::describe() {
    if (station_.chosen.empty()) {
        choose_candidates();
        stage_ = Stage::kCompare;
        return 1;
    }
    const LandmarkSnapshot& s = station_.chosen.back();
    const Eigen::Vector3d p_G = s.p_W - T_O_C_.p;
    const Eigen::Vector3d down_C = T_O_C_.q.conjugate() * Eigen::Vector3d(0.0, 0.0, -1.0);
    PlacePoint point;
    point.p_G = p_G.cast<float>();
    point.depth_sigma = s.depth_sigma_m;
    UprightSquare square;
    if (ok(upright_square(lens_, T_O_C_.q.conjugate() * p_G, down_C, square)) &&
        (square.centre - s.left_px.cast<double>()).norm() < kMaxMiss_px &&
        ok(facet::describe(pyramid_, square, point.code, point.patch))) {
        station_.view.points.push_back(point);
        station_.ids.push_back(s.id);
    }
    station_.chosen.pop_back();
    return 1;
}

void PlaceMemory::choose_candidates() {
    candidate_count_ = 0;
    next_ = 0;
    if (station_.view.points.size() < static_cast<std::size_t>(kMinInliers)) {
        return;
    }
    const YawPose T_G_M = graph_.node(station_.node).T_M.inverse();
    for (std::size_t i = 0; i < places_.size(); ++i) {
        const Place& place = places_[i];
        const YawPose T_K_G = (T_G_M * pose_of(place)).inverse();
        std::optional<double> rank;
        if (!is_located_) {
            const bool is_of_segment = place.node && *place.node >= segment_;
            rank = is_of_segment ? std::nullopt : std::optional(T_K_G.p.squaredNorm());
        } else if (!place.node || place.view.stamp < oldest_in_window_) {
            rank = unlikeness(station_.view, place.view, T_K_G, kMaxDistance, kMaxTurn_rad);
        }
        if (rank) {
            candidates_[candidate_count_++] = {*rank, i};
        }
    }
    std::sort(candidates_.begin(), candidates_.begin() + static_cast<std::ptrdiff_t>(candidate_count_));
    if (is_located_) {
        candidate_count_ = std::min(candidate_count_, kCandidates);
    }
}

/// One place.
int PlaceMemory::compare() {
    if (next_ == candidate_count_) {
        end_station();
        stage_ = Stage::kIdle;
        return 1;
    }
    const std::size_t index = candidates_[next_++].place;
    const Place& place = places_[index];
    PointMatches matches;
    match_points({station_.view.points.data(), station_.view.points.size()},
                 {place.view.points.data(), place.view.points.size()}, matches);
    if (!is_promising(matches)) {
        return kMatchSteps;
    }
    Recognition recognition{station_.view.stamp, place.view.stamp, {}, false};
    if (ok(find_pose(station_.view, place.view, matches, lens_.focal_px(), station_.number, recognition.pose)) &&
        ok(align_place(pyramid_, lens_, station_.view, place.view, matches, recognition.pose))) {
        if (found_.full()) {  // while all places are compared: the best remain
            const auto* const least =
                std::ranges::min_element(found_, {}, [](const Recognition& r) { return r.pose.inliers; });
            if (least->pose.inliers < recognition.pose.inliers) {
                const auto i = static_cast<std::size_t>(least - found_.begin());
                found_[i] = recognition;
                found_places_[i] = index;
            }
        } else {
            found_.push_back(recognition);
            found_places_.push_back(index);
        }
        if (!is_located_ || !agrees(recognition.pose, place)) {
            if (is_located_ && !disagreeing_) {
                disagreeing_ = station_.node;
            }
            votes_.add(station_.number, station_.T_O_G, pose_of(place) * recognition.pose.T_K_G,
                       recognition.pose.inliers);
            if (votes_.is_settled(is_located_ ? kAgreeingAgainst : kAgreeing)) {
                locate(index, recognition);
            }
        }
    }
    return kMatchSteps + kPoseSteps;
}

YawPose::Covariance PlaceMemory::covariance_by(const PlacePose& pose, const Place& place) const {
    const YawPose T_M_K = pose_of(place);
    const Eigen::Matrix4d turn = turned_by(T_M_K.yaw);
    const Eigen::Matrix4d carry = carried_by(T_M_K.R() * pose.T_K_G.p);
    return carry * covariance_of(place) * carry.transpose() + turn * pose.covariance * turn.transpose();
}

bool PlaceMemory::agrees(const PlacePose& pose, const Place& place) const {
    const YawPose::Tangent d = graph_.node(station_.node).T_M.box_minus_to(pose_of(place) * pose.T_K_G);
    YawPose::Covariance known = covariance_ + covariance_by(pose, place);
    known *= kCaution * kCaution;
    known(0, 0) += kHiddenYaw_rad * kHiddenYaw_rad;
    known.diagonal().tail<3>().array() += kHiddenPlace_m * kHiddenPlace_m;
    return d.dot(known.ldlt().solve(d)) < kGate;
}

/// What was recognised counts.
void PlaceMemory::end_station() {
    bool is_refused = false;
    if (is_located_) {
        for (std::size_t i = 0; i < found_.size(); ++i) {
            if (found_[i].is_accepted) {
                continue;  // by locate()
            }
            if (agrees(found_[i].pose, places_[found_places_[i]])) {
                accept(found_[i], found_places_[i]);
            } else {
                is_refused = true;
            }
        }
    }
    const bool is_recognised = std::ranges::any_of(found_, &Recognition::is_accepted);
    if (is_recognised) {
        disagreeing_.reset();
        votes_.clear();
    }
    ++counters_.stations;
    counters_.recognised += is_recognised ? 1 : 0;
    counters_.refused += is_refused && !is_recognised ? 1 : 0;
    if (station_.view.points.size() >= static_cast<std::size_t>(kMinInliers) && is_new()) {
        keep();
    }
}

void PlaceMemory::accept(Recognition& recognition, std::size_t index) {
    recognition.is_accepted = true;
    Place& place = places_[index];
    ++place.uses;
    const PlaceGraph::Relation relation{recognition.pose.T_K_G, recognition.pose.covariance.inverse()};
    if (place.node) {
        graph_.add_loop(*place.node, station_.node, relation);
    } else {
        graph_.add_fixed(place.T_M, station_.node, relation);
    }
    // Errors of place and path are correlated in a way that is not kept: the better one of both counts.
    const YawPose::Covariance by_place = covariance_by(recognition.pose, place);
    if (by_place.trace() < covariance_.trace()) {
        covariance_ = by_place;
        node_covariance_[station_.node] = covariance_;
    }
    is_graph_stale_ = true;
}

/// The pose in the map is found: all moves there since the last restart or, if odometry has slipped, since it did.
void PlaceMemory::locate(std::size_t index, Recognition& recognition) {
    const YawPose T_M_G = pose_of(places_[index]) * recognition.pose.T_K_G;
    const YawPose moved = T_M_G * graph_.node(station_.node).T_M.inverse();
    const std::size_t first = disagreeing_.value_or(segment_);
    graph_.move_from(first, moved * graph_.node(first).T_M);
    graph_.loosen(first);
    disagreeing_.reset();
    covariance_.setIdentity();
    covariance_ *= 1e6;
    is_located_ = true;
    votes_.clear();
    ++counters_.located;
    accept(recognition, index);
    for (std::size_t i = 0; i < found_.size(); ++i) {
        if (found_places_[i] == index) {
            found_[i].is_accepted = true;
        }
    }
    T_M_O_ = T_M_G * station_.T_O_G.inverse();
    next_ = candidate_count_;
}

/// Whether nothing remembered has been taken from nearly the same pose.
bool PlaceMemory::is_new() const {
    const YawPose T_G_M = graph_.node(station_.node).T_M.inverse();
    const bool is_recognised = std::ranges::any_of(found_, &Recognition::is_accepted);
    for (const Place& place : places_) {
        const bool is_comparable = is_located_ || (place.node && *place.node >= segment_);
        const bool is_in_window = place.node && place.view.stamp >= oldest_in_window_;
        if (!is_comparable || (!is_in_window && !is_recognised)) {
            continue;  // what is not recognised from here looks different now
        }
        const YawPose T_K_G = (T_G_M * pose_of(place)).inverse();
        if (unlikeness(station_.view, place.view, T_K_G, kNewDistance, kNewTurn_rad)) {
            return false;
        }
    }
    return true;
}

/// The station becomes a place.
void PlaceMemory::keep() {
    const std::size_t index = room_for_place();
    places_[index] = {station_.view, {}, station_.node, 0};
    for (OpenStation& open : open_) {
        if (open.node == station_.node) {
            open.place = index;
            open.ids = station_.ids;
        } else if (open.place == index) {
            open.place.reset();
        }
    }
}

/// Where a place may be put: while there is room behind the last one, then in place of the one recognised least often.
std::size_t PlaceMemory::room_for_place() {
    if (places_.size() < kMaxPlaces) {
        places_.emplace_back();
        return places_.size() - 1;
    }
    const auto least = std::ranges::min_element(places_, {}, &Place::uses);
    return static_cast<std::size_t>(least - places_.begin());
}

}  // namespace facet
