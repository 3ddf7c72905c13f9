// SPDX-License-Identifier: BSD-2-Clause
// A bridge for CSI cameras as a media device: sensor, receiver and capture node, and streaming that looks at the
// formats between them as the kernel's link validation does.
#pragma once

#include <linux/media-bus-format.h>
#include <linux/media.h>
#include <linux/v4l2-subdev.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "tests/drivers/camera_v4l2/fake_camera.h"

namespace facet::test {

struct FakeBusFormat {
    std::uint32_t code = 0;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    bool operator==(const FakeBusFormat&) const = default;
};

/// sensor (pad 0) -> (pad 0) receiver (pad 1) -> (pad 0) node. A second sensor may lead to the same receiver.
class FakeMedia final : public FakeKernel {
public:
    explicit FakeMedia(ManualClock& clock) : camera(clock) {
        camera.more_capabilities = V4L2_CAP_IO_MC;
        camera.on_stream = [this] { return fits() ? 0 : -EPIPE; };
    }

    FakeCamera camera;
    bool has_media = true;    ///< the media device can be opened
    bool is_linked = true;    ///< sensor and receiver; the node always is
    bool has_second = false;  ///< another sensor, whose link is not enabled
    bool has_receiver_node = true;
    bool validates = true;  ///< streaming looks at the formats
    FakeBusFormat sensor_default{MEDIA_BUS_FMT_SBGGR10_1X10, 1920, 1080};
    std::uint32_t sensor_code = MEDIA_BUS_FMT_Y8_1X8;  ///< the one it has besides
    std::uint32_t receiver_widest = 4096;
    std::array<FakeBusFormat, 3> pads{sensor_default, {}, {}};  ///< sensor, receiver's sink, receiver's source
    int open_nodes = 0;
    int links_enabled = 0;

    int open(const char* path, int flags) override {
        const std::string name(path);
        const auto found = [&](int fd) {
            ++open_nodes;
            return fd;
        };
        if (name == "/dev/media1" && has_media) {
            return found(kMedia);
        }
        if (name == "/dev/media0") {
            return found(kOther);
        }
        if (name == "/dev/v4l-subdev0" || name == "/dev/v4l-subdev1") {
            return found(name.back() == '0' ? kSensor : kReceiver);
        }
        if (name.starts_with("/sys/dev/char/81:")) {
            asked_ = name;
            return found(kUevent);
        }
        return camera.open(path, flags);
    }
    int close(int fd) override {
        if (fd < kMedia) {
            return camera.close(fd);
        }
        --open_nodes;
        return 0;
    }
    int device_number(int fd, unsigned& major, unsigned& minor) override {
        major = 81;
        minor = 7;
        return fd == FakeCamera::kFd ? 0 : -EBADF;
    }
    std::int64_t read(int fd, void* buffer, std::size_t size) override {
        if (fd != kUevent) {
            return -EBADF;
        }
        const std::string number = asked_.substr(17, asked_.find("/uevent") - 17);
        const std::string text =
            "MAJOR=81\nMINOR=" + number + "\nDEVNAME=v4l-subdev" + (number == "8" ? "0" : "1") + "\n";
        const std::size_t taken = std::min(size, text.size());
        std::memcpy(buffer, text.data(), taken);
        return static_cast<std::int64_t>(taken);
    }
    int ioctl(int fd, unsigned long request, void* argument) override {
        if (fd == kOther && request == MEDIA_IOC_G_TOPOLOGY) {
            return 0;  // of a codec: nothing in it
        }
        if (fd == kMedia && request == MEDIA_IOC_G_TOPOLOGY) {
            return topology(*static_cast<media_v2_topology*>(argument));
        }
        if (fd == kMedia && request == MEDIA_IOC_SETUP_LINK) {
            ++links_enabled;
            is_linked = true;
            return 0;
        }
        if ((fd == kSensor || fd == kReceiver) && request == VIDIOC_SUBDEV_S_FMT) {
            return set_format(fd, *static_cast<v4l2_subdev_format*>(argument));
        }
        return fd >= kMedia ? -ENOTTY : camera.ioctl(fd, request, argument);
    }
    int wait_readable(int fd, Duration timeout) override { return camera.wait_readable(fd, timeout); }
    int map(int fd, std::size_t length, std::int64_t offset, void*& address) override {
        return camera.map(fd, length, offset, address);
    }
    int unmap(void* address, std::size_t length) override { return camera.unmap(address, length); }

