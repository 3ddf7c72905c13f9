// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/bag_calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <deque>
#include <map>

#include "app/calibration/calibration_fields.h"

namespace facet {
namespace {

/// The CameraInfo in the folder of a topic of images, or one above: /left/camera_info for /left/image_raw/compressed.
const std::pair<const std::string, SurveyedLens>* lens_beside(const BagSurvey& survey, const std::string& images) {
    for (std::size_t end = images.rfind('/'); end != std::string::npos; end = images.rfind('/', end - 1)) {
        const auto found = survey.lenses.find(images.substr(0, end) + "/camera_info");
        if (found != survey.lenses.end()) {
            return &*found;
        }
        if (end == 0) {
            break;
        }
    }
    return nullptr;
}

CameraModel camera_of(const std::string& topic, const SurveyedLens& lens, bool is_rectified) {
    const YamlNode blame(YAML::Node(), topic, "", YamlNode::kNoLine);
    const auto& k = lens.k;
    const auto& p = lens.p;
    LensFields fields{.model = "pinhole",
                      .distortion = lens.distortion_model,
                      .intrinsics = {k[0], k[4], k[2], k[5]},
                      .coefficients = lens.d,
                      .resolution = {static_cast<double>(lens.width), static_cast<double>(lens.height)},
                      .model_node = blame,
                      .distortion_node = blame,
                      .intrinsics_node = blame,
                      .coefficients_node = blame,
                      .resolution_node = blame};
    const bool is_straight = std::ranges::all_of(lens.d, [](double x) { return x == 0.0; });
    if (is_rectified) {
        fields.intrinsics = {p[0], p[5], p[2], p[6]};
    }
    if (is_rectified || is_straight) {
        fields.distortion = "none";
        fields.coefficients.clear();
    }
    return make_camera(fields);
}

Se3 transform_of(const std::array<double, 7>& v) {
    return {Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized(), {v[0], v[1], v[2]}};
}

/// T_from_to, along the tree of frames in either direction.
std::optional<Se3> way(const BagSurvey& survey, const std::string& from, const std::string& to) {
    std::map<std::string, Se3> reached{{from, Se3{}}};
    std::deque<std::string> open{from};
    while (!open.empty() && !reached.contains(to)) {
        const std::string frame = open.front();
        open.pop_front();
        const Se3 T = reached.at(frame);
        for (const SurveyedTransform& t : survey.transforms) {
            const bool is_down = t.parent == frame;
            if (!is_down && t.child != frame) {
                continue;
            }
            const Se3 step = transform_of(t.values);
            if (reached.emplace(is_down ? t.child : t.parent, T * (is_down ? step : step.inverse())).second) {
                open.push_back(is_down ? t.child : t.parent);
            }
        }
    }
    const auto found = reached.find(to);
    return found == reached.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

std::optional<Calibration> calibration_of_bag(const BagSurvey& survey, const ChosenTopics& topics, std::string& lack) {
    const auto name_of_table = [&](LogTable table) { return topics.tables[static_cast<std::size_t>(table)]; };
    const TopicSurvey& imu = survey.topics.at(name_of_table(LogTable::kImu));
    std::vector<CameraModel> cameras;
    std::vector<Se3> poses;
    for (const LogTable table : {LogTable::kLeft, LogTable::kRight}) {
        const std::string images = name_of_table(table);
        if (images.empty()) {
            continue;
        }
        const auto* const lens = lens_beside(survey, images);
        if (lens == nullptr || lens->second.k[0] == 0.0) {
            lack = fmt::format("no camera_info beside {}", images);
            return std::nullopt;
        }
        const std::string frame = lens->second.frame.empty() ? survey.topics.at(images).frame : lens->second.frame;
        const std::optional<Se3> T = way(survey, imu.frame, frame);
        if (!T.has_value() || !T->q.coeffs().allFinite() || !T->p.allFinite()) {
            lack = fmt::format("no way from '{}' to '{}' in /tf_static", imu.frame, frame);
            return std::nullopt;
        }
        cameras.push_back(camera_of(lens->first, lens->second, images.find("rect") != std::string::npos));
        poses.push_back(*T);
    }
    Calibration calibration;
    calibration.source = "camera_info and tf_static";
    calibration.rig = StereoRig::monocular(cameras.front(), poses.front());
    if (cameras.size() == 2) {
        calibration.rig = {.left = cameras[0], .right = cameras[1], .T_B_C0 = poses[0], .T_B_C1 = poses[1]};
        check_baseline(calibration.rig, YamlNode(YAML::Node(), "/tf_static", "", YamlNode::kNoLine));
    }
    calibration.noise.rate_hz = std::clamp(imu.rate_hz(), 20.0, 1e4);
    return calibration;
}

}  // namespace facet
