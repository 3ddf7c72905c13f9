// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/dry_run.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/run/pairing_proof.h"
#include "app/run/stamp_mapper.h"
#include "app/run/system_probe.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

constexpr Duration kWait = Duration::from_seconds(0.05);
constexpr Duration kTimeOfAutopilot = Duration::from_seconds(2.0);  // until it is known
constexpr Duration kPause = Duration::from_seconds(0.005);

/// What a source has delivered.
struct Heard {
    int samples = 0;
    double span_s = 0.0;
    Duration oldest_age;  ///< largest age of a stamp on arrival
    bool failed = false;

    double rate_hz() const { return samples > 1 && span_s > 0.0 ? (samples - 1) / span_s : 0.0; }
};

/// Listens to a started source.
template <class Source, class Sample, class Use>
Heard listen_to(Source& source, Clock& clock, Duration listen, Use use) {
    Heard heard;
    StampMapper mapper(clock, source.clock());
    const Timestamp end = clock.now() + listen;
    Timestamp first;
    while (clock.now() < end) {
        Sample sample;
        const Timestamp begin = clock.now();
        const Status status = source.next(kWait, sample);
        if (ok(status) && ok(mapper.map(sample.stamp))) {
            first = heard.samples++ == 0 ? sample.stamp : first;
            heard.span_s = (sample.stamp - first).seconds();
            heard.oldest_age = std::max(heard.oldest_age, clock.now() - sample.stamp);
        }
        if (ok(status)) {
            use(sample);
        } else if (status == Status::kEndOfStream || status == Status::kIo) {
            heard.failed = status == Status::kIo;
            break;
        } else if (clock.now() - begin < kPause) {
            clock.sleep(kPause);
        }
    }
    return heard;
}

class Probe {
public:
    Probe(Clock& clock, const Vehicle& vehicle, Duration listen) : clock_(clock), vehicle_(vehicle), listen_(listen) {}

    void add(Finding finding, const std::string& device, const std::string& text) {
        lines_.push_back({finding, device, text});
    }
    void add(ProbeLine line) { lines_.push_back(std::move(line)); }
    template <class Source, class Sample, class Use, class Judge>
    void source(Source& source, const std::string& device, Use use, Judge judge) {
        if (!ok(source.start())) {
            add(Finding::kWrong, device, std::string(source.problem()));
            return;
        }
        const Heard heard = listen_to<Source, Sample>(source, clock_, listen_, use);
        if (heard.failed) {
            add(Finding::kWrong, device, std::string(source.problem()));
        } else if (heard.samples == 0) {
            add(Finding::kWrong, device,
                fmt::format("opens, but delivers nothing within {:.1f} s{}{}", listen_.seconds(),
                            source.problem().empty() ? "" : ": ", source.problem()));
        } else {
            judge(heard);
        }
        source.stop();
    }
    void camera(CameraSource& source, const std::string& device, const std::string& name);
    void trigger(TriggerSource& source, const std::string& device);
    void pulses(PulseOutput& pulses);
    void pairing(const PairingSources& sources, PulseOutput& pulses);
    void judge_pairing(const PairingProof& proof, const std::vector<Timestamp>& frames, const std::string& device);
    void imu(ImuSource& source, const std::string& device, bool has_data_ready);
    void imu_rounding(const ImuMavlinkOptions& imu);
    template <class Sink>
    void sink(Sink& sink, const char* device);
    void sinks(Hardware& hardware);
    void log_folder();

    bool is_good_so_far() const {
        return std::none_of(lines_.begin(), lines_.end(),
                            [](const ProbeLine& l) { return l.finding == Finding::kWrong; });
    }
    std::vector<ProbeLine> take() { return std::move(lines_); }

private:
    Clock& clock_;
    const Vehicle& vehicle_;
    Duration listen_;
    std::vector<ProbeLine> lines_;
};

void Probe::camera(CameraSource& source, const std::string& device, const std::string& name) {
    int width = 0;
    int height = 0;
    const auto measure = [&](const CameraFrame& frame) {
        width = frame.image.width;
        height = frame.image.height;
    };
    this->source<CameraSource, CameraFrame>(source, device, measure, [&](const Heard& heard) {
        const double wanted = vehicle_.cameras.rate_hz;
        const SourceCounters c = source.counters();
        const std::string what = fmt::format("{} {}x{}, {:.1f} frames/s, {} lost, {} bad", name, width, height,
                                             heard.rate_hz(), c.lost, c.corrupt);
        if (!source.warning().empty()) {
            add(Finding::kDoubtful, device, fmt::format("{}; {}", what, source.warning()));
        } else if (heard.oldest_age > Duration::from_seconds(5.0) || heard.oldest_age.ns < 0) {
            add(Finding::kWrong, device,
                fmt::format("{}; stamps are {:.1f} s off the monotonic clock", what, heard.oldest_age.seconds()));
        } else if (heard.samples > 2 && std::abs(heard.rate_hz() / wanted - 1.0) > 0.1) {
            add(Finding::kDoubtful, device, fmt::format("{}; cameras.rate_hz is {:.1f}", what, wanted));
        } else {
            add(Finding::kGood, device, what);
        }
    });
}

