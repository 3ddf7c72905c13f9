// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/place_memory.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "estimator/values/stereo_depth.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

/// A station follows the last one when the vehicle has moved this far, turned this much, or time has passed.
constexpr double kStationDistance_m = 0.25;
constexpr double kStationTurn_rad = 0.17;
constexpr double kStationTime_s = 1.0;
/// Points are spread over the image: at most so many in each of 8 x 6 cells.
constexpr int kColumns = 8;
constexpr int kRows = 6;
constexpr int kPerCell = 4;
constexpr double kMaxDepthSigma = 0.15;  ///< relative: a point less certain than that is of no use as a landmark
/// What odometry between two stations is at least uncertain by: 0.1 mrad and 0.3 mm, or a singular covariance would say
/// that a window that has not moved knows everything.
constexpr double kMinYaw_rad = 1e-4;
constexpr double kMinPlace_m = 3e-4;

double depth_sigma_of(const LandmarkSnapshot& s, const KeyframeView& view) {
    return static_cast<double>(s.depth_sigma_m) / static_cast<double>(s.depth_m) *
           std::sqrt(std::max(1.0, view.observation_variance));
}

/// 0 if there are none.
float median_depth(std::span<const LandmarkSnapshot> points) {
    FixedVector<float, kMaxPlacePoints> depths;
    for (const LandmarkSnapshot& point : points) {
        depths.push_back(point.depth_m);
    }
    auto* const middle = depths.begin() + depths.size() / 2;
    std::nth_element(depths.begin(), middle, depths.end());
    return depths.empty() ? 0.0F : *middle;
}

float shared_rho_sigma(const PlaceView& place, const StereoRig& rig, const KeyframeView& view) {
    return static_cast<float>(inverse_depth_sigma(static_cast<double>(place.depth_m), rig, view.cameras));
}

/// The symmetric matrix without its negative part, on top of the least uncertainty of a step.
YawPose::Covariance at_least_the_least(const YawPose::Covariance& q) {
    const Eigen::SelfAdjointEigenSolver<YawPose::Covariance> eigen(0.5 * (q + q.transpose()));
    YawPose::Covariance positive =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
    positive(0, 0) += kMinYaw_rad * kMinYaw_rad;
    positive.diagonal().tail<3>().array() += kMinPlace_m * kMinPlace_m;
    return positive;
}

}  // namespace

void PlaceMemory::configure(const StereoRig& rig) {
    rig_ = rig;
    lens_ = rig.left;
    const CameraIntrinsics& k = rig.left.intrinsics();
    FACET_ASSERT(ok(pyramid_.configure(k.width, k.height, kPlaceLevels)));  // the estimator has more levels
    places_.clear();
    places_.reserve(kMaxPlaces);
    graph_.configure();
    node_covariance_.clear();
    node_covariance_.reserve(PlaceGraph::kMaxNodes);
    open_.clear();
    votes_.clear();
    stage_ = Stage::kIdle;
    is_located_ = true;
    segment_ = 0;
    disagreeing_.reset();
    resets_ = 0;
    covariance_.setZero();
    T_M_O_ = {};
    is_graph_stale_ = false;
    found_.clear();
    counters_ = {};
}

Status PlaceMemory::load(std::span<const MappedPlace> places) {
    if (places.size() > kMaxPlaces) {
        return Status::kFull;
    }
    places_.clear();
    for (const MappedPlace& place : places) {
        places_.push_back({place.view, place.T_M_K, std::nullopt, 0});
    }
    is_located_ = places_.empty();
    graph_.set_floating(!places_.empty());
    return Status::kOk;
}

PlaceCounters PlaceMemory::counters() const {
    PlaceCounters counters = counters_;
    counters.places = static_cast<int>(places_.size());
    counters.nodes = static_cast<int>(graph_.size());
    return counters;
}

YawPose::Covariance PlaceMemory::covariance_of(const Place& place) const {
    return place.node ? node_covariance_[*place.node] : YawPose::Covariance(YawPose::Covariance::Zero());
}

void PlaceMemory::add(const KeyframeView& view, std::uint32_t resets, const ImageView& left) {
    if (resets != resets_) {
        resets_ = resets;
        forget_unlocated();
        open_.clear();
        stage_ = Stage::kIdle;
        is_located_ = is_located_ && graph_.size() == 0;
        segment_ = graph_.size();
        disagreeing_.reset();
        votes_.clear();
    }
    const CameraIntrinsics& k = rig_.left.intrinsics();
    if (view.is_exchanged || left.empty() || left.width != k.width || left.height != k.height) {
        return;
    }
    follow(view);
    if (stage_ == Stage::kIdle && is_station(view)) {
        begin_station(view, left);
    }
}

