// SPDX-License-Identifier: BSD-2-Clause
// Writes small video files.
#pragma once

#include <functional>
#include <string>

namespace facet::test {

/// Whether the tests are built with libavformat and libavcodec.
bool can_write_videos();

/// Frames at 20 Hz, whose stamps begin at zero; the container is that of the name's ending.
/// @param codec   an encoder of libavcodec, such as ffv1
/// @param format  of pixels: gray, gray10le, yuv420p, yuvj420p or bgr0, in which all colours are alike
/// @param grey    of a pixel of a frame, 0 to 255
void write_video(const std::string& path, const char* codec, const char* format, int width, int height, int frames,
                 const std::function<int(int k, int u, int v)>& grey);

}  // namespace facet::test
