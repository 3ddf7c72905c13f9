// SPDX-License-Identifier: BSD-2-Clause
// The log that is replayed, with the faults put into it.
#pragma once

#include <optional>

#include "app/lab/faults/fault_injector.h"
#include "app/lab/replay/replay.h"
#include "app/lab/truth/truth_injector.h"
#include "app/pipeline/frame_recorder.h"
#include "drivers/replay_asl/asl_dataset.h"

namespace facet {

/// Is given what a log holds, in the order in which the estimator wants it.
class SampleReceiver {
public:
    virtual void take(const ImuSample& sample) = 0;
    /// @param output_stamp  under which the estimate is filed
    virtual void take(const StereoFrame& frame, Timestamp output_stamp) = 0;

protected:
    ~SampleReceiver() = default;
};

/// Reads a log once or several times, one pass after the other: the stamps go on, kSeam apart. Warnings go to the
/// recorder, frames and rows to its summary. Usage: open(); while (read()) deliver(to); deliver(to) once more, as
/// faults may hold samples back. Behind the last frame there are inertial samples for a frame that waits for them; who
/// needs none calls end(to) instead of read(). Borrows everything. Thread-bound. Heap.
class FaultedLog {
public:
    FaultedLog(const ReplayOptions& options, FrameRecorder& recorder) : options_(options), recorder_(recorder) {}

    /// Throws InputError if there is no such log, or no frame in what is asked for of it.
    void open();
    /// After the end of a pass.
    void open_again();
    /// Takes true biases out of inertial samples. @param truth  nullptr: as measured
    void correct_by(TruthInjector* truth) { truth_ = truth; }

    /// Takes the next sample from the log. @return false at the end of the pass
    bool read();
    /// Of the sample read, if it is an inertial one: when it was measured.
    std::optional<Timestamp> inertial_stamp() const;
    /// Whether the last frame of the pass has been given.
    bool is_out_of_frames() const { return log_->is_out_of_frames() && !(injector_ && injector_->holds_frames()); }
    /// Ends the pass here.
    void end(SampleReceiver& to) {
        event_ = AslDataset::Event::kEnd;
        deliver(to);
    }
    /// Gives what was read, or what the faults make of it.
    void deliver(SampleReceiver& to);

    /// A fault that met no sample is likely a mistake in its times.
    void tell_idle_faults();
    std::size_t frame_count() const { return log_->frame_count(); }  ///< of a pass
    FaultInjector* faults() { return injector_.has_value() ? &*injector_ : nullptr; }

private:
    void warn(const AslWarning& warning);

    const ReplayOptions& options_;
    FrameRecorder& recorder_;
    TruthInjector* truth_ = nullptr;
    std::optional<AslDataset> log_;
    std::optional<FaultInjector> injector_;  ///< none without faults
    Duration pass_shift_{};                  ///< of all stamps in this pass
    Timestamp newest_;                       ///< latest inertial stamp given
    AslDataset::Event event_ = AslDataset::Event::kEnd;
    ImuSample sample_;
    StereoFrame frame_;
};

}  // namespace facet
