// SPDX-License-Identifier: BSD-2-Clause
// Plays a recording through the kernel's devices, each thing at its time.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "platform/port/clock.h"
#include "tests/hil/inject/child.h"
#include "tests/hil/inject/fault_plan.h"
#include "tests/hil/inject/imu_encoding.h"
#include "tests/hil/inject/kernel_devices.h"
#include "tests/hil/inject/pixel_packing.h"
#include "tests/hil/inject/recording.h"

namespace facet::hil {

struct InjectorOptions {
    ImuKind imu = ImuKind::kIcm42688;
    PixelLayout pixels;
    std::string left = "/dev/video40";
    std::string right = "/dev/video41";
    std::string trigger_pull;     ///< files of gpio-sim in sysfs
    std::string data_ready_pull;  ///< SPI
    std::string can_interface = "vcan0";
    /// The trigger edge comes half an exposure before a frame's stamp, the frame a readout after the end of its
    /// exposure, as its own stamp says.
    Duration exposure = Duration::from_seconds(0.004);
    Duration readout = Duration::from_seconds(0.008);
    Duration imu_period = Duration::from_seconds(0.005);
    /// Frames before the log's, with the image of its first one: the synchroniser believes in no assignment before it
    /// has seen a few.
    int lead_frames = 4;
    FaultPlan faults;
    /// Exposure and gain are those that the program sets; else images are the log's, with the exposure above.
    std::optional<LightOptions> light;
};

struct InjectorReport {
    Duration shift;         ///< from the log's time to the guest's monotonic clock
    Timestamp first_frame;  ///< in the log's time
    std::uint64_t frames_sent = 0;
    std::uint64_t imu_sent = 0;
    Duration latest;  ///< most that anything came late
    /// With LightOptions: of left and right, once a second.
    std::vector<std::array<ShownGrey, 2>> greys;
    bool power_cut = false;  ///< by a fault: nothing more must be done than to note it
};

/// Devices are opened by the constructor, so that a camera streams before the program under test looks for it.
/// Thread-bound.
class Injector {
public:
    Injector(const InjectorOptions& options, const Recording& recording, Clock& clock);

    /// Plays everything, the log's first instant a moment from now. Ends early if the child has ended.
    InjectorReport play(Child& child);

private:
    enum class What : std::uint8_t { kEdge, kExtraEdge, kLeft, kRight, kImu, kFaultBegin, kFaultEnd };
    struct Action {
        Timestamp due;  ///< in the log's time
        What what = What::kEdge;
        std::size_t index = 0;
    };

    /// A frame of the log, or one of the lead.
    struct PlayedFrame {
        Timestamp stamp;
        std::size_t recorded = 0;
    };

    void plan();
    void plan_frames();
    void act(std::size_t action, Child& child);
    void expose(std::size_t action);
    std::span<const std::uint8_t> shown(std::size_t camera, const PlayedFrame& played);
    void send_frame(std::size_t index, bool left);
    void send_left(std::size_t index, OutgoingFrame outgoing);
    void send_right(std::size_t index, OutgoingFrame outgoing);
    void send_imu(std::size_t index);
    void send_can(const ImuSample& sample, bool damaged);
    void send_spi(std::size_t index, bool damaged);
    void switch_fault(const Fault& fault, bool begins, Child& child);
    void switch_power(bool fails);
    void strike(FaultKind kind, Child& child);
    bool active(FaultKind kind, Timestamp log_time) const {
        return options_.faults.active(kind, log_time - recording_.frames.front().stamp);
    }

    InjectorOptions options_;
    const Recording& recording_;
    Clock& clock_;
    VideoOutput left_;
    VideoOutput right_;
    PulseLine trigger_;
    std::optional<PulseLine> data_ready_;
    std::optional<SpiImuModel> spi_;
    std::optional<IioImuModel> iio_;
    std::optional<CanNode> can_;
    std::vector<PlayedFrame> frames_;
    std::vector<Action> actions_;
    std::vector<std::uint8_t> torn_;
    std::vector<std::uint8_t> packed_;
    std::optional<SensorLight> light_;
    bool unplugged_ = false;
    bool count_anew_ = false;      ///< the left camera's next frame has number zero
    std::size_t count_from_ = 0;   ///< the frame that had it last
    std::uint32_t stalled_ = 0;    ///< frames that the right camera has not made
    std::uint32_t imu_count_ = 0;  ///< of samples, sent or not
    std::uint32_t can_frames_ = 0;
    InjectorReport report_;
};

}  // namespace facet::hil
