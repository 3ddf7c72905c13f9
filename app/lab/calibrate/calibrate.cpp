// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/calibrate.h"

#include <fmt/core.h>

#include "app/lab/calibrate/batch.h"
#include "app/lab/calibrate/calibration_files.h"
#include "app/lab/calibrate/residual_picture.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"

namespace facet {
namespace {

void write_pictures(const BatchResult& result, const StereoRig& rig, const std::string& folder) {
    for (int camera = 0; camera < 2; ++camera) {
        const CameraIntrinsics& size = (camera == 0 ? rig.left : rig.right).intrinsics();
        write_residual_picture(fmt::format("{}/residuals_cam{}_before.png", folder, camera), size, result.before,
                               camera);
        write_residual_picture(fmt::format("{}/residuals_cam{}_after.png", folder, camera), size, result.after, camera);
    }
}

}  // namespace

std::string unseen_complaint(const std::vector<RigParameter>& parameters) {
    for (const RigParameter& p : parameters) {
        const bool is_needed =
            p.name.ends_with(".cx") || p.name.ends_with(".cy") || p.name.find(".turn_") != std::string::npos;
        if (is_needed && p.verdict == ParameterVerdict::kNotObservable) {
            return fmt::format("the flight does not show {}: {}", p.name, p.advice);
        }
    }
    return {};
}

CalibrateReport calibrate(const CalibrateOptions& options, const std::atomic<bool>& stop) {
    CalibrateReport report;
    const RecordedFlight flight = record_flight(options.recording, stop);
    report.motion = measure_motion(flight);
    if (stop.load()) {
        report.refusal = "interrupted";
        return report;
    }
    report.refusal = motion_complaint(report.motion);
    if (!report.refusal.empty()) {
        return report;
    }
    const Calibration& given = options.recording.calibration;
    BatchOptions batch;
    batch.given = {given.rig, given.camera_time_shift.seconds()};
    batch.prior_sigma = prior_sigmas(given.rig, options.prior_scale);
    batch.noise = options.recording.config.imu_noise;
    batch.limits = options.recording.config.imu_limits;
    batch.gravity = options.recording.config.gravity;
    Progress progress("fit", "rounds", kBatchRounds);
    if (options.recording.show_progress) {
        batch.progress = [&progress](std::size_t rounds) { progress.update(rounds); };
    }
    BatchResult result;
    RigAndTime refined;
    const Status solved = solve_batch(flight, batch, result);
    if (options.recording.show_progress) {
        progress.finish();
    }
    if (!ok(solved) || !ok(apply_correction(batch.given, result.correction, refined))) {
        report.refusal = "no calibration explains the flight: too few points were followed, or they contradict the IMU";
        return report;
    }
    report.keyframes = result.keyframes;
    report.points = result.points;
    report.pixel_sigma_px = result.pixel_sigma;
    report.parameters = describe_parameters(batch.given, result.correction, result.sigma, batch.prior_sigma);
    report.refusal = unseen_complaint(report.parameters);
    if (report.refusal.empty()) {
        write_calibration({refined, given.noise, given.imu_model, result.sigma}, options.out);
        write_calibration_json({options.recording.dataset, given.source, report.motion.duration_s, report.parameters},
                               result, options.out);
        write_pictures(result, given.rig, options.out);
    }
    return report;
}

}  // namespace facet
