// SPDX-License-Identifier: BSD-2-Clause
// A memory of places: where the vehicle has been before, it knows again, and what odometry has drifted.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/keyframe_view.h"
#include "mesh/places/correction_votes.h"
#include "mesh/places/place_alignment.h"
#include "mesh/places/place_graph.h"
#include "mesh/places/place_pose.h"
#include "platform/base/image_view.h"
#include "platform/base/status.h"

namespace facet {

/// A place with its pose in the map M.
struct MappedPlace {
    PlaceView view;
    YawPose T_M_K;
};

/// One comparison of a view with a place that had enough in common.
struct Recognition {
    Timestamp stamp;        ///< of the view
    Timestamp place_stamp;  ///< of the place's
    PlacePose pose;
    bool is_accepted = false;
};

struct PlaceCounters {
    int stations = 0;    ///< views compared with the memory
    int recognised = 0;  ///< of them in which a place was recognised, and accepted
    int refused = 0;     ///< of them in which one was, against what is known of the vehicle's pose
    int located = 0;     ///< how often the pose in the map was found without knowing it
    int places = 0;      ///< remembered now
    int nodes = 0;       ///< of the pose graph
};

/// At stations, keyframes some way apart, the view is compared with the places where it may be, from the pose in the
/// map and its covariance. A place recognised becomes a loop of a pose graph of yaw and position (PlaceGraph); a view
/// that shows something new becomes a place. The graph gives map_from_odom(): the odometry itself never jumps.
///
/// After a restart of the estimate and in a map that was loaded the pose in the map is unknown: then all places are
/// compared, the nearest first, until a correction is believed (CorrectionVotes).
///
/// A slice of the work is done at every frame, counted in steps, of which describing a point is one: kSteps each, twice
/// as many while the pose is unknown. Heap in configure() only: 70 MB. Thread-bound. Deterministic.
class PlaceMemory {
public:
    static constexpr int kSteps = 100;
    static constexpr std::size_t kCandidates = 3;  ///< places compared at a station while the pose is known

    void configure(const StereoRig& rig);
    /// A map of another flight: its places stay where they are, and this flight is located in it. Before the first
    /// add(). @return kFull if there are more than kMaxPlaces (nothing changed)
    Status load(std::span<const MappedPlace> places);

    /// A keyframe with its image. One seen by the right camera alone (is_exchanged) is passed over.
    /// @param resets  how often the estimator has restarted
    void add(const KeyframeView& view, std::uint32_t resets, const ImageView& left);
    /// The next slice of work.
    void advance();
    /// All work that is left.
    void finish();

    /// Whether the pose in the map is known: always but after a restart of the estimate, or in a loaded map, until a
    /// place has been recognised.
    bool is_located() const { return is_located_; }
    /// From the odometry's world to the map; the last one known while not located.
    const YawPose& map_from_odom() const { return T_M_O_; }
    /// Of the newest station's pose in the map, order as KeyframeView::HeadingAndPlace.
    const YawPose::Covariance& covariance() const { return covariance_; }

    std::size_t size() const { return places_.size(); }
    /// Whether a place's pose in the map is known: not of those seen since is_located() is false.
    bool is_located(std::size_t i) const { return is_located_ || !places_[i].node || *places_[i].node < segment_; }
    MappedPlace place(std::size_t i) const { return {places_[i].view, pose_of(places_[i])}; }
    /// When the newest station was taken, and what was found there once it is compared.
    Timestamp station_stamp() const { return station_.view.stamp; }
    std::span<const Recognition> recognitions() const { return {found_.data(), found_.size()}; }
    PlaceCounters counters() const;

private:
    enum class Stage : std::uint8_t { kIdle, kDescribe, kCompare };
    struct Place {
        PlaceView view;
        YawPose T_M;                      ///< of a loaded one
        std::optional<std::size_t> node;  ///< none: loaded
        int uses = 0;
    };
    struct Candidate {
        double rank = 0.0;  ///< least first
        std::size_t place = 0;
        auto operator<=>(const Candidate&) const = default;
    };
    struct Station {
        std::uint32_t number = 0;
        std::size_t node = 0;
        YawPose T_O_G;
        PlaceView view;
        FixedVector<LandmarkSnapshot, kMaxPlacePoints> chosen;  ///< points yet to be described
        FixedVector<LandmarkId, kMaxPlacePoints> ids;           ///< of the view's points
    };
    /// A station whose keyframe is still in the window, which goes on refining it.
    struct OpenStation {
        Timestamp stamp;
        std::size_t node = 0;
        YawPose T_O_G;
        Eigen::Matrix3d R_O_C;             ///< when it was taken
        std::optional<std::size_t> place;  ///< index of the place it became
        FixedVector<LandmarkId, kMaxPlacePoints> ids;
    };

    YawPose pose_of(const Place& place) const { return place.node ? graph_.node(*place.node).T_M : place.T_M; }
    YawPose::Covariance covariance_of(const Place& place) const;
    /// Of the station's pose in the map as a recognised place has it.
    YawPose::Covariance covariance_by(const PlacePose& pose, const Place& place) const;
    /// Takes the newest station's pose in the map over to map_from_odom().
    void follow_graph();

    // Keyframes.
    void follow(const KeyframeView& view);
    void refresh(OpenStation& open, const Se3& T_O_C, const KeyframeView& view);
    bool is_station(const KeyframeView& view) const;
    void begin_station(const KeyframeView& view, const ImageView& left);
    void add_node(const KeyframeView& view);
    void choose_points(const KeyframeView& view);
    void forget_unlocated();
    void thin_out();

    // Work: each returns its steps.
    int step();
    int describe();
    int compare();
    void choose_candidates();
    void end_station();
    bool agrees(const PlacePose& pose, const Place& place) const;
    void accept(Recognition& recognition, std::size_t place);
    void locate(std::size_t place, Recognition& recognition);
    bool is_new() const;
    void keep();
    std::size_t room_for_place();

    StereoRig rig_;
    CameraModel lens_;  ///< of the newest station: the left one as its calibration is known now
    ImagePyramid pyramid_;
    std::vector<Place> places_;
    PlaceGraph graph_;
    std::vector<YawPose::Covariance> node_covariance_;  ///< of each node's pose in the map, when it was added
    FixedVector<OpenStation, kMaxKeyframes> open_;
    CorrectionVotes votes_;

    Stage stage_ = Stage::kIdle;
    Station station_;
    Se3 T_O_C_;                                                                       ///< of the newest station
    KeyframeView::HeadingAndPlace odometry_ = KeyframeView::HeadingAndPlace::Zero();  ///< covariance there
    Timestamp oldest_in_window_;
    std::array<Candidate, kMaxPlaces> candidates_{};
    std::size_t candidate_count_ = 0;
    std::size_t next_ = 0;
    FixedVector<Recognition, kCandidates> found_;
    FixedVector<std::size_t, kCandidates> found_places_;

    bool is_located_ = true;
    std::size_t segment_ = 0;                 ///< first node since the last restart of the estimate
    std::optional<std::size_t> disagreeing_;  ///< first node since which recognitions contradict odometry
    std::uint32_t resets_ = 0;
    YawPose::Covariance covariance_ = YawPose::Covariance::Zero();
    YawPose T_M_O_;
    bool is_graph_stale_ = false;
    PlaceCounters counters_;
};

}  // namespace facet
