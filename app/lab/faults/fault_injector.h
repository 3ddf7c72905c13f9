// SPDX-License-Identifier: BSD-2-Clause
// Puts faults between a log and the estimator: what the log gives goes in, what faulty sensors would deliver comes out.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <variant>
#include <vector>

#include "app/lab/faults/fault_schedule.h"
#include "app/lab/faults/frame_faults.h"
#include "app/lab/faults/inertial_faults.h"
#include "app/lab/faults/owned_frame.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/imu_noise.h"
#include "platform/base/samples.h"

namespace facet {

/// Applies faults to samples. Usage, in the order in which the log gives samples:
///   injector.add(sample);                       // or a frame; finish() at the end of the log
///   while (auto* out = injector.front()) { ... std::get_if<ImuSample>(out) ...; injector.pop(); }
/// A frame comes out when the inertial samples that came out reach the stamp it states, as the estimator needs it, but
/// after kMaxWait at the latest, as from a synchroniser that gives up. All of it is deterministic: noise and losses
/// depend on the number of the sample only. What sensors see and read is changed by FrameFaults and InertialFaults;
/// what arrives, when and under which stamp is decided here. Thread-bound. Heap: as many frames as wait.
class FaultInjector {
public:
    using Delivery = std::variant<ImuSample, OwnedFrame>;
    static constexpr Duration kMaxWait{1'000'000'000};

    /// @param noise  calibrated densities, for imu_noise
    /// @param rig    for mover and vibration
    /// @param begin  instant from which the faults' times count
    FaultInjector(std::vector<Fault> faults, const ImuNoise& noise, const StereoRig& rig, Timestamp begin);
    FaultInjector(const FaultInjector&) = delete;
    FaultInjector& operator=(const FaultInjector&) = delete;

    void add(const ImuSample& sample);
    void add(const StereoFrame& frame);
    /// The log is over: what still waits comes out.
    void finish();

    /// Whether a frame waits for inertial samples, or for the next frame.
    bool holds_frames() const { return !waiting_.empty() || late_frame_.has_value(); }

    /// What comes out next, nullptr if nothing does yet. Valid until pop().
    const Delivery* front() const { return out_.empty() ? nullptr : &out_.front(); }
    void pop() { out_.pop_front(); }

    /// As FrameFaults has them.
    bool turns_images() const { return images_.turns_images(); }
    Eigen::Vector3d turn_at(Timestamp log_stamp) { return images_.turn_at(log_stamp); }

    /// For each fault, in order, the samples or frames it has changed or swallowed.
    const std::vector<std::size_t>& hits() const { return schedule_.hits(); }
    const std::vector<Fault>& faults() const { return schedule_.faults(); }

private:
    bool is_thinned(FaultKind kind, Timestamp log_stamp, std::uint64_t number);
    bool is_lost(const OwnedFrame& frame);
    bool is_doubled(FaultKind kind, Timestamp log_stamp, std::uint64_t number);
    void deliver(const ImuSample& sample, Timestamp log_stamp);
    void emit(const ImuSample& sample);
    void deliver(OwnedFrame frame);
    void release(Timestamp log_now);

    FaultSchedule schedule_;
    InertialFaults inertial_;
    FrameFaults images_;
    std::uint64_t imu_count_ = 0;
    std::uint64_t frame_count_ = 0;
    bool has_imu_ = false;
    Timestamp newest_imu_;                  ///< latest inertial stamp that came out
    std::optional<ImuSample> overtaken_;    ///< comes out after the next
    std::optional<OwnedFrame> late_frame_;  ///< the same
    std::deque<OwnedFrame> waiting_;
    std::deque<Delivery> out_;
};

}  // namespace facet
