// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_sensors.h"

#include <fmt/core.h>

#include <array>
#include <fstream>
#include <optional>
#include <sstream>

#include "app/support/input_error.h"
#include "app/support/yaml_section.h"
#include "drivers/imu_can/openimu300.h"

namespace facet {
namespace {

using Choices = std::span<const std::string_view>;

void read_duration(YamlSection& section, const std::string& key, Duration& value, double low_s, double high_s) {
    double seconds = value.seconds();
    section.read(key, seconds, low_s, high_s);
    if (section.node().has(key)) {  // what is not given keeps its last nanosecond
        value = Duration::from_seconds(seconds);
    }
}

/// What all cameras may have in common, and each may have otherwise.
void read_camera(YamlSection& section, CameraV4l2Options& camera) {
    if (const auto format = section.find("format")) {
        const auto known = pixel_format(format->text());
        if (!known) {
            format->fail(fmt::format("'{}' is unknown; one of: GREY, Y10, Y10P, Y12, Y012, Y16, YUYV", format->text()));
        }
        camera.capture.format = *known;
    }
    section.read("significant_bits", camera.significant_bits, 0, 16);
    section.read("msb_aligned", camera.msb_aligned);
    section.read("controls_device", camera.controls_device);
    section.read("buffers", camera.capture.buffers, 2, 8);
    section.read("heap", camera.capture.heap);
    read_duration(section, "exposure_s", camera.exposure, 0.0, 1.0);
    read_duration(section, "readout_s", camera.readout, 0.0, 1.0);
    constexpr std::array<std::string_view, 4> kStamps{"as_flagged", "start_of_exposure", "end_of_frame",
                                                      "mid_exposure"};
    camera.stamp_source =
        static_cast<StampSource>(section.choice("stamps", kStamps, static_cast<std::size_t>(camera.stamp_source)));
    if (const auto controls = section.find("controls")) {
        YamlSection list(*controls);
        camera.controls.clear();
        for (const auto& item : controls->raw()) {
            const std::string name = item.first.Scalar();
            camera.controls.push_back({name, list.at(name).integer()});
        }
    }
}

void read_node(const YamlNode& node, CameraV4l2Options& camera) {
    YamlSection section(node);
    section.read("device", camera.capture.device);
    read_camera(section, camera);
    section.finish();
}

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
    constexpr std::array<std::string_view, 2> kBackends{"libgpiod", "chardev"};
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

namespace {

AutoExposureOptions read_auto_exposure(const YamlNode& node) {
    constexpr int kMost = 1'000'000;
    AutoExposureOptions options;
    YamlSection section(node);
    section.read("exposure_control", options.exposure_control);
    section.read("gain_control", options.gain_control);
    (void)section.at("exposure_step_s");
    section.read("exposure_step_s", options.exposure_step_s, 1e-7, 0.1);
    section.read("gain_one", options.gain_one, 1, kMost);
    section.read("least_exposure", options.least_exposure, 1, kMost);
    (void)section.at("most_exposure");
    section.read("most_exposure", options.most_exposure, options.least_exposure, kMost);
    options.least_gain = options.gain_one;
    section.read("least_gain", options.least_gain, 1, kMost);
    options.most_gain = options.least_gain;
    section.read("most_gain", options.most_gain, options.least_gain, kMost);
    section.read("target", options.target, 20.0, 200.0);
    section.read("latency_frames", options.latency_frames, 0, 8);
    section.finish();
    return options;
}

}  // namespace

VehicleCameras read_cameras(const YamlNode& node, const Calibration& calibration) {
    VehicleCameras cameras;
    YamlSection section(node);
    section.read("rate_hz", cameras.rate_hz, 1.0, 200.0);
    section.read("use_sequence", cameras.use_sequence);
    section.read("lag_frames", cameras.lag_frames, 0, 8);
    if (const auto automatic = section.find("auto_exposure")) {
        cameras.auto_exposure = read_auto_exposure(*automatic);
    }
    CameraV4l2Options common;
    read_camera(section, common);
    cameras.left = cameras.right = common;
    cameras.left.capture.device = "/dev/video0";
    cameras.right.capture.device = "/dev/video1";
    const auto both = section.find("side_by_side");
    const auto left = section.find("left");
    const auto right = section.find("right");
    section.finish();
    if (!calibration.rig.has_right && (both || right)) {
        (both ? *both : *right).fail("the calibration has one camera: say 'left' only");
    }
    if (both && (left || right)) {
        node.fail("has 'side_by_side' and 'left' or 'right'; choose one node or two");
    }
    const auto set_size = [](CameraV4l2Options& camera, const CameraIntrinsics& k) {
        camera.capture.width = k.width;
        camera.capture.height = k.height;
    };
    set_size(cameras.left, calibration.rig.left.intrinsics());
    set_size(cameras.right, calibration.rig.right.intrinsics());
    if (both) {
        cameras.side_by_side = true;
        if (cameras.left.capture.width != cameras.right.capture.width ||
            cameras.left.capture.height != cameras.right.capture.height) {
            both->fail("the calibration has cameras of different sizes: they cannot be side by side");
        }
        cameras.left.capture.width *= 2;
        read_node(*both, cameras.left);
    }
    if (left) {
        read_node(*left, cameras.left);
    }
    if (right) {
        read_node(*right, cameras.right);
    }
    if (!both && calibration.rig.has_right && cameras.left.capture.device == cameras.right.capture.device) {
        node.fail("left and right are the same device; an image of both is 'side_by_side'");
    }
    return cameras;
}

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
        field->fail(
            fmt::format("'{}' is no axis map: three different axes such as \"y -x z\", not mirrored", field->text()));
    }
    Duration latency;
    read_duration(section, "latency_s", latency, 0.0, 0.1);
    const auto spi = section.find("spi");
    const auto can = section.find("can");
    section.finish();
    if (spi.has_value() == can.has_value()) {
        node.fail("must have either 'spi' or 'can'");
    }
    if (spi) {
        vehicle.imu_spi = read_imu_spi(*spi);
        vehicle.imu_spi->source.axes = axes;
        vehicle.imu_spi->source.latency = latency;
    } else {
        vehicle.imu_can = read_imu_can(*can);
        vehicle.imu_can->source.axes = axes;
        vehicle.imu_can->source.latency = latency;
    }
}

}  // namespace facet
