// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/check_calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/lab/check/imu_checks.h"
#include "app/lab/check/stereo_check.h"
#include "app/lab/check/turn_check.h"
#include "app/lab/replay/log_options.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"
#include "drivers/replay_asl/asl_dataset.h"

namespace facet {
namespace {

constexpr int kStereoPairs = 10;
constexpr int kFramesPerTurn = 3;  // a longer turn stands out more from the error of its images

/// A log without its images.
struct LogOutline {
    std::vector<ImuSample> imu;
    std::vector<Timestamp> frames;
};

AslDataset open_log(const CheckOptions& options, AslOptions log_options, const AslWarningSink& sink) {
    log_options.files = options.files;
    AslDataset log;
    std::string error;
    if (!ok(log.open(options.dataset, log_options, sink, error))) {
        throw InputError(error);
    }
    return log;
}

LogOutline read_outline(const CheckOptions& options) {
    AslOptions log_options = log_options_of(options.calibration);
    log_options.decode_images = false;
    AslDataset log = open_log(options, log_options, nullptr);
    LogOutline outline;
    ImuSample sample;
    StereoFrame frame;
    for (;;) {
        switch (log.next(sample, frame)) {
            case AslDataset::Event::kImu: outline.imu.push_back(options.calibration.imu_model.corrected(sample)); break;
            case AslDataset::Event::kFrame: outline.frames.push_back(frame.stamp); break;
            case AslDataset::Event::kEnd: return outline;
        }
    }
}

/// Start of the stretch in which the gyroscope varies most, from the first frame.
Duration liveliest(const LogOutline& outline, double length_s) {
    constexpr double kStrideS = 1.0;
    Duration best;
    double most = -1.0;
    const Timestamp begin = outline.frames.front();
    for (double start_s = 0.0;; start_s += kStrideS) {
        const Timestamp from = begin + Duration::from_seconds(start_s);
        const Timestamp to = from + Duration::from_seconds(length_s);
        if (start_s > 0.0 && to > outline.frames.back()) {
            return best;
        }
        const auto first = std::ranges::lower_bound(outline.imu, from, {}, &ImuSample::stamp);
        const auto last = std::ranges::lower_bound(outline.imu, to, {}, &ImuSample::stamp);
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double squares = 0.0;
        for (auto s = first; s != last; ++s) {
            sum += s->w_B;
            squares += s->w_B.squaredNorm();
        }
        const double n = std::max(1.0, static_cast<double>(last - first));
        const double variance = squares / n - (sum / n).squaredNorm();
        if (variance > most) {
            most = variance;
            best = Duration::from_seconds(start_s);
        }
    }
}

/// What the images of the stretch show.
struct ImageEvidence {
    std::vector<PointPair> stereo;
    std::vector<double> differences;
    std::vector<CameraTurn> turns;
    std::size_t unread = 0;       ///< images
    std::string why_wrong_size;   ///< of the first of another size than the calibration's
    double brightest_mean = 0.0;  ///< grey, of pairs
};

ImageEvidence read_images(const CheckOptions& options, Duration start) {
    AslOptions log_options = log_options_of(options.calibration);
    log_options.start = start;
    log_options.length = Duration::from_seconds(options.images_s);
    ImageEvidence evidence;
    AslDataset log = open_log(options, log_options, [&](const AslWarning& warning) {
        evidence.unread +=
            warning.kind == AslWarningKind::kCorruptImage || warning.kind == AslWarningKind::kMissingFile ? 1 : 0;
        if (warning.kind == AslWarningKind::kWrongSize && evidence.why_wrong_size.empty()) {
            evidence.why_wrong_size = warning.message.substr(0, warning.message.find(';'));
        }
    });
    const CameraModel& left = options.calibration.rig.left;
    const CameraModel& right = options.calibration.rig.right;
    FreeMatcher follower;
    FreeMatcher matcher;
    const int width = left.intrinsics().width;
    const int height = left.intrinsics().height;
    const bool is_one_size =
        options.calibration.rig.has_right && right.intrinsics().width == width && right.intrinsics().height == height;
    if (!ok(follower.configure(width, height)) || !ok(matcher.configure(width, height))) {
        throw InputError("the images are too small to be checked");
    }
    const int every = std::max(1, static_cast<int>(log.frame_count()) / kStereoPairs);
    ImuSample sample;
    StereoFrame frame;
    Timestamp anchor;
    int frames = 0;
    for (;;) {
        const AslDataset::Event event = log.next(sample, frame);
        if (event == AslDataset::Event::kEnd) {
            return evidence;
        }
        if (event != AslDataset::Event::kFrame || frame.left.empty()) {
            continue;
        }
        const bool is_anchor = frames % kFramesPerTurn == 0;
        const std::vector<PointPair> followed = follower.follow(frame.left, is_anchor);
        if (is_anchor) {
            if (const auto theta_C = estimate_turn(left, followed)) {
                evidence.turns.push_back({anchor, frame.stamp, *theta_C});
            }
            anchor = frame.stamp;
        }
        if (frames++ % every == 0 && is_one_size && !frame.right.empty()) {
            evidence.differences.push_back(mean_difference(frame.left, frame.right));
            evidence.brightest_mean = std::max(evidence.brightest_mean, mean_grey(frame.left));
            const std::vector<PointPair> pairs = matcher.match_stereo(frame.left, frame.right);
            evidence.stereo.insert(evidence.stereo.end(), pairs.begin(), pairs.end());
        }
    }
}

}  // namespace

std::vector<CheckVerdict> check_calibration(const CheckOptions& options) {
    const LogOutline outline = read_outline(options);
    if (outline.frames.empty() || outline.imu.empty()) {
        throw InputError(options.dataset + ": no frame with inertial samples around it");
    }
    const Calibration& calibration = options.calibration;
    const std::vector<RestStretch> rests = find_rests(outline.imu);
    std::vector<CheckVerdict> verdicts{check_imu_rate(outline.imu, calibration.noise),
                                       check_gravity(outline.imu, rests),
                                       check_imu_noise(outline.imu, rests, calibration.noise)};
    const ImageEvidence evidence = read_images(options, liveliest(outline, options.images_s));
    if (!evidence.why_wrong_size.empty()) {
        verdicts.push_back(
            {.name = "image size",
             .level = CheckLevel::kWrong,
             .sentence = fmt::format("the calibration is that of other images: {}.", evidence.why_wrong_size),
             .figures = {}});
    }
    if (evidence.unread > 0) {
        verdicts.push_back({.name = "image files",
                            .level = CheckLevel::kSuspicious,
                            .sentence = fmt::format("{} images of the stretch cannot be read.", evidence.unread),
                            .figures = {{"unread", static_cast<double>(evidence.unread)}}});
    }
    if (calibration.rig.has_right) {
        verdicts.push_back(check_same_image(evidence.differences, evidence.brightest_mean));
        for (CheckVerdict& verdict : check_stereo(calibration.rig, evidence.stereo)) {
            verdicts.push_back(std::move(verdict));
        }
    }
    for (CheckVerdict& verdict : check_turns(evidence.turns, outline.imu, calibration.rig.T_B_C0.R())) {
        verdicts.push_back(std::move(verdict));
    }
    return verdicts;
}

bool has_wrong(const std::vector<CheckVerdict>& verdicts) {
    return std::ranges::any_of(verdicts, [](const CheckVerdict& v) { return v.level == CheckLevel::kWrong; });
}

void write_verdicts(const std::vector<CheckVerdict>& verdicts, const std::string& path) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const CheckVerdict& verdict : verdicts) {
        nlohmann::ordered_json figures = nlohmann::ordered_json::object();
        for (const auto& [name, value] : verdict.figures) {
            figures[name] = value;
        }
        rows.push_back({{"check", verdict.name},
                        {"verdict", to_string(verdict.level)},
                        {"sentence", verdict.sentence},
                        {"figures", figures}});
    }
    TextFile file(path);
    file.write(nlohmann::ordered_json{{"checks", rows}}.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
               "\n");
    file.close();
}

}  // namespace facet
