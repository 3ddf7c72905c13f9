// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/replay.h"

#include <fmt/core.h>

#include <chrono>
#include <memory>
#include <optional>

#include "app/config/config_table.h"
#include "app/lab/check/start_check.h"
#include "app/lab/faults/calibration_error.h"
#include "app/lab/replay/extra_files.h"
#include "app/lab/replay/faulted_log.h"
#include "app/lab/replay/range_log.h"
#include "app/lab/replay/replay_output.h"
#include "app/lab/replay/turned_truth.h"
#include "app/lab/replay/waiting_frames.h"
#include "app/output/map_file.h"
#include "app/pipeline/carried_estimate.h"
#include "app/pipeline/frame_pipeline.h"
#include "app/pipeline/frame_recorder.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"
#include "platform/linux/linux_clock.h"

namespace facet {
namespace {

/// The calibration that the estimator is given: with the errors that faults ask for.
Calibration disturbed(const ReplayOptions& options) {
    Calibration calibration = options.calibration;
    for (const Fault& fault : options.faults) {
        if (fault.kind == FaultKind::kCalibration &&
            !add_calibration_error(fault.values[0], static_cast<std::uint64_t>(fault.values[1]), calibration.rig,
                                   word_of<ErrorDraw>(fault, 2))) {
            throw InputError(fmt::format("--inject '{}': no usable camera is left", fault.spec));
        }
    }
    return calibration;
}

/// One run: the log, the pipeline and the files it fills.
class Replay : private SampleReceiver {
public:
    explicit Replay(const ReplayOptions& options)
        : options_(options),
          recorder_(options.out, limits(options)),
          summary_(recorder_.summary()),
          output_(clock_, options.sink, options.in_real_time),
          log_(options, recorder_) {
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
    void prepare();
    void replace_by_truth();
    void play(const std::atomic<bool>& stop);
    bool pull(const std::atomic<bool>& stop);
    void take(const ImuSample& sample) override;
    void take(const StereoFrame& frame, Timestamp output_stamp) override;
    bool offer(const StereoFrame& frame, Timestamp output_stamp, bool is_last_chance);
    void pass_on();
    void give_up_waiting();

    const ReplayOptions& options_;
    FrameRecorder recorder_;
    RunSummary& summary_;  ///< the recorder's
    LinuxClock clock_;
    ReplayOutput output_;
    FaultedLog log_;
    RangeLog ranges_;
    Eigen::Vector3d newest_w_B_ = Eigen::Vector3d::Zero();  ///< given to the estimator
    SurfaceSinks surface_;
    FramePipeline pipeline_;
    FrameResult result_;
    std::unique_ptr<CarriedEstimate> carried_;  ///< none unless the trajectory is at the IMU's rate
    WaitingFrames waiting_;
    Timestamp newest_fed_;                   ///< latest inertial stamp that the estimator has
    std::optional<StartCheck> start_check_;  ///< of what the estimator is given
    std::optional<TruthInjector> truth_;     ///< none if all is to be as measured
    std::optional<ExtraFiles> extra_files_;
    std::optional<Progress> progress_;
};

RecorderLimits Replay::limits(const ReplayOptions& options) {
    constexpr RecorderLimits kEndless{.timed_frames = 2'000, .mesh_faces = 20'000, .map_faces = 500'000};
    return options.passes > 1 || options.loops > 1 ? kEndless : RecorderLimits{};
}

/// @return false if the frame has to wait for inertial samples, and still may
bool Replay::offer(const StereoFrame& frame, Timestamp output_stamp, bool is_last_chance) {
    while (const RangeSample* const sample = ranges_.next_before(frame.stamp)) {
        pipeline_.add_range(*sample);
    }
    pipeline_.add_frame(frame, output_stamp, result_);
    if (result_.status == Status::kNotReady && !is_last_chance && newest_fed_ < frame.stamp + kRetry) {
        return false;
    }
    if (carried_) {
        carried_->correct(result_.status, result_.estimate, pipeline_.belief());
    }
    recorder_.write(result_, pipeline_.departed());
    extra_files_->write(result_, pipeline_, frame);
    pass_on();
    return true;
}

/// Gives the sink the newest result, or only its state if poses go out at inertial samples.
void Replay::pass_on() {
    if (carried_) {
        output_.report(result_.estimate.health);
    } else {
        output_.give(result_, newest_w_B_, options_.calibration.noise);
    }
}

void Replay::take(const StereoFrame& frame, Timestamp output_stamp) {
    for (const CheckVerdict& verdict : start_check_->add(frame)) {
        recorder_.warn("calibration_check",
                       fmt::format("{}: {} (facet check-calibration says more)", verdict.name, verdict.sentence));
    }
    if (waiting_.empty() && offer(frame, output_stamp, false)) {
        return;
    }
    waiting_.add(frame, output_stamp);
    while (waiting_.is_overdue()) {
        (void)offer(waiting_.front().view(), waiting_.front().output_stamp, true);
        waiting_.pop();
    }
}

void Replay::take(const ImuSample& sample) {
    pipeline_.add_imu(sample);
    newest_fed_ = sample.stamp;
    newest_w_B_ = options_.config.imu_model.corrected(sample).w_B;
    if (carried_ && carried_->add_imu(sample)) {
        const Estimate estimate = carried_->estimate();
        if (is_usable(estimate.health.state)) {
            recorder_.write_carried(estimate);
        }
        output_.give(estimate, newest_w_B_, options_.calibration.noise);
    }
    if (pipeline_.take_carried(result_)) {
        if (carried_) {
            carried_->correct(result_.status, result_.estimate, pipeline_.belief());
        }
        recorder_.write(result_, {});
        pass_on();
    }
    while (!waiting_.empty() && offer(waiting_.front().view(), waiting_.front().output_stamp, false)) {
        waiting_.pop();
    }
}

/// No inertial samples will come.
void Replay::give_up_waiting() {
    for (; !waiting_.empty(); waiting_.pop()) {
        (void)offer(waiting_.front().view(), waiting_.front().output_stamp, true);
    }
}

/// Takes one sample from the log to the estimator. @return false at the end of the log
bool Replay::pull(const std::atomic<bool>& stop) {
    const bool is_more = log_.read();
    if (const std::optional<Timestamp> stamp = log_.inertial_stamp()) {
        output_.wait_for(*stamp, stop);
    }
    log_.deliver(*this);
    return is_more;
}

void Replay::prepare() {
    log_.open();
    const Calibration given = disturbed(options_);
    if (options_.config.range.enabled) {
        ranges_ = RangeLog(options_.dataset, options_.files);
        if (ranges_.size() == 0) {
            throw InputError(options_.dataset + ": range.enabled, but there is no range0/data.csv with readings");
        }
    }
    pipeline_.configure(options_.config, given);
    pipeline_.stream_to(options_.world);
    for (FlightViewer* const viewer : options_.viewers) {
        pipeline_.show_to(viewer);
    }
    recorder_.open();
    if (log_.faults() != nullptr) {
        write_turned_truth(options_.truth_folder.empty() ? options_.dataset : options_.truth_folder, *log_.faults(),
                           options_.out + "/groundtruth.csv");
    }
    start_check_.emplace(given.rig);
    extra_files_.emplace(options_, given.rig);
    surface_.add(&recorder_.surface());
    surface_.add(options_.surface);
    pipeline_.keep_map(&surface_);
    if (options_.write_rays) {
        pipeline_.keep_grid();
    }
    if (options_.keep_places) {
        const auto known = options_.load_map.empty() ? std::vector<MappedPlace>() : read_map(options_.load_map);
        pipeline_.remember_places(known);
    }
    if (options_.at_imu_rate) {
        carried_ = std::make_unique<CarriedEstimate>(options_.config);
        recorder_.write_trajectory_at_samples();
    }
    if (options_.truth.any()) {
        replace_by_truth();
    }
    if (options_.show_progress) {
        progress_.emplace("replay", "frames", log_.frame_count() * static_cast<std::size_t>(options_.passes));
        recorder_.warnings()->set_progress(&*progress_);
    }
}

void Replay::replace_by_truth() {
    truth_.emplace(options_.truth_folder.empty() ? options_.dataset : options_.truth_folder, options_.calibration.rig,
                   options_.truth);
    log_.correct_by(&*truth_);
    pipeline_.set_observation_hook(&*truth_);
    pipeline_.set_plane_source([this](const KeyframeView& view, const PlaneProposals& found) -> const PlaneProposals& {
        return truth_->propose(view, found);
    });
}

/// All passes, or up to the frame at which it is told to stop.
void Replay::play(const std::atomic<bool>& stop) {
    for (int pass = 1;; ++pass) {
        bool is_more = true;
        while (!(summary_.interrupted = stop.load()) && is_more && !(log_.is_out_of_frames() && waiting_.empty())) {
            is_more = pull(stop);
            if (progress_) {
                progress_->update(summary_.frames);
            }
        }
        if (summary_.interrupted) {
            return;
        }
        if (is_more) {
            log_.end(*this);
        }
        give_up_waiting();
        log_.tell_idle_faults();
        if (pass >= options_.passes) {
            return;
        }
        log_.open_again();
    }
}

RunSummary Replay::run(const std::atomic<bool>& stop) {
    const auto begin = std::chrono::steady_clock::now();
    prepare();
    play(stop);
    if (progress_) {
        progress_->finish();
    }
    recorder_.warnings()->set_progress(nullptr);
    summary_.greatest_lag_s = output_.greatest_lag().seconds();
    summary_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    pipeline_.finish_places();
    pipeline_.finish_map();
    recorder_.finish(pipeline_, pipeline_.map());
    extra_files_->finish(result_, pipeline_);
    return summary_;
}

}  // namespace

RunSummary run_replay(const ReplayOptions& options, const std::atomic<bool>& stop) { return Replay(options).run(stop); }

}  // namespace facet
