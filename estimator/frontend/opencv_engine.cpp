// SPDX-License-Identifier: BSD-2-Clause
// A FeatureEngine that stands on OpenCV: corners by features2d, tracks and stereo matches by video. The one place where
// its exceptions may come up; none leaves it.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>
#include <vector>

#include "estimator/frontend/epipolar_geometry.h"
#include "estimator/frontend/feature_engine.h"

namespace facet {
namespace {

/// Where a point is looked for before any depth is known (1/m).
constexpr double kUsualInverseDepth = 0.25;
/// Candidates asked of the detector, whatever number is wanted: cells without tracks come first, not the best ones.
constexpr int kCandidates = 2 * (kMaxFeatures + kMaxSurfacePoints);

cv::Point2f to_cv(const Eigen::Vector2d& uv) { return {static_cast<float>(uv.x()), static_cast<float>(uv.y())}; }
Eigen::Vector2d from_cv(const cv::Point2f& point) { return {point.x, point.y}; }

cv::Mat mat_of(const ImageView& view) {
    // OpenCV has no read-only headers; nothing writes to this one.
    return cv::Mat(view.height, view.width, CV_8UC1, const_cast<std::uint8_t*>(view.data),
                   static_cast<std::size_t>(view.stride));
}

/// Points of one image searched in another: forward from a guess, then back.
struct FlowBatch {
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;  ///< the guess, then what was found
    std::vector<cv::Point2f> back;
    std::vector<std::uint8_t> found;
    std::vector<std::uint8_t> found_back;
    std::vector<std::size_t> owner;  ///< index of each point's track or query
    std::vector<float> error;

    void clear() {
        from.clear();
        to.clear();
        owner.clear();
    }
    void add(const Eigen::Vector2d& uv, const Eigen::Vector2d& guess, std::size_t index) {
        from.push_back(to_cv(uv));
        to.push_back(to_cv(guess));
        owner.push_back(index);
    }
    bool returned(std::size_t i, double limit_px) const {
        return found[i] != 0 && found_back[i] != 0 && cv::norm(back[i] - from[i]) < limit_px;
    }
};

/// cv::GFTTDetector over the whole image, spread over the cells of the front-end's grid as Detector does;
/// cv::calcOpticalFlowPyrLK from frame to frame and from left to right, from the same predictions and with the same
/// checks as Tracker and StereoMatcher. Tracks have no templates: what is lost is not found again, and a patch follows
/// its own drift. Heap: at every frame, by OpenCV. It runs on the calling thread alone.
class OpenCvEngine final : public FeatureEngine {
public:
    Status configure(const FrontendConfig& config, const StereoRig& rig) override;
    void reset() override {}
    void correct(const CameraCorrections& corrections) override { geometry_.correct(corrections); }
    void begin_frame(const ImagePyramid& left) override;
    void begin_right(const ImagePyramid& right) override { build(right, right_); }
    void detect(const ImagePyramid& left, const PixelMask& mask, Timestamp now,
                std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners) override;
    Status start(const ImagePyramid& left, const Eigen::Vector2d& uv, Track& track) override;
    void stop(const Track& /*track*/) override {}
    int reach() const override { return 1; }
    void follow(const ImagePyramid& earlier, const ImagePyramid& present, const FrameMotion& motion,
                std::span<Track> tracks, std::span<std::uint8_t> followed) override;
    Status find_again(const ImagePyramid& /*left*/, const LandmarkPrediction& /*prediction*/,
                      const Eigen::Quaterniond& /*q_C_Cl*/, Track& /*track*/, Eigen::Vector2d& /*shift*/) override {
        return Status::kNotFound;
    }
    void match(const ImagePyramid& left, const ImagePyramid& right, std::span<const StereoQuery> queries,
               double usual_inverse_depth, std::span<StereoMatch> matches, std::span<std::uint8_t> found) override;

private:
    using Pyramid = std::vector<cv::Mat>;

    void build(const ImagePyramid& image, Pyramid& pyramid);
    bool flow(const Pyramid& first, const Pyramid& second);
    void spread(std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners);
    std::size_t cell_of(const Eigen::Vector2d& uv) const;
    bool accept(const EpipolarGeometry::Ray& ray, const Eigen::Vector2d& right_uv, StereoMatch& match) const;