void Probe::trigger(TriggerSource& source, const std::string& device) {
    this->source<TriggerSource, TriggerEdge>(
        source, device, [](const TriggerEdge&) {},
        [&](const Heard& heard) {
            const double wanted = vehicle_.cameras.rate_hz;
            const std::string what = fmt::format("{:.1f} edges/s, {} lost", heard.rate_hz(), source.counters().lost);
            if (heard.samples > 2 && std::abs(heard.rate_hz() / wanted - 1.0) > 0.1) {
                add(Finding::kDoubtful, device, fmt::format("{}; cameras.rate_hz is {:.1f}", what, wanted));
            } else {
                add(Finding::kGood, device, what);
            }
        });
}

/// Leaves the pulses running: the cameras may wait for them.
void Probe::pulses(PulseOutput& pulses) {
    try {
        const std::string refusals = pulses.start(vehicle_.realtime.trigger);
        add(refusals.empty() ? Finding::kGood : Finding::kDoubtful, "pulses",
            fmt::format("{:.1f}/s started{}{}", 1.0 / vehicle_.pulses->pulse.period.seconds(),
                        refusals.empty() ? "" : "; ", refusals));
    } catch (const InputError& e) {
        add(Finding::kWrong, "pulses", e.what());
    }
}

/// Leaves one pulse out and looks for the gap in the cameras' frames.
void Probe::pairing(const PairingSources& sources, PulseOutput& pulses) {
    bool is_started = ok(sources.trigger->start()) && ok(sources.left->start());
    is_started = is_started && (sources.right == nullptr || ok(sources.right->start()));
    if (is_started) {
        const PairingProof proof = prove_pairing(sources, clock_, listen_, [&] { pulses.leave_out_one(); });
        if (only_gap(proof.edges, vehicle_.pulses->pulse.period)) {
            judge_pairing(proof, proof.left, sources.right == nullptr ? "pairing" : "pairing left");
            if (sources.right != nullptr) {
                judge_pairing(proof, proof.right, "pairing right");
            }
        } else {
            add(Finding::kDoubtful, "pairing",
                "a pulse was left out, and the trigger's edges do not show it: are they those of trigger_output?");
        }
    }
    sources.trigger->stop();
    sources.left->stop();
    if (sources.right != nullptr) {
        sources.right->stop();
    }
}

void Probe::judge_pairing(const PairingProof& proof, const std::vector<Timestamp>& frames, const std::string& device) {
    const Duration period = vehicle_.pulses->pulse.period;
    const std::optional<Duration> lag = proof.lag(frames, period);
    if (!lag) {
        add(Finding::kWrong, device,
            "a pulse was left out, and the frames do not show it: the camera does not expose at the pulses");
        return;
    }
    const std::int64_t whole = std::llround(lag->seconds() / period.seconds());
    const std::string what = fmt::format("a pulse was left out: the frame after it is stamped {:.1f} ms after its edge",
                                         lag->seconds() * 1e3);
    if (whole == vehicle_.cameras.lag_frames) {
        add(Finding::kGood, device, what);
    } else {
        add(Finding::kWrong, device, fmt::format("{}; set cameras.lag_frames to {}", what, whole));
    }
}

void Probe::imu(ImuSource& source, const std::string& device, bool has_data_ready) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    int count = 0;
    const auto sum = [&](const ImuSample& sample) {
        force += sample.a_B;
        ++count;
    };
    const Duration usual = listen_;
    if (vehicle_.imu_mavlink) {
        listen_ = listen_ + kTimeOfAutopilot;
    }
    this->source<ImuSource, ImuSample>(source, device, sum, [&](const Heard& heard) {
        const Eigen::Vector3d mean = force / std::max(count, 1);
        const double wanted = vehicle_.calibration.noise.rate_hz;
        const std::string what = fmt::format(
            "{:.0f} samples/s, {} lost, {} bad; mean specific force {:.2f} {:.2f} {:.2f} m/s^2", heard.rate_hz(),
            source.counters().lost, source.counters().corrupt, mean.x(), mean.y(), mean.z());
        const double gravity = vehicle_.config.gravity.magnitude_m_per_s2;
        if (!source.warning().empty()) {
            add(Finding::kDoubtful, device, fmt::format("{}; {}", what, source.warning()));
        } else if (std::abs(mean.norm() - gravity) > 2.0) {
            add(Finding::kDoubtful, device,
                fmt::format("{}; {:.1f} is expected at rest: scale or decoder are wrong, or the vehicle moves", what,
                            gravity));
        } else if (heard.samples > 2 && std::abs(heard.rate_hz() / wanted - 1.0) > 0.1) {
            add(Finding::kDoubtful, device, fmt::format("{}; the rate in the calibration is {:.0f}", what, wanted));
        } else if (!has_data_ready) {
            add(Finding::kDoubtful, device,
                what + "; polled, because no data_ready line is configured: stamps are those of the reading");
        } else {
            add(Finding::kGood, device, what);
        }
    });
    listen_ = usual;
}

