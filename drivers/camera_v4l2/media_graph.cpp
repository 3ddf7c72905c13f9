// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/media_graph.h"

#include <fcntl.h>
#include <linux/media-bus-format.h>
#include <linux/media.h>
#include <linux/v4l2-subdev.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace facet {
namespace {

constexpr int kDevices = 16;                 // /dev/media0 and so on
constexpr std::size_t kLongest = 16;         // way: a graph with a ring in it is damaged
constexpr std::uint32_t kY16OnBus = 0x202e;  // MEDIA_BUS_FMT_Y16_1X16, which older headers lack

/// Bus formats of which a bridge makes these pixels, the likeliest first.
std::vector<std::uint32_t> bus_codes(PixelFormat format) {
    switch (format) {
        case PixelFormat::kGrey: return {MEDIA_BUS_FMT_Y8_1X8};
        case PixelFormat::kY10:
        case PixelFormat::kY10p: return {MEDIA_BUS_FMT_Y10_1X10};
        case PixelFormat::kY12:
        case PixelFormat::kY012: return {MEDIA_BUS_FMT_Y12_1X12};
        case PixelFormat::kY16: return {kY16OnBus, MEDIA_BUS_FMT_Y12_1X12, MEDIA_BUS_FMT_Y10_1X10};
        case PixelFormat::kYuyv: return {MEDIA_BUS_FMT_YUYV8_1X16, MEDIA_BUS_FMT_YUYV8_2X8};
        case PixelFormat::kUyvy: return {MEDIA_BUS_FMT_UYVY8_1X16, MEDIA_BUS_FMT_UYVY8_2X8};
        case PixelFormat::kNv12: return {MEDIA_BUS_FMT_UYVY8_1X16, MEDIA_BUS_FMT_YUYV8_1X16};
        case PixelFormat::kY8i:  // cameras on USB only
        case PixelFormat::kY12i:
        case PixelFormat::kMjpg: break;
    }
    return {};
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

std::string code_text(std::uint32_t code) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text = "bus format 0x";
    for (int shift = 12; shift >= 0; shift -= 4) {
        text += kDigits[(code >> static_cast<unsigned>(shift)) & 0xFU];
    }
    return text;
}

/// The kernel's name of a device, by its numbers: DEVNAME of its uevent, below /dev.
std::string device_path(KernelIo& io, unsigned major, unsigned minor) {
    const std::string uevent = "/sys/dev/char/" + std::to_string(major) + ":" + std::to_string(minor) + "/uevent";
    const int fd = io.open(uevent.c_str(), O_RDONLY);
    if (fd < 0) {
        return "";
    }
    std::array<char, 512> text{};
    const std::int64_t size = io.read(fd, text.data(), text.size());
    (void)io.close(fd);
    const std::string_view all(text.data(), static_cast<std::size_t>(std::max<std::int64_t>(size, 0)));
    constexpr std::string_view kKey = "DEVNAME=";
    const std::size_t begin = all.find(kKey);
    if (begin == std::string_view::npos) {
        return "";
    }
    const std::string_view rest = all.substr(begin + kKey.size());
    return "/dev/" + std::string(rest.substr(0, rest.find('\n')));
}

}  // namespace

void MediaGraph::close() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
    fd_ = -1;
}

