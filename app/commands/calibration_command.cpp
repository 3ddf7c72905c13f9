// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/calibration_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/calibration/calibration.h"
#include "app/calibration/calibration_writer.h"
#include "app/commands/run_guarded.h"
#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

/// What the user typed.
struct CalibrationArguments {
    std::string file;
    std::string imu;
    std::string image_size;
    std::string to;
    std::string out;
};

void print_camera(const char* name, const CameraModel& camera, const Se3& T_B_C) {
    const CameraIntrinsics& k = camera.intrinsics();
    const LensText lens = describe_lens(k);
    print_out("{:<12} {}x{} px, {} {}, {} {}\n", name, k.width, k.height, lens.model, list_text(lens.intrinsics),
              lens.distortion, list_text(lens.coefficients));
    const Eigen::Vector3d axis = T_B_C.R().col(2);
    print_out("{:<12} at {:.4f} {:.4f} {:.4f} m on the IMU, looks along {:.3f} {:.3f} {:.3f}\n", "", T_B_C.p.x(),
              T_B_C.p.y(), T_B_C.p.z(), axis.x(), axis.y(), axis.z());
}

void print_calibration(const Calibration& c) {
    print_camera("left", c.rig.left, c.rig.T_B_C0);
    if (c.rig.has_right) {
        print_camera("right", c.rig.right, c.rig.T_B_C1);
        print_out("{:<12} {:.4f} m\n", "baseline", c.rig.baseline_m());
    }
    print_out("{:<12} {:.4f} s, t_imu = t_cam + shift\n", "time shift", c.camera_time_shift.seconds());
    print_out(
        "{:<12} {:.4g} Hz; noise {:.3g} rad/s/sqrt(Hz), {:.3g} m/s^2/sqrt(Hz); walk {:.3g} rad/s^2/sqrt(Hz), "
        "{:.3g} m/s^3/sqrt(Hz)\n",
        "imu", c.noise.rate_hz, c.noise.gyro_noise_rad_per_s_per_sqrt_hz, c.noise.accel_noise_m_per_s2_per_sqrt_hz,
        c.noise.gyro_walk_rad_per_s2_per_sqrt_hz, c.noise.accel_walk_m_per_s3_per_sqrt_hz);
    if (!c.imu_model.is_ideal()) {
        const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
        print_out("{:<12} scale and misalignment up to {:.3g} (accelerometer) and {:.3g} (gyroscope) off, applied\n",
                  "", (c.imu_model.M_a() - identity).cwiseAbs().maxCoeff(),
                  (c.imu_model.M_w() - identity).cwiseAbs().maxCoeff());
    }
}

/// "640x480"; nothing: not known.
ImageExtent parse_extent(const std::string& text) {
    if (text.empty()) {
        return {};
    }
    int width = 0;
    int height = 0;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%5dx%5d%c", &width, &height, &rest) != 2 || width <= 0 || height <= 0) {
        throw InputError("--image-size " + text + ": must be WIDTHxHEIGHT, such as 640x480");
    }
    return {width, height};
}

int show_or_convert(const CalibrationArguments& args) {
    if (args.to.empty() != args.out.empty()) {
        throw InputError("--to and --out belong together: --to kalibr --out FOLDER");
    }
    if (!std::filesystem::exists(args.file)) {
        throw InputError(args.file + ": does not exist");
    }
    const Calibration calibration = load_calibration(args.file, args.file, args.imu, parse_extent(args.image_size));
    for (const std::string& remark : calibration.remarks) {
        print_err("warning: {}\n", remark);
    }
    print_calibration(calibration);
    if (args.to == "kalibr") {
        write_kalibr_files(calibration, args.out);
    } else if (args.to == "euroc") {
        write_sensor_files(calibration, args.out);
    } else if (args.to == "opencv") {
        write_opencv_file(calibration, args.out);
    }
    if (!args.to.empty()) {
        print_out("{:<12} {}\n", "files", args.out);
    }
    return kExitDone;
}

}  // namespace

void add_calibration_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("calibration", "Show what a calibration file holds, and convert it");
    auto args = std::make_shared<CalibrationArguments>();
    command
        ->add_option("FILE", args->file,
                     "Calibration of cameras against an IMU: of Kalibr, OpenVINS, Basalt, ORB-SLAM3, OKVIS2, "
                     "VINS-Fusion, RealSense (what rs-enumerate-devices -c prints) or OAK (DepthAI's JSON), or a "
                     "folder of EuRoC's or Kimera's files")
        ->required();
    command->add_option("--imu-calibration", args->imu, "Kalibr's or OpenVINS's imu.yaml beside it")->type_name("FILE");
    command
        ->add_option("--image-size", args->image_size,
                     "WIDTHxHEIGHT of the images (px): chooses among RealSense's resolutions, scales OAK's lenses")
        ->type_name("WxH");
    command
        ->add_option("--to", args->to,
                     "kalibr: camchain-imucam.yaml and imu.yaml; euroc: cam0, cam1 and imu0/sensor.yaml; opencv: "
                     "stereo.yaml with M1, D1, M2, D2, R and T")
        ->type_name("FORM")
        ->check(CLI::IsMember({"kalibr", "euroc", "opencv"}));
    command->add_option("--out", args->out, "Folder for these files, created if missing")->type_name("DIR");
    command->footer(
        "What the file holds and is not used is named on standard error.\n"
        "Exit codes: 0 done; 2 bad usage or input, or the output cannot be written.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return show_or_convert(*args); }); });
}

}  // namespace facet
