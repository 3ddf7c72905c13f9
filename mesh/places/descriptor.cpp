// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/descriptor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/places/bilinear.h"
#include "mesh/places/random_sequence.h"

namespace facet {
namespace {

constexpr int kSide = 32;               ///< samples of a patch along each side
constexpr double kSmallest_px = 8.0;    ///< half the side of a fine patch: at least, and less than twice as much
constexpr double kUnit_m = 1.0 / 16.0;  ///< half the side of a patch of octave 0
constexpr double kMinSine = 0.26;       ///< of the angle between ray and gravity: 15 degrees
constexpr int kMargin = 3;              ///< samples along a patch's edge that are never compared

/// Patch coordinates of the two points of a comparison.
struct Pair {
    std::uint16_t first = 0;
    std::uint16_t second = 0;
};

/// Sum of three uniform values, nearly normal with a sigma of a fifth of the side, within the margin.
constexpr int random_coordinate(RandomSequence& random) {
    int sum = 0;
    for (int i = 0; i < 3; ++i) {
        sum += static_cast<int>(random.index(13));
    }
    return std::clamp(sum - 18 + kSide / 2, kMargin, kSide - 1 - kMargin);
}

constexpr std::array<Pair, 256> make_pattern() {
    std::array<Pair, 256> pattern{};
    RandomSequence random(1);
    for (Pair& pair : pattern) {
        do {
            const auto point = [&random] {
                const int u = random_coordinate(random);
                return static_cast<std::uint16_t>(random_coordinate(random) * kSide + u);
            };
            pair = {point(), point()};
        } while (pair.first == pair.second);
    }
    return pattern;
}

constexpr std::array<Pair, 256> kPattern = make_pattern();

using Patch = std::array<std::uint16_t, static_cast<std::size_t>(kSide) * kSide>;

/// Bilinear, in sixteenths of a grey value.
void sample(const SquareSampler& at, Patch& patch) {
    const Eigen::Vector2f corner = at.centre - 0.5F * (kSide - 1) * (at.down + at.right);
    for (int j = 0; j < kSide; ++j) {
        Eigen::Vector2f p = corner + static_cast<float>(j) * at.down;
        for (int i = 0; i < kSide; ++i, p += at.right) {
            const int u = static_cast<int>(p.x());
            const int v = static_cast<int>(p.y());
            const int a = static_cast<int>((p.x() - static_cast<float>(u)) * 16.0F);
            const int b = static_cast<int>((p.y() - static_cast<float>(v)) * 16.0F);
            const std::uint8_t* const upper = at.image->row(v) + u;
            const std::uint8_t* const lower = upper + at.image->stride;
            const int sum = (16 - b) * ((16 - a) * upper[0] + a * upper[1]) + b * ((16 - a) * lower[0] + a * lower[1]);
            patch[static_cast<std::size_t>(j * kSide + i)] = static_cast<std::uint16_t>(sum >> 4);
        }
    }
}

/// Sums of five neighbours along both axes, but for the two samples at each edge: 25 * 255 * 16 needs 17 bits, so a
/// quarter is kept.
void smooth(Patch& patch) {
    Patch rows{};
    for (int j = 0; j < kSide; ++j) {
        for (int i = 2; i < kSide - 2; ++i) {
            const std::uint16_t* const s = &patch[static_cast<std::size_t>(j * kSide + i)];
            rows[static_cast<std::size_t>(j * kSide + i)] =
                static_cast<std::uint16_t>((s[-2] + s[-1] + s[0] + s[1] + s[2]) >> 2);
        }
    }
    for (int j = 2; j < kSide - 2; ++j) {
        for (int i = 2; i < kSide - 2; ++i) {
            const std::uint16_t* const s = &rows[static_cast<std::size_t>(j * kSide + i)];
            patch[static_cast<std::size_t>(j * kSide + i)] =
                static_cast<std::uint16_t>(s[-2 * kSide] + s[-kSide] + s[0] + s[kSide] + s[2 * kSide]);
        }
    }
}

BinaryCode code_of(const Patch& patch) {
    BinaryCode code{};
    for (std::size_t i = 0; i < kPattern.size(); ++i) {
        const bool is_darker = patch[kPattern[i].first] < patch[kPattern[i].second];
        code[i / 64] |= static_cast<std::uint64_t>(is_darker) << (i % 64);
    }
    return code;
}

bool make_code(const ImagePyramid& pyramid, const UprightSquare& square, double half_px, BinaryCode& code) {
    const SquareSampler sampler(pyramid, square, 2.0 * half_px / kSide);
    if (!sampler.covers(kSide)) {
        return false;
    }
    Patch patch;
    sample(sampler, patch);
    smooth(patch);
    code = code_of(patch);
    return true;
}

void cut(const SquareSampler& at, UprightPatch& patch) {
    const Eigen::Vector2f corner = at.centre - 0.5F * (kPatchSide - 1) * (at.down + at.right);
    for (int j = 0; j < kPatchSide; ++j) {
        for (int i = 0; i < kPatchSide; ++i) {
            const Eigen::Vector2f p = corner + static_cast<float>(j) * at.down + static_cast<float>(i) * at.right;
            patch[static_cast<std::size_t>(j * kPatchSide + i)] =
                static_cast<std::uint8_t>(std::lround(bilinear(*at.image, p)));
        }
    }
}

}  // namespace

int UprightSquare::fine_octave() const { return static_cast<int>(std::ceil(std::log2(kSmallest_px / unit_px))); }

SquareSampler::SquareSampler(const ImagePyramid& pyramid, const UprightSquare& square, double step_px) {
    int level = 0;
    double scale = 1.0;
    while (scale * step_px > std::numbers::sqrt2 && level + 1 < kPlaceLevels) {
        ++level;
        scale *= 0.5;
    }
    image = &pyramid.level(level);
    centre = (scale * square.centre).cast<float>();
    down = (scale * step_px * square.down).cast<float>();
    right = Eigen::Vector2f(down.y(), -down.x());
}

bool SquareSampler::covers(int side, const Eigen::Vector2f& shift) const {
    const Eigen::Vector2f middle = centre + shift.x() * right + shift.y() * down;
    const float reach = 0.5F * static_cast<float>(side - 1);
    const float half = reach * (std::abs(right.x()) + std::abs(down.x()));
    const float high = reach * (std::abs(right.y()) + std::abs(down.y()));
    return middle.x() - half >= 0.0F && middle.y() - high >= 0.0F &&
           middle.x() + half < static_cast<float>(image->width - 1) &&
           middle.y() + high < static_cast<float>(image->height - 1);
}

Status upright_square(const CameraModel& camera, const Eigen::Vector3d& p_C, const Eigen::Vector3d& down_C,
                      UprightSquare& square) {
    UprightSquare made;
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    FACET_TRY(camera.project(p_C, made.centre, &d_uv_d_p));
    const double distance = p_C.norm();
    const Eigen::Vector2d down = d_uv_d_p * down_C;
    if (p_C.cross(down_C).norm() < kMinSine * distance || !(down.squaredNorm() > 0.0)) {
        return Status::kDegenerate;
    }
    made.down = down.normalized();
    made.unit_px = camera.focal_px() * kUnit_m / distance;
    square = made;
    return Status::kOk;
}

Status describe(const ImagePyramid& pyramid, const UprightSquare& square, PointCode& code, UprightPatch& patch) {
    const int octave = square.fine_octave();
    if (octave < PointCode::kMinOctave || octave > PointCode::kMaxOctave) {
        return Status::kDegenerate;
    }
    PointCode made;
    made.octave = static_cast<std::int8_t>(octave);
    const double half_px = square.half_px(octave);
    if (!make_code(pyramid, square, 2.0 * half_px, made.coarse) || !make_code(pyramid, square, half_px, made.fine)) {
        return Status::kNotFound;
    }
    cut(SquareSampler(pyramid, square, 2.0 * half_px / kPatchSide), patch);  // inside what the codes have covered
    code = made;
    return Status::kOk;
}

}  // namespace facet
