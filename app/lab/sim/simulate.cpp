// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/simulate.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "app/lab/faults/calibration_error.h"
#include "app/lab/sim/asl_writer.h"
#include "app/lab/sim/parallel.h"
#include "app/lab/sim/range_finder.h"
#include "app/lab/sim/renderer.h"
#include "app/lab/sim/truth.h"
#include "app/lab/sim/vibration.h"
#include "app/support/png_writer.h"
#include "app/support/processor_time.h"
#include "app/support/rng.h"

namespace facet::sim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Timestamp kEpoch{1'700'000'000'000'000'000};
/// First image after the first inertial sample: no multiple of a sample period, so that stamps never agree.
constexpr Duration kFirstImage{101'723'456};
constexpr double kTail_s = 0.1;  // inertial samples after the last image
constexpr double kRightGain = 1.06;
constexpr double kMoverDelay_s = 1.0;  // after take-off

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A hover has rotors, unless its samples are to be exact.
VibrationKind vibration_of(const SimOptions& o) {
    const bool is_flown = o.flight == FlightKind::kHover && !o.closed;
    return o.vibration == VibrationKind::kNone && is_flown ? VibrationKind::kFlight : o.vibration;
}

Status check_options(const SimOptions& o, std::string& error) {
    const auto names = scene_names();
    if (std::find(names.begin(), names.end(), o.scene) == names.end()) {
        error = fmt::format("--scene: there is no scene '{}' (there are: {})", o.scene, fmt::join(names, ", "));
    } else if (o.out.empty()) {
        error = "--out: no folder given";
    } else if (!(o.duration_s >= 0.1 && o.duration_s <= 3600.0)) {
        error = fmt::format("--duration: {} s is outside 0.1 to 3600 s", o.duration_s);
    } else if (!(o.rate_hz >= 1.0 && o.rate_hz <= 200.0)) {
        error = fmt::format("--rate: {} Hz is outside 1 to 200 Hz", o.rate_hz);
    } else if (!(o.imu_rate_hz >= 100.0 && o.imu_rate_hz <= 2000.0)) {
        error = fmt::format("--imu-rate: {} Hz is outside 100 to 2000 Hz", o.imu_rate_hz);
    } else if (o.samples < 1 || o.samples > 32) {
        error = fmt::format("--samples: {} is outside 1 to 32", o.samples);
    } else if (o.threads < 1 || o.threads > 64) {
        error = fmt::format("--threads: {} is outside 1 to 64", o.threads);
    } else if (o.texture_size < 16 || o.texture_size > 4096 ||
               !std::has_single_bit(static_cast<unsigned>(o.texture_size))) {
        error = fmt::format("texture size: {} is not a power of two from 16 to 4096", o.texture_size);
    } else if (!(o.stand_s >= 0.0 && o.stand_s <= 600.0)) {
        error = fmt::format("--stand: {} s is outside 0 to 600 s", o.stand_s);
    } else if (!(std::abs(o.time_offset_s) <= 0.05)) {
        error = fmt::format("--time-offset: {} s is outside -0.05 to 0.05 s", o.time_offset_s);
    } else if (!(o.extrinsic_error_deg >= 0.0 && o.extrinsic_error_deg <= 30.0)) {
        error = fmt::format("--extrinsic-error: {} deg is outside 0 to 30 deg", o.extrinsic_error_deg);
    } else if (!(o.gravity_m_per_s2 >= 1.0 && o.gravity_m_per_s2 <= 30.0)) {
        error = fmt::format("--gravity: {} m/s^2 is outside 1 to 30 m/s^2", o.gravity_m_per_s2);
    } else if (!(o.exposure_s > 0.0 && o.exposure_s * o.rate_hz <= 1.0)) {
        error = fmt::format("--exposure: {} s is outside 0 to {} s, the time from image to image", o.exposure_s,
                            1.0 / o.rate_hz);
    } else if (!(o.contrast >= 0.0 && o.contrast <= 1.0)) {
        error = fmt::format("--contrast: {} is outside 0 to 1", o.contrast);
    } else if (!(o.calibration_error >= 0.0 && o.calibration_error <= 100.0)) {
        error = fmt::format("--calibration-error: {} is outside 0 to 100", o.calibration_error);
    } else if (!(o.range_sigma_m <= 1.0)) {
        error = fmt::format("--range-finder: {} m is above 1 m", o.range_sigma_m);
    } else if (o.closed && vibration_of(o) != VibrationKind::kNone) {
        error = "--closed: a flight to be repeated has exact inertial samples; give vibration to the replay (--inject)";
    } else if (o.closed && o.mover) {
        error = "--closed: the mover does not come back to where it began";
    } else if (o.closed && o.duration_s < 2.0 * o.stand_s + 10.0) {
        error = fmt::format("--closed: {} s are too short to fly out and back", o.duration_s);
    }
    return error.empty() ? Status::kOk : Status::kInvalidArgument;
}

