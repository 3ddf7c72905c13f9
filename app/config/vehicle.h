// SPDX-License-Identifier: BSD-2-Clause
// What a vehicle has: its sensors, where they are connected, where estimates go, and what it asks of the system.
#pragma once

#include <optional>
#include <string>

#include "app/calibration/calibration.h"
#include "app/config/obstacle_options.h"
#include "app/config/program_config.h"
#include "drivers/camera_v4l2/camera_v4l2.h"
#include "drivers/can_out/can_out.h"
#include "drivers/imu_can/dbc_decoder.h"
#include "drivers/imu_can/dronecan.h"
#include "drivers/imu_can/imu_can.h"
#include "drivers/imu_iio/imu_iio.h"
#include "drivers/imu_serial/imu_serial.h"
#include "drivers/imu_spi/adis16.h"
#include "drivers/imu_spi/bmi088.h"
#include "drivers/imu_spi/icm42688.h"
#include "drivers/imu_spi/imu_spi.h"
#include "drivers/mavlink/imu_mavlink.h"
#include "drivers/mavlink/mavlink_link.h"
#include "drivers/ros2/camera_ros2.h"
#include "drivers/ros2/imu_ros2.h"
#include "drivers/ros2/ros2_node.h"
#include "drivers/trigger_gpio/trigger_gpio.h"
#include "drivers/trigger_gpio/trigger_output.h"

namespace facet {

/// Topics that the cameras' drivers publish on.
struct VehicleRos2Cameras {
    CameraRos2Options left;
    CameraRos2Options right;
};

/// Two nodes, or one whose images are twice as wide: left and right side by side. With a calibration of one camera
/// `left` is all there is. With `ros2` topics take the place of the nodes.
struct VehicleCameras {
    bool side_by_side = false;  ///< then `left` is the node, its width twice the calibration's
    bool use_sequence = true;   ///< the drivers count frames
    double rate_hz = 20.0;
    int lag_frames = 0;  ///< whole periods by which frames are stamped after their trigger edge
    CameraV4l2Options left;
    CameraV4l2Options right;
    std::optional<AutoExposureOptions> auto_exposure;  ///< of both alike
    std::optional<VehicleRos2Cameras> ros2;

    /// Of its node or topic.
    const std::string& left_name() const { return ros2 ? ros2->left.topic : left.capture.device; }
    const std::string& right_name() const { return ros2 ? ros2->right.topic : right.capture.device; }
};

/// The line whose edges mark the exposures of the cameras.
struct VehicleTrigger {
    TriggerGpioOptions input;
    Duration delay;  ///< from the edge to the start of exposure
};

enum class SpiChip : std::uint8_t { kAdis16, kIcm42688, kBmi088 };

struct VehicleImuSpi {
    SpiChip chip = SpiChip::kAdis16;
    std::string device = "/dev/spidev0.0";        ///< of the gyroscope, where there are two
    std::string accel_device = "/dev/spidev0.1";  ///< BMI088 only
    std::optional<TriggerGpioOptions> data_ready;
    Adis16Options adis16;
    Icm42688Options icm42688;
    Bmi088Options bmi088;
    ImuSpiOptions source;
};

enum class CanProtocol : std::uint8_t { kOpenImu300, kDroneCan, kDbc };

struct VehicleImuCan {
    CanProtocol protocol = CanProtocol::kOpenImu300;
    DroneCanOptions dronecan;
    std::string dbc_path;
    std::string dbc_text;  ///< content of that file, or the ready one of the product
    CanSignalMap map;
    ImuCanOptions source;
};

/// What the sinks are given.
struct VehicleOdometry {
    double rate_hz = 50.0;     ///< of estimates carried on by inertial samples; 0: one a frame, at its exposure
    double smoothing_s = 0.0;  ///< over which corrections fade in; 0: they are steps
    Se3 T_body_imu{};          ///< from the IMU (as `axes` turns it) to the frame that is reported
};

/// A local socket that serves mesh, planes and grid to planners.
struct VehicleWorld {
    std::string path;
    std::string group;     ///< that may connect, besides the program's user; empty: the program's own
    unsigned mode = 0660;  ///< of the socket
};

struct VehicleLog {
    std::string folder;         ///< created if missing; empty: no files
    bool by_flight = false;     ///< each flight has a folder of its own in there
    int keep_mb = 4096;         ///< of the disk for all flights, by_flight; the oldest are removed. 0: no limit
    int mesh_faces = 200'000;   ///< most faces kept for mesh.ply
    int timed_frames = 20'000;  ///< newest frames whose times are in summary.json
};

struct ThreadOptions {
    int cpu = -1;      ///< -1: any
    int priority = 0;  ///< of SCHED_FIFO; 0: the ordinary scheduler
};

/// Pulses that this computer makes for the cameras, at their rate.
struct VehiclePulses {
    TriggerPulse pulse;
    std::string pwm_chip;  ///< such as /sys/class/pwm/pwmchip0; empty: the line
    int pwm_channel = 0;
    GpioLineName line;
};

/// What is asked of the system; a refusal is reported, and the program goes on without.
struct VehicleRealtime {
    bool lock_memory = false;
    int prefault_stack_kb = 256;  ///< of each thread
    ThreadOptions estimator;
    ThreadOptions cameras;
    ThreadOptions imu;
    ThreadOptions trigger;
    ThreadOptions output;
};

/// Everything that `facet run` needs to know.
struct Vehicle {
    std::string source;  ///< the file it came from
    Calibration calibration;
    ProgramConfig config;
    VehicleCameras cameras;
    std::optional<VehicleTrigger> trigger;
    std::optional<VehiclePulses> pulses;
    std::optional<VehicleImuSpi> imu_spi;  ///< one of the four
    std::optional<VehicleImuCan> imu_can;
    std::optional<ImuIioOptions> imu_iio;
    std::optional<ImuSerialOptions> imu_serial;
    std::optional<ImuMavlinkOptions> imu_mavlink;  ///< over the link of `mavlink`
    std::optional<ImuRos2Options> imu_ros2;
    Ros2NodeOptions ros2;  ///< of whatever speaks ROS 2
    VehicleOdometry odometry;
    std::optional<MavlinkOptions> mavlink;
    std::optional<ObstacleOptions> obstacles;  ///< sent by mavlink
    std::optional<CanOutOptions> can_out;
    std::optional<VehicleWorld> world;
    std::optional<Ros2OutputNames> ros2_out;
    VehicleLog log;
    VehicleRealtime realtime;
};

}  // namespace facet
