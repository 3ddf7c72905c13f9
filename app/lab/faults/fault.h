// SPDX-License-Identifier: BSD-2-Clause
// One fault to be put between a log and the estimator, and the text that asks for it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/timestamp.h"

namespace facet {

/// Their numbers seed random ones: a new kind goes to the end, so that the noise of the others stays as it is.
enum class FaultKind : std::uint8_t {
    kBlackout,
    kFlash,
    kFreeze,
    kNoLeft,
    kNoRight,
    kDropFrames,
    kTimeOffset,
    kClockJump,
    kImuGap,
    kImuClip,
    kImuNoise,
    kImuDuplicate,
    kImuBias,
    kImuScale,
    kVibration,
    kCalibration,
    kDark,
    kExposure,
    kImageNoise,
    kSmear,
    kWall,
    kMover,
    kSwap,
    kPairOff,
    kFrameThin,
    kFrameDuplicate,
    kFrameOrder,
    kFrameJump,
    kImuThin,
    kImuOrder,
    kImuJump,
    kImuFreeze,
    kImuZero,
    kImuNan,
    kImuAxes,
    kCount
};

/// A fault while t, counted from the first instant of the replay, is in [begin, begin + length).
struct Fault {
    static constexpr std::size_t kMaxValues = 4;

    FaultKind kind = FaultKind::kBlackout;
    std::array<double, kMaxValues> values{};  ///< as FaultInfo says; defaults are filled in
    Duration begin;
    Duration length;
    std::string spec;  ///< as the user wrote it

    bool is_active(Duration t) const { return t >= begin && t - begin < length; }
    /// The same, but a fault without a start was there before the first instant too.
    bool is_active_or_before(Duration t) const { return is_active(t) || (begin.ns == 0 && t < begin); }
};

/// Which camera a fault is of, as the value CAMERA.
enum class FaultCamera : std::uint8_t { kBoth, kLeft, kRight };
/// Which sensor of the IMU, as the value PART.
enum class FaultPart : std::uint8_t { kBoth, kGyro, kAccel };
/// What shows a vibration, as the value SHOWN.
enum class VibrationShown : std::uint8_t {
    kSamples,  ///< inertial samples alone
    kImages,   ///< images as well: the body turns to and fro
};
/// How the IMU's axes are wrong, as the value KIND of kImuAxes.
enum class AxesError : std::uint8_t {
    kCycle,   ///< x y z carry what belongs to y z x
    kTurn,    ///< turned by 180 degrees about z: x and y negative
    kMirror,  ///< y negative: axes of the left hand
};

/// A number a fault takes.
struct FaultValue {
    const char* name;  ///< in capitals, as in help
    double min;
    double max;
    double fallback;                        ///< if not given; NaN if it must be given
    std::vector<std::string_view> words{};  ///< if any: given as one of these, the value is its index
};

/// One row of the table of all faults.
struct FaultInfo {
    FaultKind kind;
    const char* name;
    std::vector<FaultValue> values;
    const char* meaning;
    bool is_constant = false;  ///< holds for the whole run: takes no START
};
const std::vector<FaultInfo>& fault_table();

/// One word about a fault's value that is one.
template <class Word>
Word word_of(const Fault& fault, std::size_t value) {
    return static_cast<Word>(static_cast<int>(fault.values.at(value)));
}

/// Whether stamps are no longer the log's, so that a truth of the log does not fit them.
constexpr bool shifts_stamps(const Fault& fault) {
    return fault.kind == FaultKind::kTimeOffset || fault.kind == FaultKind::kClockJump ||
           fault.kind == FaultKind::kFrameJump || fault.kind == FaultKind::kImuJump;
}

/// Whether the fault is one of samples, for FaultInjector; otherwise it is one of the calibration.
constexpr bool is_of_samples(const Fault& fault) { return fault.kind != FaultKind::kCalibration; }

/// Reads NAME[=VALUE[,VALUE]][@START[+LENGTH]]: START and LENGTH in seconds; without LENGTH to the end, without START
/// from the beginning. Throws InputError that names the token.
Fault parse_fault(std::string_view spec);

/// The grammar and all faults, a line each, for --help.
std::string fault_help();

}  // namespace facet