    bool fits() const {
        const FakeBusFormat node{sensor_code, camera.width, camera.height};
        return !validates || (is_linked && pads[0] == pads[1] && pads[1] == pads[2] && pads[2] == node);
    }

private:
    static constexpr int kMedia = 100;
    static constexpr int kSensor = 101;
    static constexpr int kReceiver = 102;
    static constexpr int kUevent = 103;
    static constexpr int kOther = 104;

    template <class T>
    static std::uint32_t give(const std::vector<T>& all, std::uint32_t count, std::uint64_t pointer) {
        if (pointer != 0) {
            REQUIRE(count == all.size());
            std::memcpy(reinterpret_cast<void*>(static_cast<std::uintptr_t>(pointer)), all.data(),
                        all.size() * sizeof(T));
        }
        return static_cast<std::uint32_t>(all.size());
    }
    static media_v2_entity entity(std::uint32_t id, const char* name) {
        media_v2_entity made{};
        made.id = id;
        std::strcpy(static_cast<char*>(made.name), name);
        return made;
    }
    static media_v2_pad pad(std::uint32_t id, std::uint32_t of, std::uint32_t flags, std::uint32_t index) {
        media_v2_pad made{};
        made.id = id;
        made.entity_id = of;
        made.flags = flags;
        made.index = index;
        return made;
    }
    static media_v2_link link(std::uint32_t source, std::uint32_t sink, std::uint32_t flags) {
        media_v2_link made{};
        made.source_id = source;
        made.sink_id = sink;
        made.flags = flags;
        return made;
    }
    static media_v2_interface interface(std::uint32_t id, std::uint32_t minor) {
        media_v2_interface made{};
        made.id = id;
        made.devnode = {81, minor};
        return made;
    }
    int topology(media_v2_topology& out) const {
        std::vector<media_v2_entity> entities{entity(1, "ov9281 10-0060"), entity(2, "csi2"), entity(3, "csi-image")};
        std::vector<media_v2_pad> all_pads{pad(11, 1, MEDIA_PAD_FL_SOURCE, 0), pad(21, 2, MEDIA_PAD_FL_SINK, 0),
                                           pad(22, 2, MEDIA_PAD_FL_SOURCE, 1), pad(31, 3, MEDIA_PAD_FL_SINK, 0)};
        const std::uint32_t enabled = MEDIA_LNK_FL_DATA_LINK | MEDIA_LNK_FL_ENABLED;
        std::vector<media_v2_link> links{link(11, 21, is_linked ? enabled : MEDIA_LNK_FL_DATA_LINK),
                                         link(22, 31, enabled), link(57, 3, MEDIA_LNK_FL_INTERFACE_LINK),
                                         link(58, 1, MEDIA_LNK_FL_INTERFACE_LINK)};
        const std::vector<media_v2_interface> interfaces{interface(57, 7), interface(58, 8), interface(59, 9)};
        if (has_receiver_node) {
            links.push_back(link(59, 2, MEDIA_LNK_FL_INTERFACE_LINK));
        }
        if (has_second) {
            entities.push_back(entity(4, "imx296 11-001a"));
            all_pads.push_back(pad(41, 4, MEDIA_PAD_FL_SOURCE, 0));
            links.push_back(link(41, 21, MEDIA_LNK_FL_DATA_LINK));
        }
        out.num_entities = give(entities, out.num_entities, out.ptr_entities);
        out.num_interfaces = give(interfaces, out.num_interfaces, out.ptr_interfaces);
        out.num_pads = give(all_pads, out.num_pads, out.ptr_pads);
        out.num_links = give(links, out.num_links, out.ptr_links);
        return 0;
    }
    int set_format(int fd, v4l2_subdev_format& format) {
        CHECK(format.which == V4L2_SUBDEV_FORMAT_ACTIVE);
        FakeBusFormat wanted{format.format.code, format.format.width, format.format.height};
        if (fd == kSensor) {
            wanted = wanted.code == sensor_code && wanted.width == camera.width && wanted.height == camera.height
                         ? wanted
                         : sensor_default;
        } else if (format.pad == 0) {
            wanted.width = std::min(wanted.width, receiver_widest);
            pads[2] = wanted;
        }
        pads[fd == kSensor ? 0 : 1 + format.pad] = wanted;
        format.format.code = wanted.code;
        format.format.width = wanted.width;
        format.format.height = wanted.height;
        return 0;
    }

    std::string asked_;
};

}  // namespace facet::test
