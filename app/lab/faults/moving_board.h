// SPDX-License-Identifier: BSD-2-Clause
// A thing that goes with the vehicle and fills much of its view, such as another vehicle or the load below it.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/replay_asl/png_decoder.h"
#include "estimator/geometry/stereo_rig.h"

namespace facet {

/// A textured board at a constant distance before the left camera, square to its axis and centred on it, whose texture
/// slides along x: both cameras see it where it would be by the rig. Thread-bound. Heap in the constructor only.
class MovingBoard {
public:
    static constexpr double kDistance_m = 2.0;

    /// @param share  of the left image that it covers, (0, 1]
    MovingBoard(const StereoRig& rig, double share);

    /// Draws it over an image of the rig's size; another one stays.
    /// @param shift_m  by which the texture has slid to the right
    void draw(bool is_right, double shift_m, GreyImage& image) const;

private:
    struct Pixel {
        std::uint32_t index;  ///< in the image
        float x_m;            ///< on the board
        float y_m;
    };

    static std::vector<Pixel> pixels_of(const CameraModel& camera, const Se3& T_C0_C, double half_x_m, double half_y_m);

    std::size_t sizes_[2]{};  ///< pixels of an image
    std::vector<Pixel> pixels_[2];
};

}  // namespace facet