/// What a message rounds to is noise, which the calibration has to know of.
void Probe::imu_rounding(const ImuMavlinkOptions& imu) {
    const double rates = rounding_of_rates(imu.message, imu.rate_hz);
    const double forces = rounding_of_forces(imu.message, imu.rate_hz);
    const ImuNoise& noise = vehicle_.calibration.noise;
    if (noise.gyro_noise_rad_per_s_per_sqrt_hz < rates || noise.accel_noise_m_per_s2_per_sqrt_hz < forces) {
        add(Finding::kDoubtful, "imu noise",
            fmt::format("{} rounds; at {:g} Hz the calibration's noise densities must be {:.1e} rad/s/sqrt(Hz) and "
                        "{:.1e} m/s^2/sqrt(Hz) at least",
                        to_string(imu.message), imu.rate_hz, rates, forces));
    }
}

template <class Sink>
void Probe::sink(Sink& sink, const char* device) {
    std::string problem;
    if (ok(sink.open(problem))) {
        add(Finding::kGood, device, sink.name());
        sink.close();
    } else {
        add(Finding::kWrong, device, problem);
    }
}

void Probe::sinks(Hardware& hardware) {
    if (hardware.mavlink() != nullptr) {
        sink(*hardware.mavlink(), "mavlink");
    }
    if (hardware.can_out() != nullptr) {
        sink(*hardware.can_out(), "can out");
    }
    if (hardware.ros2_out() != nullptr) {
        sink(*hardware.ros2_out(), "ros 2");
    }
    if (hardware.mavlink() == nullptr && hardware.can_out() == nullptr && hardware.ros2_out() == nullptr) {
        add(Finding::kDoubtful, "mavlink", "not configured: nobody receives the estimates");
    }
}

void Probe::log_folder() {
    const std::string& folder = vehicle_.log.folder;
    if (folder.empty()) {
        return;
    }
    try {
        make_folder(folder);
        const std::string file = folder + "/dry_run.tmp";
        TextFile(file).close();
        std::filesystem::remove(file);
        const double free_gb = static_cast<double>(std::filesystem::space(folder).available) * 1e-9;
        add(free_gb < 1.0 ? Finding::kDoubtful : Finding::kGood, "log",
            fmt::format("{}, {:.1f} GB free", folder, free_gb));
    } catch (const std::exception& e) {
        add(Finding::kWrong, "log", e.what());
    }
}

}  // namespace

std::vector<ProbeLine> dry_run(Hardware& hardware, Clock& clock, const Vehicle& vehicle, Duration listen) {
    Probe probe(clock, vehicle, listen);
    const RunSources& sources = hardware.sources();
    const VehicleCameras& cameras = vehicle.cameras;
    if (hardware.pulses() != nullptr) {
        probe.pulses(*hardware.pulses());
    }
    probe.camera(*sources.left, vehicle.cameras.side_by_side ? "cameras" : "left camera", cameras.left_name());
    if (sources.right != nullptr) {
        probe.camera(*sources.right, "right camera", cameras.right_name());
    }
    if (sources.trigger != nullptr) {
        probe.trigger(*sources.trigger, "trigger");
    }
    probe.imu(*sources.imu, "imu", !vehicle.imu_spi || hardware.data_ready() != nullptr);
    if (vehicle.imu_mavlink) {
        probe.imu_rounding(*vehicle.imu_mavlink);
    }
    if (hardware.pulses() != nullptr) {
        if (sources.trigger != nullptr && vehicle.trigger && probe.is_good_so_far()) {
            probe.pairing({sources.trigger, sources.left, sources.right}, *hardware.pulses());
        }
        hardware.pulses()->stop();
    }
    probe.sinks(hardware);
    probe.log_folder();
    probe.add(probe_system(vehicle.realtime));
    return probe.take();
}

std::string to_text(const std::vector<ProbeLine>& lines) {
    std::string text;
    for (const ProbeLine& line : lines) {
        constexpr const char* kWords[] = {"ok", "doubtful", "WRONG"};
        text += fmt::format("{:<9} {:<13} {}\n", kWords[static_cast<std::size_t>(line.finding)], line.device + ":",
                            line.text);
    }
    return text;
}

}  // namespace facet
