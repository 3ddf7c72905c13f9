// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/replay.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <list>
#include <memory>
#include <optional>
#include <variant>

#include "app/config/config_table.h"
#include "app/lab/check/start_check.h"
#include "app/lab/faults/calibration_error.h"
#include "app/lab/faults/fault_injector.h"
#include "app/lab/faults/image_faults.h"
#include "app/lab/fusion/mesh_fusion.h"
#include "app/lab/replay/calibration_log.h"
#include "app/lab/replay/grid_picture.h"
#include "app/lab/replay/log_options.h"
#include "app/lab/replay/ray_log.h"
#include "app/lab/replay/replay_output.h"
#include "app/lab/replay/sweep_log.h"
#include "app/lab/replay/turned_truth.h"
#include "app/pipeline/carried_estimate.h"
#include "app/pipeline/frame_pipeline.h"
#include "app/pipeline/frame_recorder.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "platform/linux/linux_clock.h"

namespace facet {
namespace {

constexpr std::size_t kMaxWaiting = 256;  // frames: more than a second of a fast camera, 180 MB of EuRoC's

/// The calibration that the estimator is given: with the errors that faults ask for.
Calibration disturbed(const ReplayOptions& options) {
    Calibration calibration = options.calibration;
    for (const Fault& fault : options.faults) {
        if (fault.kind == FaultKind::kCalibration &&
            !add_calibration_error(fault.values[0], static_cast<std::uint64_t>(fault.values[1]), calibration.rig)) {
            throw InputError(fmt::format("--inject '{}': no usable camera is left", fault.spec));
        }
    }
    return calibration;
}

std::vector<Fault> faults_of_samples(const std::vector<Fault>& faults) {
    std::vector<Fault> chosen;
    std::copy_if(faults.begin(), faults.end(), std::back_inserter(chosen), is_of_samples);
    return chosen;
}

/// One run: the log, the faults put into it, the pipeline and the files it fills.
class Replay {
public:
    explicit Replay(const ReplayOptions& options)
        : options_(options),
          recorder_(options.out, limits(options)),
          summary_(recorder_.summary()),
          output_(clock_, options.sink, options.in_real_time) {
        summary_.dataset = options.dataset;
        summary_.mode = to_string(options.config.regularity.mode);
        summary_.parameters = changed_parameters(options.config);
        summary_.calibration = options.calibration.source;
        summary_.start_s = options.start_s;
        for (const Fault& fault : options.faults) {
            summary_.faults.push_back(fault.spec);
        }
    }

    RunSummary run(const std::atomic<bool>& stop);

private:
    static RecorderLimits limits(const ReplayOptions& options);
    void open_log();
    bool pull(const std::atomic<bool>& stop);
    void give(ImuSample sample);
    void give(StereoFrame frame);
    void deliver_faulted();
    void tell_idle_faults();
    void feed(const ImuSample& sample);
    void feed(const StereoFrame& frame, Timestamp output_stamp);
    bool offer(const StereoFrame& frame, Timestamp output_stamp, bool is_last_chance);
    void pass_on();
    void fuse(const StereoFrame& frame);
    void give_up_waiting();
    void warn(const AslWarning& warning);

