// SPDX-License-Identifier: BSD-2-Clause
// One camera's pictures of a scene: true lens distortion, motion blur, exposure, vignette and sensor noise.
#pragma once

#include <cstdint>
#include <vector>

#include "app/lab/sim/flight.h"
#include "app/lab/sim/mover.h"
#include "app/lab/sim/scene.h"
#include "estimator/geometry/stereo_rig.h"

namespace facet::sim {

/// What the camera does to light.
struct Photometry {
    double exposure_s = 0.006;     ///< the samples of a pixel spread over it
    double vignette = 0.42;        ///< light lost at the image corner, growing with r^2
    double gain = 1.0;             ///< relative to the other camera
    double read_noise_dn = 0.7;    ///< standard deviation in the dark (grey values of 255)
    double shot_noise_dn = 0.014;  ///< variance per grey value at gain 1
    bool noise = true;
};

/// What there is to see, and from where.
struct World {
    const Scene& scene;
    const Flight& flight;
    const Mover* mover = nullptr;  ///< nothing moves if nullptr
};

/// Camera of one rig with its cached rays. render() is reentrant: one renderer serves several threads.
class Renderer {
public:
    /// Caches rays: `samples` per pixel, spread with a tent of +-1 px around its centre (a lens's point spread), each
    /// through the inverse of the distorted model, at its own time. Place and time of the samples are the same for
    /// every pixel, so that edges stay clean while moving. Heap: 12 bytes a sample.
    Renderer(const CameraModel& camera, const Se3& T_B_C, int samples, const Photometry& photometry);

    int width() const { return width_; }
    int height() const { return height_; }

    /// Picture with mid-exposure at flight time t.
    ///   grey = gain * vignette(u, v) * mean radiance, plus noise, clipped to 0..255
    /// Within the exposure the body moves at constant rate and velocity; at 6 ms what that leaves out is below 0.01 px,
    /// and grows with the square of the exposure.
    /// @param gain       grey values per radiance (auto-exposure)
    /// @param noise_key  of this frame and camera: the noise depends on nothing but it and the pixel
    /// @param image      resized to width * height
    void render(const World& world, double t_s, double gain, std::uint64_t noise_key,
                std::vector<std::uint8_t>& image) const;

    /// Direction in C of the ray through a pixel, unit length; the optical axis where no ray is known.
    Eigen::Vector3d ray(double u, double v) const;
    /// Whether the lens shows anything at a pixel and the samples about it: a fisheye's corners stay black.
    bool sees(double u, double v) const;
    const Se3& T_B_C() const { return T_B_C_; }
    double focal_px() const { return camera_.focal_px(); }

private:
    /// Tiles of 8 x 4 pixels are cast together; pixel k of a tile is (k % 8, k / 8), those beyond the border repeat it.
    static constexpr int kTileWidth = 8;
    static constexpr int kTileHeight = 4;
    static constexpr int kTilePixels = kTileWidth * kTileHeight;

    void render_tile(const Scene& scene, const struct ExposureMotion& motion, int tile, float* radiance) const;
    /// Draws the mover over a bundle of the tile's rays that have met the scene.
    void cover_bundle(const struct ExposureMotion& motion, const RayPacket* packets, int first, int bundle,
                      float* radiance) const;
    std::uint8_t expose(float radiance, double gain, int pixel, std::uint64_t noise_key) const;

    CameraModel camera_;
    Se3 T_B_C_;
    Photometry photometry_;
    int width_ = 0;
    int height_ = 0;
    int samples_ = 0;
    int tile_columns_ = 0;
    int tile_rows_ = 0;
    std::vector<float> times_;  ///< of a tile's samples, in exposures from its middle
    std::vector<float> rays_;   ///< tile after tile: x of all its samples, pixel by pixel, then y, then z
    std::vector<float> vignette_;
};

/// Grey values per radiance for each frame, as an auto-exposure would choose them: aims at a mean grey of 95 and
/// follows slowly. From coarse pictures of every frame, also returning which surfaces were seen where.
struct CoarseHit {
    int surface = 0;
    float u = 0.0F;
    float v = 0.0F;
};
struct CoarsePass {
    std::vector<double> gains;
    std::vector<CoarseHit> hits;  ///< of all frames
};
CoarsePass coarse_pass(const Scene& scene, const Flight& flight, const Renderer& camera,
                       const std::vector<double>& times_s, int threads);

}  // namespace facet::sim
