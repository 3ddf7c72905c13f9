// SPDX-License-Identifier: BSD-2-Clause
// Makes a log folder of a ROS bag.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "app/mcap/log_messages.h"

namespace facet {

struct ImportOptions {
    std::string bag;     ///< see open_bag
    std::string folder;  ///< for the log, new or empty
    /// Topics by LogTable; an empty name: found by its type.
    std::array<std::string, 4> topics;
    std::string cameras;  ///< calibration, as load_calibration has it; empty: the log will have none
    std::string imu;
    std::function<void(double)> progress;  ///< told the share of the bag that has been read
    std::function<void(const std::string&)> warn;
};

struct ImportAccount {
    std::array<std::string, 4> topics;        ///< chosen, by LogTable; empty: none
    std::array<std::uint64_t, 4> rows{};      ///< written
    std::array<std::uint64_t, 4> left_out{};  ///< damaged, out of order, not convertible, not finite
    bool has_calibration = false;
};

/// Reads the bag twice: for its topics, and for their messages. A log needs one topic of images, or two, of which the
/// first by name is the left camera, and one of inertial samples; a topic of poses becomes ground truth, which is left
/// out with a warning if there are several and none is named. The stamps are those of the messages' headers. Messages
/// up to kSorted behind their neighbours are put in order, later ones left out. Images become 8-bit grey PNG files
/// (grey_image.h); PNG images stay as they are. Memory: a chunk of the bag, an image, and kSorted rows a table.
/// Throws InputError if the topics are not clear, naming those there are; if the calibration cannot be used; or if a
/// file cannot be written.
ImportAccount import_bag(const ImportOptions& options, const std::atomic<bool>& stop);

/// Rows that are held back to be put in order.
inline constexpr std::size_t kSorted = 512;

}  // namespace facet
