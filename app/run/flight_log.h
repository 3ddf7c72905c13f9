// SPDX-License-Identifier: BSD-2-Clause
// The log of a flight as it is flown.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/config/vehicle.h"
#include "app/output/live_account.h"
#include "app/pipeline/estimate_channels.h"
#include "app/run/estimate_queue.h"
#include "app/run/sample_recorder.h"

namespace facet {

class McapSampleLog;

/// What a log is: the folder mav0 (AslLog), or flight.mcap (McapSampleLog).
enum class LogForm : std::uint8_t { kFolder, kMcap };
inline constexpr std::array<std::string_view, 2> kLogFormNames{"folder", "mcap"};

/// Records samples with the calibration and the parameters that the estimator has; into an MCAP file also the estimates
/// and, once a second, what was lost. Its taps only copy; one thread writes. Thread-bound to its owner but for drops().
class FlightLog {
public:
    static constexpr Duration kDropsPeriod = Duration::from_seconds(1.0);  ///< of the log's stamps

    /// @param clock, vehicle  borrowed
    /// @param folder  gets the log, which must not be there yet
    /// @param counts  appends what was lost so far; called on the writing thread
    /// Throws InputError.
    FlightLog(const Clock& clock, const Vehicle& vehicle, const std::string& folder, LogForm form,
              std::function<void(std::vector<NamedCounter>&)> counts);
    ~FlightLog();
    FlightLog(const FlightLog&) = delete;
    FlightLog& operator=(const FlightLog&) = delete;

    /// The folder or file that is the log.
    const std::string& path() const { return path_; }
    SampleTap& samples() { return *recorder_; }
    /// To be called before write(): who is to be shown the estimates; nullptr if the form has none. Heap.
    FlightViewer* add_estimates();

    /// Body of the writing thread.
    void write(const std::atomic<bool>& stopping) { recorder_->write(stopping); }
    /// After the body has returned: completes the log.
    void finish() { recorder_->finish(); }

    const RecordCounters& counters() const { return recorder_->counters(); }
    /// What the log lacks, by reason. Thread-safe.
    std::vector<NamedCounter> drops() const;
    /// After finish(): why the log is incomplete; empty if it is complete.
    const std::string& failure() const { return recorder_->failure(); }

private:
    void write_more();

    std::string path_;
    std::function<void(std::vector<NamedCounter>&)> counts_;
    McapSampleLog* mcap_ = nullptr;  ///< the log, if it is one; the recorder's
    std::unique_ptr<SampleRecorder> recorder_;
    std::unique_ptr<EstimateQueue> queue_;  ///< with channels_, or neither
    std::unique_ptr<EstimateChannels> channels_;
    std::uint16_t drops_channel_ = 0;
    Timestamp next_drops_;  ///< of the writing thread
};

/// Appends counts under names of their own: those of a source with its name before them. Reentrant. Heap.
void append(const std::vector<SourceAccount>& sources, std::vector<NamedCounter>& counts);
void append(const std::vector<NamedCounter>& more, std::vector<NamedCounter>& counts);

}  // namespace facet