bool MediaGraph::read_topology() {
    media_v2_topology sizes{};
    if (io_.ioctl(fd_, MEDIA_IOC_G_TOPOLOGY, &sizes) < 0) {
        return false;
    }
    std::vector<media_v2_entity> entities(sizes.num_entities);
    std::vector<media_v2_interface> interfaces(sizes.num_interfaces);
    std::vector<media_v2_pad> pads(sizes.num_pads);
    std::vector<media_v2_link> links(sizes.num_links);
    media_v2_topology all = sizes;
    all.ptr_entities = reinterpret_cast<std::uintptr_t>(entities.data());
    all.ptr_interfaces = reinterpret_cast<std::uintptr_t>(interfaces.data());
    all.ptr_pads = reinterpret_cast<std::uintptr_t>(pads.data());
    all.ptr_links = reinterpret_cast<std::uintptr_t>(links.data());
    if (io_.ioctl(fd_, MEDIA_IOC_G_TOPOLOGY, &all) < 0) {
        return false;  // it has grown meanwhile: the next attempt to open the camera sees it
    }
    entities_.clear();
    interfaces_.clear();
    pads_.clear();
    data_links_.clear();
    interface_links_.clear();
    for (const media_v2_entity& entity : entities) {
        entities_.push_back({entity.id, std::string(entity.name, ::strnlen(entity.name, sizeof entity.name))});
    }
    for (const media_v2_interface& interface : interfaces) {
        interfaces_.push_back({interface.id, interface.devnode.major, interface.devnode.minor});
    }
    for (const media_v2_pad& pad : pads) {
        pads_.push_back({pad.id, pad.entity_id, pad.index, (pad.flags & MEDIA_PAD_FL_SINK) != 0});
    }
    for (const media_v2_link& link : links) {
        const std::uint32_t kind = link.flags & MEDIA_LNK_FL_LINK_TYPE;
        if (kind == MEDIA_LNK_FL_DATA_LINK) {
            data_links_.push_back({link.source_id, link.sink_id, link.flags});
        } else if (kind == MEDIA_LNK_FL_INTERFACE_LINK) {
            interface_links_.push_back({link.source_id, link.sink_id, link.flags});
        }
    }
    return true;
}

/// The media device that has the capture node as an interface.
Status MediaGraph::find_device(int video_fd, std::uint32_t& entity, std::string& problem) {
    unsigned major = 0;
    unsigned minor = 0;
    if (const int result = io_.device_number(video_fd, major, minor); result < 0) {
        problem = std::string("its number is not known: ") + std::strerror(-result);
        return Status::kIo;
    }
    for (int i = 0; i < kDevices; ++i) {
        close();
        path_ = "/dev/media" + std::to_string(i);
        fd_ = io_.open(path_.c_str(), O_RDWR);
        if (fd_ < 0 || !read_topology()) {
            continue;
        }
        const auto interface = std::ranges::find_if(
            interfaces_, [&](const Interface& known) { return known.major == major && known.minor == minor; });
        if (interface == interfaces_.end()) {
            continue;
        }
        const auto link = std::ranges::find(interface_links_, interface->id, &Link::source);
        if (link != interface_links_.end()) {
            entity = link->sink;
            return Status::kOk;
        }
    }
    problem = "its images come through a media device, but none that can be opened (/dev/media*) has it";
    return Status::kNotFound;
}

const MediaGraph::Pad* MediaGraph::pad(std::uint32_t id) const {
    const auto found = std::ranges::find(pads_, id, &Pad::id);
    return found == pads_.end() ? nullptr : &*found;
}

std::string MediaGraph::name_of(std::uint32_t entity) const {
    const auto found = std::ranges::find(entities_, entity, &Entity::id);
    return path_ + " '" + (found == entities_.end() ? "?" : found->name) + "'";
}

/// Of a part's own node; empty if it has none, as where the bridge's driver sets its parts itself.
std::string MediaGraph::node_of(std::uint32_t entity) const {
    for (const Link& link : interface_links_) {
        const auto interface = std::ranges::find(interfaces_, link.source, &Interface::id);
        if (link.sink == entity && interface != interfaces_.end()) {
            return device_path(io_, interface->major, interface->minor);
        }
    }
    return "";
}

Status MediaGraph::enable(const Pad& source, const Pad& sink, std::string& problem) {
    media_link_desc link{};
    link.source = {source.entity, static_cast<__u16>(source.index), MEDIA_PAD_FL_SOURCE, {}};
    link.sink = {sink.entity, static_cast<__u16>(sink.index), MEDIA_PAD_FL_SINK, {}};
    link.flags = MEDIA_LNK_FL_ENABLED;
    const int result = io_.ioctl(fd_, MEDIA_IOC_SETUP_LINK, &link);
    if (result < 0) {
        problem = name_of(sink.entity) + ": the link from " + name_of(source.entity) +
                  " cannot be enabled: " + std::strerror(-result);
        return Status::kIo;
    }
    return Status::kOk;
}

/// The enabled link into a pad; the only one there is will be enabled.
Status MediaGraph::choose_link(const Pad& sink, Pad& source, std::string& problem) {
    const Link* only = nullptr;
    int links = 0;
    for (const Link& link : data_links_) {
        const Pad* const from = link.sink == sink.id ? pad(link.source) : nullptr;
        if (from == nullptr) {
            continue;
        }
        if ((link.flags & MEDIA_LNK_FL_ENABLED) != 0) {
            source = *from;
            return Status::kOk;
        }
        only = &link;
        ++links;
    }
    if (links == 1) {
        source = *pad(only->source);
        return enable(source, sink, problem);
    }
    problem = name_of(sink.entity) + ": " +
              (links == 0 ? "no link leads to it"
                          : "none of " + std::to_string(links) + " links to it is enabled: choose one with media-ctl");
    return Status::kInvalidArgument;
}

