// SPDX-License-Identifier: BSD-2-Clause
// Decodes inertial frames as a CAN database and a signal map say.
#pragma once

#include <array>
#include <string>

#include "drivers/imu_can/can_decoder.h"
#include "drivers/imu_can/dbc_file.h"

namespace facet {

/// One signal by name; an empty message means there is none.
struct CanSignalName {
    std::string message;
    std::string signal;
};

/// Which signals are what. The three axes of a quantity are in one message; the two quantities may be in two.
struct CanSignalMap {
    std::array<CanSignalName, 3> rate;   ///< x, y, z
    std::array<CanSignalName, 3> force;  ///< x, y, z
    CanSignalName temperature;           ///< optional; only looked at in the message of the rate or the force
    CanSignalName counter;               ///< optional; in the message of the rate: raised by one with every frame
    /// Match the parameter group of 29-bit identifiers only: priority and source address of J1939 are left out.
    bool j1939 = false;
    int source_address = -1;  ///< with j1939: only from this node; -1 for any
};

/// Factor to SI from a unit as DBC files spell it: "rad/s", "deg/s", "dps", "mdps", "m/s^2", "m/s2", "g", "mg", "" (1).
/// @return kInvalidArgument for anything else
Result<double> si_factor(std::string_view unit);

/// Thread-bound. Heap in configure.
class DbcDecoder final : public CanDecoder {
public:
    /// Binds the map to the database.
    /// @return kInvalidArgument with `error` naming the message, signal or unit that does not fit.
    Status configure(const DbcFile& database, const CanSignalMap& map, std::string& error);

    Status decode(const CanFrame& frame, CanMeasurement& measurement) override;
    std::vector<CanFilter> filters() const override;
    void reset() override { counter_known_ = false; }

private:
    struct Quantity {
        DbcMessage message;
        std::array<DbcSignal, 3> axes;
        std::array<double, 3> factors{};
    };
    Status bind(const DbcFile& database, const std::array<CanSignalName, 3>& names, const char* what,
                Quantity& quantity, std::string& error);
    bool matches(const DbcMessage& message, const CanFrame& frame) const;
    std::uint32_t mask(const DbcMessage& message) const;
    Status read(const Quantity& quantity, const CanFrame& frame, std::optional<Eigen::Vector3d>& value) const;
    void count(const CanFrame& frame, CanMeasurement& measurement);

    CanSignalMap map_;
    Quantity rate_;
    Quantity force_;
    std::optional<DbcSignal> temperature_in_rate_;
    std::optional<DbcSignal> temperature_in_force_;
    std::optional<DbcSignal> counter_;
    std::uint64_t counter_value_ = 0;
    bool counter_known_ = false;
};

}  // namespace facet