    const ReplayOptions& options_;
    FrameRecorder recorder_;
    RunSummary& summary_;  ///< the recorder's
    LinuxClock clock_;
    ReplayOutput output_;
    Eigen::Vector3d newest_w_B_ = Eigen::Vector3d::Zero();  ///< given to the estimator
    std::optional<AslDataset> log_;
    Duration pass_shift_{};  ///< of all stamps in this pass
    Timestamp newest_;       ///< latest stamp given
    FramePipeline pipeline_;
    FrameResult result_;
    std::unique_ptr<CarriedEstimate> carried_;   ///< none unless the trajectory is at the IMU's rate
    std::list<OwnedFrame> waiting_;              ///< for inertial samples
    std::list<OwnedFrame> spare_;                ///< have waited: their storage serves the next ones
    Timestamp newest_fed_;                       ///< of these, the latest that the estimator has
    std::optional<FaultInjector> injector_;      ///< none without faults
    std::optional<StartCheck> start_check_;      ///< of what the estimator is given
    std::optional<TruthInjector> truth_;         ///< none if all is to be as measured
    std::optional<RayLog> rays_;                 ///< none unless asked for
    std::optional<SweepLog> sweeps_;             ///< as rays_
    std::optional<MeshFusion> fusion_;           ///< the same
    std::optional<CalibrationLog> corrections_;  ///< the same
};

RecorderLimits Replay::limits(const ReplayOptions& options) {
    constexpr RecorderLimits kEndless{.timed_frames = 2'000, .mesh_faces = 20'000};
    return options.passes > 1 || options.loops > 1 ? kEndless : RecorderLimits{};
}

void Replay::open_log() {
    AslOptions log_options = log_options_of(options_.calibration);
    log_options.files = options_.files;
    log_options.loops = options_.loops;
    log_options.start = Duration::from_seconds(options_.start_s);
    if (options_.duration_s.has_value()) {
        log_options.length = Duration::from_seconds(*options_.duration_s);
    }
    std::string error;
    const std::size_t rows_skipped = summary_.rows_skipped;
    log_.emplace();
    if (!ok(log_->open(
            options_.dataset, log_options, [this](const AslWarning& w) { warn(w); }, error))) {
        throw InputError(error);
    }
    if (log_->frame_count() == 0) {
        throw InputError(fmt::format("{}: no frame between --start and its --duration", options_.dataset));
    }
    // A left row that was skipped is a frame all the same; the right view may have made one of it already.
    const std::size_t skipped = summary_.rows_skipped - rows_skipped;
    summary_.frames_listed += log_->frame_count() + skipped - std::min(skipped, log_->right_only_count());
    const std::vector<Fault> faults = faults_of_samples(options_.faults);
    if (!faults.empty()) {
        injector_.emplace(faults, options_.calibration.noise, options_.calibration.rig,
                          log_->log_begin() + pass_shift_ + log_options.start);
    }
}

void Replay::warn(const AslWarning& warning) {
    const bool is_row_skipped = warning.kind == AslWarningKind::kMalformedRow ||
                                warning.kind == AslWarningKind::kOutOfOrder ||
                                warning.kind == AslWarningKind::kDuplicate;
    if (is_row_skipped && warning.file.ends_with("cam0/data.csv")) {
        ++summary_.rows_skipped;
    }
    recorder_.warn(to_string(warning.kind), warning.text());
}

/// @return false if the frame has to wait for inertial samples, and still may
bool Replay::offer(const StereoFrame& frame, Timestamp output_stamp, bool is_last_chance) {
    pipeline_.add_frame(frame, output_stamp, result_);
    if (result_.status == Status::kNotReady && !is_last_chance && newest_fed_ < frame.stamp + kRetry) {
        return false;
    }
    if (carried_) {
        carried_->correct(result_.status, result_.estimate, pipeline_.belief());
    }
    recorder_.write(result_, pipeline_.departed());
    if (rays_) {
        rays_->write(result_, pipeline_);
        sweeps_->write(result_, pipeline_);
    }
    fuse(frame);
    if (corrections_) {
        corrections_->write(result_, pipeline_);
    }
    pass_on();
    return true;
}

void Replay::fuse(const StereoFrame& frame) {
    if (!fusion_ || !result_.is_usable) {
        return;
    }
    if (result_.has_mesh) {
        const MeshedKeyframe& keyframe = pipeline_.meshed();
        fusion_->add(pipeline_.keyframe_view(), keyframe.reset_counter, keyframe.frame.left, keyframe.frame.right,
                     pipeline_.mesher());
    }
    if (!result_.is_keyframe) {
        const std::uint32_t resets = result_.estimate.health.reset_counter;
        const NavState& state = result_.estimate.state;
        fusion_->add_between(Se3{state.q_W_B, state.p_W_B} * pipeline_.rig().T_B_C0, resets, frame.left, frame.right);
    }
}

/// Gives the sink the newest result, or only its state if poses go out at inertial samples.
void Replay::pass_on() {
    if (carried_) {
        output_.report(result_.estimate.health);
    } else {
        output_.give(result_, newest_w_B_, options_.calibration.noise);
    }
}

void Replay::feed(const StereoFrame& frame, Timestamp output_stamp) {
    for (const CheckVerdict& verdict : start_check_->add(frame)) {
        recorder_.warn("calibration_check",
                       fmt::format("{}: {} (facet check-calibration says more)", verdict.name, verdict.sentence));
    }
    if (waiting_.empty() && offer(frame, output_stamp, false)) {
        return;
    }
    if (spare_.empty()) {
        spare_.emplace_back();
    }
    waiting_.splice(waiting_.end(), spare_, spare_.begin());
    OwnedFrame& kept = waiting_.back();
    kept.stamp = frame.stamp;
    kept.output_stamp = output_stamp;
    kept.has_left = !frame.left.empty();
    kept.has_right = !frame.right.empty();
    copy_image(frame.left, kept.left);
    copy_image(frame.right, kept.right);
    // A clock may have stopped, or jumped for an hour: what waits for it must not hold up those that come later.
    const auto is_in_vain = [](Duration apart) { return apart > kRetry || apart < Duration{-kRetry.ns}; };
    while (waiting_.size() > kMaxWaiting || is_in_vain(waiting_.back().stamp - waiting_.front().stamp)) {
        (void)offer(waiting_.front().view(), waiting_.front().output_stamp, true);
        waiting_.pop_front();
    }
}

void Replay::feed(const ImuSample& sample) {
    pipeline_.add_imu(sample);
    newest_fed_ = sample.stamp;
    newest_w_B_ = sample.w_B;
    if (carried_ && carried_->add_imu(sample)) {
        const Estimate estimate = carried_->estimate();
        if (is_usable(estimate.health.state)) {
            recorder_.write_carried(estimate);
        }
        output_.give(estimate, sample.w_B, options_.calibration.noise);
    }
    if (pipeline_.take_carried(result_)) {
        if (carried_) {
            carried_->correct(result_.status, result_.estimate, pipeline_.belief());
        }
        recorder_.write(result_, {});
        pass_on();
    }
    while (!waiting_.empty() && offer(waiting_.front().view(), waiting_.front().output_stamp, false)) {
        spare_.splice(spare_.end(), waiting_, waiting_.begin());
    }
}

/// No inertial samples will come.
void Replay::give_up_waiting() {
    for (const OwnedFrame& frame : waiting_) {
        (void)offer(frame.view(), frame.output_stamp, true);
    }
    waiting_.clear();
}

void Replay::give(ImuSample sample) {
    if (truth_) {
        truth_->correct(sample);
    }
    sample.stamp = sample.stamp + pass_shift_;
    newest_ = sample.stamp;
    if (injector_) {
        injector_->add(sample);
    } else {
        feed(sample);
    }
}

void Replay::give(StereoFrame frame) {
    frame.stamp = frame.stamp + pass_shift_;
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
            recorder_.warn("idle_fault", fmt::format("--inject '{}' met no sample", injector_->faults()[i].spec));
        }
    }
}

