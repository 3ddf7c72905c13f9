// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/v4l2_controls.h"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <cctype>
#include <cerrno>
#include <cstring>

namespace facet {
namespace {

/// "Exposure Time, Absolute" -> "exposure_time_absolute", as v4l2-ctl does.
std::string control_name(const char* text, std::size_t size) {
    std::string name;
    bool gap = false;
    for (std::size_t i = 0; i < size && text[i] != '\0'; ++i) {
        if (std::isalnum(static_cast<unsigned char>(text[i])) != 0) {
            if (gap && !name.empty()) {
                name += '_';
            }
            gap = false;
            name += static_cast<char>(std::tolower(static_cast<unsigned char>(text[i])));
        } else {
            gap = true;
        }
    }
    return name;
}

}  // namespace

Status V4l2Controls::fail(const std::string& what, int result, std::string& problem) const {
    problem = device_ + ": " + what + (result != 0 ? std::string(": ") + std::strerror(-result) : "");
    return result == -ENOENT || result == -ENODEV || result == -ENXIO ? Status::kNotFound : Status::kIo;
}

Status V4l2Controls::open(const std::string& device, std::string& problem) {
    close();
    device_ = device;
    fd_ = io_.open(device.c_str(), O_RDWR | O_NONBLOCK);
    is_own_ = fd_ >= 0;
    return is_own_ ? Status::kOk : fail("cannot be opened", fd_, problem);
}

void V4l2Controls::borrow(int descriptor, const std::string& device) {
    close();
    device_ = device;
    fd_ = descriptor;
}

void V4l2Controls::close() {
    if (is_own_) {
        (void)io_.close(fd_);
    }
    is_own_ = false;
    fd_ = -1;
}

Status V4l2Controls::find(std::string_view name, V4l2Control& control, std::string& problem) {
    std::string there;
    v4l2_query_ext_ctrl query{};
    for (query.id = V4L2_CTRL_FLAG_NEXT_CTRL; io_.ioctl(fd_, VIDIOC_QUERY_EXT_CTRL, &query) >= 0;
         query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
        const std::string found = control_name(query.name, sizeof query.name);
        if (found == name) {
            control = {query.id, query.minimum, query.maximum, query.type == V4L2_CTRL_TYPE_INTEGER64};
            return Status::kOk;
        }
        there += (there.empty() ? "" : ", ") + found;
    }
    (void)fail("has no control " + std::string(name) + "; there " + (there.empty() ? "are none" : "are: " + there), 0,
               problem);
    return Status::kNotFound;
}

int V4l2Controls::write(const V4l2Control& control, std::int64_t value) {
    if (value < control.least || value > control.most) {
        return -ERANGE;
    }
    v4l2_ext_control one{};
    one.id = control.id;
    if (control.is_wide) {
        one.value64 = value;
    } else {
        one.value = static_cast<std::int32_t>(value);
    }
    v4l2_ext_controls all{};
    all.which = V4L2_CTRL_WHICH_CUR_VAL;
    all.count = 1;
    all.controls = &one;
    return io_.ioctl(fd_, VIDIOC_S_EXT_CTRLS, &all);
}

Status V4l2Controls::set(std::string_view name, std::int64_t value, std::string& problem) {
    V4l2Control control;
    FACET_TRY(find(name, control, problem));
    if (value < control.least || value > control.most) {
        (void)fail("control " + std::string(name) + " must be " + std::to_string(control.least) + " to " +
                       std::to_string(control.most) + ", not " + std::to_string(value),
                   0, problem);
        return Status::kInvalidArgument;
    }
    const int result = write(control, value);
    return result < 0 ? fail("control " + std::string(name) + " refused", result, problem) : Status::kOk;
}

}  // namespace facet