/// Makes the folder ready: it must be new or empty, or --force lets mav0/ and truth/ in it go.
Status prepare_folder(const SimOptions& o, std::string& error) {
    namespace fs = std::filesystem;
    std::error_code code;
    fs::create_directories(o.out, code);
    if (code || !fs::is_directory(o.out, code)) {
        error = fmt::format("--out: cannot make the folder '{}'", o.out);
        return Status::kIo;
    }
    const bool empty = fs::is_empty(o.out, code);
    if (code) {
        error = fmt::format("--out: cannot look into the folder '{}'", o.out);
        return Status::kIo;
    }
    if (empty) {
        return Status::kOk;
    }
    if (!o.force) {
        error = fmt::format("--out: the folder '{}' is not empty (--force replaces mav0/ and truth/ in it)", o.out);
        return Status::kInvalidArgument;
    }
    for (const char* part : {"/mav0", "/truth"}) {
        fs::remove_all(o.out + part, code);
        if (code) {
            error = fmt::format("--force: cannot remove '{}{}'", o.out, part);
            return Status::kIo;
        }
    }
    return Status::kOk;
}

SceneDetail scene_detail(const SimOptions& o) {
    SceneDetail detail;
    detail.texture_size = o.texture_size;
    detail.contrast = o.contrast;
    detail.threads = o.threads;
    if (o.texture_size < 256) {  // a draft: coarse light too
        detail.light_spacing_m = 0.5;
        detail.light_samples = 4;
    }
    return detail;
}

std::vector<Timestamp> image_stamps(const SimOptions& o) {
    std::vector<Timestamp> stamps;
    // The last image of a closed flight comes one period before the first of its repetition.
    const auto frames = std::max(1, static_cast<int>(o.duration_s * o.rate_hz + 1e-9) + (o.closed ? 0 : 1));
    stamps.reserve(static_cast<std::size_t>(frames));
    for (int i = 0; i < frames; ++i) {
        stamps.push_back(kEpoch + kFirstImage + Duration::from_seconds(i / o.rate_hz));
    }
    return stamps;
}

std::string meta_json(const SimOptions& o, const FlightReport& flight) {
    nlohmann::ordered_json meta;
    meta["scene"] = o.scene;
    meta["seed"] = o.seed;
    meta["duration_s"] = o.duration_s;
    meta["rate_hz"] = o.rate_hz;
    meta["imu_rate_hz"] = o.imu_rate_hz;
    meta["samples"] = o.samples;
    meta["noise"] = o.noise;
    meta["flight"] = o.flight == FlightKind::kHover ? "hover" : o.flight == FlightKind::kTurn ? "turn" : "tour";
    meta["camera"] = o.camera == LensKind::kFisheye ? "fisheye" : "pinhole";
    meta["stand_s"] = o.stand_s;
    meta["closed"] = o.closed;
    meta["vibration"] = kVibrationNames.at(static_cast<std::size_t>(vibration_of(o)));
    meta["mover"] = o.mover;
    meta["time_offset_s"] = o.time_offset_s;
    meta["extrinsic_error_deg"] = o.extrinsic_error_deg;
    meta["calibration_error"] = o.calibration_error;
    meta["gravity_m_per_s2"] = o.gravity_m_per_s2;
    meta["clearance_m"] = flight.min_clearance_m;
    meta["path_m"] = flight.path_m;
    meta["max_speed_m_per_s"] = flight.max_speed_m_per_s;
    meta["max_rate_rad_per_s"] = flight.max_rate_rad_per_s;
    return meta.dump(1) + "\n";
}

/// When the motors start, in flight time.
double take_off_s(const SimOptions& o) { return kFirstImage.seconds() + o.stand_s; }

