// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/output_threads.h"

#include <algorithm>
#include <exception>

namespace facet {
namespace {

constexpr Duration kPoll = Duration::from_seconds(0.1);
constexpr Duration kWatch = Duration::from_seconds(0.05);  // longest time between two looks at what may hang
constexpr int kStalledQuality = 30;
constexpr Duration kFlushPeriod = Duration::from_seconds(1.0);
constexpr std::size_t kShownEvents = 6;
constexpr auto kLoose = std::memory_order_relaxed;

}  // namespace

OutputThreads::OutputThreads(const Clock& clock, const ProgramConfig& config, const VehicleOdometry& odometry,
                             std::vector<OdometrySink*> sinks, FrameRecorder& recorder, std::vector<EventQueue*> events,
                             std::size_t keep_latencies)
    : clock_(clock),
      stream_(config, odometry),
      sinks_(std::move(sinks)),
      recorder_(recorder),
      events_(std::move(events)),
      keep_latencies_(keep_latencies),
      watch_(clock),
      readings_(clock),
      sending_(clock),
      lost_after_s_(config.health.lost_after_s),
      next_flush_(clock.now()) {
    events_.push_back(&reports_);
    events_.push_back(&stall_reports_);
    batch_.reserve(decltype(faces_)::capacity());
    latencies_ms_.reserve(std::min<std::size_t>(keep_latencies, 1U << 17U));
}

void OutputThreads::on_sample(const ImuSample& sample) {
    counters_.poses_dropped.fetch_add(ok(samples_.push(sample)) ? 0 : 1, kLoose);
    readings_.beat();
    pose_wakeup_.notify();
}

void OutputThreads::on_estimate(const FrameResult& frame, const Belief& belief, const Eigen::Vector3d& w_B) {
    const FrameOutcome outcome{frame.status, frame.has_frame, frame.frame_stamp, frame.estimate, belief,
                               w_B,          frame.T_M_W};
    counters_.poses_dropped.fetch_add(ok(outcomes_.push(outcome)) ? 0 : 1, kLoose);
    pose_wakeup_.notify();
    watch_.beat();
}

void OutputThreads::on_frame(const FrameResult& frame, std::span<const DepartedFace> departed) {
    news_.on_frame(frame);
    pose_wakeup_.notify();
    std::uint64_t lost = 0;
    for (const DepartedFace& face : departed) {
        lost += ok(faces_.push(face)) ? 0 : 1;
    }
    counters_.faces_dropped.fetch_add(lost, kLoose);
    counters_.frames_dropped.fetch_add(ok(frame_queue_.push(frame)) ? 0 : 1, kLoose);
    frames_.fetch_add(frame.has_frame && ok(frame.status) ? 1 : 0, kLoose);
    watch_.beat();
    frame_wakeup_.notify();
}

void OutputThreads::on_report(const SyncReport& report) {
    const char* camera = report.camera == SyncCamera::kLeft    ? "left camera: "
                         : report.camera == SyncCamera::kRight ? "right camera: "
                                                               : "";
    (void)reports_.push(RunEvent::make("synchroniser", "synchroniser: {}{} (value {}, at {} ns)", camera,
                                       to_string(report.fault), report.value, report.stamp.ns));
    frame_wakeup_.notify();
}

void OutputThreads::keep_latency(double latency_ms) {
    const std::lock_guard lock(mutex_);
    recent_ms_.push(latency_ms);
    if (latencies_ms_.size() < keep_latencies_) {
        latencies_ms_.push_back(latency_ms);
    } else if (keep_latencies_ > 0) {
        latencies_ms_[oldest_latency_] = latency_ms;
        oldest_latency_ = (oldest_latency_ + 1) % keep_latencies_;
    }
}

void OutputThreads::send(const Odometry& odometry) {
    for (OdometrySink* sink : sinks_) {
        counters_.refused.fetch_add(ok(sink->send(odometry)) ? 0 : 1, kLoose);
    }
    counters_.poses_sent.fetch_add(1, kLoose);
    if (unsent_frame_) {
        keep_latency((clock_.now() - *unsent_frame_).seconds() * 1e3);
        unsent_frame_.reset();
    }
}

/// Takes the samples that have come, then one frame's outcome. @return whether there was one
bool OutputThreads::carry_on() {
    // The outcome first: the samples that it needs are then in their queue.
    const bool any = ok(outcomes_.pop(outcome_));
    Odometry odometry;
    for (ImuSample sample; ok(samples_.pop(sample));) {
        if (stream_.add_imu(sample, odometry)) {
            send(odometry);
        }
    }
    if (!any) {
        return false;
    }
    const bool is_to_be_sent = stream_.add_frame(outcome_, odometry);
    if (outcome_.has_frame && ok(outcome_.status) && outcome_.estimate.health.state != TrackingState::kInit) {
        unsent_frame_ = outcome_.frame_stamp;
    }
    if (is_to_be_sent) {
        send(odometry);
    }
    return true;
}

/// Poses go on with the last health but for the state: of what is no frame, only the health counts.
void OutputThreads::mark_stalled(TrackingState state) {
    stalled_ = state;
    FrameOutcome outcome = outcome_;
    outcome.status = Status::kIo;
    Health& health = outcome.estimate.health;
    health.state = state;
    health.reasons |= stall_reason_;
    health.quality = state == TrackingState::kLost ? 0 : std::min(health.quality, kStalledQuality);
    Odometry unused;
    (void)stream_.add_frame(outcome, unused);
    SinkNews::report(sinks_, state, health.reasons);
}

void OutputThreads::add_end(Health& health) const {
    if (stalled_) {
        health.state = *stalled_;
        health.reasons |= stall_reason_;
    }
}

/// Readings that come again do not make a state yet: the next frame does.
void OutputThreads::end_stall() {
    if (!stalled_ || (stall_reason_ == kReasonImuGap && outcome_.frame_stamp == stalled_at_)) {
        return;
    }
    stalled_.reset();
    if (stall_reason_ == kReasonStalled) {
        (void)stall_reports_.push(RunEvent::make("estimator_stalled", "estimator: works again"));
        frame_wakeup_.notify();
    }
    SinkNews::report(sinks_, outcome_.estimate.health.state, outcome_.estimate.health.reasons);
}

/// A thread that hangs cannot say so itself, nor be ended: see hanging_thread(). Without readings no frame is ever
/// complete, so that no estimate says so either.
void OutputThreads::watch() {
    if (!watch_.is_awaited()) {
        return;
    }
    const bool hangs = watch_.silence().has_value();
    const std::optional<Duration> silence = hangs ? watch_.silence() : readings_.silence();
    if (!silence) {
        end_stall();
        return;
    }
    if (!is_usable(outcome_.estimate.health.state)) {
        return;  // nobody is misled
    }
    if (!stalled_) {
        stall_reason_ = hangs ? kReasonStalled : kReasonImuGap;
        stalled_at_ = outcome_.frame_stamp;
    }
    if (!stalled_ && hangs) {  // the silence of a sensor is reported by its thread
        (void)stall_reports_.push(RunEvent::make("estimator_stalled",
                                                 "estimator: no sign of life for {} ms; poses go on without it",
                                                 silence->ns / 1'000'000));
        frame_wakeup_.notify();
    }
    const bool is_lost = silence->seconds() > lost_after_s_;
    if (const TrackingState state = is_lost ? TrackingState::kLost : TrackingState::kDegraded; stalled_ != state) {
        mark_stalled(state);
    }
}

const char* OutputThreads::silent_thread() const {
    return !readings_.is_awaited() || readings_.silence() ? "imu"
           : watch_.silence()                             ? "estimator"
           : sending_.silence()                           ? "sinks"
                                                          : nullptr;
}

const char* OutputThreads::hanging_thread() const {
    const auto hangs = [this](const StallWatch& watch) {
        const std::optional<Duration> silence = watch.silence();
        return silence && silence->seconds() > lost_after_s_;
    };
    return hangs(watch_) ? "estimator" : hangs(sending_) ? "sinks" : nullptr;
}

void OutputThreads::send_poses(const std::atomic<bool>& stopping) {
    for (;;) {
        const bool last = stopping.load(std::memory_order_acquire);
        sending_.beat();
        watch();  // before the samples that have come are sent
        while (carry_on()) {
        }
        if (last) {
            news_.pass_on(sinks_);
            sending_.end();
            return;
        }
        const Duration wait = news_.pass_on(sinks_);
        (void)pose_wakeup_.wait(std::min(wait, kWatch));
    }
}

/// Calls a function of the recorder unless it has failed before.
template <class Function>
void OutputThreads::guarded(Function function) {
    if (!failure_.empty()) {
        return;
    }
    try {
        function();
    } catch (const std::exception& e) {
        failure_ = e.what();
        const std::lock_guard lock(mutex_);
        status_.events.push_back(failure_ + "; nothing more is written");
    }
}

bool OutputThreads::write_events() {
    bool any = false;
    RunEvent event;
    for (EventQueue* queue : events_) {
        while (ok(queue->pop(event))) {
            any = true;
            guarded([&] { recorder_.warn(event.kind.data(), event.text.data()); });
            const std::lock_guard lock(mutex_);
            status_.events.emplace_back(event.text.data());
            if (status_.events.size() > kShownEvents) {
                status_.events.erase(status_.events.begin());
            }
        }
    }
    return any;
}

void OutputThreads::publish(const FrameResult& frame) {
    const std::lock_guard lock(mutex_);
    status_.frames += frame.has_frame ? 1 : 0;
    status_.health = frame.estimate.health;
    if (frame.is_usable) {
        status_.p_W_B = frame.estimate.state.p_W_B;
        status_.speed_m_per_s = frame.estimate.state.v_W_B.norm();
    }
    status_.total_ms = frame.has_frame ? frame.timing.total.wall_ms : status_.total_ms;
    if (frame.has_mesh) {
        status_.planes = frame.planes.size();
        status_.mesh_faces = frame.mesh_faces;
    }
}

/// Writes one frame, if there is one.
bool OutputThreads::write_once() {
    if (!ok(frame_queue_.pop(frame_))) {
        return false;
    }
    // Faces come before their frame; those of later frames may be among them, which does not matter.
    batch_.clear();
    for (DepartedFace face; batch_.size() < batch_.capacity() && ok(faces_.pop(face));) {
        batch_.push_back(face);
    }
    guarded([&] {
        recorder_.collect(batch_);
        recorder_.write(frame_, {});
    });
    publish(frame_);
    return true;
}

void OutputThreads::write_files(const std::atomic<bool>& stopping) {
    for (;;) {
        const bool last = stopping.load(std::memory_order_acquire);
        bool any = write_events();
        while (write_once()) {
            any = write_events() || any;
        }
        if (clock_.now() >= next_flush_ || last) {
            next_flush_ = clock_.now() + kFlushPeriod;
            guarded([&] { recorder_.flush(); });
        }
        if (last) {
            return;
        }
        if (!any) {
            (void)frame_wakeup_.wait(kPoll);
        }
    }
}

FrameStatus OutputThreads::status() const {
    const std::lock_guard lock(mutex_);
    FrameStatus status = status_;
    std::vector<double> recent;
    for (std::size_t i = 0; i < recent_ms_.size(); ++i) {
        recent.push_back(recent_ms_[i]);
    }
    const TimingStatistics latency = timing_statistics(std::move(recent));
    status.latency_median_ms = latency.median_ms;
    status.latency_p99_ms = latency.p99_ms;
    return status;
}

}  // namespace facet