    FrontendConfig config_;
    CameraModel camera_;
    EpipolarGeometry geometry_;
    double border_px_ = 0.0;
    cv::Size window_;
    cv::Mat lens_mask_;  ///< where corners may lie
    cv::Mat mask_;       ///< likewise, without the surroundings of tracks and what moves with the vehicle
    std::vector<std::uint8_t> covered_;
    cv::Ptr<cv::GFTTDetector> detector_;
    std::vector<cv::KeyPoint> keypoints_;
    std::vector<std::vector<std::size_t>> cells_;  ///< candidates of each cell, strongest first
    std::vector<int> tracks_in_;                   ///< tracks and new corners of each cell
    Pyramid left_;
    Pyramid previous_;
    Pyramid right_;
    FlowBatch batch_;
};

Status OpenCvEngine::configure(const FrontendConfig& config, const StereoRig& rig) {
    config_ = config;
    camera_ = rig.left;
    geometry_.configure(rig);
    const int half_window = config.window_px / 2;
    border_px_ = half_window + 2.0;
    window_ = {config.window_px, config.window_px};
    cv::setNumThreads(1);
    const int width = rig.left.intrinsics().width;
    const int height = rig.left.intrinsics().height;
    lens_mask_ = cv::Mat::zeros(height, width, CV_8UC1);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            const Eigen::Vector2d uv(u, v);
            lens_mask_.at<std::uint8_t>(v, u) =
                camera_.in_image(uv, border_px_) && camera_.in_lens(uv, border_px_) ? 255 : 0;
        }
    }
    const std::size_t cells =
        static_cast<std::size_t>(config.corners.columns) * static_cast<std::size_t>(config.corners.rows);
    cells_.assign(cells, {});
    tracks_in_.assign(cells, 0);
    detector_ = cv::GFTTDetector::create(kCandidates, config.corners.quality, config.corners.min_distance_px);
    left_.clear();
    previous_.clear();
    right_.clear();
    return Status::kOk;
}

void OpenCvEngine::build(const ImagePyramid& image, Pyramid& pyramid) {
    try {
        cv::buildOpticalFlowPyramid(mat_of(image.level(0)), pyramid, window_, config_.pyramid_levels - 1);
    } catch (const cv::Exception&) {
        pyramid.clear();  // nothing is found in it
    }
}

void OpenCvEngine::begin_frame(const ImagePyramid& left) {
    std::swap(left_, previous_);
    build(left, left_);
}

/// Both ways; false if there is nothing to search.
bool OpenCvEngine::flow(const Pyramid& first, const Pyramid& second) {
    if (batch_.from.empty() || first.empty() || second.empty()) {
        return false;
    }
    const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, FrontendConfig::kLkIterations,
                                    FrontendConfig::kLkEpsilon_px);
    const int levels = config_.pyramid_levels - 1;
    try {
        cv::calcOpticalFlowPyrLK(first, second, batch_.from, batch_.to, batch_.found, batch_.error, window_, levels,
                                 criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
        batch_.back = batch_.from;
        cv::calcOpticalFlowPyrLK(second, first, batch_.to, batch_.back, batch_.found_back, batch_.error, window_, 0,
                                 criteria, cv::OPTFLOW_USE_INITIAL_FLOW);
    } catch (const cv::Exception&) {
        return false;
    }
    return true;
}

std::size_t OpenCvEngine::cell_of(const Eigen::Vector2d& uv) const {
    const int u = std::clamp(static_cast<int>(uv.x()), 0, lens_mask_.cols - 1);
    const int v = std::clamp(static_cast<int>(uv.y()), 0, lens_mask_.rows - 1);
    const int column = u * config_.corners.columns / lens_mask_.cols;
    const int row = v * config_.corners.rows / lens_mask_.rows;
    return static_cast<std::size_t>(row * config_.corners.columns + column);
}

/// One corner per cell in each round, cells with the fewest tracks first.
void OpenCvEngine::spread(std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners) {
    std::fill(tracks_in_.begin(), tracks_in_.end(), 0);
    for (const Eigen::Vector2d& uv : occupied) {
        ++tracks_in_[cell_of(uv)];
    }
    for (std::vector<std::size_t>& cell : cells_) {
        cell.clear();
    }
    for (std::size_t i = keypoints_.size(); i-- > 0;) {  // the strongest comes last, to be taken from the end
        cells_[cell_of(from_cv(keypoints_[i].pt))].push_back(i);
    }
    while (wanted > 0) {
        std::size_t best = cells_.size();
        for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
            if (!cells_[cell].empty() && (best == cells_.size() || tracks_in_[cell] < tracks_in_[best])) {
                best = cell;
            }
        }
        if (best == cells_.size()) {
            return;
        }
        corners.push_back(from_cv(keypoints_[cells_[best].back()].pt));
        cells_[best].pop_back();
        ++tracks_in_[best];
        --wanted;
    }
}

void OpenCvEngine::detect(const ImagePyramid& left, const PixelMask& mask, Timestamp now,
                          std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners) {
    wanted = std::min(wanted, static_cast<int>(corners.capacity() - corners.size()));
    if (wanted <= 0) {
        return;
    }
    try {
        lens_mask_.copyTo(mask_);
        covered_.resize(mask_.total());
        mask.write(now, covered_);
        mask_.setTo(0, cv::Mat(mask_.size(), CV_8U, covered_.data()));
        for (const Eigen::Vector2d& uv : occupied) {
            cv::circle(mask_, to_cv(uv), static_cast<int>(std::ceil(config_.corners.min_distance_px)), 0, cv::FILLED);
        }
        detector_->detect(mat_of(left.level(0)), keypoints_, mask_);
    } catch (const cv::Exception&) {
        return;
    }
    spread(occupied, wanted, corners);
}

