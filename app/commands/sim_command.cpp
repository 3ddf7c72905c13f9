// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/sim_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>

#include "app/lab/sim/scene.h"
#include "app/lab/sim/simulate.h"
#include "app/support/console.h"

namespace facet {
namespace {

using Clock = std::chrono::steady_clock;

/// Images done, rate and time left: a bar that redraws itself on a terminal, otherwise a line every tenth.
class ProgressLine {
public:
    void show(int done, int total) {
        const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
        const double rate = elapsed_s > 0.0 ? done / elapsed_s : 0.0;
        const int left_s = rate > 0.0 ? static_cast<int>(std::lround((total - done) / rate)) : 0;
        const int percent = static_cast<int>(100LL * done / total);
        if (terminal_) {
            if (elapsed_s - shown_s_ < 0.1 && done < total) {
                return;
            }
            shown_s_ = elapsed_s;
            constexpr int kWidth = 30;
            const int filled = kWidth * done / total;
            print_err("\rrender [{:#<{}}{:.<{}}] {:3d} %  {}/{}  {:.1f} images/s  {}:{:02d} left ", "", filled, "",
                      kWidth - filled, percent, done, total, rate, left_s / 60, left_s % 60);
            if (done == total) {
                print_err("\n");
            }
            std::fflush(stderr);
        } else if (percent / 10 > tenth_) {
            tenth_ = percent / 10;
            print_err("render {:3d} %  {}/{}  {:.1f} images/s  {}:{:02d} left\n", percent, done, total, rate,
                      left_s / 60, left_s % 60);
        }
    }

private:
    bool terminal_ = isatty(STDERR_FILENO) != 0;
    Clock::time_point start_ = Clock::now();
    double shown_s_ = -1.0;
    int tenth_ = 0;
};

int run(const sim::SimOptions& options) {
    std::unique_ptr<ProgressLine> line;  // its clock starts with the first image
    const auto progress = [&line](int done, int total) {
        if (total == 0) {
            print_err("prepare scene, light and flight\n");
        } else if (line == nullptr) {
            line = std::make_unique<ProgressLine>();
        } else {
            line->show(done, total);
        }
    };
    sim::SimSummary summary;
    std::string error;
    if (!ok(sim::simulate(options, progress, summary, error))) {
        print_err("facet sim: {}\n", error);
        return 2;
    }
    const sim::FlightReport& f = summary.flight;
    print_out(
        "{}: {} stereo frames of '{}', path {:.1f} m, up to {:.2f} m/s and {:.2f} rad/s, clearance {:.2f} m, {} "
        "planes\n",
        options.out, summary.frames, options.scene, f.path_m, f.max_speed_m_per_s, f.max_rate_rad_per_s,
        f.min_clearance_m, summary.planes);
    print_out("prepared in {:.1f} s, rendered in {:.1f} s, {:.0f} ms of CPU time per image\n", summary.prepare_s,
              summary.render_s, summary.ms_per_image);
    return 0;
}

}  // namespace

void add_sim_command(CLI::App& app, int& exit_code) {
    const auto options = std::make_shared<sim::SimOptions>();
    CLI::App* sub = app.add_subcommand("sim", "Render a flight with ground truth: stereo images and inertial samples");
    sub->add_option("--scene", options->scene,
                    fmt::format("What to fly through: {}", fmt::join(sim::scene_names(), ", ")))
        ->type_name("NAME")
        ->capture_default_str();
    sub->add_option("--out", options->out, "Folder to write: mav0/ (EuRoC/ASL) and truth/")
        ->type_name("DIR")
        ->required();
    sub->add_option("--seed", options->seed, "Flight, noise and the plan of a building; equal seeds give equal bytes")
        ->type_name("N")
        ->check([](const std::string& text) { return text.starts_with('-') ? "must not be negative" : std::string(); })
        ->capture_default_str();
    sub->add_option("--duration", options->duration_s, "Seconds from first to last image, standing included")
        ->type_name("SECONDS")
        ->capture_default_str();
    sub->add_option("--stand", options->stand_s, "Seconds without motion at the start")
        ->type_name("SECONDS")
        ->capture_default_str();
    static const std::map<std::string, sim::FlightKind> kKinds{
        {"tour", sim::FlightKind::kTour}, {"hover", sim::FlightKind::kHover}, {"turn", sim::FlightKind::kTurn}};
    sub->add_option(
           "--flight", options->flight,
           "tour: through the whole scene; hover: take off and hold a place with a few cm of slow wander, with "
           "--vibration flight; turn: the same without vibration, turning on the spot by 70 degrees every 5 s")
        ->type_name("KIND")
        ->transform(CLI::CheckedTransformer(kKinds).description("{tour,hover,turn}"))
        ->default_str("tour");
    static const std::map<std::string, sim::LensKind> kLenses{{"pinhole", sim::LensKind::kPinhole},
                                                              {"fisheye", sim::LensKind::kFisheye}};
    sub->add_option("--camera", options->camera,
                    "pinhole: EuRoC's lenses, 80 degrees across; fisheye: equidistant ones, 160 degrees across")
        ->type_name("KIND")
        ->transform(CLI::CheckedTransformer(kLenses).description("{pinhole,fisheye}"))
        ->default_str("pinhole");
    static const std::map<std::string, VibrationKind> kVibrations{
        {"none", VibrationKind::kNone}, {"idle", VibrationKind::kIdle}, {"flight", VibrationKind::kFlight}};
    sub->add_option(
           "--vibration", options->vibration,
           "What rotors add to the inertial samples, as on a real multicopter: idle: idling throughout (0.2 to 0.6 "
           "m/s^2 "
           "and 0.02 to 0.04 rad/s rms an axis); flight: idling until take-off, then as in flight (0.5 to 1 m/s^2 and "
           "0.025 to 0.05 rad/s)")
        ->type_name("KIND")
        ->transform(CLI::CheckedTransformer(kVibrations).description("{none,idle,flight}"))
        ->default_str("none");
    sub->add_flag("--closed", options->closed,
                  "Return the same way and end as it began, so that facet replay --loops can repeat it without a "
                  "seam; inertial samples are exact: --inject imu_noise, imu_bias and vibration are new at each turn");
    sub->add_flag("--mover", options->mover, "A textured box glides across the view every few seconds");
    sub->add_option("--time-offset", options->time_offset_s,
                    "Added to the stamps of the images, which are taken at their true time (s)")
        ->type_name("SECONDS")
        ->capture_default_str();
    sub->add_option("--extrinsic-error", options->extrinsic_error_deg,
                    "Rotate both cameras together relative to the IMU in the calibration files (deg); truth/ has the "
                    "true extrinsics")
        ->type_name("DEGREES")
        ->capture_default_str();
    sub->add_option("--calibration-error", options->calibration_error,
                    "K: both cameras' calibration files are perturbed by K sigma of a good calibration (as --inject "
                    "calibration=K,SEED of facet replay); truth/ has the true ones")
        ->type_name("K")
        ->capture_default_str();
    sub->add_option("--gravity", options->gravity_m_per_s2,
                    "Strength of gravity (m/s^2); estimate with --set gravity.magnitude_m_per_s2 at the same value")
        ->type_name("M_PER_S2")
        ->capture_default_str();
    sub->add_option("--rate", options->rate_hz, "Camera rate (Hz)")->type_name("HZ")->capture_default_str();
    sub->add_option("--imu-rate", options->imu_rate_hz, "Rate of the inertial samples (Hz)")
        ->type_name("HZ")
        ->capture_default_str();
    sub->add_option("--exposure", options->exposure_s,
                    "Exposure of an image (s): the rays of a pixel spread over it, one alone blurs nothing")
        ->type_name("SECONDS")
        ->capture_default_str();
    sub->add_option("--contrast", options->contrast,
                    "Contrast of every surface, relative to the scene's: at 0.1 there is little to track")
        ->type_name("FACTOR")
        ->capture_default_str();
    sub->add_option("--range-finder", options->range_sigma_m,
                    "Also readings of a range finder that looks down (mav0/range0), with this standard deviation (m)")
        ->type_name("SIGMA");
    sub->add_option("--samples", options->samples, "Rays per pixel, spread over pixel and exposure")
        ->type_name("N")
        ->capture_default_str();
    sub->add_option("--threads", options->threads, "Threads; the output does not depend on it")
        ->type_name("N")
        ->capture_default_str();
    sub->add_flag("!--no-noise", options->noise, "Exact images and inertial samples: no noise, no bias");
    sub->add_flag("--force", options->force, "Replace mav0/ and truth/ in a folder that is not empty");
    sub->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace facet
