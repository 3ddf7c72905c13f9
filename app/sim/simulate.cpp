// SPDX-License-Identifier: BSD-2-Clause
#include "app/sim/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/sim/asl_writer.h"
#include "app/sim/default_rig.h"
#include "app/sim/parallel.h"
#include "app/sim/png_writer.h"
#include "app/sim/renderer.h"
#include "app/sim/truth.h"
#include "app/support/rng.h"

namespace facet::sim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Timestamp kEpoch{1'700'000'000'000'000'000};
/// First image after the first inertial sample: no multiple of a sample period, so that stamps never agree.
constexpr Duration kFirstImage{101'723'456};
constexpr double kTail_s = 0.1;  // inertial samples after the last image
constexpr double kImuRate_hz = 200.0;
constexpr double kRightGain = 1.06;

/// Processor time of this thread (s): what an image costs, whatever else the machine does.
double thread_cpu_s() {
    std::timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

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
    } else if (o.samples < 1 || o.samples > 32) {
        error = fmt::format("--samples: {} is outside 1 to 32", o.samples);
    } else if (o.threads < 1 || o.threads > 64) {
        error = fmt::format("--threads: {} is outside 1 to 64", o.threads);
    } else if (o.texture_size < 16 || o.texture_size > 4096 ||
               !std::has_single_bit(static_cast<unsigned>(o.texture_size))) {
        error = fmt::format("texture size: {} is not a power of two from 16 to 4096", o.texture_size);
    } else if (!(o.stand_s >= 0.0 && o.stand_s <= 60.0)) {
        error = fmt::format("standing time: {} s is outside 0 to 60 s", o.stand_s);
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
    detail.threads = o.threads;
    if (o.texture_size < 256) {  // a draft: coarse light too
        detail.light_spacing_m = 0.5;
        detail.light_samples = 4;
    }
    return detail;
}

std::vector<Timestamp> image_stamps(const SimOptions& o) {
    std::vector<Timestamp> stamps;
    const auto frames = static_cast<int>(o.duration_s * o.rate_hz + 1e-9) + 1;
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
    meta["samples"] = o.samples;
    meta["noise"] = o.noise;
    meta["clearance_m"] = flight.min_clearance_m;
    meta["path_m"] = flight.path_m;
    meta["max_speed_m_per_s"] = flight.max_speed_m_per_s;
    meta["max_rate_rad_per_s"] = flight.max_rate_rad_per_s;
    return meta.dump(1) + "\n";
}

/// Everything that the images are rendered from.
struct Job {
    const SimOptions& options;
    const Scene& scene;
    const Flight& flight;
    const Renderer& left;
    const Renderer& right;
    const std::vector<Timestamp>& stamps;
    const std::vector<double>& times_s;
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
        const double begin_s = thread_cpu_s();
        const auto frame = static_cast<std::size_t>(i / 2);
        const int camera = i % 2;
        const Renderer& renderer = camera == 0 ? job.left : job.right;
        const std::uint64_t key = hash64(job.options.seed, 31, static_cast<std::uint64_t>(i));
        std::vector<std::uint8_t> image;
        renderer.render(job.scene, job.flight, job.times_s[frame], job.gains[frame], key, image);
        const std::string path = asl_image_path(job.options.out, camera, job.stamps[frame]);
        const bool written = ok(write_png(path, {image.data(), renderer.width(), renderer.height(), renderer.width()}));
        const std::lock_guard<std::mutex> lock(mutex);
        cpu_s += thread_cpu_s() - begin_s;
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
    const Clock::time_point start = Clock::now();
    const Scene scene = make_scene(options.scene, scene_detail(options));
    const std::vector<Timestamp> stamps = image_stamps(options);
    std::vector<double> times_s;
    times_s.reserve(stamps.size());
    for (const Timestamp stamp : stamps) {
        times_s.push_back((stamp - kEpoch).seconds());
    }
    const double end_s = times_s.back() + kTail_s;

    const FlightPlan plan{
        .duration_s = end_s + kTail_s, .stand_s = kFirstImage.seconds() + options.stand_s, .seed = options.seed};
    Flight flight;
    if (!ok(plan_flight(scene, plan, flight))) {
        error = fmt::format("--seed: found no flight through '{}' that keeps its distance; try another seed",
                            options.scene);
        return Status::kDegenerate;
    }
    const StereoRig rig = euroc_rig();
    const ImuNoise noise = euroc_imu_noise();
    Photometry photometry;
    photometry.noise = options.noise;
    const Renderer left(rig.left, rig.T_B_C0, options.samples, photometry);
    photometry.gain = kRightGain;
    const Renderer right(rig.right, rig.T_B_C1, options.samples, photometry);
    const CoarsePass coarse = coarse_pass(scene, flight, left, times_s, options.threads);
    const std::vector<ImuRecord> imu =
        synthesise_imu(flight, end_s, kEpoch, options.noise ? &noise : nullptr, kImuRate_hz, options.seed);
    summary.flight = inspect_flight(flight, scene);
    summary.frames = static_cast<int>(stamps.size());
    summary.planes = static_cast<int>(true_planes(scene, coarse.hits).size());

    std::string path;
    const AslContent content{&rig, noise, options.rate_hz, stamps, imu};
    Status status = write_asl(options.out, content, path);
    if (ok(status)) {
        status = write_truth(options.out, scene, coarse.hits, meta_json(options, summary.flight), path);
    }
    if (!ok(status)) {
        error = fmt::format("cannot write '{}'", path);
        return status;
    }
    summary.prepare_s = seconds_since(start);
    const Clock::time_point rendering = Clock::now();
    double cpu_s = 0.0;
    FACET_TRY(
        render_images({options, scene, flight, left, right, stamps, times_s, coarse.gains}, progress, cpu_s, error));
    summary.render_s = seconds_since(rendering);
    summary.ms_per_image = 1e3 * cpu_s / (2.0 * summary.frames);
    return Status::kOk;
}

}  // namespace facet::sim
