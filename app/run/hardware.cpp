// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/hardware.h"

#include "app/support/input_error.h"

namespace facet {

Hardware::Hardware(KernelIo& io, Clock& clock, const Vehicle& vehicle) {
    if (vehicle.cameras.ros2 || vehicle.imu_ros2 || vehicle.ros2_out) {
        make_ros2(clock, vehicle);
    }
    make_cameras(io, clock, vehicle);
    if (vehicle.trigger) {
        trigger_ = std::make_unique<TriggerGpio>(io, clock, vehicle.trigger->input);
        sources_.trigger = trigger_.get();
    }
    if (vehicle.pulses) {
        pulses_ = std::make_unique<PulseOutput>(io, clock, *vehicle.pulses);
    }
    if (vehicle.mavlink) {
        mavlink_ = std::make_unique<MavlinkLink>(io, clock, *vehicle.mavlink);
        if (vehicle.mavlink->range) {
            mavlink_->give_ranges_to(&ranges_);
            sources_.ranges = &ranges_;
        }
    }
    if (vehicle.imu_spi) {
        make_spi(io, clock, *vehicle.imu_spi);
    } else if (vehicle.imu_iio) {
        imu_ = std::make_unique<ImuIio>(io, clock, *vehicle.imu_iio);
    } else if (vehicle.imu_serial) {
        imu_ = std::make_unique<ImuSerial>(io, clock, *vehicle.imu_serial);
    } else if (vehicle.imu_mavlink) {
        auto imu = std::make_unique<ImuMavlink>(*mavlink_, clock, *vehicle.imu_mavlink);
        imu_mavlink_ = imu.get();
        imu_ = std::move(imu);
    } else if (vehicle.imu_ros2) {
        imu_ = std::make_unique<ImuRos2>(*ros2_, clock, *vehicle.imu_ros2);
    } else {
        make_can(io, clock, *vehicle.imu_can);
    }
    sources_.imu = imu_.get();
    if (vehicle.can_out) {
        can_out_ = std::make_unique<CanOut>(io, clock, *vehicle.can_out);
    }
}

void Hardware::make_ros2(const Clock& clock, const Vehicle& vehicle) {
    ros2_ = make_ros2_node(vehicle.ros2);
    if (vehicle.ros2_out) {
        ros2_view_ = std::make_unique<Ros2View>();
        ros2_out_ = std::make_unique<Ros2Output>(*ros2_, clock, *vehicle.ros2_out);
        ros2_out_->show(ros2_view_.get());
    }
}

void Hardware::make_cameras(KernelIo& io, const Clock& clock, const Vehicle& vehicle) {
    const VehicleCameras& cameras = vehicle.cameras;
    const bool has_second = !cameras.side_by_side && vehicle.calibration.rig.has_right;
    if (cameras.ros2) {
        left_ = std::make_unique<CameraRos2>(*ros2_, clock, cameras.ros2->left);
    } else {
        if (cameras.auto_exposure) {
            exposure_ = std::make_unique<SharedExposure>(*cameras.auto_exposure);
        }
        left_ = std::make_unique<CameraV4l2>(io, clock, cameras.left, exposure_.get(), 0);
    }
    if (has_second && cameras.ros2) {
        right_ = std::make_unique<CameraRos2>(*ros2_, clock, cameras.ros2->right);
    } else if (has_second) {
        right_ = std::make_unique<CameraV4l2>(io, clock, cameras.right, exposure_.get(), 1);
    }
    sources_.left = left_.get();
    sources_.right = right_.get();
}

OdometrySink* Hardware::mavlink_sink() {
    return imu_mavlink_ != nullptr ? static_cast<OdometrySink*>(&imu_mavlink_->outbox()) : mavlink_.get();
}

void Hardware::make_spi(KernelIo& io, Clock& clock, const VehicleImuSpi& spi) {
    bus_ = std::make_unique<Spidev>(io, spi.device);
    switch (spi.chip) {
        case SpiChip::kAdis16: chip_ = std::make_unique<Adis16>(*bus_, clock, spi.adis16); break;
        case SpiChip::kIcm42688: chip_ = std::make_unique<Icm42688>(*bus_, clock, spi.icm42688); break;
        case SpiChip::kBmi088:
            accel_bus_ = std::make_unique<Spidev>(io, spi.accel_device);
            chip_ = std::make_unique<Bmi088>(*bus_, *accel_bus_, clock, spi.bmi088);
            break;
    }
    if (spi.data_ready) {
        data_ready_ = std::make_unique<TriggerGpio>(io, clock, *spi.data_ready);
    }
    imu_ = std::make_unique<ImuSpi>(*chip_, data_ready_.get(), clock, spi.source);
}

void Hardware::make_can(KernelIo& io, const Clock& clock, const VehicleImuCan& can) {
    if (can.protocol == CanProtocol::kDroneCan) {
        decoder_ = std::make_unique<DroneCanDecoder>(can.dronecan);
    } else {
        auto decoder = std::make_unique<DbcDecoder>();
        DbcFile database;
        std::string error;
        if (!ok(database.parse(can.dbc_text, can.dbc_path, error)) ||
            !ok(decoder->configure(database, can.map, error))) {
            throw InputError(error);
        }
        decoder_ = std::move(decoder);
    }
    imu_ = std::make_unique<ImuCan>(io, clock, *decoder_, can.source);
}

}  // namespace facet