Status plan(const SimOptions& o, const Scene& scene, double end_s, Flight& flight, std::string& error) {
    const FlightPlan plan{.kind = o.flight,
                          .duration_s = o.closed ? o.duration_s : end_s + kTail_s,
                          .stand_s = take_off_s(o),
                          .seed = o.seed,
                          .closed = o.closed};
    const Status status = plan_flight(scene, plan, flight);
    if (!ok(status)) {
        error = fmt::format("--seed: found no flight through '{}' that keeps its distance; try another seed", o.scene);
    }
    return status;
}

std::vector<ImuRecord> make_imu(const SimOptions& o, const Flight& flight, double end_s) {
    const ImuNoise noise = euroc_imu_noise();
    const bool is_exact = !o.noise || o.closed;  // noise that is the same at each turn would be none
    std::vector<ImuRecord> imu =
        synthesise_imu(flight, end_s, kEpoch, {is_exact ? nullptr : &noise, o.imu_rate_hz, o.gravity_m_per_s2}, o.seed);
    add_vibration(vibration_of(o), take_off_s(o), o.seed, imu);
    return imu;
}

/// The extrinsics that calibration files claim: both cameras turned as one, about an axis drawn from the seed through
/// the left camera's centre.
std::array<Eigen::Matrix4d, 2> claimed_extrinsics(const SimOptions& o) {
    std::array<Eigen::Matrix4d, 2> T_B_C{euroc_T_B_C(0), euroc_T_B_C(1)};
    if (o.extrinsic_error_deg == 0.0) {
        return T_B_C;
    }
    RandomStream random(o.seed, 42);
    const double x = random.normal();
    const double y = random.normal();
    const Eigen::Vector3d axis = Eigen::Vector3d(x, y, random.normal()).normalized();
    const Eigen::Vector3d pivot = T_B_C[0].topRightCorner<3, 1>();
    const Eigen::Affine3d turn = Eigen::Translation3d(pivot) *
                                 Eigen::AngleAxisd(o.extrinsic_error_deg * std::numbers::pi / 180.0, axis) *
                                 Eigen::Translation3d(-pivot);
    for (Eigen::Matrix4d& T : T_B_C) {
        T = turn.matrix() * T;
    }
    return T_B_C;
}

/// The calibration that the files claim.
Status claim_calibration(const SimOptions& o, StereoRig& rig, std::array<Eigen::Matrix4d, 2>& T_B_C,
                         std::string& error) {
    T_B_C = claimed_extrinsics(o);
    if (o.calibration_error == 0.0) {
        return Status::kOk;
    }
    rig.T_B_C0 = Se3::from_matrix(T_B_C[0]);
    rig.T_B_C1 = Se3::from_matrix(T_B_C[1]);
    if (!add_calibration_error(o.calibration_error, o.seed, rig)) {
        error = fmt::format("--calibration-error: {} leaves no usable camera", o.calibration_error);
        return Status::kInvalidArgument;
    }
    T_B_C = {rig.T_B_C0.matrix(), rig.T_B_C1.matrix()};
    return Status::kOk;
}

/// All files but the images.
/// @param stamps  of the images, as written
Status write_tables(const SimOptions& o, const World& world, const CoarsePass& coarse,
                    const std::vector<Timestamp>& stamps, double end_s, std::string& error) {
    const StereoRig rig = rig_with(o.camera);
    StereoRig claimed = rig;
    AslContent content{&claimed, {}, euroc_imu_noise(), o.rate_hz, stamps, {}};
    content.imu_noise.rate_hz = o.imu_rate_hz;
    FACET_TRY(claim_calibration(o, claimed, content.T_B_C, error));
    const std::vector<ImuRecord> imu = make_imu(o, world.flight, end_s);
    content.imu = imu;
    const std::string meta = meta_json(o, inspect_flight(world.flight, world.scene));
    std::string path;
    Status status = write_asl(o.out, content, path);
    if (ok(status) && o.range_sigma_m >= 0.0) {
        path = o.out + "/mav0/range0/data.csv";
        status = write_ranges(path, find_ranges(world.scene, imu, o.range_sigma_m, o.seed));
    }
    if (ok(status)) {
        status = write_truth(o.out, world.scene, coarse.hits, meta, path);
    }
    if (ok(status) && world.mover != nullptr) {
        path = o.out + "/truth/mover.json";
        std::ofstream file(path);
        file << mover_json(*world.mover, kEpoch);
        file.close();
        status = file ? Status::kOk : Status::kIo;
    }
    content.rig = &rig;
    content.T_B_C = {euroc_T_B_C(0), euroc_T_B_C(1)};
    for (int camera = 0; camera < 2 && ok(status); ++camera) {
        status = write_camera_yaml(fmt::format("{}/truth/cam{}_sensor.yaml", o.out, camera), camera, content, path);
    }
    if (!ok(status)) {
        error = fmt::format("cannot write '{}'", path);
    }
    return status;
}

