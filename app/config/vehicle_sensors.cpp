// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_sensors.h"

#include <fmt/core.h>

#include <array>
#include <fstream>
#include <optional>
#include <sstream>

#include "app/config/read_duration.h"
#include "app/config/vehicle_iio.h"
#include "app/config/vehicle_mavlink.h"
#include "app/config/vehicle_ros2.h"
#include "app/config/vehicle_serial.h"
#include "app/support/input_error.h"
#include "app/support/yaml_section.h"
#include "drivers/imu_can/openimu300.h"

namespace facet {
namespace {

using Choices = std::span<const std::string_view>;

/// gpiochip and line, by number or name, and how its edges are taken.
GpioLineName read_line_name(YamlSection& section) {
    GpioLineName name;
    section.read("chip", name.chip);
    const YamlNode line = section.at("line");
    int offset = 0;
    if (line.raw().IsScalar() && YAML::convert<int>::decode(line.raw(), offset)) {
        if (offset < 0) {
            line.fail("must not be negative");
        }
        name.offset = offset;
    } else {
        name.name = line.text();
    }
    constexpr std::array<std::string_view, 3> kBackends{"auto", "libgpiod", "chardev"};
    name.backend = static_cast<GpioBackend>(section.choice("backend", kBackends, 0));
    return name;
}

TriggerGpioOptions read_line(YamlSection& section) {
    TriggerGpioOptions options;
    options.line = read_line_name(section);
    constexpr std::array<std::string_view, 2> kEdges{"rising", "falling"};
    const bool falling = section.choice("edge", kEdges, 0) == 1;
    options.input.rising = !falling;
    options.input.falling = falling;
    section.read("pull_up", options.input.pull_up);
    constexpr std::array<std::string_view, 3> kClocks{"monotonic", "realtime", "hardware"};
    constexpr std::array kDomains{ClockDomain::kMonotonic, ClockDomain::kRealtime, ClockDomain::kHardware};
    options.input.clock = kDomains[section.choice("clock", kClocks, 0)];
    int debounce_us = 0;
    section.read("debounce_us", debounce_us, 0, 100'000);
    options.input.debounce_us = static_cast<std::uint32_t>(debounce_us);
    return options;
}

void read_rate(YamlSection& section, std::uint16_t& rate_hz, std::initializer_list<int> rates) {
    int value = rate_hz;
    section.read_one_of("rate_hz", value, rates);
    rate_hz = static_cast<std::uint16_t>(value);
}

void read_chip(YamlSection& section, VehicleImuSpi& imu) {
    constexpr std::array<std::string_view, 7> kChips{"adis16448",   "adis16470", "adis16475-1", "adis16475-2",
                                                     "adis16475-3", "icm42688",  "bmi088"};
    (void)section.at("chip");
    const std::size_t chip = section.choice("chip", kChips, 0);
    imu.source.name = std::string(kChips[chip]);
    bool self_test = true;
    section.read("self_test", self_test);
    imu.adis16.self_test = imu.icm42688.self_test = imu.bmi088.self_test = self_test;
    if (chip <= static_cast<std::size_t>(Adis16Model::k16475Dash3)) {
        imu.chip = SpiChip::kAdis16;
        imu.adis16.model = static_cast<Adis16Model>(chip);
        int decimation = imu.adis16.decimation;
        section.read("decimation", decimation, 0, 1999);
        imu.adis16.decimation = static_cast<std::uint16_t>(decimation);
    } else if (kChips[chip] == "icm42688") {
        imu.chip = SpiChip::kIcm42688;
        read_rate(section, imu.icm42688.rate_hz, {200, 500, 1000, 2000});
        int watermark = imu.icm42688.watermark;
        section.read("watermark", watermark, 1, 50);
        imu.icm42688.watermark = static_cast<std::uint8_t>(watermark);
    } else {
        imu.chip = SpiChip::kBmi088;
        read_rate(section, imu.bmi088.gyro_rate_hz, {200, 400, 1000, 2000});
        constexpr std::array<std::string_view, 4> kRanges{"3", "6", "12", "24"};
        imu.bmi088.force_range_code =
            static_cast<std::uint8_t>(section.choice("force_range_g", kRanges, imu.bmi088.force_range_code));
        section.read("accel_device", imu.accel_device);
    }
}

VehicleImuSpi read_imu_spi(const YamlNode& node) {
    VehicleImuSpi imu;
    YamlSection section(node);
    read_chip(section, imu);
    section.read("device", imu.device);
    if (const auto line = section.find("data_ready")) {
        YamlSection fields(*line);
        imu.data_ready = read_line(fields);
        fields.finish();
        imu.bmi088.clock = imu.data_ready->input.clock;
        if (imu.chip == SpiChip::kBmi088 && imu.bmi088.clock == ClockDomain::kHardware) {
            line->fail("clock must be monotonic or realtime: the BMI088's forces are stamped by the host");
        }
    }
    read_duration(section, "poll_period_s", imu.source.poll_period, 1e-4, 0.1);
    section.finish();
    return imu;
}

CanSignalName read_signal(const YamlNode& node) {
    if (!node.raw().IsSequence() || node.raw().size() != 2 || !node.raw()[0].IsScalar() || !node.raw()[1].IsScalar()) {
        node.fail("must be [message, signal]");
    }
    return {node.raw()[0].Scalar(), node.raw()[1].Scalar()};
}

/// {message: M, signals: [x, y, z]}
std::array<CanSignalName, 3> read_axes(const YamlNode& node) {
    YamlSection section(node);
    const std::string message = section.at("message").text();
    const YamlNode signals = section.at("signals");
    section.finish();
    if (!signals.raw().IsSequence() || signals.raw().size() != 3) {
        signals.fail("must be a list of three signals: x, y, z");
    }
    std::array<CanSignalName, 3> names;
    for (std::size_t i = 0; i < names.size(); ++i) {
        names[i] = {message, signals.raw()[i].Scalar()};
    }
    return names;
}

CanSignalMap read_map(const YamlNode& node) {
    CanSignalMap map;
    YamlSection section(node);
    map.rate = read_axes(section.at("rate"));
    map.force = read_axes(section.at("force"));
    if (const auto temperature = section.find("temperature")) {
        map.temperature = read_signal(*temperature);
    }
    if (const auto counter = section.find("counter")) {
        map.counter = read_signal(*counter);
    }
    section.read("j1939", map.j1939);
    section.read("source_address", map.source_address, -1, 253);
    section.finish();
    return map;
}

/// Loads the database and tries the map on it.
void read_dbc(YamlSection& section, VehicleImuCan& imu) {
    const YamlNode path = section.at("dbc");
    const YamlNode map = section.at("map");
    std::optional<InputError> mistake;  // of the map: that of the file comes first
    try {
        imu.map = read_map(map);
    } catch (const InputError& e) {
        mistake = e;
    }
    imu.dbc_path = beside(path);
    std::ifstream file(imu.dbc_path, std::ios::binary);
    std::ostringstream bytes;
    if (!file || !(bytes << file.rdbuf())) {
        path.fail(imu.dbc_path + ": cannot be read");
    }
    imu.dbc_text = bytes.str();
    if (mistake) {
        throw InputError(*mistake);
    }
    DbcFile database;
    DbcDecoder decoder;
    std::string error;
    if (!ok(database.parse(imu.dbc_text, imu.dbc_path, error))) {
        path.fail(error);
    }
    if (!ok(decoder.configure(database, imu.map, error))) {
        map.fail(error);
    }
}

VehicleImuCan read_imu_can(const YamlNode& node) {
    VehicleImuCan imu;
    YamlSection section(node);
    section.read("interface", imu.source.socket.interface);
    section.read("fd", imu.source.socket.fd);
    section.read("hardware_stamps", imu.source.socket.hardware_stamps);
    constexpr std::array<std::string_view, 3> kProtocols{"openimu300", "dronecan", "dbc"};
    (void)section.at("decoder");
    imu.protocol = static_cast<CanProtocol>(section.choice("decoder", kProtocols, 0));
    switch (imu.protocol) {
        case CanProtocol::kOpenImu300:
            imu.dbc_path = "openimu300";
            imu.dbc_text = openimu300_dbc();
            imu.map = openimu300_map();
            section.read("source_address", imu.map.source_address, -1, 253);
            break;
        case CanProtocol::kDroneCan:
            section.read("node_id", imu.dronecan.node_id, -1, 127);
            section.read("use_integrals", imu.dronecan.use_integrals);
            break;
        case CanProtocol::kDbc: read_dbc(section, imu); break;
    }
    section.finish();
    return imu;
}

}  // namespace

VehicleTrigger read_trigger(const YamlNode& node) {
    VehicleTrigger trigger;
    YamlSection section(node);
    trigger.input = read_line(section);
    read_duration(section, "delay_s", trigger.delay, 0.0, 1.0);
    section.finish();
    return trigger;
}

VehiclePulses read_pulses(const YamlNode& node, double rate_hz) {
    VehiclePulses pulses;
    pulses.pulse.period = Duration::from_seconds(1.0 / rate_hz);
    YamlSection section(node);
    read_duration(section, "width_s", pulses.pulse.width, 1e-6, 1.0);
    const auto pwm = section.find("pwm");
    const auto gpio = section.find("gpio");
    section.finish();
    if (pwm.has_value() == gpio.has_value()) {
        node.fail("must have either 'pwm' or 'gpio'");
    }
    if (pulses.pulse.width >= pulses.pulse.period) {
        node.fail(fmt::format("width_s must be below {:g}, the period of cameras.rate_hz", 1.0 / rate_hz));
    }
    if (pwm) {
        YamlSection fields(*pwm);
        pulses.pwm_chip = "/sys/class/pwm/pwmchip0";
        fields.read("chip", pulses.pwm_chip);
        fields.read("channel", pulses.pwm_channel, 0, 63);
        fields.finish();
    } else {
        YamlSection fields(*gpio);
        pulses.line = read_line_name(fields);
        fields.finish();
    }
    return pulses;
}

void read_imu(const YamlNode& node, Vehicle& vehicle) {
    YamlSection section(node);
    AxisMap axes;
    if (const auto field = section.find("axes"); field && !ok(axes.parse(field->text()))) {
        field->fail(fmt::format("'{}' is not an axis map: three different axes such as \"y -x z\", not mirrored",
                                field->text()));
    }
    Duration latency;
    read_duration(section, "latency_s", latency, 0.0, 0.1);
    const auto spi = section.find("spi");
    const auto can = section.find("can");
    const auto iio = section.find("iio");
    const auto serial = section.find("serial");
    const auto mavlink = section.find("mavlink");
    const auto ros2 = section.find("ros2");
    section.finish();
    const int chosen = int{spi.has_value()} + int{can.has_value()} + int{iio.has_value()} + int{serial.has_value()} +
                       int{mavlink.has_value()} + int{ros2.has_value()};
    if (chosen != 1) {
        node.fail("must have one of 'spi', 'can', 'iio', 'serial', 'mavlink' and 'ros2'");
    }
    if (spi) {
        vehicle.imu_spi = read_imu_spi(*spi);
        vehicle.imu_spi->source.axes = axes;
        vehicle.imu_spi->source.latency = latency;
    } else if (iio) {
        vehicle.imu_iio = read_imu_iio(*iio, vehicle.calibration.noise.rate_hz);
        vehicle.imu_iio->axes = axes;
        vehicle.imu_iio->latency = latency;
    } else if (serial) {
        vehicle.imu_serial = read_imu_serial(*serial);
        vehicle.imu_serial->axes = axes;
        vehicle.imu_serial->latency = latency;
    } else if (mavlink) {
        vehicle.imu_mavlink = read_imu_mavlink(*mavlink, vehicle.calibration.noise.rate_hz);
        vehicle.imu_mavlink->axes = axes;
        vehicle.imu_mavlink->latency = latency;
    } else if (ros2) {
        vehicle.imu_ros2 = read_imu_ros2(*ros2);
        vehicle.imu_ros2->axes = axes;
        vehicle.imu_ros2->latency = latency;
    } else {
        vehicle.imu_can = read_imu_can(*can);
        vehicle.imu_can->source.axes = axes;
        vehicle.imu_can->source.latency = latency;
    }
}

}  // namespace facet