/// Brings the stations in the window to what it knows of them now.
void PlaceMemory::follow(const KeyframeView& view) {
    oldest_in_window_ = view.oldest_stamp;
    for (std::size_t i = 0; i < open_.size();) {
        OpenStation& open = open_[i];
        const auto* const pose = std::ranges::find(view.keyframes, open.stamp, &KeyframePose::stamp);
        if (pose != view.keyframes.end()) {
            refresh(open, pose->T_W_C0, view);
        }
        if (open.stamp < view.oldest_stamp) {
            open_.erase_at(i);
        } else {
            ++i;
        }
    }
    for (std::size_t i = 1; i < open_.size(); ++i) {
        if (open_[i].node == open_[i - 1].node + 1 && open_[i].node != segment_) {
            graph_.set_odometry(open_[i].node, open_[i - 1].T_O_G.inverse() * open_[i].T_O_G);
        }
    }
    if (!open_.empty() && graph_.loop_count() == 0) {  // the map's frame is the odometry's
        const OpenStation& first = open_.front();
        graph_.lay_out_from(first.node, first.node == 0 ? first.T_O_G : graph_.node(first.node).T_M);
    }
    follow_graph();
}

void PlaceMemory::follow_graph() {
    if (!open_.empty() && is_located_) {
        T_M_O_ = graph_.node(open_.back().node).T_M * open_.back().T_O_G.inverse();
    }
}

void PlaceMemory::refresh(OpenStation& open, const Se3& T_O_C, const KeyframeView& view) {
    const Eigen::Matrix3d r = T_O_C.R();
    open.T_O_G = {yaw_between(open.R_O_C, r), T_O_C.p};
    if (!open.place) {
        return;
    }
    PlaceView& known = places_[*open.place].view;
    const YawPose T_G_O = open.T_O_G.inverse();
    known.q_G_C = Eigen::Quaterniond(yaw_matrix(-open.T_O_G.yaw) * r).normalized().cast<float>();
    known.shared_rho_sigma = shared_rho_sigma(known, rig_, view);
    const double variance = std::max(1.0, view.observation_variance);
    for (std::size_t i = 0; i < known.points.size(); ++i) {
        const auto* const s = std::ranges::lower_bound(view.landmarks, open.ids[i].value, {},
                                                       [](const LandmarkSnapshot& l) { return l.id.value; });
        if (s == view.landmarks.end() || s->id.value != open.ids[i].value) {
            continue;
        }
        const Eigen::Vector3d p_G = T_G_O * s->p_W;
        const Eigen::Vector3d ray_W = (s->p_W - T_O_C.p).normalized();
        known.points[i].p_G = p_G.cast<float>();
        known.points[i].depth_sigma =
            static_cast<float>(std::sqrt(variance * ray_W.dot(s->covariance_W.cast<double>() * ray_W)) / p_G.norm());
    }
}

bool PlaceMemory::is_station(const KeyframeView& view) const {
    if (graph_.size() == segment_ || !is_located_) {
        return true;  // the first one since a restart, or all that can help to be located
    }
    const Eigen::Vector3d turn = so3_log(T_O_C_.q.conjugate() * view.T_W_C0.q);
    return (view.T_W_C0.p - T_O_C_.p).norm() > kStationDistance_m || turn.norm() > kStationTurn_rad ||
           (view.stamp - station_.view.stamp).seconds() > kStationTime_s;
}

void PlaceMemory::begin_station(const KeyframeView& view, const ImageView& left) {
    thin_out();
    pyramid_.build(left);
    lens_ = corrected(rig_.left, view.cameras.lens[0]);
    add_node(view);
    ++station_.number;
    station_.node = graph_.size() - 1;
    station_.T_O_G = {0.0, view.T_W_C0.p};
    station_.view.stamp = view.stamp;
    station_.view.q_G_C = view.T_W_C0.q.cast<float>();
    station_.view.points.clear();
    station_.ids.clear();
    choose_points(view);
    station_.view.depth_m = median_depth({station_.chosen.data(), station_.chosen.size()});
    station_.view.shared_rho_sigma = shared_rho_sigma(station_.view, rig_, view);
    if (open_.full()) {
        open_.erase_at(0);
    }
    open_.push_back({view.stamp, station_.node, station_.T_O_G, view.T_W_C0.R(), std::nullopt, {}});
    T_O_C_ = view.T_W_C0;
    odometry_ = view.heading_and_place;
    found_.clear();
    found_places_.clear();
    stage_ = Stage::kDescribe;
}

