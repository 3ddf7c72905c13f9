// SPDX-License-Identifier: BSD-2-Clause
// Which elements of a scan are used, and what their numbers mean.
#include <Eigen/LU>
#include <cerrno>

#include "drivers/imu_iio/iio_device.h"

namespace facet {
namespace {

constexpr std::array kAxes{"x", "y", "z"};

/// Three rows of three numbers: "1, 0, 0; 0, 1, 0; 0, 0, 1".
bool parse_matrix(std::string_view text, Eigen::Matrix3d& matrix) {
    for (int i = 0; i < 9; ++i) {
        if (!take_number(text, matrix(i / 3, i % 3))) {
            return false;
        }
        text.remove_prefix(i < 8 && (text.starts_with(",") || text.starts_with(";")) ? 1 : 0);
    }
    return text.empty();
}

bool is_rotation(const Eigen::Matrix3d& matrix) {
    constexpr double kRounding = 1e-3;  // of matrices in device trees
    return (matrix * matrix.transpose()).isIdentity(kRounding) && matrix.determinant() > 0.0;
}

}  // namespace

std::optional<IioDevice::Slot> IioDevice::slot_of(std::string_view element) const {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
        const auto is = [&](std::string_view type) {
            return element.starts_with(type) && element.substr(type.size()) == kAxes[axis];
        };
        if (quantities_.rate && is("in_anglvel_")) {
            return static_cast<Slot>(kRate + axis);
        }
        if (quantities_.force && is("in_accel_")) {
            return static_cast<Slot>(kForce + axis);
        }
    }
    if (element == "in_timestamp" && options_.has_stamps) {
        return kStamp;
    }
    return element == "in_temp" || element == "in_temp0" ? std::optional(kTemperature) : std::nullopt;
}

Status IioDevice::read_element(std::string_view name, Slot slot, std::string& problem) {
    const IioPath base = folder_ / "scan_elements";
    const auto attribute = [&](std::string_view suffix) {
        ShortText<127> text(name);
        text.append(suffix);
        return base / text.view();
    };
    Channel& channel = channels_[slot];
    IioText type;
    int error = read_number(io_, attribute("_index"), channel.element.index);
    error = error == 0 ? read_attribute(io_, attribute("_type"), type) : error;
    if (error != 0) {
        return fail("scan_elements/" + std::string(name) + " has no index or no type", error, problem);
    }
    if (!ok(parse_scan_type(type.view(), channel.element.type))) {
        return fail("scan_elements/" + std::string(name) + "_type is '" + std::string(type.view()) +
                        "', a form that is not known",
                    0, problem);
    }
    error = write_attribute(io_, attribute("_en"), "1");
    channel.is_enabled = error == 0;
    return error == 0 || slot == kTemperature
               ? Status::kOk
               : fail("scan_elements/" + std::string(name) + "_en cannot be set", error, problem);
}

/// Enables what is wanted and disables what anybody else has left enabled, which would move everything.
Status IioDevice::enable_elements(std::string& problem) {
    constexpr std::string_view kEnable = "_en";
    channels_ = {};
    IioFolder elements(io_, folder_ / "scan_elements");
    for (std::string_view entry; elements.next(entry);) {
        if (!entry.ends_with(kEnable)) {
            continue;
        }
        const std::string_view name = entry.substr(0, entry.size() - kEnable.size());
        const auto slot = slot_of(name);
        if (slot && !channels_[*slot].is_enabled) {
            FACET_TRY(read_element(name, *slot, problem));
            continue;
        }
        const IioPath path = folder_ / "scan_elements" / entry;
        int is_on = 0;
        if (read_number(io_, path, is_on) == 0 && is_on != 0) {
            (void)write_attribute(io_, path, "0");
        }
    }
    if (elements.error() != 0) {
        return fail("has no scan_elements: its driver has no buffer", 0, problem);
    }
    return lay_out(problem);
}

