// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/core.h>

#include <array>

#include "app/calibration/correction_names.h"
#include "app/foxglove/json_values.h"
#include "app/foxglove/messages.h"
#include "app/foxglove/own_schemas.h"
#include "app/foxglove/schema_parts.h"

namespace facet {
namespace {

using json_values::Json;

/// One property of facet.Health.
struct HealthField {
    const char* name;
    const char* type;  ///< of JSON
    const char* words;
    Json (*value)(const Health&);
};

constexpr std::array kHealthFields{
    HealthField{"state", "string", "INIT, TRACKING, DEGRADED or LOST",
                [](const Health& h) { return Json(to_string(h.state)); }},
    HealthField{"reasons", "integer", "why the state is what it is, a bit for each of reason_names",
                [](const Health& h) { return Json(h.reasons); }},
    HealthField{"quality", "integer", "0: must not be used; 1 to 100, best",
                [](const Health& h) { return Json(h.quality); }},
    HealthField{"reset_counter", "integer", "restarts; position or yaw may have jumped when it rises",
                [](const Health& h) { return Json(h.reset_counter); }},
    HealthField{"is_keyframe", "boolean", "the frame is one", [](const Health& h) { return Json(h.is_keyframe); }},
    HealthField{"is_exchanged", "boolean", "the right camera plays the left one",
                [](const Health& h) { return Json(h.is_exchanged); }},
    HealthField{"is_still", "boolean", "the vehicle stands", [](const Health& h) { return Json(h.is_still); }},
    HealthField{"tracked", "integer", "features carried over from the previous frame",
                [](const Health& h) { return Json(h.tracked); }},
    HealthField{"detected", "integer", "new features", [](const Health& h) { return Json(h.detected); }},
    HealthField{"stereo", "integer", "features with a match in the right image",
                [](const Health& h) { return Json(h.stereo); }},
    HealthField{"recalled", "integer", "lost landmarks found again", [](const Health& h) { return Json(h.recalled); }},
    HealthField{"outliers", "integer", "features rejected", [](const Health& h) { return Json(h.outliers); }},
    HealthField{"fixed_share", "number", "of the image, left out because it moves with the vehicle",
                [](const Health& h) { return Json(h.fixed_share); }},
    HealthField{"keyframes", "integer", "in the window", [](const Health& h) { return Json(h.keyframes); }},
    HealthField{"landmarks", "integer", "of the window that took part in the last optimization",
                [](const Health& h) { return Json(h.landmarks); }},
    HealthField{"landmarks_dropped", "integer", "since the start, for want of room in the window",
                [](const Health& h) { return Json(h.landmarks_dropped); }},
    HealthField{"iterations", "integer", "solver steps", [](const Health& h) { return Json(h.iterations); }},
    HealthField{"map_landmarks", "integer", "of the newest keyframe, found in this frame and used",
                [](const Health& h) { return Json(h.map_landmarks); }},
    HealthField{"frame_chi2", "number", "variance of their residuals over the expected one",
                [](const Health& h) { return Json(h.frame_chi2); }},
    HealthField{"mean_vision_chi2", "number", "squared vision residual per degree of freedom",
                [](const Health& h) { return Json(h.mean_vision_chi2); }},
    HealthField{"pixel_sigma_px", "number", "standard deviation that observations are weighted with (px)",
                [](const Health& h) { return Json(h.pixel_sigma_px); }},
    HealthField{"residual_bias_px", "number", "largest mean of the residuals of an image coordinate (px)",
                [](const Health& h) { return Json(h.residual_bias_px); }},
    HealthField{"calibration_stretch", "number", "largest correction of the calibration, in sigmas of what was given",
                [](const Health& h) { return Json(h.calibration_stretch); }},
    HealthField{"calibration_scale", "number", "learnt factor on those sigmas",
                [](const Health& h) { return Json(h.calibration_scale); }},
    HealthField{"imu_chi2", "number", "squared whitened residual per degree of freedom of the newest inertial factor",
                [](const Health& h) { return Json(h.imu_chi2); }},
    HealthField{"time_offset_s", "number", "image stamps plus this are the IMU's time (s)",
                [](const Health& h) { return Json(h.time_offset_s); }},
    HealthField{"time_offset_sigma_s", "number", "0 if it is not estimated (s)",
                [](const Health& h) { return Json(h.time_offset_sigma_s); }},
    HealthField{"imu_gaps", "integer", "since the start", [](const Health& h) { return Json(h.imu_gaps); }},
    HealthField{"imu_clipped", "integer", "samples at the IMU's range since the start",
                [](const Health& h) { return Json(h.imu_clipped); }},
    HealthField{"imu_dropped", "integer", "samples dropped since the start",
                [](const Health& h) { return Json(h.imu_dropped); }},
};

/// Units of a parameter of the calibration, by its name.
const char* unit_of(std::string_view parameter) {
    if (parameter == "time_offset") {
        return "s";
    }
    if (parameter.find("theta") != std::string_view::npos) {
        return "rad";
    }
    if (parameter.find("_p_") != std::string_view::npos) {
        return "m";
    }
    return parameter.ends_with("cx") || parameter.ends_with("cy") ? "px" : "-";
}

/// Adds a property that is always there.
void add(Json& schema, const std::string& name, Json type) {
    schema["properties"][name] = std::move(type);
    schema["required"].push_back(name);
}

/// "total", then the stages' names.
const char* name_of_time(std::size_t place) {
    constexpr std::array<const char*, 2> kFirst{"total", "estimate"};
    return place < kFirst.size() ? kFirst[place] : to_string(static_cast<Stage>(place - kFirst.size()));
}

}  // namespace

nlohmann::ordered_json health_schema(const char* title) {
    Json schema = schema_parts::object(title, {{"timestamp", schema_parts::time()}});
    for (const HealthField& field : kHealthFields) {
        add(schema, field.name, schema_parts::described({{"type", field.type}}, field.words));
    }
    add(schema, "reason_names", schema_parts::described(schema_parts::text(), "names of the reasons, joined by |"));
    return schema;
}

std::string health_message(Timestamp stamp, const Health& health, std::string_view reasons) {
    Json message{{"timestamp", json_values::stamp(stamp)}};
    for (const HealthField& field : kHealthFields) {
        message[field.name] = field.value(health);
    }
    message["reason_names"] = reasons;
    return message.dump();
}

nlohmann::ordered_json calibration_schema(const char* title) {
    Json schema = schema_parts::object(title, {{"timestamp", schema_parts::time()}});
    for (const char* name : kCorrectionNames) {
        add(schema, name,
            schema_parts::described(schema_parts::number(),
                                    fmt::format("correction of the calibration as given ({})", unit_of(name))));
        add(schema, fmt::format("{}_sigma", name),
            schema_parts::described(schema_parts::number(), "its standard deviation; 0 if it is not estimated"));
    }
    return schema;
}

std::string calibration_message(Timestamp stamp, const CalibrationEstimate& estimate) {
    Json message{{"timestamp", json_values::stamp(stamp)}};
    const RigCalibration::Tangent correction = RigCalibration{}.box_minus_to(estimate.correction);
    for (std::size_t i = 0; i < kCorrectionNames.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(i);
        message[kCorrectionNames[i]] = correction(at);
        message[fmt::format("{}_sigma", kCorrectionNames[i])] = estimate.sigma(at);
    }
    return message.dump();
}

nlohmann::ordered_json timing_schema(const char* title) {
    Json schema =
        schema_parts::object(title, {{"timestamp", schema_parts::time()}, {"is_keyframe", schema_parts::boolean()}});
    for (std::size_t i = 0; i < kMessageTimes; ++i) {
        add(schema, fmt::format("{}_ms", name_of_time(i)),
            schema_parts::described(schema_parts::number(), "by the wall's clock (ms)"));
        add(schema, fmt::format("{}_cpu_ms", name_of_time(i)),
            schema_parts::described(schema_parts::number(), "CPU time of the estimator's thread (ms)"));
    }
    return schema;
}

std::string timing_message(Timestamp stamp, bool is_keyframe, const MessageTimes& times) {
    Json message{{"timestamp", json_values::stamp(stamp)}, {"is_keyframe", is_keyframe}};
    for (std::size_t i = 0; i < kMessageTimes; ++i) {
        message[fmt::format("{}_ms", name_of_time(i))] = times[i].wall_ms;
        message[fmt::format("{}_cpu_ms", name_of_time(i))] = times[i].processor_ms;
    }
    return message.dump();
}

}  // namespace facet
