// SPDX-License-Identifier: BSD-2-Clause
// Readers of the parts that calibration files share.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/support/yaml_file.h"

namespace facet {

/// Rigid transform of a 4x4 matrix field. The rotation may be off orthonormality by 1e-3 (rounded files) and is then
/// projected onto SO(3). Throws InputError if it is farther off, reflects, or if the last row is not 0 0 0 1.
Se3 read_transform(const YamlNode& field);

/// The same of a rotation alone. @param field  that errors name
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& rotation, const YamlNode& field);

/// What a file says of a lens, in the words of its format. The nodes are what errors name.
struct LensFields {
    std::string model;                 ///< of the projection: pinhole, omni, ds, eucm, kb4 and others' names
    std::string distortion;            ///< radtan, plumb_bob, equidistant, fov, none and others' names
    std::vector<double> intrinsics;    ///< as Kalibr orders them: what the model adds, then fu fv cu cv
    std::vector<double> coefficients;  ///< of the distortion
    std::vector<double> resolution;    ///< width, height (px)
    YamlNode model_node;
    YamlNode distortion_node;
    YamlNode intrinsics_node;
    YamlNode coefficients_node;
    YamlNode resolution_node;
};

/// The camera of such a lens. Throws InputError if model or distortion is unknown, a number is missing or too many, or
/// the camera is implausible.
CameraModel make_camera(const LensFields& lens);

/// A camera with camera_model, resolution, intrinsics, distortion_model, and coefficients under the given key. Throws
/// InputError if a field is missing, and as above.
CameraModel read_camera(const YamlNode& camera, const std::string& coefficients_key);

/// Kalibr's timeshift_cam_imu or another such field: t_imu = t_cam + shift. None without it. Throws InputError if it is
/// more than 1 s. @param unit_s  of the number
Duration read_time_shift(const YamlNode& node, const std::string& key, double unit_s = 1.0);

/// Throws InputError if the baseline is not between 1 mm and 10 m.
void check_baseline(const StereoRig& rig, const YamlNode& right_extrinsics);

/// From the keys that `facet calibrate` writes beside a camera's values: intrinsics_sigma [fu fv cu cv] (px),
/// distortion_sigma [4] (-), rotation_sigma_deg [3]. Empty unless both cameras have all three. Throws InputError if one
/// is no list of that many finite numbers.
std::optional<StatedSigmas> read_stated_sigmas(const YamlNode& left, const YamlNode& right, const StereoRig& rig);

/// Adds a remark for every key of a map that is not among these.
void remark_unused(const YamlNode& node, std::initializer_list<std::string_view> used,
                   std::vector<std::string>& remarks);

}  // namespace facet
