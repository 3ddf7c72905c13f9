// SPDX-License-Identifier: BSD-2-Clause
// A recorded log that flows through a live run without a drop, however slow the machine is: the sources wait.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <thread>

#include "platform/port/camera_source.h"
#include "platform/port/imu_source.h"

namespace facet {

/// A clock on which nothing takes any time, so that no frame overruns. Sleeping lets other threads run. Thread-safe.
class StillClock final : public Clock {
public:
    Timestamp now() const override { return {1'000'000'000}; }
    ClockPair read_pair() const override { return {now(), now(), {}}; }
    void sleep_until(Timestamp /*until*/) override { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }
};

/// How far the sources of a log have come, for them to keep step, whatever the machine's load. An inertial sample waits
/// until every camera has come near it; a camera's next image waits for the other camera's last one, and until inertial
/// samples cover its own last one. Thread-safe.
class Pace {
public:
    /// @param cameras  one or two
    /// @param lead     how far inertial samples may be ahead of the newest image that all cameras have given; positive
    Pace(std::size_t cameras, Duration lead) : lead_(lead) {
        for (std::size_t i = 0; i < newest_ns_.size(); ++i) {
            newest_ns_[i] = i < cameras ? kNone : kEnded;
        }
    }

    void give_image(std::size_t camera, Timestamp stamp) { newest_ns_[camera] = stamp.ns; }
    void give_sample(Timestamp stamp) { newest_sample_ns_ = stamp.ns; }
    void end_camera(std::size_t camera) { newest_ns_[camera] = kEnded; }
    void end_samples() { newest_sample_ns_ = kEnded; }
    bool cameras_ended() const { return newest_ns_[0] == kEnded && newest_ns_[1] == kEnded; }
    bool lets_sample(Timestamp stamp) const {
        const std::int64_t limit_ns = stamp.ns - lead_.ns;
        return newest_ns_[0] >= limit_ns && newest_ns_[1] >= limit_ns;
    }
    bool lets_image(std::size_t camera) const {
        const std::int64_t last_ns = newest_ns_[camera];
        return last_ns <= newest_ns_[1 - camera] && last_ns <= newest_sample_ns_;
    }

private:
    static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();
    static constexpr std::int64_t kEnded = std::numeric_limits<std::int64_t>::max();

    Duration lead_;
    std::array<std::atomic<std::int64_t>, 2> newest_ns_;
    std::atomic<std::int64_t> newest_sample_ns_{kNone};
};

/// A camera that keeps step. With one slot it also waits for each image to be used.
class PacedCamera final : public CameraSource {
public:
    /// Borrowed: camera and pace. @param index  of the camera, from 0
    PacedCamera(CameraSource& camera, Pace& pace, std::size_t index) : camera_(camera), pace_(pace), index_(index) {}

    Status start() override { return camera_.start(); }
    void stop() override { camera_.stop(); }
    ClockDomain clock() const override { return camera_.clock(); }
    SourceCounters counters() const override { return camera_.counters(); }
    std::string_view problem() const override { return camera_.problem(); }
    Status next(Duration timeout, CameraFrame& frame) override {
        if (!pace_.lets_image(index_)) {
            return Status::kNotReady;
        }
        const Status status = camera_.next(timeout, frame);
        if (ok(status)) {
            pace_.give_image(index_, frame.stamp);
        } else if (status == Status::kEndOfStream) {
            pace_.end_camera(index_);
        }
        return status;
    }

private:
    CameraSource& camera_;
    Pace& pace_;
    std::size_t index_;
};

/// Inertial samples that keep step with the cameras, and end with them.
class PacedImu final : public ImuSource {
public:
    /// Borrowed: imu and pace.
    PacedImu(ImuSource& imu, Pace& pace) : imu_(imu), pace_(pace) {}

    Status start() override { return imu_.start(); }
    void stop() override { imu_.stop(); }
    ClockDomain clock() const override { return imu_.clock(); }
    SourceCounters counters() const override { return imu_.counters(); }
    std::string_view problem() const override { return imu_.problem(); }
    Status next(Duration timeout, ImuSample& sample) override {
        if (pace_.cameras_ended()) {
            return Status::kEndOfStream;
        }
        if (!ahead_) {
            ImuSample taken;
            const Status status = imu_.next(timeout, taken);
            if (status == Status::kEndOfStream) {
                pace_.end_samples();
            }
            FACET_TRY(status);
            ahead_ = taken;
        }
        if (!pace_.lets_sample(ahead_->stamp)) {
            return Status::kNotReady;
        }
        sample = *ahead_;
        ahead_.reset();
        pace_.give_sample(sample.stamp);
        return Status::kOk;
    }

private:
    ImuSource& imu_;
    Pace& pace_;
    std::optional<ImuSample> ahead_;  ///< the next one, until the cameras have come near
};

}  // namespace facet
