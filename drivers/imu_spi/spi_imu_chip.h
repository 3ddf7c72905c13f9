// SPDX-License-Identifier: BSD-2-Clause
// What the supported inertial chips have in common.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "platform/base/angle.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/status.h"
#include "platform/port/trigger_source.h"

namespace facet {

inline constexpr double kStandardGravity = 9.80665;  ///< m/s^2, of the data sheets' "g"

/// One reading of a chip, in the chip's axes, SI units.
struct SpiMeasurement {
    Timestamp stamp;
    std::optional<Eigen::Vector3d> rate;   ///< (rad/s)
    std::optional<Eigen::Vector3d> force;  ///< (m/s^2)
    double temperature_c = std::numeric_limits<double>::quiet_NaN();
    std::uint32_t lost = 0;  ///< measurements missing before this one
};

/// Room for a whole 2 KB FIFO of 20-byte packets.
using SpiMeasurements = FixedVector<SpiMeasurement, 104>;

/// A self-test pushes the chip's masses and judges their answer: it takes up to a second and needs a vehicle at rest.
enum class SelfTest : bool { kSkip, kRun };

/// One kind of chip. Thread-bound. Heap in configure, for the words of a problem.
class SpiImuChip {
public:
    virtual ~SpiImuChip() = default;

    /// Opens, resets, identifies, tests (unless skipped here or by the chip's options) and sets up the chip; takes a
    /// few hundred milliseconds.
    /// @param problem  set on failure
    /// @return kNotFound if there is no such bus or another chip answers, kIo if the bus or the self-test fails
    virtual Status configure(SelfTest test, std::string& problem) = 0;
    virtual void close() = 0;

    /// Reads what is there after a data-ready edge; appends to `out` in order of time.
    /// @return kNotReady if there is nothing new, kCorrupt if the data cannot be trusted (`out` may still have gained
    ///         good
    ///         measurements), kIo if the bus fails
    virtual Status read(const TriggerEdge& edge, SpiMeasurements& out) = 0;

    /// Whether only the newest of several waiting edges is of use, because the chip keeps one measurement.
    virtual bool newest_edge_only() const = 0;
    virtual std::string_view problem() const = 0;
};

}  // namespace facet
