// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/ros2_output.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>

#include "drivers/ros2/odometry_message.h"

namespace facet {
namespace {

constexpr std::chrono::milliseconds kTick{30};
constexpr Duration kScenePeriod = Duration::from_seconds(0.03);
constexpr Duration kDiagnosticPeriod = Duration::from_seconds(1.0);
constexpr Duration kStale = Duration::from_seconds(1.0);  // without an estimate
constexpr auto kRelaxed = std::memory_order_relaxed;

const char* word_for(SinkState state) {
    switch (state) {
        case SinkState::kInit: return "INIT";
        case SinkState::kTracking: return "TRACKING";
        case SinkState::kDegraded: return "DEGRADED";
        case SinkState::kLost: return "LOST";
    }
    return "";
}

Ros2Diagnostic::Level level_of(SinkState state) {
    switch (state) {
        case SinkState::kTracking: return Ros2Diagnostic::Level::kOk;
        case SinkState::kLost: return Ros2Diagnostic::Level::kError;
        default: return Ros2Diagnostic::Level::kWarn;
    }
}

std::string hexadecimal(std::uint32_t bits) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "0x%x", bits);
    return text.data();
}

}  // namespace

Ros2Output::Ros2Output(Ros2Node& node, const Clock& clock, const Ros2OutputNames& names)
    : clock_(clock), names_(names), publisher_(node.publisher(names)) {}

Status Ros2Output::open(std::string& problem) {
    if (thread_.joinable()) {
        return Status::kOk;
    }
    FACET_TRY(publisher_->open(problem));
    stopping_ = false;
    next_scene_ = next_diagnostics_ = clock_.now();
    thread_ = std::thread([this] { work(); });
    return Status::kOk;
}

void Ros2Output::close() {
    if (thread_.joinable()) {
        stopping_ = true;
        wakeup_.release();
        thread_.join();
        publisher_->close();
    }
}

std::string Ros2Output::name() const { return "ROS 2: " + names_.prefix + "/odometry"; }

Status Ros2Output::send(const Odometry& odometry) {
    if (!is_publishable(odometry)) {
        return Status::kInvalidArgument;
    }
    if (!ok(poses_.push(odometry))) {
        counters_.dropped.fetch_add(1, kRelaxed);
        return Status::kFull;
    }
    wakeup_.release();
    return Status::kOk;
}

void Ros2Output::report(const StateChange& change) { (void)changes_.push(change); }

void Ros2Output::work() {
    for (bool last = false; !last;) {
        last = stopping_;
        publish_poses();
        for (StateChange change; ok(changes_.pop(change));) {
            state_ = change;
        }
        const Timestamp now = clock_.now();
        if (now >= next_diagnostics_ || last) {
            next_diagnostics_ = now + kDiagnosticPeriod;
            publish_diagnostics();
        }
        if (scene_source_ != nullptr && now >= next_scene_) {
            next_scene_ = now + kScenePeriod;
            publish_scene();
        }
        if (!last) {
            (void)wakeup_.try_acquire_for(kTick);
        }
    }
}

Timestamp Ros2Output::to_realtime(Timestamp stamp) const {
    const ClockPair pair = clock_.read_pair();
    return stamp + (pair.realtime - pair.monotonic);
}

void Ros2Output::publish_poses() {
    while (ok(poses_.pop(newest_))) {
        any_ = true;
        state_.state = newest_.state;
        if (newest_.quality < 0 || newest_.state == SinkState::kLost || newest_.state == SinkState::kInit) {
            counters_.lost.fetch_add(1, kRelaxed);
            continue;
        }
        const bool is_sent = ok(publisher_->publish(to_ros2(newest_, to_realtime(newest_.stamp))));
        (is_sent ? counters_.poses : counters_.dropped).fetch_add(1, kRelaxed);
    }
}

void Ros2Output::publish_scene() {
    Ros2Wishes wishes;
    wishes.mesh = publisher_->has_listeners(Ros2Topic::kMesh) || publisher_->has_listeners(Ros2Topic::kPlanes);
    wishes.landmarks = publisher_->has_listeners(Ros2Topic::kLandmarks);
    wishes.path = publisher_->has_listeners(Ros2Topic::kPath);
    wishes.grid = publisher_->has_listeners(Ros2Topic::kGrid);
    scene_.has_mesh = scene_.has_landmarks = scene_.has_path = scene_.has_grid = scene_.has_map = false;
    scene_.mesh.clear();
    scene_.planes.clear();
    scene_.landmarks.clear();
    scene_.path.clear();
    if (!scene_source_->take(wishes, scene_)) {
        return;
    }
    const Timestamp stamp = to_realtime(scene_.stamp);
    const auto count = [this](Status status) {
        (ok(status) ? counters_.scenes : counters_.dropped).fetch_add(1, kRelaxed);
    };
    if (scene_.has_mesh) {
        count(publisher_->publish(Ros2Topic::kMesh, stamp, scene_.mesh));
        count(publisher_->publish(Ros2Topic::kPlanes, stamp, scene_.planes));
    }
    if (scene_.has_landmarks) {
        count(publisher_->publish(stamp, std::span<const Eigen::Vector3f>(scene_.landmarks)));
    }
    if (scene_.has_path) {
        count(publisher_->publish(stamp, std::span<const Ros2Pose>(scene_.path)));
    }
    if (scene_.has_grid) {
        count(publisher_->publish(stamp, scene_.grid));
    }
    if (scene_.has_map) {
        (void)publisher_->publish_map(stamp, scene_.map);
    }
}

void Ros2Output::publish_diagnostics() {
    const Timestamp now = clock_.now();
    const bool is_stale = !any_ || now - newest_.stamp > kStale;
    Ros2Diagnostic diagnostic;
    diagnostic.name = "facet: estimator";
    diagnostic.level = level_of(state_.state);
    diagnostic.message = state_.text.front() == '\0' ? word_for(state_.state) : state_.text.data();
    if (is_stale && state_.state != SinkState::kInit) {
        diagnostic.level = Ros2Diagnostic::Level::kStale;
        diagnostic.message = "no estimate for a second";
    }
    diagnostic.values = {{"state", word_for(state_.state)},
                         {"quality", std::to_string(newest_.quality)},
                         {"reasons", hexadecimal(any_ ? newest_.reasons : state_.reasons)},
                         {"reset_counter", std::to_string(newest_.reset_counter)},
                         {"poses", std::to_string(counters_.poses.load(kRelaxed))},
                         {"dropped", std::to_string(counters_.dropped.load(kRelaxed))}};
    (void)publisher_->publish(to_realtime(now), diagnostic);
}

}  // namespace facet