Status OpenCvEngine::start(const ImagePyramid& /*left*/, const Eigen::Vector2d& uv, Track& track) {
    Eigen::Vector2d xy;
    FACET_TRY(camera_.unproject(uv, xy));
    track = Track{};
    track.pose.uv = uv;
    track.xy = xy;
    return Status::kOk;
}

void OpenCvEngine::follow(const ImagePyramid& /*earlier*/, const ImagePyramid& /*present*/, const FrameMotion& motion,
                          std::span<Track> tracks, std::span<std::uint8_t> followed) {
    const Eigen::Matrix3d R = motion.q_C_Cp.toRotationMatrix();
    const auto turned = [&R](const Track& track) -> Eigen::Vector3d { return R * track.xy.homogeneous(); };
    batch_.clear();
    std::fill(followed.begin(), followed.end(), std::uint8_t{0});
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        const Eigen::Vector3d ray = turned(tracks[i]);
        Eigen::Vector2d predicted;
        if (ray.z() > 0.1) {
            const Eigen::Vector2d xy = ray.hnormalized() + motion.dt_s * tracks[i].velocity;
            if (ok(camera_.project(xy.homogeneous(), predicted)) && camera_.in_image(predicted, 0.0)) {
                batch_.add(tracks[i].pose.uv, predicted, i);
            }
        }
    }
    if (!flow(previous_, left_)) {
        return;
    }
    for (std::size_t k = 0; k < batch_.owner.size(); ++k) {
        Track& track = tracks[batch_.owner[k]];
        const Eigen::Vector2d uv = from_cv(batch_.to[k]);
        Eigen::Vector2d xy;
        if (batch_.returned(k, FrontendConfig::kForwardBackward_px) && camera_.in_image(uv, border_px_) &&
            camera_.in_lens(uv, border_px_) && ok(camera_.unproject(uv, xy))) {
            track.velocity = (xy - turned(track).hnormalized()) / motion.dt_s;
            track.has_velocity = true;
            track.pose.uv = uv;
            track.xy = xy;
            ++track.age_frames;
            followed[batch_.owner[k]] = 1;
        }
    }
}

/// The checks of StereoMatcher: inside the image, near the epipolar line, at a possible depth.
bool OpenCvEngine::accept(const EpipolarGeometry::Ray& ray, const Eigen::Vector2d& right_uv, StereoMatch& match) const {
    EpipolarGeometry::Place place;
    if (!geometry_.in_right_image(right_uv, 1.0) || !geometry_.in_right_lens(right_uv, border_px_) ||
        !ok(geometry_.compare(ray, right_uv, place))) {
        return false;
    }
    const double limit_px = std::hypot(FrontendConfig::kStereoEpipolar_px, kLineSigmas * place.off_sigma_px);
    if (!(place.off_px < limit_px) ||
        !(place.inverse_depth > 1e-4 && place.inverse_depth < 1.0 / config_.min_depth_m)) {
        return false;
    }
    match = {right_uv, place.given_xy, place.inverse_depth, ray.given_xy.homogeneous() / place.inverse_depth};
    return true;
}

void OpenCvEngine::match(const ImagePyramid& /*left*/, const ImagePyramid& /*right*/,
                         std::span<const StereoQuery> queries, double usual_inverse_depth,
                         std::span<StereoMatch> matches, std::span<std::uint8_t> found) {
    const double usual = usual_inverse_depth > 0.0 ? usual_inverse_depth : kUsualInverseDepth;
    batch_.clear();
    std::fill(found.begin(), found.end(), std::uint8_t{0});
    EpipolarGeometry::Ray ray;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const double known = queries[i].known_inverse_depth;
        Eigen::Vector2d guess;
        Eigen::Matrix2f ignored;
        if (ok(geometry_.ray_of(queries[i].left_uv, ray)) &&
            ok(geometry_.point_at(ray, known >= 0.0 ? known : usual, guess, ignored))) {
            batch_.add(queries[i].left_uv, guess, i);
        }
    }
    if (!flow(left_, right_)) {
        return;
    }
    for (std::size_t k = 0; k < batch_.owner.size(); ++k) {
        const std::size_t i = batch_.owner[k];
        if (batch_.returned(k, FrontendConfig::kForwardBackward_px) && ok(geometry_.ray_of(queries[i].left_uv, ray)) &&
            accept(ray, from_cv(batch_.to[k]), matches[i])) {
            found[i] = 1;
        }
    }
}

}  // namespace

bool has_opencv_engine() { return true; }

std::unique_ptr<FeatureEngine> make_opencv_engine() { return std::make_unique<OpenCvEngine>(); }

}  // namespace facet
