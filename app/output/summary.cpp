// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/summary.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "app/output/mesh_log.h"
#include "app/output/plane_log.h"
#include "app/output/residual_log.h"
#include "app/support/statistics.h"
#include "app/support/text_file.h"
#include "estimator/geometry/lens_correction.h"
#include "estimator/geometry/so3.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json to_json(const TimingStatistics& s) {
    return {{"count", s.count}, {"mean", s.mean_ms}, {"median", s.median_ms}, {"p99", s.p99_ms}, {"max", s.max_ms}};
}

Json final_state(const Estimate& last) {
    const NavState& s = last.state;
    return {{"stamp_ns", last.stamp.ns},
            {"state", to_string(last.health.state)},
            {"reasons", reason_names(last.health.reasons)},
            {"position_m", to_json(s.p_W_B)},
            {"quaternion_xyzw", Json::array({s.q_W_B.x(), s.q_W_B.y(), s.q_W_B.z(), s.q_W_B.w()})},
            {"velocity_m_per_s", to_json(s.v_W_B)},
            {"gyro_bias_rad_per_s", to_json(s.bias.gyro)},
            {"accel_bias_m_per_s2", to_json(s.bias.accel)},
            {"time_offset_s", last.health.time_offset_s},
            {"time_offset_sigma_s", last.health.time_offset_sigma_s},
            {"camera_turned_deg", to_json(so3_log(last.T_B_Bc.q) / kRadPerDeg)},
            {"camera_turned_sigma_deg", to_json(last.T_B_Bc_sigma.head<3>() / kRadPerDeg)},
            {"camera_moved_m", to_json(last.T_B_Bc.p)},
            {"camera_moved_sigma_m", to_json(last.T_B_Bc_sigma.tail<3>())},
            {"imu_gaps", last.health.imu_gaps},
            {"imu_dropped", last.health.imu_dropped}};
}

/// What a camera's parameters were corrected by, and the standard deviations left.
Json lens(const LensCorrection& d) {
    return {{"focal_relative", Json::array({d(0), d(1)})},
            {"principal_point_px", Json::array({d(2), d(3)})},
            {"distortion", Json::array({d(4), d(5), d(6), d(7)})}};
}

/// Corrections of the IMU's axes, row by row; of the accelerometer the lower triangle.
Json imu_scale(const ImuScale::Tangent& d) {
    const auto values = [&](int first, int count) {
        Json json = Json::array();
        for (int i = first; i < first + count; ++i) {
            json.push_back(d(i));
        }
        return json;
    };
    return {{"gyroscope", values(0, ImuScale::kGyroDim)},
            {"accelerometer", values(ImuScale::kGyroDim, ImuScale::kDim - ImuScale::kGyroDim)}};
}

Json corrections(const CalibrationEstimate& estimate) {
    const RigCalibration& c = estimate.correction;
    const RigCalibration::Tangent& sigma = estimate.sigma;
    return {{"imu", imu_scale(ImuScale{}.box_minus_to(c.imu))},
            {"imu_sigma", imu_scale(sigma.segment<ImuScale::kDim>(kImuScale))},
            {"left", lens(c.lens[0])},
            {"left_sigma", lens(sigma.segment<kLensDim>(kLeftLens))},
            {"right", lens(c.lens[1])},
            {"right_sigma", lens(sigma.segment<kLensDim>(kRightLens))},
            {"right_turned_deg", to_json(so3_log(c.right.q) / kRadPerDeg)},
            {"right_turned_sigma_deg", to_json(sigma.segment<3>(kRightTheta) / kRadPerDeg)},
            {"right_moved_m", to_json(c.right.p)},
            {"right_moved_sigma_m", to_json(sigma.segment<3>(kRightPos))}};
}

Json camera(const CameraModel& model, const Se3& T_B_C) {
    const CameraIntrinsics& k = model.intrinsics();
    return {{"intrinsics_px", Json::array({k.fx, k.fy, k.cx, k.cy})},
            {"distortion", k.coeffs},
            {"p_B_C_m", to_json(T_B_C.p)},
            {"q_B_C_xyzw", Json::array({T_B_C.q.x(), T_B_C.q.y(), T_B_C.q.z(), T_B_C.q.w()})}};
}

