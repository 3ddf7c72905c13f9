// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/core.h>

#include <array>
#include <optional>

#include "app/config/read_duration.h"
#include "app/config/vehicle_ros2.h"
#include "app/config/vehicle_sensors.h"

namespace facet {
namespace {

/// What all cameras may have in common, and each may have otherwise.
void read_camera(YamlSection& section, CameraV4l2Options& camera) {
    if (const auto format = section.find("format")) {
        const auto known = pixel_format(format->text());
        camera.capture.any_format = format->text() == "auto";
        if (!known && !camera.capture.any_format) {
            format->fail(fmt::format(
                "'{}' is unknown; one of: auto, GREY, Y10, Y10P, Y12, Y012, Y16, YUYV, UYVY, NV12, Y8I, Y12I, MJPG",
                format->text()));
        }
        camera.capture.format = known.value_or(PixelFormat::kGrey);
    }
    section.read("significant_bits", camera.significant_bits, 0, 16);
    section.read("msb_aligned", camera.msb_aligned);
    section.read("controls_device", camera.controls_device);
    section.read("buffers", camera.capture.buffers, 2, 8);
    section.read("heap", camera.capture.heap);
    read_duration(section, "exposure_s", camera.exposure, 0.0, 1.0);
    read_duration(section, "readout_s", camera.readout, 0.0, 1.0);
    constexpr std::array<std::string_view, 4> kStamps{"as_flagged", "start_of_exposure", "end_of_frame",
                                                      "mid_exposure"};
    camera.stamp_source =
        static_cast<StampSource>(section.choice("stamps", kStamps, static_cast<std::size_t>(camera.stamp_source)));
    if (const auto controls = section.find("controls")) {
        YamlSection list(*controls);
        camera.controls.clear();
        for (const auto& item : controls->raw()) {
            const std::string name = item.first.Scalar();
            camera.controls.push_back({name, list.at(name).integer()});
        }
    }
}

void read_node(const YamlNode& node, CameraV4l2Options& camera) {
    YamlSection section(node);
    section.read("device", camera.capture.device);
    read_camera(section, camera);
    section.finish();
}

AutoExposureOptions read_auto_exposure(const YamlNode& node) {
    constexpr int kMost = 1'000'000;
    AutoExposureOptions options;
    YamlSection section(node);
    section.read("exposure_control", options.exposure_control);
    section.read("gain_control", options.gain_control);
    (void)section.at("exposure_step_s");
    section.read("exposure_step_s", options.exposure_step_s, 1e-7, 0.1);
    section.read("gain_one", options.gain_one, 1, kMost);
    section.read("least_exposure", options.least_exposure, 1, kMost);
    (void)section.at("most_exposure");
    section.read("most_exposure", options.most_exposure, options.least_exposure, kMost);
    options.least_gain = options.gain_one;
    section.read("least_gain", options.least_gain, 1, kMost);
    options.most_gain = options.least_gain;
    section.read("most_gain", options.most_gain, options.least_gain, kMost);
    section.read("target", options.target, 20.0, 200.0);
    section.read("latency_frames", options.latency_frames, 0, 8);
    section.finish();
    return options;
}

/// Topics take the place of nodes, of which nothing else may be said then.
void read_topics(const YamlNode& node, const YamlNode& topics, const Calibration& calibration,
                 VehicleCameras& cameras) {
    for (const auto& item : node.raw()) {
        const std::string key = item.first.Scalar();
        if (key != "rate_hz" && key != "lag_frames" && key != "ros2") {
            node.fail(fmt::format("'{}' is of cameras on nodes, not of topics: leave out that or 'ros2'", key));
        }
    }
    cameras.ros2 = read_ros2_cameras(topics, calibration);
    cameras.use_sequence = false;  // their messages are not numbered
}

}  // namespace

VehicleCameras read_cameras(const YamlNode& node, const Calibration& calibration) {
    VehicleCameras cameras;
    YamlSection section(node);
    section.read("rate_hz", cameras.rate_hz, 1.0, 200.0);
    section.read("use_sequence", cameras.use_sequence);
    section.read("lag_frames", cameras.lag_frames, 0, 8);
    if (const auto automatic = section.find("auto_exposure")) {
        cameras.auto_exposure = read_auto_exposure(*automatic);
    }
    CameraV4l2Options common;
    common.capture.any_format = true;
    read_camera(section, common);
    cameras.left = cameras.right = common;
    cameras.left.capture.device = "/dev/video0";
    cameras.right.capture.device = "/dev/video1";
    const auto both = section.find("side_by_side");
    const auto left = section.find("left");
    const auto right = section.find("right");
    const auto topics = section.find("ros2");
    section.finish();
    if (topics) {
        read_topics(node, *topics, calibration, cameras);
        return cameras;
    }
    if (!calibration.rig.has_right && (both || right)) {
        (both ? *both : *right).fail("the calibration has one camera: say 'left' only");
    }
    if (both && (left || right)) {
        node.fail("has 'side_by_side' and 'left' or 'right'; choose one node or two");
    }
    const auto set_size = [](CameraV4l2Options& camera, const CameraIntrinsics& k) {
        camera.capture.width = k.width;
        camera.capture.height = k.height;
    };
    set_size(cameras.left, calibration.rig.left.intrinsics());
    set_size(cameras.right, calibration.rig.right.intrinsics());
    if (both) {
        cameras.side_by_side = true;
        if (cameras.left.capture.width != cameras.right.capture.width ||
            cameras.left.capture.height != cameras.right.capture.height) {
            both->fail("the calibration has cameras of different sizes: they cannot be side by side");
        }
        cameras.left.capture.width *= 2;
        cameras.left.capture.has_two_views = true;
        read_node(*both, cameras.left);
    }
    if (left) {
        read_node(*left, cameras.left);
    }
    if (right) {
        read_node(*right, cameras.right);
    }
    for (const CameraV4l2Options* camera : {&cameras.left, &cameras.right}) {
        const PixelFormat format = camera->capture.format;
        if (is_interleaved(format) && !camera->capture.has_two_views && (camera == &cameras.left || !both)) {
            node.fail(fmt::format("{} holds both views in one image: say 'side_by_side'", to_string(format)));
        }
    }
    if (!both && calibration.rig.has_right && cameras.left.capture.device == cameras.right.capture.device) {
        node.fail("left and right are the same device; an image of both is 'side_by_side'");
    }
    return cameras;
}

}  // namespace facet
