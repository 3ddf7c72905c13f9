// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/faulted_log.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <variant>

#include "app/lab/faults/image_faults.h"
#include "app/lab/replay/log_options.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

std::vector<Fault> faults_of_samples(const std::vector<Fault>& faults) {
    std::vector<Fault> chosen;
    std::copy_if(faults.begin(), faults.end(), std::back_inserter(chosen), is_of_samples);
    return chosen;
}

}  // namespace

void FaultedLog::open() {
    AslOptions log_options = log_options_of(options_.calibration);
    log_options.files = options_.files;
    log_options.decode_ahead = true;
    log_options.loops = options_.loops;
    log_options.imu_tail = kRetry;
    log_options.start = Duration::from_seconds(options_.start_s);
    if (options_.duration_s.has_value()) {
        log_options.length = Duration::from_seconds(*options_.duration_s);
    }
    RunSummary& summary = recorder_.summary();
    std::string error;
    const std::size_t rows_skipped = summary.rows_skipped;
    log_.emplace();
    if (!ok(log_->open(
            options_.dataset, log_options, [this](const AslWarning& w) { warn(w); }, error))) {
        throw InputError(error);
    }
    if (log_->frame_count() == 0) {
        throw InputError(fmt::format("{}: no frame between --start and its --duration", options_.dataset));
    }
    // A left row that was skipped is a frame all the same; the right view may have made one of it already.
    const std::size_t skipped = summary.rows_skipped - rows_skipped;
    summary.frames_listed += log_->frame_count() + skipped - std::min(skipped, log_->right_only_count());
    const std::vector<Fault> faults = faults_of_samples(options_.faults);
    if (!faults.empty()) {
        injector_.emplace(faults, options_.calibration.noise, options_.calibration.rig,
                          log_->log_begin() + pass_shift_ + log_options.start);
    }
}

void FaultedLog::open_again() {
    pass_shift_ = newest_ + kSeam - (log_->log_begin() + Duration::from_seconds(options_.start_s));
    open();
}

void FaultedLog::warn(const AslWarning& warning) {
    const bool is_row_skipped = warning.kind == AslWarningKind::kMalformedRow ||
                                warning.kind == AslWarningKind::kOutOfOrder ||
                                warning.kind == AslWarningKind::kDuplicate;
    if (is_row_skipped && warning.file.ends_with("cam0/data.csv")) {
        ++recorder_.summary().rows_skipped;
    }
    recorder_.warn(to_string(warning.kind), warning.text());
}

bool FaultedLog::read() {
    event_ = log_->next(sample_, frame_);
    if (event_ == AslDataset::Event::kImu) {
        if (truth_ != nullptr) {
            truth_->correct(sample_);
        }
        sample_.stamp = sample_.stamp + pass_shift_;
        newest_ = sample_.stamp;
    } else if (event_ == AslDataset::Event::kFrame) {
        frame_.stamp = frame_.stamp + pass_shift_;
    }
    return event_ != AslDataset::Event::kEnd;
}

std::optional<Timestamp> FaultedLog::inertial_stamp() const {
    return event_ == AslDataset::Event::kImu ? std::optional(sample_.stamp) : std::nullopt;
}

void FaultedLog::deliver(SampleReceiver& to) {
    if (!injector_) {
        switch (event_) {
            case AslDataset::Event::kImu: to.take(sample_); break;
            case AslDataset::Event::kFrame: to.take(frame_, frame_.stamp); break;
            case AslDataset::Event::kEnd: break;
        }
        return;
    }
    switch (event_) {
        case AslDataset::Event::kImu: injector_->add(sample_); break;
        case AslDataset::Event::kFrame: injector_->add(frame_); break;
        case AslDataset::Event::kEnd: injector_->finish(); break;
    }
    for (const FaultInjector::Delivery* out = nullptr; (out = injector_->front()) != nullptr; injector_->pop()) {
        if (const auto* sample = std::get_if<ImuSample>(out)) {
            to.take(*sample);
        } else {
            const auto& frame = std::get<OwnedFrame>(*out);
            to.take(frame.view(), frame.output_stamp);
        }
    }
}

void FaultedLog::tell_idle_faults() {
    for (std::size_t i = 0; injector_ && i < injector_->hits().size(); ++i) {
        if (injector_->hits()[i] == 0) {
            recorder_.warn("idle_fault", fmt::format("--inject '{}' met no sample", injector_->faults()[i].spec));
        }
    }
}

}  // namespace facet
