// SPDX-License-Identifier: BSD-2-Clause
// Puts faults between a log and the estimator: what the log gives goes in, what faulty sensors would deliver comes out.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <variant>
#include <vector>

#include "app/lab/faults/fault.h"
#include "app/lab/faults/rotor_vibration.h"
#include "drivers/replay_asl/png_decoder.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/imu_scale.h"
#include "estimator/values/nav_state.h"
#include "platform/base/samples.h"

namespace facet {

/// A frame with pixels of its own.
struct OwnedFrame {
    Timestamp stamp;         ///< that the estimator is given
    Timestamp log_stamp;     ///< what the log said
    Timestamp output_stamp;  ///< under which the estimate is filed: `stamp` with the jumps of the clock taken out again
    GreyImage left;
    GreyImage right;
    bool has_left = true;
    bool has_right = false;

    StereoFrame view() const {
        return {.stamp = stamp,
                .left = has_left ? left.view() : ImageView{},
                .right = has_right ? right.view() : ImageView{}};
    }
};

/// Applies faults to samples. Usage, in the order in which the log gives samples:
///   injector.add(sample);                       // or a frame; finish() at the end of the log
///   while (auto* out = injector.front()) { ... std::get_if<ImuSample>(out) ...; injector.pop(); }
/// A frame comes out when the inertial samples that came out reach the stamp it claims, as the estimator wants it, but
/// after kMaxWait at the latest, as from a synchroniser that gives up. All of it is deterministic: noise and losses
/// depend on the number of the sample only. Thread-bound. Heap: as many frames as wait.
class FaultInjector {
public:
    using Delivery = std::variant<ImuSample, OwnedFrame>;
    static constexpr Duration kMaxWait{1'000'000'000};

    /// @param noise  calibrated densities, for imu_noise
    /// @param begin  instant from which the faults' times count
    FaultInjector(std::vector<Fault> faults, const ImuNoise& noise, Timestamp begin);

    void add(const ImuSample& sample);
    void add(const StereoFrame& frame);
    /// The log is over: frames that still wait come out.
    void finish();

    /// What comes out next, nullptr if nothing does yet. Valid until pop().
    const Delivery* front() const { return out_.empty() ? nullptr : &out_.front(); }
    void pop() { out_.pop_front(); }

    /// For each fault, in order, the samples or frames it has changed or swallowed.
    const std::vector<std::size_t>& hits() const { return hits_; }
    const std::vector<Fault>& faults() const { return faults_; }

private:
    /// Calls apply(fault, index) for each active fault of this kind; it returns whether it did something, for hits_.
    template <class Apply>
    void for_active(FaultKind kind, Timestamp log_stamp, Apply apply);
    bool is_active(FaultKind kind, Timestamp log_stamp);
    Duration shift(FaultKind kind, Timestamp log_stamp);
    bool is_lost(const OwnedFrame& frame);
    void change_images(OwnedFrame& frame);
    void freeze(OwnedFrame& frame);
    void change_values(ImuSample& sample, Timestamp log_stamp);
    void shake_and_bias(ImuSample& sample, Duration t);
    void walk(const Fault& fault, std::size_t index);
    void release(Timestamp log_now);

    std::vector<Fault> faults_;
    std::vector<std::size_t> hits_;
    std::map<std::size_t, RotorVibration> vibrations_;  ///< by fault
    std::map<std::size_t, ImuBias> biases_;             ///< by fault
    std::map<std::size_t, ImuScale> scales_;            ///< errors, by fault
    ImuNoise noise_;
    Timestamp begin_;
    std::uint64_t imu_count_ = 0;
    std::uint64_t frame_count_ = 0;
    bool has_imu_ = false;
    Timestamp newest_imu_;  ///< latest inertial stamp that came out
    std::deque<OwnedFrame> waiting_;
    std::deque<Delivery> out_;
    bool is_frozen_ = false;
    OwnedFrame frozen_;  ///< images of the first frame of the freeze under way
};

}  // namespace facet
