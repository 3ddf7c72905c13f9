// SPDX-License-Identifier: BSD-2-Clause
// The calibration of an OAK camera, as DepthAI exports it.
#pragma once

#include "app/calibration/calibration.h"
#include "app/support/yaml_file.h"

namespace facet {

/// The JSON file of CalibrationHandler::eepromToJsonFile: cameraData, a list of [socket, camera], and imuExtrinsics.
/// The cameras are the stereo pair that stereoRectificationData names, else sockets 1 and 2, else 0 alone. The
/// extrinsics of a camera, and of the IMU, map into the frame of toCameraSocket, p_to = R p + t, in centimetres unless
/// lengthUnit says otherwise. A perspective lens (cameraType 0) has OpenCV's fourteen coefficients, of which thin prism
/// and tilt must be zero, a fisheye (1) four of the equidistant model.
/// @param images  of the log; where it is another size than that of the calibration, the lens is scaled to the larger
///                of the ratios and cropped around the middle, as DepthAI's outputs are; zero: it is that size
/// Throws InputError naming file, line and field; so if the IMU's place is not in the file, as in many of the
/// factory's.
void read_depthai(const YamlNode& root, const ImageExtent& images, Calibration& calibration);

}  // namespace facet
