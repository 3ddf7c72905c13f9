// SPDX-License-Identifier: BSD-2-Clause
// One device of the kernel's industrial I/O, read through its buffer.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/imu_iio/iio_attributes.h"
#include "drivers/imu_iio/scan_format.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/timestamp.h"

namespace facet {

/// An attribute that the user sets.
struct IioSetting {
    std::string name;  ///< such as in_accel_scale
    std::string value;
};

/// The clock by which the kernel stamps scans.
enum class IioClock : std::uint8_t { kMonotonic, kRealtime };

struct IioOptions {
    std::string sysfs = "/sys/bus/iio/devices";
    std::string dev = "/dev";
    std::string trigger;                    ///< empty: the device's own
    double rate_hz = 0.0;                   ///< scans a second; 0: as it is
    int buffer_length = 128;                ///< scans that the kernel keeps
    int watermark = 1;                      ///< scans that wake a reader
    IioClock clock = IioClock::kMonotonic;  ///< asked for; kernels without the choice stamp by the wall clock
    bool has_stamps = true;                 ///< false: the element of stamps is left out
    bool use_mount_matrix = true;
    std::vector<IioSetting> settings;  ///< in this order; those that a device lacks are left out
};

/// Which quantities a device is read for.
struct IioQuantities {
    bool rate = false;
    bool force = false;
};

/// One scan, in SI units and the axes that the mount matrix leads to.
struct IioScan {
    std::int64_t stamp_ns = 0;             ///< of the device's clock; 0 without stamps
    std::optional<Eigen::Vector3d> rate;   ///< rad/s
    std::optional<Eigen::Vector3d> force;  ///< m/s^2
    std::optional<double> temperature_c;
};

/// Finds a device by its name, sets its buffer up through sysfs, and reads scans from its node
/// (Documentation/iio/iio_devbuf.rst). Never waits. Thread-bound. Heap for problem texts only.
class IioDevice {
public:
    /// Everything is borrowed and must outlive this object.
    /// @param name  content of the device's attribute `name` or `label`, or its folder's name such as iio:device0
    IioDevice(KernelIo& io, const IioOptions& options, const std::string& name, IioQuantities quantities)
        : io_(io), options_(options), name_(name), quantities_(quantities) {}
    ~IioDevice() { close(); }
    IioDevice(const IioDevice&) = delete;
    IioDevice& operator=(const IioDevice&) = delete;

    /// Finds the device again, sets it up and starts its buffer.
    /// @return kNotFound if there is no such device, kInvalidArgument if it can never work (no buffer, no such axes, a
    ///         format that is not known), kIo if the kernel refuses; `problem` has the words, with the name. What was
    ///         opened is left to close().
    Status open(std::string& problem);
    /// Stops the buffer and closes. Nothing if closed.
    void close();

    /// @return kNotReady if there is none now; kCorrupt for a read that is no whole number of scans, whose whole ones
    ///         follow; kIo if the device is gone (error() has the errno)
    Status read(IioScan& scan);

    int fd() const { return fd_; }
    int error() const { return error_; }
    const std::string& name() const { return name_; }
    /// Clock of the stamps, since open.
    IioClock clock() const { return clock_; }
    /// Scans a second that the device says it makes, since open; 0: it does not say.
    double rate_hz() const { return rate_hz_; }
    /// Whether it has this attribute, since open.
    bool has(const std::string& attribute) const;

private:
    static constexpr std::size_t kReadBytes = 32 * kMaxScanBytes;
    static constexpr std::size_t kElements = 8;  ///< three rates, three forces, stamp, temperature

    /// One number of a scan: (raw + offset) * scale.
    struct Channel {
        bool is_enabled = false;
        ScanElement element;
        double scale = 1.0;
        double offset = 0.0;
    };
    enum Slot : std::uint8_t { kRate = 0, kForce = 3, kStamp = 6, kTemperature = 7 };

    Status fail(const std::string& what, int error, std::string& problem);
    Status find(std::string& problem);
    Status open_node(std::string& problem);
    Status set_up(std::string& problem);
    void choose_clock();
    Status apply_settings(std::string& problem);
    void choose_rate();
    bool set_rate(const IioPath& folder, const char* attribute);
    Status choose_trigger(std::string& problem);
    bool is_trigger_set(std::string_view name);
    IioPath trigger_folder();
    Status enable_elements(std::string& problem);
    std::optional<Slot> slot_of(std::string_view element) const;
    Status read_element(std::string_view name, Slot slot, std::string& problem);
    Status lay_out(std::string& problem);
    Status read_conversions(std::string& problem);
    Status read_conversion(Slot slot, const char* type, const char* axis, std::string& problem);
    Status read_mount(const char* type, Eigen::Matrix3d& mount, std::string& problem);
    Status start_buffer(std::string& problem);
    Status fill();
    double value_of(Slot slot, std::size_t axis) const;
    Eigen::Vector3d vector_of(Slot slot, const Eigen::Matrix3d& mount) const;

    KernelIo& io_;
    const IioOptions& options_;
    const std::string& name_;
    IioQuantities quantities_;
    IioPath folder_;
    ShortText<63> node_;  ///< iio:deviceN
    int fd_ = -1;
    int error_ = 0;
    bool is_running_ = false;
    IioClock clock_ = IioClock::kRealtime;
    double rate_hz_ = 0.0;
    std::array<Channel, kElements> channels_;
    Eigen::Matrix3d rate_mount_ = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d force_mount_ = Eigen::Matrix3d::Identity();
    std::size_t scan_bytes_ = 0;
    std::array<std::uint8_t, kReadBytes> bytes_{};
    std::size_t filled_ = 0;
    std::size_t at_ = 0;
};

}  // namespace facet
