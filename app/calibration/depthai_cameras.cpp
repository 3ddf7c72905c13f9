// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/depthai_cameras.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "app/calibration/calibration_fields.h"

namespace facet {
namespace {

constexpr int kNoSocket = -1;

/// Cameras by socket; in some files they are a map instead of a list of pairs.
std::map<int, YamlNode> cameras_of(const YamlNode& data) {
    std::map<int, YamlNode> cameras;
    if (data.raw().IsMap()) {
        for (const auto& entry : data.raw()) {
            const std::string name = entry.first.Scalar();
            cameras.insert({YamlNode(entry.first, data.file(), data.field(), data.line()).integer(), data.at(name)});
        }
        return cameras;
    }
    for (std::size_t i = 0; i < data.size(); ++i) {
        const YamlNode pair = data.item(i);
        cameras.insert({pair.item(0).integer(), pair.item(1)});
    }
    return cameras;
}

/// Whether a socket has a calibrated camera.
bool is_calibrated(const std::map<int, YamlNode>& cameras, int socket) {
    const auto found = cameras.find(socket);
    if (found == cameras.end() || !found->second.has("intrinsicMatrix")) {
        return false;
    }
    const YamlNode matrix = found->second.at("intrinsicMatrix");
    return matrix.size() == 3 && matrix.item(0).size() == 3 && matrix.item(0).item(0).number() > 0.0;
}

Eigen::Vector3d vector_at(const YamlNode& node) {
    return {node.at("x").number(), node.at("y").number(), node.at("z").number()};
}

/// In the order of DepthAI's LengthUnit.
double metres_a_unit(const YamlNode& extrinsics) {
    constexpr std::array kUnits{1.0, 0.01, 0.001, 0.0254, 0.3048};
    if (!extrinsics.has("lengthUnit")) {
        return kUnits[1];
    }
    const int unit = extrinsics.at("lengthUnit").integer();
    if (unit < 0 || unit >= static_cast<int>(kUnits.size())) {
        extrinsics.at("lengthUnit").fail("is not a unit of length of DepthAI: 0 to 4 (m, cm, mm, inch, foot)");
    }
    return kUnits[static_cast<std::size_t>(unit)];
}

/// Where extrinsics lead to; none if they are empty.
int target_of(const YamlNode& extrinsics) {
    if (!extrinsics.has("toCameraSocket") || !extrinsics.has("rotationMatrix") ||
        extrinsics.at("rotationMatrix").size() == 0) {
        return kNoSocket;
    }
    const bool is_zero = extrinsics.at("rotationMatrix").matrix3().isZero(0.0);
    return is_zero ? kNoSocket : extrinsics.at("toCameraSocket").integer();
}

/// Calibrated places, or where there are none those of the drawing.
Se3 read_extrinsics(const YamlNode& extrinsics, std::vector<std::string>& remarks) {
    const YamlNode rotation = extrinsics.at("rotationMatrix");
    Eigen::Vector3d p = vector_at(extrinsics.at("translation"));
    if (p.isZero(0.0) && extrinsics.has("specTranslation")) {
        p = vector_at(extrinsics.at("specTranslation"));
        if (!p.isZero(0.0)) {
            remarks.push_back(fmt::format("{}:{}: {}: translation is zero, specTranslation is used instead",
                                          extrinsics.file(), extrinsics.line(), extrinsics.field()));
        }
    }
    return {Eigen::Quaterniond(nearest_rotation(rotation.matrix3(), rotation)).normalized(),
            metres_a_unit(extrinsics) * p};
}

/// Maps from one camera's frame to that of another to which its chain of extrinsics leads.
std::optional<Se3> chain_from(const std::map<int, YamlNode>& cameras, int from, int to,
                              std::vector<std::string>& remarks) {
    Se3 T;
    for (std::size_t steps = 0; from != to; ++steps) {
        const auto camera = cameras.find(from);
        if (camera == cameras.end() || steps > cameras.size() || !camera->second.has("extrinsics")) {
            return std::nullopt;
        }
        const YamlNode extrinsics = camera->second.at("extrinsics");
        from = target_of(extrinsics);
        if (from == kNoSocket) {
            return std::nullopt;
        }
        T = read_extrinsics(extrinsics, remarks) * T;
    }
    return T;
}

/// Maps from one camera's frame to another's; both chains may end in a third.
std::optional<Se3> between(const std::map<int, YamlNode>& cameras, int from, int to,
                           std::vector<std::string>& remarks) {
    for (const auto& [middle, camera] : cameras) {
        std::vector<std::string> said;
        const std::optional<Se3> there = chain_from(cameras, from, middle, said);
        const std::optional<Se3> back = chain_from(cameras, to, middle, said);
        if (there.has_value() && back.has_value()) {
            remarks.insert(remarks.end(), said.begin(), said.end());
            return back->inverse() * *there;
        }
    }
    return std::nullopt;
}

/// Pixel (0, 0) is the centre of its pixel before and after.
void scale_lens(const ImageExtent& images, std::vector<double>& size, std::vector<double>& k) {
    const double scale = std::max(images.width / size[0], images.height / size[1]);
    const std::array<double, 2> cut{scale * size[0] - images.width, scale * size[1] - images.height};
    k[0] *= scale;
    k[1] *= scale;
    for (std::size_t i = 0; i < 2; ++i) {
        k[2 + i] = scale * (k[2 + i] + 0.5) - 0.5 - 0.5 * cut[i];
    }
    size = {static_cast<double>(images.width), static_cast<double>(images.height)};
}

CameraModel depthai_camera(const YamlNode& camera, const ImageExtent& images, std::vector<std::string>& remarks) {
    const YamlNode matrix = camera.at("intrinsicMatrix");
    const Eigen::Matrix3d K = matrix.matrix3();
    const YamlNode coefficients = camera.at("distortionCoeff");
    const YamlNode width = camera.at("width");
    const YamlNode type = camera.has("cameraType") ? camera.at("cameraType") : matrix;
    const int kind = camera.has("cameraType") ? type.integer() : 0;
    if (kind != 0 && kind != 1) {
        type.fail(fmt::format("is {}: only 0, perspective, and 1, fisheye, are lens models here", kind));
    }
    std::vector<double> c = coefficients.numbers();
    if (kind == 1) {
        c.resize(4);
    } else if (c.empty()) {
        c.resize(4);
        remarks.push_back(fmt::format("{}:{}: {}: is empty: no distortion is assumed", camera.file(),
                                      coefficients.line(), coefficients.field()));
    }
    std::vector<double> k{K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
    std::vector<double> size{width.number(), camera.at("height").number()};
    const bool is_other_size = images.width > 0 && (size[0] != images.width || size[1] != images.height);
    if (is_other_size && size[0] > 0.0 && size[1] > 0.0) {
        remarks.push_back(fmt::format("{}:{}: {}: is for images of {}x{} px, scaled to {}x{}", camera.file(),
                                      camera.line(), camera.field(), size[0], size[1], images.width, images.height));
        scale_lens(images, size, k);
    }
    return make_camera({.model = "pinhole",
                        .distortion = kind == 1 ? "equidistant" : "rational",
                        .intrinsics = k,
                        .coefficients = c,
                        .resolution = size,
                        .model_node = type,
                        .distortion_node = type,
                        .intrinsics_node = matrix,
                        .coefficients_node = coefficients,
                        .resolution_node = width});
}

/// Left and right; the second is none if there is one camera.
std::pair<int, int> choose_sockets(const YamlNode& root, const std::map<int, YamlNode>& cameras) {
    std::vector<std::pair<int, int>> pairs;
    if (root.has("stereoRectificationData")) {
        const YamlNode stereo = root.at("stereoRectificationData");
        if (stereo.has("leftCameraSocket") && stereo.has("rightCameraSocket")) {
            pairs.emplace_back(stereo.at("leftCameraSocket").integer(), stereo.at("rightCameraSocket").integer());
        }
    }
    pairs.emplace_back(1, 2);
    for (const auto& [left, right] : pairs) {
        if (left != right && is_calibrated(cameras, left) && is_calibrated(cameras, right)) {
            return {left, right};
        }
    }
    for (const auto& [socket, camera] : cameras) {
        if (is_calibrated(cameras, socket)) {
            return {socket, kNoSocket};
        }
    }
    root.fail("cameraData: none of the cameras is calibrated");
}

void remark_other_cameras(const YamlNode& root, const std::map<int, YamlNode>& cameras, const std::pair<int, int>& used,
                          Calibration& calibration) {
    for (const auto& [socket, camera] : cameras) {
        if (socket != used.first && socket != used.second && is_calibrated(cameras, socket)) {
            calibration.remarks.push_back(fmt::format("{}:{}: {}: the camera of socket {} is not used", root.file(),
                                                      camera.line(), camera.field(), socket));
        }
    }
}

}  // namespace

void read_depthai(const YamlNode& root, const ImageExtent& images, Calibration& calibration) {
    const YamlNode data = root.at("cameraData");
    const std::map<int, YamlNode> cameras = cameras_of(data);
    const std::pair<int, int> sockets = choose_sockets(root, cameras);
    const YamlNode imu = root.has("imuExtrinsics") ? root.at("imuExtrinsics") : root;
    const int at = root.has("imuExtrinsics") ? target_of(imu) : kNoSocket;
    if (at == kNoSocket) {
        imu.fail(
            "is empty: this camera's calibration does not say where the IMU sits, as many of the factory's do not; "
            "calibrate it, for example with Kalibr's kalibr_calibrate_imu_camera");
    }
    std::vector<std::string>& remarks = calibration.remarks;
    const auto place_of = [&](int socket) {
        const std::optional<Se3> T_C_at = between(cameras, at, socket, remarks);
        if (!T_C_at.has_value()) {
            data.fail(fmt::format("no extrinsics lead from socket {} to socket {}", at, socket));
        }
        return (*T_C_at * read_extrinsics(imu, remarks)).inverse();
    };
    const CameraModel left = depthai_camera(cameras.at(sockets.first), images, remarks);
    calibration.rig = StereoRig::monocular(left, place_of(sockets.first));
    if (sockets.second != kNoSocket) {
        calibration.rig = {.left = left,
                           .right = depthai_camera(cameras.at(sockets.second), images, remarks),
                           .T_B_C0 = calibration.rig.T_B_C0,
                           .T_B_C1 = place_of(sockets.second)};
        check_baseline(calibration.rig, data);
        if (calibration.rig.T_C1_C0().p.x() > 0.0) {
            remarks.push_back(
                fmt::format("{}: the camera of socket {}, called left, is to the right of socket {}: "
                            "cam0 must hold its images",
                            root.file(), sockets.first, sockets.second));
        }
    }
    std::ranges::sort(remarks);
    remarks.erase(std::unique(remarks.begin(), remarks.end()), remarks.end());
    remark_other_cameras(root, cameras, sockets, calibration);
}

}  // namespace facet
