// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dbc_decoder.h"

#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr double kStandardGravity = 9.80665;  // m/s^2
// A 29-bit identifier of J1939: 3 bits priority, 18 bits parameter group number, 8 bits source address. Groups whose
// format byte is below 240 carry a destination address in their lowest byte.
constexpr std::uint32_t kPgnMask = 0x03FFFF00U;
constexpr std::uint32_t kPgnMaskAddressed = 0x03FF0000U;
constexpr std::uint32_t kFirstBroadcastFormat = 240;

std::optional<DbcSignal> find_optional(const DbcMessage& message, const CanSignalName& name) {
    const DbcSignal* const signal = message.name == name.message ? message.find(name.signal) : nullptr;
    return signal == nullptr ? std::nullopt : std::optional<DbcSignal>(*signal);
}

}  // namespace

Result<double> si_factor(std::string_view unit) {
    struct Unit {
        std::string_view name;
        double factor;
    };
    static constexpr Unit kUnits[] = {
        {"", 1.0},
        {"rad/s", 1.0},
        {"m/s^2", 1.0},
        {"m/s2", 1.0},
        {"m/s**2", 1.0},
        {"deg/s", kRadPerDeg},
        {"dps", kRadPerDeg},
        {"mdps", 1e-3 * kRadPerDeg},
        {"mrad/s", 1e-3},
        {"g", kStandardGravity},
        {"mg", 1e-3 * kStandardGravity},
    };
    for (const Unit& known : kUnits) {
        if (known.name == unit) {
            return known.factor;
        }
    }
    return Status::kInvalidArgument;
}

Status DbcDecoder::bind(const DbcFile& database, const std::array<CanSignalName, 3>& names, const char* what,
                        Quantity& quantity, std::string& error) {
    const DbcMessage* const message = database.find(names[0].message);
    if (message == nullptr) {
        error = std::string(what) + ": there is no message '" + names[0].message + "' in the database";
        return Status::kInvalidArgument;
    }
    if (map_.j1939 && !message->extended) {
        error = std::string(what) + ": message '" + message->name + "' has no 29-bit identifier, which J1939 requires";
        return Status::kInvalidArgument;
    }
    quantity.message = *message;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const DbcSignal* const signal = message->find(names[axis].signal);
        if (names[axis].message != message->name || signal == nullptr) {
            error = std::string(what) + ": there is no signal '" + names[axis].signal + "' in message '" +
                    message->name + "'";
            return Status::kInvalidArgument;
        }
        const Result<double> factor = si_factor(signal->unit);
        if (!factor.ok()) {
            error = std::string(what) + ": unit '" + signal->unit + "' of signal '" + signal->name + "' is unknown";
            return factor.status();
        }
        quantity.axes[axis] = *signal;
        quantity.factors[axis] = factor.value();
    }
    return Status::kOk;
}

Status DbcDecoder::configure(const DbcFile& database, const CanSignalMap& map, std::string& error) {
    map_ = map;
    FACET_TRY(bind(database, map.rate, "angular rate", rate_, error));
    FACET_TRY(bind(database, map.force, "specific force", force_, error));
    temperature_in_rate_ = find_optional(rate_.message, map.temperature);
    temperature_in_force_ = find_optional(force_.message, map.temperature);
    if (!map.temperature.message.empty() && !temperature_in_rate_ && !temperature_in_force_) {
        error = "temperature: no signal '" + map.temperature.signal + "' in the messages of rate and force";
        return Status::kInvalidArgument;
    }
    counter_ = find_optional(rate_.message, map.counter);
    if (!map.counter.message.empty() && !counter_) {
        error = "counter: no signal '" + map.counter.signal + "' in the message of the angular rate";
        return Status::kInvalidArgument;
    }
    reset();
    return Status::kOk;
}

std::uint32_t DbcDecoder::mask(const DbcMessage& message) const {
    if (!map_.j1939) {
        return message.extended ? 0x1FFFFFFFU : 0x7FFU;
    }
    const bool broadcast = ((message.id >> 16) & 0xFFU) >= kFirstBroadcastFormat;
    return (broadcast ? kPgnMask : kPgnMaskAddressed) | (map_.source_address >= 0 ? 0xFFU : 0U);
}

bool DbcDecoder::matches(const DbcMessage& message, const CanFrame& frame) const {
    std::uint32_t id = message.id;
    if (map_.j1939 && map_.source_address >= 0) {
        id = (id & ~0xFFU) | static_cast<std::uint32_t>(map_.source_address);
    }
    return frame.extended == message.extended && ((frame.id ^ id) & mask(message)) == 0;
}

std::vector<CanFilter> DbcDecoder::filters() const {
    std::vector<CanFilter> result;
    for (const DbcMessage* message : {&rate_.message, &force_.message}) {
        std::uint32_t id = message->id;
        if (map_.j1939 && map_.source_address >= 0) {
            id = (id & ~0xFFU) | static_cast<std::uint32_t>(map_.source_address);
        }
        result.push_back({id, mask(*message), message->extended});
    }
    if (rate_.message.id == force_.message.id && rate_.message.extended == force_.message.extended) {
        result.pop_back();
    }
    return result;
}

Status DbcDecoder::read(const Quantity& quantity, const CanFrame& frame, std::optional<Eigen::Vector3d>& value) const {
    Eigen::Vector3d v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Result<double> number = quantity.message.value(quantity.axes[axis], frame.data());
        if (!number.ok()) {
            return number.status();
        }
        v[static_cast<Eigen::Index>(axis)] = number.value() * quantity.factors[axis];
    }
    value = v;
    return Status::kOk;
}

void DbcDecoder::count(const CanFrame& frame, CanMeasurement& measurement) {
    if (!counter_ || counter_->bytes_needed() > static_cast<int>(frame.data().size())) {
        return;
    }
    const std::uint64_t value = counter_->raw(frame.data());
    const std::uint64_t wrap = counter_->length == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << counter_->length) - 1;
    if (counter_known_) {
        measurement.lost = static_cast<std::uint32_t>((value - counter_value_ - 1) & wrap);
    }
    counter_value_ = value;
    counter_known_ = true;
}

Status DbcDecoder::decode(const CanFrame& frame, CanMeasurement& measurement) {
    const bool is_rate = matches(rate_.message, frame);
    const bool is_force = matches(force_.message, frame);
    if (frame.error || (!is_rate && !is_force)) {
        return Status::kNotFound;
    }
    CanMeasurement result;
    // A multiplexed message may hold only one of the two, or neither: then there is nothing to decode.
    Status status = Status::kNotFound;
    if (is_rate) {
        status = read(rate_, frame, result.rate);
    }
    if (is_force && status != Status::kCorrupt) {
        const Status forces = read(force_, frame, result.force);
        status = forces == Status::kNotFound ? status : forces;
    }
    FACET_TRY(status);
    if (result.rate) {
        count(frame, result);
    }
    if (is_rate && temperature_in_rate_) {
        result.temperature_c = rate_.message.value(*temperature_in_rate_, frame.data()).value_or(result.temperature_c);
    } else if (is_force && temperature_in_force_) {
        result.temperature_c =
            force_.message.value(*temperature_in_force_, frame.data()).value_or(result.temperature_c);
    }
    measurement = result;
    return Status::kOk;
}

}  // namespace facet
