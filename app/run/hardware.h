// SPDX-License-Identifier: BSD-2-Clause
// The drivers of a vehicle's sensors and sinks, connected as its vehicle file says.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/config/vehicle.h"
#include "app/run/pulse_output.h"
#include "app/run/ros2_view.h"
#include "app/run/sensor_threads.h"
#include "drivers/imu_spi/spidev.h"

namespace facet {

/// Constructs the drivers; opens no device. Thread-bound. Heap.
class Hardware {
public:
    /// Everything is borrowed and must outlive this.
    Hardware(KernelIo& io, Clock& clock, const Vehicle& vehicle);

    const RunSources& sources() const { return sources_; }
    MavlinkLink* mavlink() { return mavlink_.get(); }
    /// What estimates for the flight controller are given to: the link, or, if it is its inertial sensor's, the outbox.
    OdometrySink* mavlink_sink();
    /// nullptr if the inertial sensor is another.
    const ImuMavlink* imu_mavlink() const { return imu_mavlink_; }
    /// nullptr if no estimates go onto a CAN bus.
    CanOut* can_out() { return can_out_.get(); }
    /// nullptr if no estimates go to ROS 2.
    Ros2Output* ros2_out() { return ros2_out_.get(); }
    /// Who is shown the flight for it; nullptr without.
    FlightViewer* ros2_view() { return ros2_view_.get(); }
    /// nullptr if something else triggers the cameras.
    PulseOutput* pulses() { return pulses_.get(); }
    /// nullptr if the IMU's data-ready line is not wired.
    TriggerGpio* data_ready() { return data_ready_.get(); }

private:
    void make_cameras(KernelIo& io, const Clock& clock, const Vehicle& vehicle);
    void make_ros2(const Clock& clock, const Vehicle& vehicle);
    void make_spi(KernelIo& io, Clock& clock, const VehicleImuSpi& spi);
    void make_can(KernelIo& io, const Clock& clock, const VehicleImuCan& can);

    std::unique_ptr<Ros2Node> ros2_;  ///< before those who use it
    std::unique_ptr<Ros2View> ros2_view_;
    std::unique_ptr<Ros2Output> ros2_out_;
    std::unique_ptr<SharedExposure> exposure_;
    std::unique_ptr<CameraSource> left_;
    std::unique_ptr<CameraSource> right_;
    std::unique_ptr<TriggerGpio> trigger_;
    std::unique_ptr<PulseOutput> pulses_;
    std::unique_ptr<TriggerGpio> data_ready_;
    std::unique_ptr<Spidev> bus_;
    std::unique_ptr<Spidev> accel_bus_;
    std::unique_ptr<SpiImuChip> chip_;
    std::unique_ptr<CanDecoder> decoder_;
    std::unique_ptr<MavlinkLink> mavlink_;
    std::unique_ptr<ImuSource> imu_;
    ImuMavlink* imu_mavlink_ = nullptr;  ///< imu_, if it is one
    std::unique_ptr<CanOut> can_out_;
    RangeQueue ranges_;
    RunSources sources_;
};

}  // namespace facet
