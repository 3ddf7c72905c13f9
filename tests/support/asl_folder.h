// SPDX-License-Identifier: BSD-2-Clause
// Writes tiny EuRoC/ASL folders for tests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/temp_dir.h"

namespace facet::test {

inline constexpr int kAslWidth = 160;
inline constexpr int kAslHeight = 120;
inline constexpr std::int64_t kAslBegin = 1'400'000'000'000'000'000;  // ns
inline constexpr std::int64_t kAslFrameStep = 50'000'000;             // 20 Hz
inline constexpr std::int64_t kAslImuStep = 5'000'000;                // 200 Hz

/// Encodes an image with libpng. Samples are row by row, channels interleaved.
/// @param channels  1 grey, 2 grey + alpha, 3 RGB, 4 RGBA
/// @param bits      8 or 16; values are taken as they are
std::string encode_png(int width, int height, int channels, int bits, const std::vector<std::uint16_t>& samples);

/// Encodes an image of one value with libjpeg. @param channels  1 grey, 3 RGB
std::string encode_jpeg(int width, int height, int channels, std::uint8_t value);

/// Grey value of pixel (u, v) of frame k in the log below; differs between frames and cameras.
std::uint8_t asl_pixel(int camera, int frame, int u, int v);

/// Row of cam<camera>/data.csv for frame k, and its file name.
std::string asl_image_row(int frame);
std::string asl_image_name(int frame);
/// Row of imu0/data.csv for sample i: rates (0, 0, 0.01), specific force (0, 0, 9.81).
std::string asl_imu_row(int sample);

/// A good log: stereo frames at kAslBegin + k * 50 ms, inertial samples at 5 ms from one frame step before the first
/// frame to one after the last, sensor.yaml files with a 0.1 m baseline.
void write_asl_folder(const TempDir& dir, int frames);

/// sensor.yaml texts of the folder above.
std::string asl_camera_yaml(int camera);
std::string asl_imu_yaml();

/// Replaces one line (from 1) of a file by other text; an empty text removes the line.
void replace_line(const std::string& path, int line, const std::string& text);

}  // namespace facet::test
