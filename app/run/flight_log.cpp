// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/flight_log.h"

#include <fstream>
#include <iterator>
#include <utility>

#include "app/config/config_file.h"
#include "app/foxglove/drops_message.h"
#include "app/output/asl_log.h"
#include "app/output/mcap_sample_log.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string content{std::istreambuf_iterator<char>(file), {}};
    if (!file) {
        throw InputError(path + ": cannot be read");
    }
    return content;
}

void add_files(const Vehicle& vehicle, SampleLog& log) {
    for (const CalibrationFile& file : vehicle.calibration.files) {
        log.add_file(file.place, content_of(file.path));
    }
    log.add_file("parameters.yaml", print_config(vehicle.config));
    log.commit();
}

}  // namespace

FlightLog::FlightLog(const Clock& clock, const Vehicle& vehicle, const std::string& folder, LogForm form,
                     std::function<void(std::vector<NamedCounter>&)> counts)
    : path_(folder + "/" + (form == LogForm::kMcap ? McapSampleLog::kFileName : "mav0")), counts_(std::move(counts)) {
    const CameraIntrinsics k = vehicle.calibration.rig.left.intrinsics();
    const bool has_right = vehicle.calibration.rig.has_right;
    std::unique_ptr<SampleLog> log;
    if (form == LogForm::kMcap) {
        auto made = std::make_unique<McapSampleLog>(folder, has_right);
        mcap_ = made.get();
        log = std::move(made);
    } else {
        log = std::make_unique<AslLog>(folder, has_right);
    }
    add_files(vehicle, *log);
    recorder_ = std::make_unique<SampleRecorder>(
        clock, std::move(log), static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    if (mcap_ != nullptr) {
        McapWriter& writer = mcap_->writer();
        const std::uint16_t schema = writer.add_schema(kDropsSchema, "jsonschema", drops_schema_text());
        drops_channel_ = writer.add_channel(schema, kDropsTopic, "json", {});
        recorder_->write_also([this] { write_more(); });
    }
}

FlightLog::~FlightLog() = default;

FlightViewer* FlightLog::add_estimates() {
    if (mcap_ == nullptr) {
        return nullptr;
    }
    queue_ = std::make_unique<EstimateQueue>();
    channels_ = std::make_unique<EstimateChannels>(mcap_->writer());
    return queue_.get();
}

/// On the writing thread.
void FlightLog::write_more() {
    if (queue_) {
        queue_->pass_on(*channels_);
    }
    const Timestamp now = mcap_->newest();
    if (now < next_drops_) {
        return;
    }
    next_drops_ = now + kDropsPeriod;
    std::vector<NamedCounter> counts;
    counts_(counts);
    mcap_->writer().add_message(drops_channel_, static_cast<std::uint64_t>(now.ns), drops_message(now, counts));
}

std::vector<NamedCounter> FlightLog::drops() const {
    std::vector<NamedCounter> drops{{"pairs_not_recorded", counters().pairs_dropped},
                                    {"samples_not_recorded", counters().samples_dropped}};
    if (queue_) {
        drops.push_back({"estimates_not_recorded", queue_->dropped()});
    }
    return drops;
}

void append(const std::vector<SourceAccount>& sources, std::vector<NamedCounter>& counts) {
    for (const SourceAccount& source : sources) {
        const auto add = [&](const char* name, std::uint64_t value) {
            counts.push_back({source.name + "_" + name, value});
        };
        add("delivered", source.counters.delivered);
        add("lost", source.counters.lost);
        add("corrupt", source.counters.corrupt);
        add("errors", source.counters.errors);
        add("rejected", source.rejected);
        add("unmapped", source.unmapped);
    }
}

void append(const std::vector<NamedCounter>& more, std::vector<NamedCounter>& counts) {
    counts.insert(counts.end(), more.begin(), more.end());
}

}  // namespace facet
