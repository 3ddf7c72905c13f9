// SPDX-License-Identifier: BSD-2-Clause
// How a device is found and set up; attributes are those of Documentation/ABI/testing/sysfs-bus-iio.
#include <fcntl.h>

#include <cerrno>
#include <cstring>

#include "drivers/imu_iio/iio_device.h"

namespace facet {
namespace {

/// Names of all devices, for a message.
std::string known_names(KernelIo& io, const IioPath& root) {
    std::string names;
    IioFolder devices(io, root);
    for (std::string_view entry; devices.next(entry);) {
        IioText name;
        if (entry.starts_with("iio:device") && read_attribute(io, root / entry / "name", name) == 0) {
            names += (names.empty() ? "" : ", ") + std::string(name.view());
        }
    }
    return names;
}

/// The least of the listed frequencies that is as fast as asked for, or the fastest. Lists are numbers with spaces;
/// ranges "[least step most]" take whatever lies within.
double nearest_rate(std::string_view list, double wanted_hz) {
    if (list.starts_with("[")) {
        return wanted_hz;
    }
    double best_hz = 0.0;
    for (double rate_hz = 0.0; take_number(list, rate_hz);) {
        const bool is_enough = rate_hz >= wanted_hz * 0.999;
        const bool is_better = best_hz >= wanted_hz * 0.999 ? is_enough && rate_hz < best_hz : rate_hz > best_hz;
        best_hz = is_better ? rate_hz : best_hz;
    }
    return best_hz > 0.0 ? best_hz : wanted_hz;
}

}  // namespace

Status IioDevice::fail(const std::string& what, int error, std::string& problem) {
    problem = name_ + ": " + what + (error == 0 ? "" : std::string(": ") + std::strerror(-error));
    if (error == -EACCES || error == -EPERM) {
        problem += "; the program's user must be allowed to write the attributes";
    }
    return error == 0 ? Status::kInvalidArgument : Status::kIo;
}

Status IioDevice::find(std::string& problem) {
    const IioPath root(options_.sysfs);
    IioFolder devices(io_, root);
    for (std::string_view entry; devices.next(entry);) {
        if (!entry.starts_with("iio:device")) {
            continue;
        }
        IioText name;
        IioText label;
        (void)read_attribute(io_, root / entry / "name", name);
        (void)read_attribute(io_, root / entry / "label", label);
        if (name_ == entry || name_ == name.view() || name_ == label.view()) {
            folder_ = root / entry;
            node_ = ShortText<63>(entry);
            return Status::kOk;
        }
    }
    const std::string known = known_names(io_, root);
    problem = name_ + ": no such device in " + options_.sysfs +
              (known.empty() ? ", which has none" : "; there are: " + known);
    return Status::kNotFound;
}

/// First of all, so that another program's buffer is not stopped.
Status IioDevice::open_node(std::string& problem) {
    const IioPath node = IioPath(options_.dev) / node_.view();
    const int fd = io_.open(node.c_str(), O_RDONLY | O_NONBLOCK);
    if (fd < 0) {
        return fail(std::string(node.view()) + " cannot be opened", fd, problem);
    }
    fd_ = fd;
    return Status::kOk;
}

bool IioDevice::has(const std::string& attribute) const {
    IioText text;
    return read_attribute(io_, folder_ / attribute, text) == 0;
}

void IioDevice::choose_clock() {
    const IioPath path = folder_ / "current_timestamp_clock";
    const std::string_view wanted = options_.clock == IioClock::kMonotonic ? "monotonic" : "realtime";
    IioText now;
    (void)write_attribute(io_, path, wanted);
    const bool is_monotonic = read_attribute(io_, path, now) == 0 && now.view() == "monotonic";
    clock_ = is_monotonic ? IioClock::kMonotonic : IioClock::kRealtime;
}

/// Sensor hubs report changes above a threshold only, which is taken away; then what the user has set.
Status IioDevice::apply_settings(std::string& problem) {
    for (const char* hysteresis : {"in_accel_hysteresis", "in_anglvel_hysteresis"}) {
        (void)write_attribute(io_, folder_ / hysteresis, "0");
    }
    for (const IioSetting& setting : options_.settings) {
        const int error = write_attribute(io_, folder_ / setting.name, setting.value);
        if (error != 0 && error != -ENOENT) {
            return fail(setting.name + " does not take '" + setting.value + "'", error, problem);
        }
    }
    return Status::kOk;
}

/// @return whether there is such an attribute
bool IioDevice::set_rate(const IioPath& folder, const char* attribute) {
    const IioPath path = folder / attribute;
    IioText text;
    if (read_attribute(io_, path, text) != 0) {
        return false;
    }
    if (options_.rate_hz > 0.0) {
        IioText list;
        ShortText<63> available(attribute);
        available.append("_available");
        const bool is_listed = read_attribute(io_, folder / available.view(), list) == 0;
        const double rate_hz = is_listed ? nearest_rate(list.view(), options_.rate_hz) : options_.rate_hz;
        (void)write_attribute(io_, path, NumberText(rate_hz).view());
    }
    (void)read_number(io_, path, rate_hz_);
    return true;
}

/// One frequency for all, or one for each quantity; else the trigger's. What becomes of it is for the caller to judge.
void IioDevice::choose_rate() {
    rate_hz_ = 0.0;
    bool is_set = set_rate(folder_, "sampling_frequency");
    if (quantities_.force) {
        is_set = set_rate(folder_, "in_accel_sampling_frequency") || is_set;
    }
    if (quantities_.rate) {
        is_set = set_rate(folder_, "in_anglvel_sampling_frequency") || is_set;
    }
    if (!is_set || !options_.trigger.empty()) {
        (void)set_rate(trigger_folder(), "sampling_frequency");
    }
}

/// The folder of the current trigger; the root's if there is none.
IioPath IioDevice::trigger_folder() {
    const IioPath root(options_.sysfs);
    IioText current;
    if (read_attribute(io_, folder_ / "trigger/current_trigger", current) != 0 || current.view().empty()) {
        return root;
    }
    IioFolder entries(io_, root);
    for (std::string_view entry; entries.next(entry);) {
        IioText name;
        if (entry.starts_with("trigger") && read_attribute(io_, root / entry / "name", name) == 0 &&
            name.view() == current.view()) {
            return root / entry;
        }
    }
    return root;
}

/// The kernel takes the name of a trigger that does not exist as that of none.
bool IioDevice::is_trigger_set(std::string_view name) {
    const IioPath path = folder_ / "trigger/current_trigger";
    IioText now;
    return write_attribute(io_, path, name) == 0 && read_attribute(io_, path, now) == 0 && now.view() == name;
}

Status IioDevice::choose_trigger(std::string& problem) {
    IioText current;
    const int error = read_attribute(io_, folder_ / "trigger/current_trigger", current);
    if (!options_.trigger.empty()) {
        if (error != 0) {
            return fail("takes no trigger; leave imu.iio.trigger out", 0, problem);
        }
        return is_trigger_set(options_.trigger)
                   ? Status::kOk
                   : fail("trigger '" + options_.trigger + "' does not exist, or is not for this device", 0, problem);
    }
    if (error == 0 && current.view().empty()) {
        // Drivers call the trigger of their own interrupt NAME-devN.
        IioText name;
        (void)read_attribute(io_, folder_ / "name", name);
        name.append("-dev");
        name.append(node_.view().substr(std::string_view("iio:device").size()));
        (void)is_trigger_set(name.view());
    }
    return Status::kOk;
}

Status IioDevice::start_buffer(std::string& problem) {
    if (const int error = write_attribute(io_, folder_ / "buffer/length", NumberText(options_.buffer_length).view());
        error != 0) {
        return fail("buffer/length cannot be set", error, problem);
    }
    // Kernels and drivers without it wake readers at every scan.
    (void)write_attribute(io_, folder_ / "buffer/watermark", NumberText(options_.watermark).view());
    const int error = write_attribute(io_, folder_ / "buffer/enable", "1");
    if (error != 0) {
        IioText trigger;
        const bool lacks_trigger =
            read_attribute(io_, folder_ / "trigger/current_trigger", trigger) == 0 && trigger.view().empty();
        return fail(lacks_trigger ? "the buffer does not start without a trigger: imu.iio.trigger"
                                  : "the buffer does not start",
                    error, problem);
    }
    is_running_ = true;
    return Status::kOk;
}

Status IioDevice::set_up(std::string& problem) {
    if (const int error = write_attribute(io_, folder_ / "buffer/enable", "0"); error != 0) {
        return error == -ENOENT ? fail("has no buffer: its driver gives single readings only", 0, problem)
                                : fail("buffer/enable cannot be set", error, problem);
    }
    choose_clock();
    FACET_TRY(apply_settings(problem));
    FACET_TRY(choose_trigger(problem));
    choose_rate();
    FACET_TRY(enable_elements(problem));
    return read_conversions(problem);
}

Status IioDevice::open(std::string& problem) {
    close();
    FACET_TRY(find(problem));
    FACET_TRY(open_node(problem));
    FACET_TRY(set_up(problem));
    return start_buffer(problem);
}

}  // namespace facet