/// Both cameras as given, and as the corrections make them.
Json cameras(const StereoRig& given, const RigCalibration& c) {
    const CameraModel left = corrected(given.left, c.lens[0]);
    const CameraModel right = corrected(given.right, c.lens[1]);
    return {{"given", {{"cam0", camera(given.left, given.T_B_C0)}, {"cam1", camera(given.right, given.T_B_C1)}}},
            {"final",
             {{"cam0", camera(left, c.T_B_Bc * given.T_B_C0)},
              {"cam1", camera(right, c.T_B_Bc * c.T_Bc_C1(given.T_B_C1))}}}};
}

void add(const std::vector<NamedCounter>& counters, Json& json) {
    for (const NamedCounter& counter : counters) {
        json[counter.name] = counter.value;
    }
}

Json map(const RunSummary& summary) {
    const MapCounters& map = *summary.map;
    const double settled = std::max<double>(1.0, static_cast<double>(map.settled));
    return {{"keyframes", map.keyframes},
            {"skipped", map.skipped},
            {"integrated", map.integrated},
            {"restarts", map.restarts},
            {"moved_mean_m", map.moved_m / settled},
            {"moved_max_m", map.moved_most_m},
            {"blocks", summary.map_blocks},
            {"blocks_left", summary.map_blocks_left}};
}

Json mesh(const RunSummary& summary) {
    Json json = {{"vertices", summary.mesh_vertices},
                 {"faces", summary.mesh_faces},
                 {"faces_max", summary.mesh_faces_max},
                 {"run_faces", summary.run_mesh_faces},
                 {"updates", summary.mesh.updates}};
    add(named_counters(summary.mesh), json);
    return json;
}

Json residuals(const VisionResiduals& residuals) {
    Json json;
    for (const NamedResiduals& named : named_residuals(residuals)) {
        const ResidualHistogram& h = *named.histogram;
        json[named.name] = {{"count", h.total()}, {"mean", h.mean_px()}, {"deviation", h.deviation_px()}};
    }
    return json;
}

Json planes(const RunSummary& summary) {
    Json json;
    add(named_counters(summary.planes), json);
    return json;
}

/// Stages that every frame has.
bool is_of_every_frame(Stage stage) {
    return stage == Stage::kPropagation || stage == Stage::kTracking || stage == Stage::kFrameUpdate;
}

/// Statistics of one of the two times that a frame has. A keyframe's stages: at keyframes what every frame has, all
/// else at the frames that did it, which may be those that follow.
Json timing_by(double SpentTime::*time, const RunSummary& summary) {
    std::vector<double> all;
    std::vector<double> estimates;
    std::vector<double> tracked;
    std::vector<double> keyframes;
    std::array<std::vector<double>, kStageCount> stages;
    for (const RunSummary::TimedFrame& frame : summary.timed) {
        all.push_back(frame.timing.total.*time);
        estimates.push_back(frame.timing.estimate.*time);
        (frame.is_keyframe ? keyframes : tracked).push_back(frame.timing.total.*time);
        for (std::size_t i = 0; i < kStageCount; ++i) {
            const double spent = frame.timing.stages[i].*time;
            if (is_of_every_frame(static_cast<Stage>(i)) ? frame.is_keyframe : spent > 0.0) {
                stages[i].push_back(spent);
            }
        }
    }
    Json json = {{"all", to_json(timing_statistics(all))},
                 {"estimate", to_json(timing_statistics(estimates))},
                 {"tracked", to_json(timing_statistics(tracked))},
                 {"keyframe", to_json(timing_statistics(keyframes))}};
    for (std::size_t i = 0; i < kStageCount; ++i) {
        json["keyframe_stages"][to_string(static_cast<Stage>(i))] = to_json(timing_statistics(stages[i]));
    }
    return json;
}

