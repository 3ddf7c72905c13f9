// SPDX-License-Identifier: BSD-2-Clause
// The far side of the kernel's devices: what a sensor does to them. All throw std::system_error with the device's name.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/camera_v4l2/unpack.h"
#include "drivers/common/can_frame.h"
#include "tests/hil/inject/sensor_light.h"

namespace facet::hil {

/// A file descriptor with an owner and a name for messages.
class Descriptor {
public:
    Descriptor() = default;
    Descriptor(int fd, std::string name);
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    Descriptor(Descriptor&& other) noexcept;
    Descriptor& operator=(Descriptor&& other) noexcept;
    ~Descriptor();

    int get() const { return fd_; }
    const std::string& name() const { return name_; }
    /// Result of a system call on it; throws if it is negative.
    int check(int result, const char* what) const;

private:
    int fd_ = -1;
    std::string name_;
};

struct OutgoingFrame {
    std::span<const std::uint8_t> bytes;
    Timestamp stamp;  ///< as the camera's driver would give it
    std::uint32_t sequence = 0;
    bool error = false;  ///< flagged as damaged
};

/// The writing end of a loopback video device, with tests/hil/kernel/patches.
class VideoOutput {
public:
    VideoOutput(const std::string& device, int width, int height, PixelFormat format);
    VideoOutput(const VideoOutput&) = delete;
    VideoOutput& operator=(const VideoOutput&) = delete;
    ~VideoOutput();

    /// Copies; too few bytes make a short frame.
    void send(const OutgoingFrame& frame);
    /// The plug is pulled: every call on the device fails from now on, and its node goes.
    void unplug();
    /// It is plugged in again: a new node, under the old name.
    void plug();
    /// What the reader has set; nullopt while it is unplugged.
    std::optional<ExposureControls> controls() const;

private:
    static constexpr std::uint32_t kBuffers = 4;

    void set_connected(bool connected);

    Descriptor fd_;
    std::array<std::span<std::uint8_t>, kBuffers> buffers_{};
    std::uint32_t next_ = 0;
    std::uint64_t device_number_ = 0;
};

/// A simulated line (gpio-sim).
class PulseLine {
public:
    /// @param pull  the line's file in sysfs
    explicit PulseLine(const std::string& pull);
    /// Up and down again.
    void pulse();

private:
    Descriptor fd_;
};

/// The inertial sensor of tests/hil/kernel/facet_hil/spi_imu.c.
class SpiImuModel {
public:
    SpiImuModel();
    void push_packet(std::span<const std::uint8_t> packet) { write_at(0x1000, packet); }
    void set_burst(std::span<const std::uint8_t> burst) { write_at(0x2000, burst); }
    void set_dead(bool dead) { set_bus(dead ? 1 : 0); }
    /// Its registers are as after power-on.
    void power_on() { set_bus(2); }
    /// Whether it has been set up to make data-ready edges.
    bool makes_edges() const;

private:
    void set_bus(std::uint8_t state) { write_at(0x3000, {&state, 1}); }
    void write_at(std::int64_t offset, std::span<const std::uint8_t> bytes);

    Descriptor fd_;
};

/// The inertial sensor of tests/hil/kernel/facet_hil/iio_imu.c.
class IioImuModel {
public:
    IioImuModel();
    /// @param counts  rates, then forces
    void measure(const std::array<std::int32_t, 6>& counts);
    /// The kernel's driver is taken from the device, which goes with its node.
    void unplug() { write_driver("unbind"); }
    /// It is there again, as after power-on, with whatever number is free.
    void plug() { write_driver("bind"); }

private:
    static void write_driver(const std::string& attribute);

    Descriptor fd_;
};

/// Another node on the bus; it also speaks for the controller, whose error frames user space may send on a virtual bus.
class CanNode {
public:
    explicit CanNode(const std::string& interface);
    void send(const CanFrame& frame);
    /// @param error_class  of linux/can/error.h
    void send_error(std::uint32_t error_class);
    void set_up(bool up);

private:
    std::string interface_;
    Descriptor fd_;
};

}  // namespace facet::hil
