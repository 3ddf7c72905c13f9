// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/hardware.h"

#include "app/support/input_error.h"

namespace facet {

Hardware::Hardware(KernelIo& io, Clock& clock, const Vehicle& vehicle) {
    if (vehicle.cameras.auto_exposure) {
        exposure_ = std::make_unique<SharedExposure>(*vehicle.cameras.auto_exposure);
    }
    left_ = std::make_unique<CameraV4l2>(io, clock, vehicle.cameras.left, exposure_.get(), 0);
    sources_.left = left_.get();
    if (!vehicle.cameras.side_by_side && vehicle.calibration.rig.has_right) {
        right_ = std::make_unique<CameraV4l2>(io, clock, vehicle.cameras.right, exposure_.get(), 1);
        sources_.right = right_.get();
    }
    if (vehicle.trigger) {
        trigger_ = std::make_unique<TriggerGpio>(io, clock, vehicle.trigger->input);
        sources_.trigger = trigger_.get();
    }
    if (vehicle.pulses) {
        pulses_ = std::make_unique<PulseOutput>(io, clock, *vehicle.pulses);
    }
    if (vehicle.mavlink) {
        mavlink_ = std::make_unique<MavlinkLink>(io, clock, *vehicle.mavlink);
    }
    if (vehicle.imu_spi) {
        make_spi(io, clock, *vehicle.imu_spi);
    } else if (vehicle.imu_iio) {
        imu_ = std::make_unique<ImuIio>(io, clock, *vehicle.imu_iio);
    } else if (vehicle.imu_mavlink) {
        auto imu = std::make_unique<ImuMavlink>(*mavlink_, clock, *vehicle.imu_mavlink);
        imu_mavlink_ = imu.get();
        imu_ = std::move(imu);
    } else {
        make_can(io, clock, *vehicle.imu_can);
    }
    sources_.imu = imu_.get();
    if (vehicle.can_out) {
        can_out_ = std::make_unique<CanOut>(io, clock, *vehicle.can_out);
    }
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