Json timing(const RunSummary& summary) {
    Json json = {{"unit", "ms"}};
    json.update(timing_by(&SpentTime::wall_ms, summary));
    json["processor"] = timing_by(&SpentTime::processor_ms, summary);
    json["wall_s"] = summary.wall_s;
    return json;
}

Json live(const LiveAccount& account) {
    Json json = {{"duration_s", account.duration_s},
                 {"latency_ms", to_json(timing_statistics(account.latency_ms))},
                 {"poses", account.poses},
                 {"overruns", account.overruns}};
    for (const NamedCounter& drop : account.drops) {
        json["drops"][drop.name] = drop.value;
    }
    for (const NamedCounter& finding : account.findings) {
        json["synchroniser"][finding.name] = finding.value;
    }
    for (const SourceAccount& source : account.sources) {
        const SourceCounters& c = source.counters;
        json["sources"][source.name] = {{"delivered", c.delivered},    {"lost", c.lost},
                                        {"corrupt", c.corrupt},        {"discarded", c.discarded},
                                        {"errors", c.errors},          {"recoveries", c.recoveries},
                                        {"rejected", source.rejected}, {"unmapped", source.unmapped}};
    }
    json["refusals"] = account.refusals;
    return json;
}

}  // namespace

double RunSummary::coverage() const {
    return frames_listed == 0 ? 0.0 : static_cast<double>(estimates) / static_cast<double>(frames_listed);
}

TimingStatistics timing_statistics(std::vector<double> times_ms) {
    TimingStatistics s;
    const OrderStatistics order(std::move(times_ms));
    s.count = order.count();
    for (const double t : order.sorted()) {
        s.mean_ms += t / static_cast<double>(s.count);
    }
    s.median_ms = order.median();
    s.p99_ms = order.nearest_rank(0.99);
    s.max_ms = order.max();
    return s;
}

void write_summary(const RunSummary& summary, const std::string& folder) {
    std::size_t warnings = 0;
    Json by_kind = Json::object();
    for (const auto& [kind, count] : summary.warnings) {
        by_kind[kind] = count;
        warnings += count;
    }
    Json json = {{"dataset", summary.dataset},
                 {"mode", summary.mode},
                 {"parameters", Json(summary.parameters)},
                 {"version", FACET_VERSION},
                 {"calibration", summary.calibration},
                 {"start_s", summary.start_s},
                 {"faults", summary.faults},
                 {"frames_listed", summary.frames_listed},
                 {"rows_skipped", summary.rows_skipped},
                 {"frames", summary.frames},
                 {"frames_not_ready", summary.frames_not_ready},
                 {"frames_refused", summary.frames_refused},
                 {"reports_without_frame", summary.reports_without_frame},
                 {"frames_by_state", Json(summary.frames_by_state)},
                 {"frames_contradicted", summary.frames_contradicted},
                 {"frames_fixed_pattern", summary.frames_fixed_pattern},
                 {"keyframes", summary.keyframes},
                 {"estimates", summary.estimates},
                 {"coverage", summary.coverage()},
                 {"imu_samples", summary.imu_samples},
                 {"imu_refused", summary.imu_refused},
                 {"warnings", warnings},
                 {"warnings_by_kind", by_kind},
                 {"path_m", summary.path_m},
                 {"interrupted", summary.interrupted},
                 {"not_finite", summary.not_finite},
                 {"first_estimate_ns", summary.first_estimate.ns},
                 {"final", final_state(summary.last)}};
    json["cameras"] = cameras(summary.rig, summary.corrections.correction);
    json["calibration_corrections"] = corrections(summary.corrections);
    json["residuals_px"] = residuals(summary.residuals);
    json["mesh"] = mesh(summary);
    if (summary.map) {
        json["map"] = map(summary);
    }
    json["planes"] = planes(summary);
    json["timing"] = timing(summary);
    if (summary.live) {
        json["live"] = live(*summary.live);
    }
    TextFile file(folder + "/summary.json");
    file.write(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    file.close();
}

}  // namespace facet