Status MediaGraph::find_way(std::uint32_t entity, std::string& problem) {
    way_.clear();
    for (std::size_t steps = 0; steps < kLongest; ++steps) {
        const auto sink =
            std::ranges::find_if(pads_, [&](const Pad& known) { return known.entity == entity && known.is_sink; });
        if (sink == pads_.end()) {
            return Status::kOk;  // nothing leads into a sensor
        }
        Step step{{}, *sink};
        FACET_TRY(choose_link(step.sink, step.source, problem));
        way_.insert(way_.begin(), step);
        entity = step.source.entity;
    }
    problem = path_ + ": its links lead in a ring";
    return Status::kInvalidArgument;
}

/// @param given  what the part makes of it
Status MediaGraph::set_format(const Pad& pad, const BusFormat& wanted, BusFormat& given, std::string& problem) {
    given = wanted;
    const std::string node = node_of(pad.entity);
    if (node.empty()) {
        return Status::kOk;
    }
    const int fd = io_.open(node.c_str(), O_RDWR);
    if (fd < 0) {
        problem = name_of(pad.entity) + ": " + node + " cannot be opened: " + std::strerror(-fd);
        return Status::kIo;
    }
    v4l2_subdev_format format{};
    format.which = V4L2_SUBDEV_FORMAT_ACTIVE;
    format.pad = pad.index;
    format.format.width = wanted.width;
    format.format.height = wanted.height;
    format.format.code = wanted.code;
    format.format.field = V4L2_FIELD_NONE;
    const int result = io_.ioctl(fd, VIDIOC_SUBDEV_S_FMT, &format);
    (void)io_.close(fd);
    if (result < 0) {
        problem =
            name_of(pad.entity) + ": " + size_text(wanted.width, wanted.height) + " refused: " + std::strerror(-result);
        return Status::kIo;
    }
    given = {format.format.code, format.format.width, format.format.height};
    return Status::kOk;
}

Status MediaGraph::set_sensor(const Pad& source, const Wanted& wanted, BusFormat& format, std::string& problem) {
    BusFormat given;
    for (const std::uint32_t code : bus_codes(wanted.format)) {
        format = {code, wanted.width, wanted.height};
        FACET_TRY(set_format(source, format, given, problem));
        if (given == format) {
            return Status::kOk;
        }
    }
    problem = name_of(source.entity) + ": gives " + size_text(given.width, given.height) + " in " +
              code_text(given.code) + " instead of " + size_text(wanted.width, wanted.height) + " in " +
              code_text(format.code);
    return Status::kInvalidArgument;
}

Status MediaGraph::set_formats(const Wanted& wanted, std::string& problem) {
    BusFormat format;
    for (const Step& step : way_) {
        if (&step == &way_.front()) {
            FACET_TRY(set_sensor(step.source, wanted, format, problem));
        } else {
            BusFormat given;
            FACET_TRY(set_format(step.source, format, given, problem));
            format = given;
        }
        if (&step == &way_.back()) {
            break;  // the node's own format is set by whoever captures
        }
        BusFormat taken;
        FACET_TRY(set_format(step.sink, format, taken, problem));
        if (taken != format) {
            problem = name_of(step.sink.entity) + ": takes " + size_text(taken.width, taken.height) + " in " +
                      code_text(taken.code) + ", not " + size_text(format.width, format.height) + " in " +
                      code_text(format.code);
            return Status::kInvalidArgument;
        }
    }
    return Status::kOk;
}

Status MediaGraph::set_up(int video_fd, const Wanted& wanted, std::string& problem) {
    std::uint32_t entity = 0;
    FACET_TRY(find_device(video_fd, entity, problem));
    FACET_TRY(find_way(entity, problem));
    if (way_.empty()) {
        problem = path_ + ": nothing leads to the node";
        return Status::kInvalidArgument;
    }
    const Status status = set_formats(wanted, problem);
    close();
    return status;
}

}  // namespace facet
