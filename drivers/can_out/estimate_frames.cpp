// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/can_out/estimate_frames.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

/// The signals' names in the database, without "Position" and so on spelt out.
enum Quantity : std::uint8_t {
    kCount,
    kState,
    kQuality,
    kResets,
    kStamp,
    kAge,
    kPosition,
    kAttitude = kPosition + 3,  // w x y z
    kVelocity = kAttitude + 4,
    kRate = kVelocity + 3,
    kPositionSigma = kRate + 3,
    kAttitudeSigma = kPositionSigma + 3,
    kVelocitySigma = kAttitudeSigma + 3,
    kReasons = kVelocitySigma + 3,
    kAlive,
    kQuantities
};

using Values = std::array<double, kQuantities>;

/// Where signals lie in a frame: little-endian, DBC's numbers of bits. Several of one kind follow each other.
struct Field {
    std::uint8_t first;  ///< Quantity
    std::uint8_t count;
    std::uint16_t start_bit;
    std::uint8_t bits;  ///< of each
    bool is_signed;
    double scale;
};

struct Layout {
    std::uint32_t id;  ///< behind the first one
    std::uint8_t length;
    std::array<Field, 13> fields;
};

constexpr double kMicro = 1e-6;

constexpr Layout kHealthLayout{0,
                               8,
                               {{{kState, 1, 0, 4, false, 1.0},
                                 {kAlive, 1, 4, 4, false, 1.0},
                                 {kQuality, 1, 8, 8, true, 1.0},
                                 {kResets, 1, 16, 8, false, 1.0},
                                 {kReasons, 1, 24, 32, false, 1.0},
                                 {kAge, 1, 56, 8, false, 0.01}}}};

constexpr Layout kFdLayout{1,
                           64,
                           {{{kCount, 1, 0, 8, false, 1.0},
                             {kState, 1, 8, 4, false, 1.0},
                             {kQuality, 1, 16, 8, true, 1.0},
                             {kResets, 1, 24, 8, false, 1.0},
                             {kStamp, 1, 32, 48, false, kMicro},
                             {kPosition, 3, 80, 32, true, 1e-4},
                             {kAttitude, 4, 176, 16, true, 4e-5},
                             {kVelocity, 3, 240, 24, true, 1e-4},
                             {kRate, 3, 312, 16, true, 2e-3},
                             {kPositionSigma, 3, 360, 16, false, 2e-4},
                             {kAttitudeSigma, 3, 408, 16, false, 1e-4},
                             {kVelocitySigma, 3, 456, 16, false, 2e-4},
                             {kAge, 1, 504, 8, false, 1e-3}}}};

constexpr Field kCountField{kCount, 1, 0, 8, false, 1.0};

constexpr std::array<Layout, kClassicFrames> kClassicLayouts{{
    {2, 8, {{kCountField, {kStamp, 1, 8, 48, false, kMicro}, {kAge, 1, 56, 8, false, 1e-3}}}},
    {3, 8, {{kCountField, {kPosition, 2, 8, 28, true, 1e-4}}}},
    {4,
     7,
     {{kCountField,
       {kPosition + 2, 1, 8, 28, true, 1e-4},
       {kState, 1, 36, 4, false, 1.0},
       {kResets, 1, 40, 8, false, 1.0},
       {kQuality, 1, 48, 8, true, 1.0}}}},
    {5, 8, {{kCountField, {kAttitude, 4, 8, 14, true, 1.25e-4}}}},
    {6, 8, {{kCountField, {kVelocity, 3, 8, 18, true, 5e-4}}}},
    {7, 8, {{kCountField, {kRate, 3, 8, 18, true, 5e-4}}}},
    {8, 7, {{kCountField, {kPositionSigma, 3, 8, 16, false, 2e-4}}}},
    {9, 7, {{kCountField, {kAttitudeSigma, 3, 8, 16, false, 1e-4}}}},
    {10, 7, {{kCountField, {kVelocitySigma, 3, 8, 16, false, 2e-4}}}},
}};

