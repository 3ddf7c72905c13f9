// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/report.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "app/lab/eval/pose_difference.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const ErrorStatistics& s) {
    if (s.count == 0) {
        return nullptr;
    }
    return {{"count", s.count}, {"median", s.median}, {"mean", s.mean}, {"rmse", s.rmse}, {"max", s.max}};
}

Json to_json(const AbsoluteError& e) {
    const Se3& t = e.T_true_est;
    return {{"alignment", to_string(e.mode)},
            {"translation_m", to_json(e.translation_m)},
            {"rotation_deg", to_json(e.rotation_deg)},
            {"transform", {{"p", {t.p.x(), t.p.y(), t.p.z()}}, {"q_xyzw", {t.q.x(), t.q.y(), t.q.z(), t.q.w()}}}}};
}

Json to_json(const RelativeError& e) {
    return {{"length_m", e.length_m},
            {"translation_m", to_json(e.translation_m)},
            {"translation_percent", to_json(e.translation_percent)},
            {"rotation_deg", to_json(e.rotation_deg)},
            {"rotation_deg_per_m", to_json(e.rotation_deg_per_m)},
            {"yaw_deg", to_json(e.yaw_deg)}};
}

Json to_json(const Consistency& c) {
    Json nees = Json::object();
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        const NeesStatistics& s = c.parts[k];
        nees[kClaimParts[k].name] = nullptr;
        if (s.count > 0) {
            nees[kClaimParts[k].name] = {
                {"dof", kClaimParts[k].size}, {"count", s.count},       {"mean", s.mean},
                {"inside_95", s.inside_95},   {"above_95", s.above_95}, {"within_3_sigma", s.within_3_sigma}};
        }
    }
    return {{"gauge", "4-DoF (yaw + translation) where the position is known best"},
            {"gauge_stamp_ns", c.gauge_stamp.ns},
            {"samples", c.samples.size()},
            {"unusable", c.unusable},
            {"nees", nees}};
}

Json to_json(const Fitted& f) { return {{"value", f.value}, {"sigma", f.sigma}}; }

Json to_json(const FittedVector& f) {
    return {{"value", {f.value.x(), f.value.y(), f.value.z()}}, {"sigma", {f.sigma.x(), f.sigma.y(), f.sigma.z()}}};
}

Json to_json(const TruthFit& f) {
    return {{"position_lag_s", to_json(f.lag_s)},
            {"lever_arm_m", to_json(f.lever_arm_m)},
            {"scale", to_json(f.scale)},
            {"position_rmse_m", f.position_rmse_m},
            {"position_swift_rmse_m", f.position_swift_rmse_m},
            {"orientation_lag_s", to_json(f.orientation_lag_s)},
            {"turn_rad", to_json(f.turn_rad)},
            {"orientation_rmse_rad", f.orientation_rmse_rad},
            {"orientation_swift_rmse_rad", f.orientation_swift_rmse_rad}};
}

std::string row(const char* name, const FittedVector& f, double factor, const char* unit) {
    const Eigen::Vector3d v = factor * f.value;
    const Eigen::Vector3d s = factor * f.sigma;
    return fmt::format("  {:<17} {:+8.2f} {:+8.2f} {:+8.2f}  +- {:.2f} {:.2f} {:.2f} {}\n", name, v.x(), v.y(), v.z(),
                       s.x(), s.y(), s.z(), unit);
}

std::string truth_fit_rows(const TruthFit& f) {
    if (!f.is_known) {
        return "";
    }
    return "best fit to the ground truth, 1 sigma (not applied to any error above or below)\n" +
           fmt::format("  {:<17} {:+8.2f}  +- {:.2f} ms (positive: the ground truth is late)\n", "position lag",
                       1e3 * f.lag_s.value, 1e3 * f.lag_s.sigma) +
           row("lever arm", f.lever_arm_m, 1e3, "mm") +
           fmt::format("  {:<17} {:8.5f}  +- {:.5f}\n", "scale", f.scale.value, f.scale.sigma) +
           fmt::format("  {:<17} {:8.4f} m, {:.4f} m of it within a second\n", "positions left", f.position_rmse_m,
                       f.position_swift_rmse_m) +
           fmt::format("  {:<17} {:+8.2f}  +- {:.2f} ms\n", "orientation lag", 1e3 * f.orientation_lag_s.value,
                       1e3 * f.orientation_lag_s.sigma) +
           row("turn of the body", f.turn_rad, kDegPerRad, "deg") +
           fmt::format("  {:<17} {:8.4f} deg, {:.4f} deg of it within a second\n", "orientations left",
                       kDegPerRad * f.orientation_rmse_rad, kDegPerRad * f.orientation_swift_rmse_rad);
}

std::string absolute_rows(const AbsoluteError& e) {
    const ErrorStatistics& t = e.translation_m;
    const ErrorStatistics& r = e.rotation_deg;
    return fmt::format("ATE, alignment {}\n", to_string(e.mode)) +
           fmt::format("  translation  {:9.4f}  {:9.4f}  {:9.4f}  {:9.4f}  m\n", t.median, t.mean, t.rmse, t.max) +
           fmt::format("  rotation     {:9.4f}  {:9.4f}  {:9.4f}  {:9.4f}  deg\n", r.median, r.mean, r.rmse, r.max);
}

