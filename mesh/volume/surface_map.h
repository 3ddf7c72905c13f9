// SPDX-License-Identifier: BSD-2-Clause
// The surfaces around the vehicle, from the depth of its keyframes, a slice of work at every frame.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "estimator/frontend/image_pyramid.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/keyframe_view.h"
#include "mesh/capacity.h"
#include "mesh/volume/bare_surfaces.h"
#include "mesh/volume/depth_growth.h"
#include "mesh/volume/depth_samples.h"
#include "mesh/volume/map_config.h"
#include "mesh/volume/partners.h"
#include "mesh/volume/surface_nets.h"
#include "mesh/volume/surface_patches.h"
#include "mesh/volume/tsdf_volume.h"
#include "platform/base/image_view.h"

namespace facet {

/// What has been done since configure().
struct MapCounters {
    std::uint64_t keyframes = 0;  ///< taken
    std::uint64_t skipped =
        0;  ///< that show little new while others wait, or came while too many did, or cannot be matched
    std::uint64_t integrated = 0;  ///< of those taken
    std::uint64_t settled = 0;     ///< of those integrated: have left the window, or were in it at the last keyframe
    double moved_m = 0.0;          ///< sum over `settled`: how far the pose has moved since it was integrated,
    double moved_most_m = 0.0;     ///< and the farthest
    std::uint64_t restarts = 0;    ///< the estimate restarted, and the map with it
};

/// Takes the surface of what has changed.
class SurfaceSink {
public:
    virtual ~SurfaceSink() = default;
    /// @param restart  counts restarts: pieces of different ones do not belong together
    virtual void take(const SurfacePiece& piece, std::uint32_t restart) = 0;
};

/// Several as one.
class SurfaceSinks final : public SurfaceSink {
public:
    /// Borrowed; nullptr: nobody. Heap.
    void add(SurfaceSink* sink) {
        if (sink != nullptr) {
            sinks_.push_back(sink);
        }
    }
    bool empty() const { return sinks_.empty(); }
    void take(const SurfacePiece& piece, std::uint32_t restart) override {
        for (SurfaceSink* const sink : sinks_) {
            sink->take(piece, restart);
        }
    }

private:
    std::vector<SurfaceSink*> sinks_;
};

/// Each keyframe is copied. When kSettle newer ones have come, or it has left the window, one pixel of each of its
/// squares is matched in stereo, near what landmarks and squares around say (DepthGrowth); the farthest view on either
/// side in time that shows the same confirms, sharpens or refutes these depths (choose_partners); pieces of plane are
/// laid through those that agree (fit_patch) and over what is bare between them (BareSurfaces); and these go into the
/// volume with the pose that the window has for it then (TsdfVolume). Every few keyframes the surface is extracted
/// again where voxels have changed (SurfaceNets) and given away. The same parts, with more views and smaller squares,
/// make the fused mesh of a replay.
///
/// Work is counted in steps (MapConfig::steps_per_frame): what a frame costs is bounded, and results depend on the
/// order of calls alone. Only one bare region is looked at in one go. Keyframes wait in a ring; the more of them do,
/// the more a new one must show that the last one did not, or it is skipped.
///
/// After a restart of the estimate the map restarts. When blocks are used up, the farthest leave. Heap in
/// configure() only: max_blocks of 8 KB, and kViews stereo pairs (82 MB as given, with images of 752 x 480).
/// Thread-bound. Deterministic.
class SurfaceMap {
public:
    static constexpr std::size_t kViews = 16;  ///< kept, as partners of one another
    static constexpr std::size_t kSettle = 4;  ///< of them newer than that which is integrated

    /// @return kInvalidArgument if a field is out of range, or the images are too small (the object must not be used
    ///         then).
    Status configure(const MapConfig& config, const StereoRig& rig);

    /// Who is given the surface, a few pieces a frame; borrowed, or nullptr: nobody.
    void give_to(SurfaceSink* sink) { sink_ = sink; }

    /// A keyframe. Images of other sizes than the rig's are left out.
    /// @param resets  how often the estimator has restarted
    void add(const KeyframeView& view, std::uint32_t resets, const ImageView& left, const ImageView& right);

    /// The next slice of work. @return whether some may be left
    bool advance();

    /// All work that is left, on the views still waiting too, and all surface that has changed: at the end of a run, or
    /// whenever there is time.
    void finish();

    const TsdfVolume& volume() const { return *volume_; }
    const MapCounters& counters() const { return counters_; }

private:
    enum class Stage : std::uint8_t { kIdle, kMeasure, kChoose, kCompare, kFit, kBare, kAdd, kUpdate };
    enum class Fate : std::uint8_t { kWaits, kIntegrated, kSettled };
    struct View {
        Timestamp stamp;
        Se3 T_W_C0;
        Se3 T_integrated;  ///< likewise, when it was integrated
        CameraCorrections cameras;
        std::vector<std::uint8_t> left;
        std::vector<std::uint8_t> right;
        FixedVector<DepthSeed, kMaxMeshPoints> seeds;
        bool is_in_window = true;
        Fate fate = Fate::kWaits;
    };
    /// A view that depths are compared with.
    struct Partner {
        std::size_t slot = 0;
        Se3 T_own_other;
    };

    View& view(std::size_t i) { return views_[(oldest_ + i) % kViews]; }
    void restart();
    void follow(const KeyframeView& seen);
    void settle(View& known);
    bool shows_enough(const Se3& T_W_C0);
    bool make_place();
    void take(const KeyframeView& seen, const ImageView& left, const ImageView& right);
    void add_seeds(std::span<const LandmarkSnapshot> landmarks, View& taken) const;

    // Work: each returns its steps.
    std::int64_t step();
    std::int64_t begin_due();
    std::int64_t measure();
    std::int64_t choose();
    double median_depth();
    void begin_partner();
    std::int64_t compare();
    std::int64_t fit();
    void begin_volume();
    void end_view();
    bool extract(std::int64_t steps);
    void extract_all();

    MapConfig config_;
    std::unique_ptr<DepthSampler> sampler_;
    std::unique_ptr<DepthGrowth> growth_;
    std::unique_ptr<SquareRaster> raster_;
    std::unique_ptr<BareSurfaces> bare_;
    std::unique_ptr<TsdfVolume> volume_;
    std::unique_ptr<SurfacePiece> piece_;
    SurfaceNets nets_;
    SquareLayout layout_;
    SurfaceSink* sink_ = nullptr;
    MapCounters counters_;
    std::array<View, kViews> views_;  ///< a ring
    std::size_t oldest_ = 0;
    std::size_t count_ = 0;
    ImagePyramid own_left_;
    ImagePyramid right_;
    ImagePyramid other_left_;
    Eigen::Vector2i left_size_ = Eigen::Vector2i::Zero();
    Eigen::Vector2i right_size_ = Eigen::Vector2i::Zero();
    std::vector<DepthSample> samples_;  ///< of the view that is worked on
    std::vector<SurfacePatch> patches_;
    std::vector<float> depths_;  ///< room to sort
    std::uint32_t resets_ = 0;
    bool is_at_end_ = false;

    Stage stage_ = Stage::kIdle;
    std::size_t own_ = 0;  ///< slot of the view that is worked on
    FixedVector<Partner, 2> partners_;
    std::size_t partner_ = 0;
    int next_ = 0;                ///< square
    std::size_t next_piece_ = 0;  ///< slot
    std::size_t round_left_ = 0;  ///< slots to look at for surface that has changed
};

}  // namespace facet
