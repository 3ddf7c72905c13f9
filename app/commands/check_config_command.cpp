// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/check_config_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "app/commands/run_guarded.h"
#include "app/config/config_reference.h"
#include "app/config/service_drop_in.h"
#include "app/config/vehicle_file.h"
#include "app/config/vehicle_files.h"
#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

std::string describe_cameras(const Vehicle& vehicle) {
    const VehicleCameras& cameras = vehicle.cameras;
    const CameraIntrinsics& size = vehicle.calibration.rig.left.intrinsics();
    const std::string& left = cameras.left_name();
    const std::string devices = cameras.side_by_side                ? left + ", both views side by side"
                                : vehicle.calibration.rig.has_right ? left + " and " + cameras.right_name()
                                                                    : left + ", one camera";
    return fmt::format("{}, {}x{} at {:g} Hz", devices, size.width, size.height, cameras.rate_hz);
}

std::string describe_imu(const Vehicle& vehicle) {
    if (vehicle.imu_spi) {
        return fmt::format("{} on {}, {}", vehicle.imu_spi->source.name, vehicle.imu_spi->device,
                           vehicle.imu_spi->data_ready ? "with a data-ready line" : "polled: for the bench only");
    }
    if (vehicle.imu_iio) {
        const ImuIioOptions& iio = *vehicle.imu_iio;
        return fmt::format("{} of the kernel's industrial I/O{}",
                           iio.gyro == iio.accel ? iio.gyro : iio.gyro + " and " + iio.accel,
                           iio.stamps == IioStamps::kKernel ? "" : ", stamped when read: for the bench only");
    }
    if (vehicle.imu_serial) {
        return fmt::format("packets on {} at {} bit/s", vehicle.imu_serial->device, vehicle.imu_serial->baud);
    }
    if (vehicle.imu_mavlink) {
        return fmt::format("the flight controller's, {} at {:g} Hz", to_string(vehicle.imu_mavlink->message),
                           vehicle.imu_mavlink->rate_hz);
    }
    if (vehicle.imu_ros2) {
        return fmt::format("ROS 2, {}", vehicle.imu_ros2->topic);
    }
    return fmt::format("CAN, {}", vehicle.imu_can->source.socket.interface);
}

std::string describe_can_out(const CanOutOptions& can) {
    constexpr const char* kFormats[] = {"CAN FD where the interface has it", "classic CAN", "CAN FD"};
    return fmt::format("{}, {}, identifiers {:#x} to {:#x}{}", can.interface,
                       kFormats[static_cast<std::size_t>(can.format)], can.first_id, can.first_id + kCanOutIds - 1,
                       can.node_id != 0 ? fmt::format(", DroneCAN node {}", can.node_id) : "");
}

std::string describe_mavlink(const Vehicle& vehicle) {
    if (!vehicle.mavlink) {
        return vehicle.can_out || vehicle.ros2_out ? "none" : "none: nobody receives the estimates";
    }
    const MavlinkOptions& link = *vehicle.mavlink;
    const MavlinkChannelOptions& channel = link.channel;
    std::string text = channel.serial.empty() ? fmt::format("udp {}:{}", channel.udp_host, channel.udp_port)
                                              : fmt::format("{} at {} baud", channel.serial, channel.baud);
    text += fmt::format(", system {} component {}", link.address.system, link.address.component);
    text += link.time == MavlinkTime::kAutopilot ? ", stamps in the autopilot's time" : ", stamps in our own time";
    text += link.commands_from == 0 ? ", obeys nobody" : fmt::format(", obeys system {}", link.commands_from);
    text += link.signing ? ", signed" : "";
    text += vehicle.obstacles ? ", with obstacles" : "";
    return text;
}

std::string describe_files(const VehicleLog& log) {
    if (log.folder.empty()) {
        return "none";
    }
    return fmt::format("{}, a folder a flight, {}", log.folder,
                       log.keep_mb > 0 ? fmt::format("the newest {} MB are kept", log.keep_mb) : "all are kept");
}

/// What is to be printed of a good file.
struct VehicleArguments {
    std::string path;
    bool files = false;
    bool drop_in = false;
    bool reference = false;
};

constexpr const char* kReferenceHead =
    "# Every key of a vehicle file, with its default: facet check-config --reference\n"
    "# What is required has none. app/config/examples has whole files.\n\n";
constexpr const char* kParameterHead =
    "\n---\n# Every parameter of the file that estimator.config names; facet replay --config takes one as well.\n\n";

int print_reference() {
    print_out("{}{}{}{}", kReferenceHead, vehicle_reference(), kParameterHead, parameter_reference());
    const std::vector<std::string> gaps = reference_gaps();
    for (const std::string& gap : gaps) {
        print_error(gap.c_str());
    }
    return gaps.empty() ? kExitDone : kExitFailed;
}

int check_vehicle_file(const VehicleArguments& args) {
    if (args.reference) {
        return print_reference();
    }
    const std::string& path = args.path;
    if (path.empty()) {
        throw InputError("a vehicle file is needed, or --reference");
    }
    Vehicle vehicle;
    const std::vector<std::string> errors = check_vehicle(path, vehicle);
    for (const std::string& error : errors) {
        print_error(error.c_str());
    }
    if (!errors.empty()) {
        return kExitBadInput;
    }
    for (const std::string& remark : vehicle.calibration.remarks) {
        print_err("warning: {}\n", remark);
    }
    if (args.files) {
        for (const std::string& file : files_named_by(path)) {
            print_out("{}\n", file);
        }
    }
    if (args.drop_in) {
        print_out("{}", service_drop_in(vehicle));
    }
    if (args.files || args.drop_in) {
        return kExitDone;
    }
    print_out("calibration  {}\n", vehicle.calibration.source);
    print_out("cameras      {}\n", describe_cameras(vehicle));
    print_out("trigger      {}\n", vehicle.trigger ? "edges are stamped" : "none");
    print_out("imu          {}\n", describe_imu(vehicle));
    print_out("mavlink      {}\n", describe_mavlink(vehicle));
    if (vehicle.can_out) {
        print_out("can out      {}\n", describe_can_out(*vehicle.can_out));
    }
    print_out("files        {}\n", describe_files(vehicle.log));
    print_out("{}: can be used; facet run --dry-run tries the hardware\n", path);
    return kExitDone;
}

}  // namespace

void add_check_config_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("check-config", "Check a vehicle file without hardware");
    auto args = std::make_shared<VehicleArguments>();
    command->add_option("VEHICLE", args->path, "Vehicle file (YAML), as for facet run --config");
    command->add_flag(
        "--reference", args->reference,
        "Only print every key of vehicle files and parameter files, with default, unit, bounds and meaning");
    command->add_flag("--files", args->files, "Only print the files that it names, as it names them");
    command->add_flag("--drop-in", args->drop_in,
                      "Only print a systemd drop-in for facet.service that allows the devices and addresses it names");
    command->footer(
        "Reports the first mistake of each section with file, line and field, or else what the file describes.\n"
        "Exit codes: 0 the file can be used; 2 it cannot.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return check_vehicle_file(*args); }); });
}

}  // namespace facet
