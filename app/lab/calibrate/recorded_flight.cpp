// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/recorded_flight.h"

#include <fmt/core.h>

#include <utility>

#include "app/config/program_config.h"
#include "app/lab/replay/log_options.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "estimator/api/estimator.h"

namespace facet {
namespace {

/// Keeps what the front-end saw at the last frame.
class SightingRecorder : public ObservationHook {
public:
    void edit(Timestamp /*stamp*/, std::span<FeatureObservation> observations) override {
        sightings.clear();
        for (const FeatureObservation& o : observations) {
            sightings.push_back({.point = o.landmark.value,
                                 .left_px = o.left_px.cast<double>(),
                                 .right_px = o.right_px.cast<double>(),
                                 .has_right = o.has_right});
        }
    }

    std::vector<PointSighting> sightings;
};

/// The time offset that is found may ask for samples beyond a frame's stamp; a frame is offered once.
constexpr Duration kFrameDelay = Duration::from_seconds(0.02);

AslOptions log_options(const RecordingOptions& options) {
    AslOptions log = log_options_of(options.calibration);
    log.frame_delay = kFrameDelay;
    log.start = Duration::from_seconds(options.start_s);
    log.length = Duration::from_seconds(options.duration_s);
    return log;
}

/// Takes the log to the estimator and keeps its keyframes, a stretch at a time.
class Recording {
public:
    explicit Recording(const RecordingOptions& options)
        : imu_model_(options.calibration.imu_model), imu_limits_(options.config.imu_limits) {
        if (!ok(estimator_.configure(options.config, options.calibration.rig))) {
            throw InputError(fmt::format("calibration ({}): the estimator refuses these cameras or the parameters",
                                         options.calibration.source));
        }
        estimator_.set_observation_hook(&recorder_);
    }

    void add(const ImuSample& measured) {
        const ImuSample sample = imu_model_.corrected(measured);
        if (ok(estimator_.add_imu(sample, imu_limits_.clipped_axes(measured)))) {
            flight_.imu.push_back(sample);
        }
    }

    void add(const StereoFrame& frame) {
        Estimate estimate;
        if (!ok(estimator_.add_frame(frame, estimate))) {
            return;
        }
        const TrackingState state = estimate.health.state;
        const bool is_usable = state == TrackingState::kTracking || state == TrackingState::kDegraded;
        if (!is_usable || estimate.health.reset_counter != reset_counter_) {
            reset_counter_ = estimate.health.reset_counter;
            end_stretch();
        }
        if (is_usable && estimate.health.is_keyframe) {
            stretch_.push_back({frame.stamp, estimate.stamp, estimate.state, recorder_.sightings});
        }
    }

    RecordedFlight take() {
        end_stretch();
        return std::move(flight_);
    }

private:
    void end_stretch() {
        if (stretch_.size() > flight_.keyframes.size()) {
            flight_.keyframes = std::move(stretch_);
        }
        stretch_.clear();
    }

    ImuModel imu_model_;
    ImuLimits imu_limits_;
    Estimator estimator_;
    SightingRecorder recorder_;
    RecordedFlight flight_;
    std::vector<RecordedKeyframe> stretch_;
    std::uint32_t reset_counter_ = 0;
};

}  // namespace

RecordedFlight record_flight(const RecordingOptions& options, const std::atomic<bool>& stop) {
    Recording recording(options);
    AslDataset log;
    std::string error;
    if (!ok(log.open(options.dataset, log_options(options), nullptr, error))) {
        throw InputError(error);
    }
    if (log.frame_count() == 0) {
        throw InputError(fmt::format("{}: no frame between --start and its --duration", options.dataset));
    }
    std::optional<Progress> progress;
    if (options.show_progress) {
        progress.emplace("fly", "frames", log.frame_count());
    }
    std::size_t frames = 0;
    ImuSample sample;
    StereoFrame frame;
    for (bool at_end = false; !at_end && !stop.load();) {
        switch (log.next(sample, frame)) {
            case AslDataset::Event::kImu: recording.add(sample); break;
            case AslDataset::Event::kFrame:
                recording.add(frame);
                if (progress) {
                    progress->update(++frames);
                }
                break;
            case AslDataset::Event::kEnd: at_end = true; break;
        }
    }
    if (progress) {
        progress->finish();
    }
    return recording.take();
}

}  // namespace facet
