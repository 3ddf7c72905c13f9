// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/replay.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "app/faults/fault_injector.h"
#include "app/mesh_output/mesh_log.h"
#include "app/mesh_output/plane_log.h"
#include "app/mesh_output/run_mesh.h"
#include "app/output/trajectory_writer.h"
#include "app/pipeline/stage_timer.h"
#include "app/pipeline/warning_log.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "estimator/api/estimator.h"
#include "mesh/planes/plane_finder.h"

namespace facet {
namespace {

/// The estimator may find that images are later than their stamps say: it can then use them only this much later.
constexpr Duration kFrameDelay = Duration::from_seconds(0.02);

bool is_finite(const NavState& s) {
    return s.q_W_B.coeffs().allFinite() && s.p_W_B.allFinite() && s.v_W_B.allFinite() && s.bias.gyro.allFinite() &&
           s.bias.accel.allFinite();
}

bool is_usable(TrackingState state) { return state == TrackingState::kTracking || state == TrackingState::kDegraded; }

/// One run: the estimator, its observer and the files it fills.
class Replay {
public:
    explicit Replay(const ReplayOptions& options)
        : options_(options),
          warnings_(options.out),
          trajectory_(options.out),
          timing_(options.out),
          health_(options.out),
          mesh_log_(options.out),
          plane_log_(options.out) {
        summary_.dataset = options.dataset;
        summary_.mode = to_string(options.config.regularity.mode);
        summary_.calibration = options.calibration.source;
        summary_.start_s = options.start_s;
        for (const Fault& fault : options.faults) {
            summary_.faults.push_back(fault.spec);
        }
    }

    RunSummary run(const std::atomic<bool>& stop);

private:
    void open_log();
    void configure();
    bool pull();
    void give(const ImuSample& sample);
    void give(const StereoFrame& frame);
    void deliver_faulted();
    void tell_idle_faults();
    void feed(const ImuSample& sample);
    void feed(const StereoFrame& frame, Timestamp output_stamp);
    void keep(const Estimate& estimate);
    void update_mesh(const StereoFrame& frame, const Health& health);
    void update_planes(const KeyframeView& view, const Health& health);

