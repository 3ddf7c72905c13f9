// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/asl_sources.h"

#include <algorithm>
#include <utility>

namespace facet {
namespace {

/// Whether a warning means that a sample of the wanted kind was bad.
bool spoils(AslWarningKind kind, AslDataset::Event wanted) {
    switch (kind) {
        case AslWarningKind::kMissingFile:
        case AslWarningKind::kCorruptImage:
        case AslWarningKind::kWrongSize: return wanted == AslDataset::Event::kFrame;
        case AslWarningKind::kMalformedRow:
        case AslWarningKind::kNotFinite: return wanted == AslDataset::Event::kImu;
        default: return false;
    }
}

}  // namespace

AslPlayback::AslPlayback(Clock& clock, AslSourceOptions options, AslWarningSink sink)
    : clock_(clock), options_(std::move(options)), sink_(std::move(sink)) {}

Status AslPlayback::start() {
    if (!opened_) {
        const AslDataset::Event wanted =
            options_.log.decode_images ? AslDataset::Event::kFrame : AslDataset::Event::kImu;
        const auto on_warning = [this, wanted](const AslWarning& warning) {
            bad_ += opened_ && spoils(warning.kind, wanted) ? 1 : 0;
            if (sink_) {
                sink_(warning);
            }
        };
        if (!ok(log_.open(options_.folder, options_.log, on_warning, problem_))) {
            return Status::kNotFound;
        }
        opened_ = true;
    }
    started_ = true;
    return Status::kOk;
}

Status AslPlayback::wait_for(Timestamp stamp, Duration timeout) {
    if (options_.pace.as_fast_as_asked) {
        return Status::kOk;
    }
    const Timestamp due = options_.pace.host_begin + (stamp - options_.pace.log_begin);
    const Timestamp now = clock_.now();
    if (due > now && timeout.ns > 0) {
        clock_.sleep_until(std::min(due, now + timeout));
    }
    return clock_.now() >= due ? Status::kOk : Status::kNotReady;
}

Status AslPlayback::next(AslDataset::Event wanted, Duration timeout, ImuSample& sample, StereoFrame& frame) {
    if (!started_) {
        return Status::kNotReady;
    }
    while (!due_ && !ended_) {
        const AslDataset::Event event = log_.next(sample_, frame_);
        ended_ = event == AslDataset::Event::kEnd;
        if (event == wanted) {
            due_ = event == AslDataset::Event::kImu ? sample_.stamp : frame_.stamp + options_.log.frame_delay;
        }
    }
    if (bad_ > 0) {
        --bad_;
        ++counters_.corrupt;
        return Status::kCorrupt;
    }
    if (!due_) {
        return Status::kEndOfStream;
    }
    FACET_TRY(wait_for(*due_, timeout));
    due_.reset();
    ++counters_.delivered;
    const Duration moved = options_.pace.keep_stamps ? Duration{} : options_.pace.host_begin - options_.pace.log_begin;
    if (wanted == AslDataset::Event::kImu) {
        sample = sample_;
        sample.stamp = sample.stamp + moved;
    } else {
        frame = frame_;
        frame.stamp = frame.stamp + moved;
    }
    return Status::kOk;
}

}  // namespace facet
