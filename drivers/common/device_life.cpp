// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/device_life.h"

#include <algorithm>
#include <utility>

namespace facet {

Status DeviceLife::open() {
    std::string problem;
    const Status status = device_.open(problem);
    if (!ok(status)) {
        device_.close();
        problem_ = std::move(problem);
        return status;
    }
    state_ = State::kOpen;
    heard_ = clock_.now();
    any_heard_ = false;
    refused_for_ = nullptr;
    return Status::kOk;
}

Status DeviceLife::start() {
    if (is_started()) {
        return Status::kOk;
    }
    problem_.clear();
    is_failing_ = false;
    return open();
}

void DeviceLife::stop() {
    device_.close();
    state_ = State::kStopped;
}

Status DeviceLife::check() {
    if (state_ == State::kOpen) {
        return Status::kOk;
    }
    if (state_ == State::kStopped || !retry_.pass(clock_.now())) {
        return Status::kNotReady;
    }
    return ok(open()) ? Status::kOk : fail_without_closing(std::move(problem_));
}

Status DeviceLife::fail(std::string problem) {
    device_.close();
    state_ = State::kWaiting;
    retry_.close(clock_.now());
    return fail_without_closing(std::move(problem));
}

Status DeviceLife::fail_without_closing(std::string problem) {
    problem_ = std::move(problem);
    counters_.errors += is_failing_ ? 0 : 1;
    is_failing_ = true;
    return Status::kIo;
}

bool DeviceLife::is_silent(const std::string& name) {
    const Duration quiet = clock_.now() - heard_;
    const Duration limit = any_heard_ ? silence_ : std::max(silence_, kFirstSample);
    if (silence_.ns == 0 || state_ != State::kOpen || quiet <= limit) {
        return false;
    }
    device_.close();
    state_ = State::kWaiting;
    (void)fail_without_closing(name + (refused_for_ == nullptr ? ": no data for " : ": no good data for ") +
                               std::to_string(quiet.ns / 1'000'000) + " ms" +
                               (refused_for_ == nullptr ? "" : std::string(": ") + refused_for_));
    return true;
}

void DeviceLife::works() {
    heard_ = clock_.now();
    any_heard_ = true;
    refused_for_ = nullptr;
    counters_.recoveries += is_failing_ ? 1 : 0;
    is_failing_ = false;
}

}  // namespace facet