/// Its odometry since the last station is as uncertain as the estimate's heading and place have become on the way:
/// what they have now, less what they had then as the way has carried it here.
void PlaceMemory::add_node(const KeyframeView& view) {
    const YawPose T_O_G{0.0, view.T_W_C0.p};
    PlaceGraph::Node node;
    if (graph_.size() == segment_) {
        node.T_M = T_M_O_ * T_O_G;
        node.before.information *= PlaceGraph::kUnknown;
        if (graph_.size() > 0) {
            node.before.T_a_b = graph_.node(graph_.size() - 1).T_M.inverse() * node.T_M;
        }
        covariance_ += view.heading_and_place;
    } else {
        // The last station's pose as known when it was taken; follow() refines what the window still holds.
        const YawPose T_O_last = open_.empty() ? station_.T_O_G : open_.back().T_O_G;
        node.before.T_a_b = T_O_last.inverse() * T_O_G;
        const Eigen::Matrix4d carry = carried_by(T_O_G.p - T_O_last.p);
        const YawPose::Covariance q_O =
            at_least_the_least(view.heading_and_place - carry * odometry_ * carry.transpose());
        const Eigen::Matrix4d to_last = turned_by(-T_O_last.yaw);
        node.before.information = (to_last * q_O * to_last.transpose()).inverse();
        const PlaceGraph::Node& last = graph_.node(graph_.size() - 1);
        node.T_M = last.T_M * node.before.T_a_b;
        const Eigen::Matrix4d carry_M = carried_by(node.T_M.p - last.T_M.p);
        const Eigen::Matrix4d to_map = turned_by(T_M_O_.yaw);
        covariance_ = carry_M * covariance_ * carry_M.transpose() + to_map * q_O * to_map.transpose();
    }
    graph_.add_node(node);
    node_covariance_.push_back(covariance_);
}

/// Landmarks first, then points that this keyframe alone has measured.
void PlaceMemory::choose_points(const KeyframeView& view) {
    const CameraIntrinsics& k = rig_.left.intrinsics();
    std::array<int, static_cast<std::size_t>(kColumns) * kRows> count{};
    station_.chosen.clear();
    const auto offer = [&](const LandmarkSnapshot& s) {
        if (!s.is_tracked || s.depth_m <= 0.0F || station_.chosen.full() || depth_sigma_of(s, view) > kMaxDepthSigma) {
            return;
        }
        const int column = std::clamp(static_cast<int>(s.left_px.x()) * kColumns / k.width, 0, kColumns - 1);
        const int row = std::clamp(static_cast<int>(s.left_px.y()) * kRows / k.height, 0, kRows - 1);
        int& in_cell = count[static_cast<std::size_t>(row * kColumns + column)];
        if (in_cell < kPerCell) {
            ++in_cell;
            station_.chosen.push_back(s);
        }
    };
    std::ranges::for_each(view.landmarks, offer);
    std::ranges::for_each(view.surface, offer);
    for (LandmarkSnapshot& s : station_.chosen) {
        s.depth_sigma_m = static_cast<float>(depth_sigma_of(s, view));  // relative from here on
    }
}

/// Places whose pose in the map was never found, and never will be.
void PlaceMemory::forget_unlocated() {
    if (!is_located_) {
        std::erase_if(places_, [this](const Place& place) { return place.node && *place.node >= segment_; });
    }
}

/// Makes room for a node: the oldest one that is no place goes.
void PlaceMemory::thin_out() {
    if (graph_.size() < PlaceGraph::kMaxNodes) {
        return;
    }
    std::array<bool, PlaceGraph::kMaxNodes> is_kept{};
    is_kept[segment_] = true;
    for (const Place& place : places_) {
        if (place.node) {
            is_kept[*place.node] = true;
        }
    }
    std::size_t i = 1;
    while (i + kMaxKeyframes + 1 < graph_.size() && is_kept[i]) {
        ++i;
    }
    graph_.remove(i);
    node_covariance_.erase(node_covariance_.begin() + static_cast<std::ptrdiff_t>(i));
    const auto shift = [i](std::size_t& node) { node -= node > i ? 1 : 0; };
    for (Place& place : places_) {
        if (place.node) {
            shift(*place.node);
        }
    }
    for (OpenStation& open : open_) {
        shift(open.node);
    }
    shift(station_.node);
    shift(segment_);
    if (disagreeing_) {
        shift(*disagreeing_);
    }
}

}  // namespace facet