/// Everything that the images are rendered from.
struct Job {
    const SimOptions& options;
    World world;
    const Renderer& left;
    const Renderer& right;
    const std::vector<Timestamp>& stamps;  ///< as written
    const std::vector<double>& times_s;    ///< true ones, in the flight
    const std::vector<double>& gains;
};

Status render_images(const Job& job, const SimProgress& progress, double& cpu_s, std::string& error) {
    const auto total = static_cast<int>(2 * job.stamps.size());
    std::mutex mutex;
    int done = 0;
    std::atomic<bool> failed{false};
    parallel_for(total, job.options.threads, [&](int i) {
        if (failed) {
            return;
        }
        const double begin_s = thread_processor_s();
        const auto frame = static_cast<std::size_t>(i / 2);
        const int camera = i % 2;
        const Renderer& renderer = camera == 0 ? job.left : job.right;
        const std::uint64_t key = hash64(job.options.seed, 31, static_cast<std::uint64_t>(i));
        std::vector<std::uint8_t> image;
        renderer.render(job.world, job.times_s[frame], job.gains[frame], key, image);
        const std::string path = asl_image_path(job.options.out, camera, job.stamps[frame]);
        const bool written = ok(write_png(path, {image.data(), renderer.width(), renderer.height(), renderer.width()}));
        const std::lock_guard<std::mutex> lock(mutex);
        cpu_s += thread_processor_s() - begin_s;
        if (!written) {
            failed = true;
            error = fmt::format("cannot write '{}'", path);
        } else if (progress) {
            progress(++done, total);
        }
    });
    return failed ? Status::kIo : Status::kOk;
}

}  // namespace

Status simulate(const SimOptions& options, const SimProgress& progress, SimSummary& summary, std::string& error) {
    error.clear();
    FACET_TRY(check_options(options, error));
    FACET_TRY(prepare_folder(options, error));
    if (progress) {
        progress(0, 0);
    }
    const Clock::time_point start = Clock::now();
    const Scene scene = make_scene(options.scene, scene_detail(options), options.seed);
    std::vector<Timestamp> stamps = image_stamps(options);
    std::vector<double> times_s;
    times_s.reserve(stamps.size());
    for (Timestamp& stamp : stamps) {
        times_s.push_back((stamp - kEpoch).seconds());
        stamp = stamp + Duration::from_seconds(options.time_offset_s);
    }
    const double end_s = times_s.back() + kTail_s;
    Flight flight;
    FACET_TRY(plan(options, scene, end_s, flight, error));
    const StereoRig rig = rig_with(options.camera);
    Photometry photometry;
    photometry.noise = options.noise;
    photometry.exposure_s = options.exposure_s;
    const Renderer left(rig.left, rig.T_B_C0, options.samples, photometry);
    photometry.gain = kRightGain;
    const Renderer right(rig.right, rig.T_B_C1, options.samples, photometry);
    const CoarsePass coarse = coarse_pass(scene, flight, left, times_s, options.threads);
    std::optional<Mover> mover;
    if (options.mover) {
        const double from_s = take_off_s(options) + kMoverDelay_s;
        mover.emplace(scene_detail(options), plan_crossings(scene, flight, rig.T_B_C0, from_s, end_s, options.seed));
    }
    const World world{scene, flight, mover ? &*mover : nullptr};
    summary.flight = inspect_flight(flight, scene);
    summary.frames = static_cast<int>(stamps.size());
    summary.planes = static_cast<int>(true_planes(scene, coarse.hits).size());
    FACET_TRY(write_tables(options, world, coarse, stamps, end_s, error));
    summary.prepare_s = seconds_since(start);
    const Clock::time_point rendering = Clock::now();
    double cpu_s = 0.0;
    FACET_TRY(render_images({options, world, left, right, stamps, times_s, coarse.gains}, progress, cpu_s, error));
    summary.render_s = seconds_since(rendering);
    summary.ms_per_image = 1e3 * cpu_s / (2.0 * summary.frames);
    return Status::kOk;
}

}  // namespace facet::sim
