// SPDX-License-Identifier: BSD-2-Clause
// Sets up the way from a sensor to the node that delivers its images.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/camera_v4l2/unpack.h"
#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// Behind a capture node that says V4L2_CAP_IO_MC (Raspberry Pi, i.MX, Rockchip and other bridges for CSI) lies a graph
/// of a media device: sensor, receiver, perhaps a processor. There the node's own format sets nothing but the layout in
/// memory; size and bus format are set on each part of the way, and streaming starts only if they agree (kernel
/// documentation "Media Controller devices", "Sub-device Interface"). This goes upstream from the node along the links
/// that are enabled, enabling one where it is the only one there is, and then sets the formats from the sensor
/// downwards. Thread-bound. Heap.
class MediaGraph {
public:
    explicit MediaGraph(KernelIo& io) : io_(io) {}
    ~MediaGraph() { close(); }
    MediaGraph(const MediaGraph&) = delete;
    MediaGraph& operator=(const MediaGraph&) = delete;

    struct Wanted {
        std::uint32_t width = 0;
        std::uint32_t height = 0;
        PixelFormat format = PixelFormat::kGrey;
    };

    /// @param video_fd  the capture node, open
    /// @param problem   set on failure, without the node's name: what is wrong, with the names of media device and part
    /// @return kNotFound if no media device has the node, kInvalidArgument if there is no way from a sensor, or a part
    /// of
    ///         it does not take the size or any bus format of these pixels, kIo if the system refuses
    Status set_up(int video_fd, const Wanted& wanted, std::string& problem);

private:
    struct Pad {
        std::uint32_t id = 0;
        std::uint32_t entity = 0;
        std::uint32_t index = 0;
        bool is_sink = false;
    };
    struct Link {
        std::uint32_t source = 0;  ///< pad, or interface
        std::uint32_t sink = 0;    ///< pad, or entity
        std::uint32_t flags = 0;
    };
    struct Entity {
        std::uint32_t id = 0;
        std::string name;
    };
    struct Interface {
        std::uint32_t id = 0;
        unsigned major = 0;
        unsigned minor = 0;
    };
    /// A link of the way: from the source pad of one part to the sink pad of the next.
    struct Step {
        Pad source;
        Pad sink;
    };
    struct BusFormat {
        std::uint32_t code = 0;
        std::uint32_t width = 0;
        std::uint32_t height = 0;
        bool operator==(const BusFormat&) const = default;
    };

    Status find_device(int video_fd, std::uint32_t& entity, std::string& problem);
    bool read_topology();
    Status find_way(std::uint32_t entity, std::string& problem);
    Status choose_link(const Pad& sink, Pad& source, std::string& problem);
    Status enable(const Pad& source, const Pad& sink, std::string& problem);
    Status set_formats(const Wanted& wanted, std::string& problem);
    Status set_sensor(const Pad& source, const Wanted& wanted, BusFormat& format, std::string& problem);
    Status set_format(const Pad& pad, const BusFormat& wanted, BusFormat& given, std::string& problem);
    std::string node_of(std::uint32_t entity) const;
    std::string name_of(std::uint32_t entity) const;
    const Pad* pad(std::uint32_t id) const;
    void close();

    KernelIo& io_;
    int fd_ = -1;
    std::string path_;
    std::vector<Entity> entities_;
    std::vector<Interface> interfaces_;
    std::vector<Pad> pads_;
    std::vector<Link> data_links_;
    std::vector<Link> interface_links_;
    std::vector<Step> way_;  ///< from the sensor to the node
};

}  // namespace facet