/// @param value  finite
void put(CanFrame& frame, unsigned start_bit, const Field& field, double value) {
    const double highest = std::ldexp(1.0, field.bits - (field.is_signed ? 1 : 0)) - 1.0;
    const bool is_sigma =
        field.first >= kPositionSigma && field.first < kReasons;  // never zero: somebody divides by it
    const double lowest = field.is_signed ? -highest - 1.0 : (is_sigma ? 1.0 : 0.0);
    const auto raw = static_cast<std::uint64_t>(std::llround(std::clamp(value / field.scale, lowest, highest)));
    for (unsigned i = 0; i < field.bits; ++i) {
        const unsigned bit = start_bit + i;
        frame.bytes[bit / 8] |= static_cast<std::uint8_t>(((raw >> i) & 1U) << (bit % 8));
    }
}

CanFrame encode(const Layout& layout, const Values& values, const CanFrameInfo& info) {
    CanFrame frame;
    frame.id = info.first_id + layout.id;
    frame.length = layout.length;
    frame.fd = layout.length > 8;
    frame.bit_rate_switch = frame.fd && info.bit_rate_switch;
    for (const Field& field : layout.fields) {
        for (unsigned i = 0; i < field.count; ++i) {
            put(frame, field.start_bit + i * field.bits, field, values[field.first + i]);
        }
    }
    return frame;
}

/// @return kInvalidArgument if a number is not finite or a variance not positive
Status collect(const Odometry& odometry, const CanFrameInfo& info, Values& values) {
    const Eigen::Matrix<double, 6, 1> pose_variance = odometry.pose_covariance.diagonal();
    const Eigen::Vector3d v_variance = odometry.v_covariance.diagonal();
    const Eigen::Quaterniond& q = odometry.q_W_B;
    const bool is_good = odometry.p_W_B.allFinite() && q.coeffs().allFinite() && odometry.v_W_B.allFinite() &&
                         odometry.w_B.allFinite() && pose_variance.allFinite() && v_variance.allFinite() &&
                         pose_variance.minCoeff() > 0.0 && v_variance.minCoeff() > 0.0;
    if (!is_good) {
        return Status::kInvalidArgument;
    }
    values[kCount] = info.count;
    values[kState] = static_cast<double>(odometry.state);
    values[kQuality] = odometry.quality;
    values[kResets] = odometry.reset_counter;
    const std::int64_t stamp_us = odometry.stamp.ns / 1000;
    values[kStamp] = static_cast<double>(stamp_us) * kMicro;
    values[kAge] = info.age.seconds();
    const double sign = q.w() < 0.0 ? -1.0 : 1.0;
    values[kAttitude] = sign * q.w();
    for (int i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        values[kPosition + k] = odometry.p_W_B[i];
        values[kAttitude + 1 + k] = sign * q.vec()[i];
        values[kVelocity + k] = odometry.v_W_B[i];
        values[kRate + k] = odometry.w_B[i];
        values[kPositionSigma + k] = std::sqrt(pose_variance[i]);
        values[kAttitudeSigma + k] = std::sqrt(pose_variance[3 + i]);
        values[kVelocitySigma + k] = std::sqrt(v_variance[i]);
    }
    return Status::kOk;
}

}  // namespace

Status encode_classic(const Odometry& odometry, const CanFrameInfo& info,
                      std::array<CanFrame, kClassicFrames>& frames) {
    Values values{};
    FACET_TRY(collect(odometry, info, values));
    for (std::size_t i = 0; i < kClassicFrames; ++i) {
        frames[i] = encode(kClassicLayouts[i], values, info);
    }
    return Status::kOk;
}

Status encode_fd(const Odometry& odometry, const CanFrameInfo& info, CanFrame& frame) {
    Values values{};
    FACET_TRY(collect(odometry, info, values));
    frame = encode(kFdLayout, values, info);
    return Status::kOk;
}

CanFrame encode_health(const CanHealth& health, std::uint32_t first_id) {
    Values values{};
    values[kState] = static_cast<double>(health.state);
    values[kQuality] = health.quality;
    values[kResets] = health.resets;
    values[kReasons] = health.reasons;
    values[kAlive] = health.alive & 0x0FU;
    values[kAge] = health.age.seconds();
    return encode(kHealthLayout, values, {.first_id = first_id, .count = 0, .age = {}, .bit_rate_switch = false});
}

}  // namespace facet
