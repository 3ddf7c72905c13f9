// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "app/lab/sim/parallel.h"
#include "app/support/rng.h"

namespace facet::sim {

/// Camera motion during one exposure: d_W = R (d + tau w x d), o_W = p + tau v.
struct ExposureMotion {
    Eigen::Matrix3f R_W_C;
    Eigen::Vector3f w_C;
    Eigen::Vector3f p_W;
    Eigen::Vector3f v_W;
    float exposure_s = 0.0F;
    const Mover* mover = nullptr;
    std::optional<MoverPose> mover_pose;  ///< at mid-exposure
};

namespace {

using Eigen::Vector3d;

/// Inverse of a tent's distribution on [-1, 1].
double tent(double x) { return x < 0.5 ? std::sqrt(2.0 * x) - 1.0 : 1.0 - std::sqrt(2.0 - 2.0 * x); }

constexpr double kSampleReach_px = 2.0;  // of a pixel's samples from its centre, at most

/// Offsets of a pixel's samples (px), mean exactly zero: R2 sequence through the tent.
std::vector<Eigen::Vector2d> sample_offsets(int count) {
    std::vector<Eigen::Vector2d> offsets;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (int i = 0; i < count; ++i) {
        const double a = 0.5 + 0.7548776662466927 * i;
        offsets.emplace_back(tent((i + 0.5) / count), tent(a - std::floor(a)));
        mean += offsets.back() / count;
    }
    for (Eigen::Vector2d& o : offsets) {
        o -= mean;
    }
    return offsets;
}

/// Times of a pixel's samples (exposures from its middle): the middles of equal slots, dealt out so that neighbours in
/// time are not neighbours in place.
std::vector<float> sample_times(int count) {
    std::vector<std::pair<double, int>> order;
    for (int i = 0; i < count; ++i) {
        const double b = 0.25 + 0.5698402909980532 * i;
        order.emplace_back(b - std::floor(b), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<float> times(static_cast<std::size_t>(count));
    for (int slot = 0; slot < count; ++slot) {
        times[static_cast<std::size_t>(order[static_cast<std::size_t>(slot)].second)] =
            (static_cast<float>(slot) + 0.5F) / static_cast<float>(count) - 0.5F;
    }
    return times;
}

ExposureMotion exposure_motion(const Flight& flight, double t_s, const Se3& T_B_C, double exposure_s) {
    const FlightState s = flight.evaluate(t_s);
    const Se3 T_W_C = s.T_W_B * T_B_C;
    ExposureMotion m;
    m.R_W_C = T_W_C.R().cast<float>();
    m.w_C = (T_B_C.q.conjugate() * s.w_B).cast<float>();
    m.p_W = T_W_C.p.cast<float>();
    m.v_W = (s.v_W + s.T_W_B.q * s.w_B.cross(T_B_C.p)).cast<float>();
    m.exposure_s = static_cast<float>(exposure_s);
    return m;
}

F4 load(const float* p) { return F4{p[0], p[1], p[2], p[3]}; }

/// Ray packet of four samples at times tau (s) from mid-exposure.
RayPacket moving_rays(const ExposureMotion& m, const V4& d, F4 tau) {
    const V4 turned{d.x + tau * (m.w_C.y() * d.z - m.w_C.z() * d.y), d.y + tau * (m.w_C.z() * d.x - m.w_C.x() * d.z),
                    d.z + tau * (m.w_C.x() * d.y - m.w_C.y() * d.x)};
    const Eigen::Matrix3f& r = m.R_W_C;
    RayPacket packet;
    packet.direction = {r(0, 0) * turned.x + r(0, 1) * turned.y + r(0, 2) * turned.z,
                        r(1, 0) * turned.x + r(1, 1) * turned.y + r(1, 2) * turned.z,
                        r(2, 0) * turned.x + r(2, 1) * turned.y + r(2, 2) * turned.z};
    packet.origin = {m.p_W.x() + tau * m.v_W.x(), m.p_W.y() + tau * m.v_W.y(), m.p_W.z() + tau * m.v_W.z()};
    packet.t = splat(RayPacket::kFar);
    packet.primitive = I4{-1, -1, -1, -1};
    return packet;
}

}  // namespace

Renderer::Renderer(const CameraModel& camera, const Se3& T_B_C, int samples, const Photometry& photometry)
    : camera_(camera),
      T_B_C_(T_B_C),
      photometry_(photometry),
      width_(camera.intrinsics().width),
      height_(camera.intrinsics().height),
      samples_(samples),
      tile_columns_((width_ + kTileWidth - 1) / kTileWidth),
      tile_rows_((height_ + kTileHeight - 1) / kTileHeight) {
    const std::vector<Eigen::Vector2d> offsets = sample_offsets(samples);
    const std::vector<float> times = sample_times(samples);
    for (int k = 0; k < kTilePixels; ++k) {
        times_.insert(times_.end(), times.begin(), times.end());
    }
    const int tile_samples = kTilePixels * samples_;
    rays_.reserve(static_cast<std::size_t>(3 * tile_samples) * static_cast<std::size_t>(tile_columns_ * tile_rows_));
    std::vector<float> tile(static_cast<std::size_t>(3 * tile_samples));
    for (int t = 0; t < tile_columns_ * tile_rows_; ++t) {
        for (int i = 0; i < tile_samples; ++i) {
            const int k = i / samples_;
            const int u = std::min(t % tile_columns_ * kTileWidth + k % kTileWidth, width_ - 1);
            const int v = std::min(t / tile_columns_ * kTileHeight + k / kTileWidth, height_ - 1);
            const Eigen::Vector2d& offset = offsets[static_cast<std::size_t>(i % samples_)];
            const Vector3d d = ray(u + offset.x(), v + offset.y());
            for (int axis = 0; axis < 3; ++axis) {
                tile[static_cast<std::size_t>(axis * tile_samples + i)] = static_cast<float>(d[axis]);
            }
        }
        rays_.insert(rays_.end(), tile.begin(), tile.end());
    }
    const Eigen::Vector2d centre(camera.intrinsics().cx, camera.intrinsics().cy);
    const double corner2 = std::max(centre.squaredNorm(), (Eigen::Vector2d(width_, height_) - centre).squaredNorm());
    for (int v = 0; v < height_; ++v) {
        for (int u = 0; u < width_; ++u) {
            const double r2 = (Eigen::Vector2d(u, v) - centre).squaredNorm() / corner2;
            vignette_.push_back(sees(u, v) ? static_cast<float>(1.0 - photometry_.vignette * r2) : 0.0F);
        }
    }
}

Vector3d Renderer::ray(double u, double v) const {
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();
    const Status status = camera_.unproject({u, v}, xy);
    return ok(status) ? Vector3d(xy.x(), xy.y(), 1.0).normalized() : Vector3d::UnitZ();
}

bool Renderer::sees(double u, double v) const { return camera_.in_lens({u, v}, kSampleReach_px); }

void Renderer::render_tile(const Scene& scene, const ExposureMotion& motion, int tile, float* radiance) const {
    const int count = kTilePixels * samples_;
    const float* x = rays_.data() + static_cast<std::size_t>(tile) * 3 * static_cast<std::size_t>(count);
    const float* y = x + count;
    const float* z = y + count;
    const float spread = 0.8F / static_cast<float>(camera_.focal_px());
    RayPacket packets[Bvh::kMaxBundle];
    for (int first = 0; first < count; first += kLanes * Bvh::kMaxBundle) {
        const int bundle = std::min(Bvh::kMaxBundle, (count - first) / kLanes);
        for (int p = 0; p < bundle; ++p) {
            const int i = first + p * kLanes;
            packets[p] = moving_rays(motion, {load(x + i), load(y + i), load(z + i)},
                                     motion.exposure_s * load(times_.data() + i));
        }
        scene.bvh().intersect_bundle({packets, static_cast<std::size_t>(bundle)});
        for (int p = 0; p < bundle; ++p) {
            scene.shade(packets[p], spread, radiance + first + p * kLanes);
        }
        if (motion.mover_pose.has_value()) {
            cover_bundle(motion, packets, first, bundle, radiance);
        }
    }
}

void Renderer::cover_bundle(const ExposureMotion& motion, const RayPacket* packets, int first, int bundle,
                            float* radiance) const {
    const float spread = 0.8F / static_cast<float>(camera_.focal_px());
    for (int p = 0; p < bundle; ++p) {
        const int i = first + p * kLanes;
        motion.mover->cover(*motion.mover_pose, motion.exposure_s * load(times_.data() + i), packets[p], spread,
                            radiance + i);
    }
}

std::uint8_t Renderer::expose(float radiance, double gain, int pixel, std::uint64_t noise_key) const {
    const float signal =
        static_cast<float>(gain * photometry_.gain) * vignette_[static_cast<std::size_t>(pixel)] * radiance;
    float grey = std::min(signal, 255.0F);
    if (photometry_.noise) {
        const double variance =
            photometry_.read_noise_dn * photometry_.read_noise_dn + photometry_.shot_noise_dn * grey;
        const std::uint64_t bits = mix64(noise_key + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(pixel + 1));
        grey += std::sqrt(static_cast<float>(variance)) * irwin_hall_normal(bits);
    }
    return static_cast<std::uint8_t>(std::clamp(grey + 0.5F, 0.0F, 255.0F));
}

void Renderer::render(const World& world, double t_s, double gain, std::uint64_t noise_key,
                      std::vector<std::uint8_t>& image) const {
    ExposureMotion motion = exposure_motion(world.flight, t_s, T_B_C_, photometry_.exposure_s);
    if (world.mover != nullptr) {
        motion.mover = world.mover;
        motion.mover_pose = world.mover->pose(t_s);
    }
    image.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    std::vector<float> radiance(static_cast<std::size_t>(kTilePixels * samples_));
    const float inverse = 1.0F / static_cast<float>(samples_);
    for (int tile = 0; tile < tile_columns_ * tile_rows_; ++tile) {
        render_tile(world.scene, motion, tile, radiance.data());
        for (int k = 0; k < kTilePixels; ++k) {
            const int u = tile % tile_columns_ * kTileWidth + k % kTileWidth;
            const int v = tile / tile_columns_ * kTileHeight + k / kTileWidth;
            if (u >= width_ || v >= height_) {
                continue;
            }
            float sum = 0.0F;
            for (int i = 0; i < samples_; ++i) {
                sum += radiance[static_cast<std::size_t>(k * samples_ + i)];
            }
            const int pixel = v * width_ + u;
            image[static_cast<std::size_t>(pixel)] = expose(sum * inverse, gain, pixel, noise_key);
        }
    }
}

CoarsePass coarse_pass(const Scene& scene, const Flight& flight, const Renderer& camera,
                       const std::vector<double>& times_s, int threads) {
    constexpr int kSpacing_px = 16;
    constexpr double kTarget_grey = 95.0;
    constexpr double kFollow = 0.12;  // of the way in log gain, each frame
    std::vector<Vector3d> rays;
    for (int v = kSpacing_px / 2; v < camera.height(); v += kSpacing_px) {
        for (int u = kSpacing_px / 2; u < camera.width(); u += kSpacing_px) {
            if (camera.sees(u, v)) {
                rays.push_back(camera.ray(u, v));
            }
        }
    }
    rays.resize((rays.size() + kLanes - 1) / kLanes * kLanes, rays.back());
    CoarsePass pass;
    pass.hits.resize(rays.size() * times_s.size());
    std::vector<double> means(times_s.size());
    parallel_for(static_cast<int>(times_s.size()), threads, [&](int frame) {
        const ExposureMotion motion =
            exposure_motion(flight, times_s[static_cast<std::size_t>(frame)], camera.T_B_C(), 0.0);
        double sum = 0.0;
        for (std::size_t i = 0; i < rays.size(); i += kLanes) {
            V4 d{};
            for (int k = 0; k < kLanes; ++k) {
                const Eigen::Vector3f r = rays[i + static_cast<std::size_t>(k)].cast<float>();
                d.x[k] = r.x();
                d.y[k] = r.y();
                d.z[k] = r.z();
            }
            RayPacket packet = moving_rays(motion, d, splat(0.0F));
            scene.bvh().intersect(packet);
            float radiance[kLanes];
            scene.shade(packet, static_cast<float>(kSpacing_px / camera.focal_px()), radiance);
            for (int k = 0; k < kLanes; ++k) {
                sum += std::min(radiance[k], 1.5F);
                CoarseHit& hit =
                    pass.hits[static_cast<std::size_t>(frame) * rays.size() + i + static_cast<std::size_t>(k)];
                hit.surface = -1;
                if (packet.primitive[k] >= 0) {
                    const Primitive& primitive =
                        scene.bvh().primitives()[static_cast<std::size_t>(packet.primitive[k])];
                    const V4 p = packet.origin + packet.t * packet.direction;
                    const float point[3] = {p.x[k], p.y[k], p.z[k]};
                    const float direction[3] = {packet.direction.x[k], packet.direction.y[k], packet.direction.z[k]};
                    const SurfaceHit at = locate(primitive, point, direction);
                    hit = {static_cast<int>(primitive.surface), at.u, at.v};
                }
            }
        }
        means[static_cast<std::size_t>(frame)] = std::max(sum / static_cast<double>(rays.size()), 0.02);
    });
    double gain = means.empty() ? 0.0 : kTarget_grey / means.front();
    for (const double mean : means) {
        gain *= std::pow(kTarget_grey / mean / gain, kFollow);
        pass.gains.push_back(gain);
    }
    return pass;
}

}  // namespace facet::sim