    const ReplayOptions& options_;
    WarningLog warnings_;
    TrajectoryWriter trajectory_;
    TimingWriter timing_;
    HealthWriter health_;
    MeshLog mesh_log_;
    PlaneLog plane_log_;
    AslDataset log_;
    Estimator estimator_;
    std::unique_ptr<Mesher> mesher_ = std::make_unique<Mesher>();
    std::unique_ptr<PlaneFinder> planes_ = std::make_unique<PlaneFinder>();
    std::uint32_t planes_reset_counter_ = 0;  ///< the estimator's when the planes were last looked for
    RunMesh run_mesh_;
    std::uint32_t last_view_ = 0;
    StageTimer timer_;
    RunSummary summary_;
    std::optional<FaultInjector> injector_;  ///< none without faults
};

void Replay::open_log() {
    const CameraIntrinsics& left = options_.calibration.rig.left.intrinsics();
    const CameraIntrinsics& right = options_.calibration.rig.right.intrinsics();
    AslOptions log_options;
    log_options.camera_time_shift = options_.calibration.camera_time_shift;
    log_options.frame_delay = kFrameDelay;
    log_options.start = Duration::from_seconds(options_.start_s);
    if (options_.duration_s.has_value()) {
        log_options.length = Duration::from_seconds(*options_.duration_s);
    }
    log_options.left_size = {left.width, left.height};
    log_options.right_size = {right.width, right.height};
    std::string error;
    if (!ok(log_.open(
            options_.dataset, log_options, [this](const AslWarning& w) { warnings_.add(w); }, error))) {
        throw InputError(error);
    }
    summary_.frames_listed = log_.frame_count();
    if (summary_.frames_listed == 0) {
        throw InputError(fmt::format("{}: no frame between --start and its --duration", options_.dataset));
    }
    if (!options_.faults.empty()) {
        injector_.emplace(options_.faults, options_.calibration.noise, log_.log_begin() + log_options.start,
                          kFrameDelay);
    }
}

/// Section of the parameters that its module refuses, also for reasons the single ranges do not tell; empty if none.
std::string refused_section(const ProgramConfig& config) {
    if (!ok(config.frontend.validate())) {
        return "frontend";
    }
    if (!ok(config.initializer.validate())) {
        return "initializer";
    }
    if (!ok(config.window.validate())) {
        return "window";
    }
    if (!ok(config.calibration.validate())) {
        return "calibration";
    }
    if (!ok(config.regularity.validate())) {
        return "regularity";
    }
    if (!ok(config.stationarity.validate())) {
        return "stationarity";
    }
    if (!ok(config.health.validate())) {
        return "health";
    }
    if (!ok(config.imu_limits.validate())) {
        return "imu_limits";
    }
    if (!ok(config.mesh.validate())) {
        return "mesh";
    }
    if (!ok(config.planes.validate())) {
        return "planes";
    }
    return ok(config.validate()) ? "" : "imu_noise";
}

void Replay::configure() {
    if (const std::string section = refused_section(options_.config); !section.empty()) {
        throw InputError(fmt::format("parameters '{}.*': one is out of range, or two contradict each other", section));
    }
    if (!ok(estimator_.configure(options_.config, options_.calibration.rig))) {
        const CameraIntrinsics& left = options_.calibration.rig.left.intrinsics();
        throw InputError(
            fmt::format("calibration ({}): the estimator refuses these cameras; are {}x{} pixels too few for "
                        "frontend.pyramid_levels {}?",
                        options_.calibration.source, left.width, left.height, options_.config.frontend.pyramid_levels));
    }
    FACET_ASSERT(ok(mesher_->configure(options_.config.mesh, options_.calibration.rig.left)));  // judged above
    FACET_ASSERT(ok(planes_->configure(options_.config.planes)));
    estimator_.set_stage_observer(&timer_);
}

void Replay::feed(const ImuSample& sample) {
    const auto begin = StageTimer::Clock::now();
    const Status status = estimator_.add_imu(sample);
    timer_.add_total(begin);
    ++summary_.imu_samples;
    summary_.imu_refused += ok(status) ? 0 : 1;
}

void Replay::feed(const StereoFrame& frame, Timestamp output_stamp) {
    Estimate estimate;
    estimate.stamp = frame.stamp;
    estimate.health.state = summary_.last.health.state;  // stands if the estimator says nothing
    const auto begin = StageTimer::Clock::now();
    const Status status = estimator_.add_frame(frame, estimate);
    timer_.add_total(begin);
    estimate.stamp = estimate.stamp - (frame.stamp - output_stamp);
    if (ok(status) && estimate.health.is_keyframe && is_usable(estimate.health.state)) {
        update_mesh(frame, estimate.health);
    }
    const FrameTiming timing = timer_.take();
    ++summary_.frames;
    if (status == Status::kNotReady) {
        ++summary_.frames_not_ready;
    } else if (!ok(status)) {
        ++summary_.frames_refused;
        warnings_.add("refused_frame",
                      fmt::format("frame {}: refused by the estimator: {}", output_stamp.ns, to_string(status)));
    }
    const bool is_keyframe = ok(status) && estimate.health.is_keyframe;
    summary_.keyframes += is_keyframe ? 1 : 0;
    summary_.timed.push_back({is_keyframe, timing});
    ++summary_.frames_by_state[to_string(estimate.health.state)];
    timing_.write(output_stamp, is_keyframe, timing);
    health_.write(output_stamp, estimate.health);
    if (ok(status) && is_usable(estimate.health.state)) {
        keep(estimate);
    } else {
        summary_.last.stamp = estimate.stamp;
        summary_.last.health = estimate.health;
    }
}

/// The turn of mesher and plane finder at a keyframe: part of the keyframe's time.
void Replay::update_mesh(const StereoFrame& frame, const Health& health) {
    const KeyframeView& view = estimator_.keyframe_view();
    if (view.number == last_view_) {
        return;  // the first keyframe, or one the window refused
    }
    last_view_ = view.number;
    const auto begin = StageTimer::Clock::now();
    timer_.begin(Stage::kMesh);
    mesher_->update(view, frame.left);
    timer_.end(Stage::kMesh);
    update_planes(view, health);
    timer_.add_total(begin);
    plane_log_.write(frame.stamp, *planes_);
    run_mesh_.collect(*mesher_);
    mesh_log_.write(frame.stamp, *mesher_);
    summary_.mesh_faces_max = std::max(summary_.mesh_faces_max, mesher_->mesh().face_count());
}

/// Planes are found in every mode; whether the estimator uses them is its mode's business.
void Replay::update_planes(const KeyframeView& view, const Health& health) {
    if (health.reset_counter != planes_reset_counter_) {
        planes_->reset();
        planes_reset_counter_ = health.reset_counter;
    }
    timer_.begin(Stage::kPlanes);
    const PlaneProposals& proposals = planes_->update(mesher_->mesh(), view);
    planes_->label(mesher_->mesh());
    estimator_.set_planes(proposals);
    timer_.end(Stage::kPlanes);
}

void Replay::keep(const Estimate& estimate) {
    if (!is_finite(estimate.state)) {
        summary_.not_finite = true;
        warnings_.add("not_finite_estimate",
                      fmt::format("frame {}: estimate is not finite; not written", estimate.stamp.ns));
        summary_.last.health = estimate.health;
        return;
    }
    trajectory_.write(estimate);
    if (summary_.estimates++ == 0) {
        summary_.first_estimate = estimate.stamp;
    } else {
        summary_.path_m += (estimate.state.p_W_B - summary_.last.state.p_W_B).norm();
    }
    summary_.last = estimate;
}

void Replay::give(const ImuSample& sample) {
    if (injector_) {
        injector_->add(sample);
    } else {
        feed(sample);
    }
}

void Replay::give(const StereoFrame& frame) {
    if (injector_) {
        injector_->add(frame);
    } else {
        feed(frame, frame.stamp);
    }
}

/// Feeds what the injector has ready.
void Replay::deliver_faulted() {
    for (const FaultInjector::Delivery* out = nullptr; injector_ && (out = injector_->front()) != nullptr;) {
        if (const auto* sample = std::get_if<ImuSample>(out)) {
            feed(*sample);
        } else {
            const auto& frame = std::get<OwnedFrame>(*out);
            feed(frame.view(), frame.output_stamp);
        }
        injector_->pop();
    }
}

/// A fault that met no sample is likely a mistake in its times.
void Replay::tell_idle_faults() {
    for (std::size_t i = 0; injector_ && i < injector_->hits().size(); ++i) {
        if (injector_->hits()[i] == 0) {
            warnings_.add("idle_fault", fmt::format("--inject '{}' met no sample", injector_->faults()[i].spec));
        }
    }
}

/// Takes one sample from the log to the estimator. @return false at the end of the log
bool Replay::pull() {
    ImuSample sample;
    StereoFrame frame;
    const AslDataset::Event event = log_.next(sample, frame);
    switch (event) {
        case AslDataset::Event::kImu: give(sample); break;
        case AslDataset::Event::kFrame: give(frame); break;
        case AslDataset::Event::kEnd:
            if (injector_) {
                injector_->finish();
            }
            break;
    }
    deliver_faulted();
    return event != AslDataset::Event::kEnd;
}

RunSummary Replay::run(const std::atomic<bool>& stop) {
    const auto begin = StageTimer::Clock::now();
    open_log();
    configure();
    std::optional<Progress> progress;
    if (options_.show_progress) {
        progress.emplace("replay", "frames", log_.frame_count());
        warnings_.set_progress(&*progress);
    }
    while (!(summary_.interrupted = stop.load()) && pull()) {
        if (progress) {
            progress->update(summary_.frames);
        }
    }
    if (!summary_.interrupted) {
        tell_idle_faults();
    }
    if (progress) {
        progress->finish();
    }
    warnings_.set_progress(nullptr);
    summary_.wall_s = std::chrono::duration<double>(StageTimer::Clock::now() - begin).count();
    summary_.warnings = warnings_.counts();
    trajectory_.close();
    timing_.close();
    health_.close();
    mesh_log_.close();
    plane_log_.close();
    plane_log_.write_planes(options_.out);
    run_mesh_.write(*mesher_, options_.out);
    summary_.mesh = mesher_->counters();
    summary_.planes = planes_->counters();
    summary_.mesh_vertices = mesher_->mesh().vertex_count();
    summary_.mesh_faces = mesher_->mesh().face_count();
    summary_.run_mesh_faces = run_mesh_.faces();
    warnings_.close();
    write_summary(summary_, options_.out);
    return summary_;
}

}  // namespace

RunSummary run_replay(const ReplayOptions& options, const std::atomic<bool>& stop) {
    make_folder(options.out);
    return Replay(options).run(stop);
}

}  // namespace facet
