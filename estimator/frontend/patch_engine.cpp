// SPDX-License-Identifier: BSD-2-Clause
// Our own detector, tracker and stereo matcher as a FeatureEngine. Heap: in configure() only.
#include "estimator/frontend/feature_engine.h"

namespace facet {
namespace {

class PatchEngine final : public FeatureEngine {
public:
    Status configure(const FrontendConfig& config, const StereoRig& rig) override {
        FACET_TRY(tracker_.configure(config, rig.left));
        FACET_TRY(stereo_matcher_.configure(config, rig));
        detector_.configure(config, rig.left, tracker_.border_px());
        return Status::kOk;
    }
    void reset() override { tracker_.reset(); }
    void correct(const CameraCorrections& corrections) override { stereo_matcher_.correct(corrections); }
    void begin_frame(const ImagePyramid& /*left*/) override {}
    void begin_right(const ImagePyramid& /*right*/) override {}

    void detect(const ImagePyramid& left, const PixelMask& mask, Timestamp now,
                std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners) override {
        detector_.detect(left.level(0), occupied, wanted, corners, &mask, now);
    }
    Status start(const ImagePyramid& left, const Eigen::Vector2d& uv, Track& track) override {
        return tracker_.start(left, uv, track);
    }
    void stop(const Track& track) override { tracker_.stop(track); }

    int reach() const override { return kMaxTurns; }
    void follow(const ImagePyramid& earlier, const ImagePyramid& present, const FrameMotion& motion,
                std::span<Track> tracks, std::span<std::uint8_t> followed) override {
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            followed[i] = ok(tracker_.follow(earlier, present, motion, tracks[i])) ? 1 : 0;
        }
    }
    Status find_again(const ImagePyramid& left, const LandmarkPrediction& prediction, const Eigen::Quaterniond& q_C_Cl,
                      Track& track, Eigen::Vector2d& shift) override {
        return tracker_.find_again(left, prediction, q_C_Cl, track, shift);
    }
    void match(const ImagePyramid& left, const ImagePyramid& right, std::span<const StereoQuery> queries,
               double /*usual_inverse_depth*/, std::span<StereoMatch> matches, std::span<std::uint8_t> found) override {
        for (std::size_t i = 0; i < queries.size(); ++i) {
            const StereoQuery& query = queries[i];
            const Status status =
                stereo_matcher_.match(left, right, query.left_uv, query.known_inverse_depth, matches[i]);
            found[i] = ok(status) ? 1 : 0;
        }
    }

private:
    Detector detector_;
    Tracker tracker_;
    StereoMatcher stereo_matcher_;
};

}  // namespace

std::unique_ptr<FeatureEngine> make_patch_engine() { return std::make_unique<PatchEngine>(); }

}  // namespace facet
