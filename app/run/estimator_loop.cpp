// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/estimator_loop.h"

#include <utility>

namespace facet {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;
/// The estimated time offset may put a frame after its stamp: it is offered again until samples are this far past it.
constexpr Duration kMaxRetry = Duration::from_seconds(0.2);

}  // namespace

EstimatorLoop::EstimatorLoop(const EstimatorLoopOptions& options, const Clock& clock, FramePipeline& pipeline,
                             RunQueues& queues, LoopOutput& output)
    : options_(options), clock_(clock), pipeline_(pipeline), intake_(options, queues), output_(output) {}

/// Passes on what the synchroniser has found.
void EstimatorLoop::pass_on_reports() {
    for (SyncReport report; ok(intake_.sync().pop_report(report));) {
        output_.on_report(report);
    }
    intake_.publish(counters_.findings);
}

void EstimatorLoop::hold(const ImuSample& sample) {
    if (held_.full()) {
        feed_next();
    }
    held_.push(sample);
    newest_ = sample;
}

/// Gives the oldest sample held to the estimator.
void EstimatorLoop::feed_next() {
    fed_ = held_.front();
    held_.pop_front();
    any_fed_ = true;
    pipeline_.add_imu(fed_);
    if (pipeline_.take_carried(result_)) {
        output_.on_estimate(result_, pipeline_.belief(), pipeline_.imu_model().corrected(fed_).w_B);
        output_.on_frame(result_, {});
    }
}

void EstimatorLoop::feed_until(Timestamp stamp) {
    while (!held_.empty() && (!any_fed_ || fed_.stamp < stamp)) {
        feed_next();
    }
}

/// Offers the pending frame to the estimator. @return whether it was used
bool EstimatorLoop::try_frame() {
    const Timestamp stamp = pending_->stamp + options_.camera_time_shift;
    const Timestamp begin = clock_.now();
    const StereoFrame frame{stamp, pending_->left.image, pending_->right.image, pending_->is_by_stamps};
    feed_until(stamp);
    intake_.take_ranges(stamp, [this](const RangeSample& sample) { pipeline_.add_range(sample); });
    pipeline_.estimate_frame(frame, stamp, result_);
    while (result_.status == Status::kNotReady && !held_.empty()) {
        feed_next();
        pipeline_.estimate_frame(frame, stamp, result_);
    }
    if (result_.status == Status::kNotReady && newest_.stamp < stamp + kMaxRetry) {
        return false;
    }
    output_.on_estimate(result_, pipeline_.belief(), pipeline_.imu_model().corrected(fed_).w_B);
    pipeline_.finish_frame(frame, result_);
    (ok(result_.status) ? counters_.used : counters_.refused).fetch_add(1, kRelaxed);
    if (clock_.now() - begin > options_.sync.period) {
        counters_.overruns.fetch_add(1, kRelaxed);
        pipeline_.report_overrun();
    }
    const Health& health = result_.estimate.health;
    intake_.sync().add_offset(pending_->stamp, Duration::from_seconds(health.time_offset_s),
                              Duration::from_seconds(health.time_offset_sigma_s));
    output_.on_frame(result_, pipeline_.departed());
    pending_.reset();
    return true;
}

bool EstimatorLoop::give_frames() {
    bool any = false;
    SyncedFrame frame;
    while (intake_.pop(frame)) {
        any = true;
        counters_.paired.fetch_add(1, kRelaxed);
        if (pending_) {
            counters_.late.fetch_add(1, kRelaxed);
        }
        pending_ = std::move(frame);
    }
    if (pending_ && (any || !held_.empty())) {
        any = try_frame() || any;
    }
    pass_on_reports();
    return any;
}

bool EstimatorLoop::step() {
    bool any = intake_.take_edges() > 0;
    any = intake_.take_images([this] { pass_on_reports(); }) || any;
    any = intake_.take_inertial([this](const ImuSample& sample) { hold(sample); }) > 0 || any;
    any = give_frames() || any;
    while (!held_.empty() && newest_.stamp - held_.front().stamp > options_.max_hold) {
        feed_next();
    }
    return any;
}

void EstimatorLoop::finish() {
    while (step()) {
    }
    drop_frame();
}

bool EstimatorLoop::drop_frame() {
    if (!pending_) {
        return false;
    }
    counters_.late.fetch_add(1, kRelaxed);
    pending_.reset();
    return true;
}

}  // namespace facet