std::string relative_row(const RelativeError& e) {
    if (e.translation_m.count == 0) {
        return fmt::format("  {:6g} m      path too short\n", e.length_m);
    }
    return fmt::format("  {:6g} m   {:9.4f} m {:7.3f} %  {:8.4f} deg {:8.4f} deg/m  {:8.4f} deg  {:6}\n", e.length_m,
                       e.translation_m.rmse, e.translation_percent.rmse, e.rotation_deg.rmse, e.rotation_deg_per_m.rmse,
                       e.yaw_deg.rmse, e.translation_m.count);
}

std::string nees_rows(const Consistency& c) {
    std::string text;
    text += "  NEES          mean  expected   in 95 % band   above it   components within 3 sigma\n";
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        const NeesStatistics& s = c.parts[k];
        const ClaimPart& part = kClaimParts[k];
        if (s.count == 0) {
            text += fmt::format("  {:<11} nothing to compare\n", part.name);
            continue;
        }
        text += fmt::format("  {:<11} {:6.2f}  {:8}   {:10.1f} %   {:6.1f} %   {:23.1f} %\n", part.name, s.mean,
                            part.size, 100.0 * s.inside_95, 100.0 * s.above_95, 100.0 * s.within_3_sigma);
    }
    return text;
}

}  // namespace

std::string text_report(const Evaluation& e) {
    const Coverage& c = e.coverage;
    std::string text = fmt::format("matched      {} of {} estimates, ground truth {} poses\n", e.matched,
                                   e.estimate_poses, e.truth_poses) +
                       fmt::format("path         {:.3f} m in {:.3f} s\n", e.path_m, e.duration_s) +
                       fmt::format("coverage     {:.2f} % of the time{}, {:.2f} % of all ground truth\n",
                                   100.0 * c.time, c.has_frames ? " with frames" : "", 100.0 * c.truth_span);
    if (c.has_frames) {
        text += fmt::format("             {} of {} frames ({:.2f} %)\n", c.frames_matched, c.frames,
                            100.0 * c.frame_share());
    }
    if (e.matched == 0) {
        return text + "no estimate matches the ground truth: no errors to report\n";
    }
    text +=
        "                  median       mean       RMSE        max\n" + absolute_rows(e.se3) + absolute_rows(e.yaw4);
    text += fmt::format("scale        {:.5f} (what SIM(3) would choose; not applied)\n", e.scale);
    text += truth_fit_rows(e.truth_fit);
    text += fmt::format("end drift    {:.4f} m ({:.3f} % of the path), first poses made equal\n", e.end_drift_m,
                        e.drift_percent());
    text += "RPE, RMSE over stretches of the true path, no alignment (yaw: world axes by 4-DoF alignment)\n";
    text += "  length     translation                  rotation                        yaw   count\n";
    for (const RelativeError& r : e.relative) {
        text += relative_row(r);
    }
    return text;
}

std::string text_report(const Claims& claims) {
    const Consistency& c = claims.as_is;
    return fmt::format(
               "consistency of {} samples ({} unusable); yaw and position aligned where the position is known best\n",
               c.samples.size(), c.unusable) +
           nees_rows(c) +
           (claims.with_fit
                ? "the same with lag, lever arm and turn of the ground truth as fitted\n" + nees_rows(*claims.with_fit)
                : "");
}

std::string json_report(const Evaluation& e, const std::string& groundtruth, const std::string& estimate,
                        const Claims* claims) {
    Json json = {{"groundtruth", groundtruth},
                 {"estimate", estimate},
                 {"matched", e.matched},
                 {"estimates", e.estimate_poses},
                 {"groundtruth_poses", e.truth_poses},
                 {"path_m", e.path_m},
                 {"duration_s", e.duration_s},
                 {"ate_se3", to_json(e.se3)},
                 {"ate_yaw4", to_json(e.yaw4)},
                 {"sim3_scale", e.scale},
                 {"end_drift_m", e.end_drift_m},
                 {"end_drift_percent", e.drift_percent()}};
    if (e.truth_fit.is_known) {
        json["truth_fit"] = to_json(e.truth_fit);
    }
    json["rpe"] = Json::array();
    for (const RelativeError& r : e.relative) {
        json["rpe"].push_back(to_json(r));
    }
    const Coverage& c = e.coverage;
    json["coverage"] = {{"time", c.time}, {"groundtruth_time", c.truth_span}};
    if (c.has_frames) {
        json["coverage"]["frames"] = c.frames;
        json["coverage"]["frames_matched"] = c.frames_matched;
        json["coverage"]["frame_share"] = c.frame_share();
    }
    if (claims != nullptr) {
        json["consistency"] = to_json(claims->as_is);
        if (claims->with_fit) {
            json["consistency_with_fit"] = to_json(*claims->with_fit);
        }
    }
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace facet