/// Takes one sample from the log to the estimator. @return false at the end of the log
bool Replay::pull(const std::atomic<bool>& stop) {
    ImuSample sample;
    StereoFrame frame;
    const AslDataset::Event event = log_->next(sample, frame);
    switch (event) {
        case AslDataset::Event::kImu:
            output_.wait_for(sample.stamp + pass_shift_, stop);
            give(sample);
            break;
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
    const auto begin = std::chrono::steady_clock::now();
    open_log();
    const Calibration given = disturbed(options_);
    pipeline_.configure(options_.config, given);
    pipeline_.stream_to(options_.world);
    for (FlightViewer* const viewer : options_.viewers) {
        pipeline_.show_to(viewer);
    }
    recorder_.open();
    if (injector_) {
        write_turned_truth(options_.truth_folder.empty() ? options_.dataset : options_.truth_folder, *injector_,
                           options_.out + "/groundtruth.csv");
    }
    start_check_.emplace(given.rig);
    if (options_.write_rays) {
        pipeline_.keep_grid();
        rays_.emplace(options_.out);
        sweeps_.emplace(options_.out);
    }
    if (options_.write_fused) {
        fusion_.emplace(given.rig);
    }
    if (options_.write_calibration) {
        corrections_.emplace(options_.out);
    }
    if (options_.at_imu_rate) {
        carried_ = std::make_unique<CarriedEstimate>(options_.config);
        recorder_.write_trajectory_at_samples();
    }
    if (options_.truth.any()) {
        truth_.emplace(options_.truth_folder.empty() ? options_.dataset : options_.truth_folder,
                       options_.calibration.rig, options_.truth);
        pipeline_.set_observation_hook(&*truth_);
        pipeline_.set_plane_source(
            [this](const KeyframeView& view, const PlaneProposals& found) -> const PlaneProposals& {
                return truth_->propose(view, found);
            });
    }
    std::optional<Progress> progress;
    if (options_.show_progress) {
        progress.emplace("replay", "frames", log_->frame_count() * static_cast<std::size_t>(options_.passes));
        recorder_.warnings()->set_progress(&*progress);
    }
    for (int pass = 1;; ++pass) {
        while (!(summary_.interrupted = stop.load()) && pull(stop)) {
            if (progress) {
                progress->update(summary_.frames);
            }
        }
        if (summary_.interrupted) {
            break;
        }
        give_up_waiting();
        tell_idle_faults();
        if (pass >= options_.passes) {
            break;
        }
        pass_shift_ = newest_ + kSeam - (log_->log_begin() + Duration::from_seconds(options_.start_s));
        open_log();
    }
    if (progress) {
        progress->finish();
    }
    recorder_.warnings()->set_progress(nullptr);
    summary_.greatest_lag_s = output_.greatest_lag().seconds();
    summary_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    recorder_.finish(pipeline_);
    if (rays_) {
        rays_->close();
        sweeps_->close();
        if (pipeline_.grid() != nullptr) {
            write_grid_picture(*pipeline_.grid(), result_.estimate.state.p_W_B, options_.out + "/grid.png");
        }
    }
    if (fusion_) {
        fusion_->write(options_.out + "/mesh_fused.ply");
    }
    if (corrections_) {
        corrections_->close();
    }
    return summary_;
}

}  // namespace

RunSummary run_replay(const ReplayOptions& options, const std::atomic<bool>& stop) { return Replay(options).run(stop); }

}  // namespace facet