Status IioDevice::lay_out(std::string& problem) {
    const auto has_all = [&](Slot first) {
        return channels_[first].is_enabled && channels_[first + 1].is_enabled && channels_[first + 2].is_enabled;
    };
    if ((quantities_.rate && !has_all(kRate)) || (quantities_.force && !has_all(kForce))) {
        const char* const what = quantities_.rate && !has_all(kRate) ? "angular rates (in_anglvel_x to z)"
                                                                     : "accelerations (in_accel_x to z)";
        return fail(std::string("has no ") + what + " in its scans", 0, problem);
    }
    if (options_.has_stamps && !channels_[kStamp].is_enabled) {
        return fail("has no time stamps in its scans; imu.iio.stamps: arrival is for the bench", 0, problem);
    }
    FixedVector<ScanElement, kElements> elements;
    for (const Channel& channel : channels_) {
        if (channel.is_enabled) {
            elements.push_back(channel.element);
        }
    }
    if (!ok(lay_out_scan(std::span(elements.data(), elements.size()), scan_bytes_))) {
        return fail("its scan elements have equal indices, or are too large together", 0, problem);
    }
    for (Channel& channel : channels_) {
        for (const ScanElement& element : elements) {
            channel.element = element.index == channel.element.index ? element : channel.element;
        }
    }
    return Status::kOk;
}

/// Scale and offset of one axis, or of all of a type. @param axis  nullptr: there is one value only
Status IioDevice::read_conversion(Slot slot, const char* type, const char* axis, std::string& problem) {
    const auto read = [&](const char* what, double& value) {
        ShortText<63> own(type);
        if (axis != nullptr) {
            own.append("_");
            own.append(axis);
        }
        own.append(what);
        ShortText<63> shared(type);
        shared.append(what);
        const int error = read_number(io_, folder_ / own.view(), value);
        return error == -ENOENT ? read_number(io_, folder_ / shared.view(), value) : error;
    };
    Channel& channel = channels_[slot];
    if (const int error = read("_offset", channel.offset); error != 0 && error != -ENOENT) {
        return fail(std::string(type) + "_offset cannot be read", error, problem);
    }
    const int error = read("_scale", channel.scale);
    if (slot == kTemperature) {
        channel.is_enabled = channel.is_enabled && error == 0;  // its place in the scan stays
        return Status::kOk;
    }
    if (error == 0 && channel.scale == 0.0) {
        return fail(std::string(type) + "_scale is zero", 0, problem);
    }
    return error == 0 ? Status::kOk : fail(std::string(type) + "_scale cannot be read", error, problem);
}

Status IioDevice::read_mount(const char* type, Eigen::Matrix3d& mount, std::string& problem) {
    mount.setIdentity();
    if (!options_.use_mount_matrix) {
        return Status::kOk;
    }
    for (const char* prefix : {type, "in", ""}) {
        ShortText<63> name(prefix);
        name.append(*prefix == '\0' ? "mount_matrix" : "_mount_matrix");
        IioText text;
        if (read_attribute(io_, folder_ / name.view(), text) != 0) {
            continue;
        }
        if (!parse_matrix(text.view(), mount) || !is_rotation(mount)) {
            return fail(std::string(name.view()) + " is '" + std::string(text.view()) +
                            "', no rotation; imu.iio.mount_matrix: false leaves it out",
                        0, problem);
        }
        return Status::kOk;
    }
    return Status::kOk;
}

Status IioDevice::read_conversions(std::string& problem) {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
        if (quantities_.rate) {
            FACET_TRY(read_conversion(static_cast<Slot>(kRate + axis), "in_anglvel", kAxes[axis], problem));
        }
        if (quantities_.force) {
            FACET_TRY(read_conversion(static_cast<Slot>(kForce + axis), "in_accel", kAxes[axis], problem));
        }
    }
    (void)read_conversion(kTemperature, "in_temp", nullptr, problem);
    FACET_TRY(read_mount("in_anglvel", rate_mount_, problem));
    return read_mount("in_accel", force_mount_, problem);
}

}  // namespace facet
