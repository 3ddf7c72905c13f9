// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/device_life.h"

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

void DeviceLife::works() {
    counters_.recoveries += is_failing_ ? 1 : 0;
    is_failing_ = false;
}

}  // namespace facet
