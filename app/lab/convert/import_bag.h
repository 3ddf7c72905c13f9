// SPDX-License-Identifier: BSD-2-Clause
// Makes a log folder of a ROS bag.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "app/mcap/log_messages.h"

namespace facet {

struct ImportOptions {
    std::string bag;     ///< see open_bag
    std::string folder;  ///< for the log, new or empty
    /// Topics by LogTable; an empty name: found by its type. That of the IMU may be GYROSCOPE,ACCELEROMETER.
    std::array<std::string, 4> topics;
    bool is_side_by_side = false;  ///< each image holds the left one and the right one
    bool align_clocks = false;     ///< shifts inertial stamps to the images' clock if the two do not overlap
    int bits = 0;                  ///< that images of 16 bits use; 0: as many as their greatest sample needs
    std::string cameras;           ///< calibration, as load_calibration has it; empty: the log will have none
    std::string imu;
    std::function<void(double)> progress;  ///< called with the share of the bag that has been read
    std::function<void(const std::string&)> warn;
};

struct ImportAccount {
    std::array<std::string, 4> topics;        ///< chosen, by LogTable; empty: none
    std::array<std::uint64_t, 4> rows{};      ///< written
    std::array<std::uint64_t, 4> left_out{};  ///< damaged, out of order, not convertible, not finite
    bool has_calibration = false;             ///< given, or the bag's own
    bool is_own_calibration = false;          ///< of CameraInfo and /tf_static
    std::string calibration_lack;             ///< what the bag lacks for one of its own
    std::string accelerometer;                ///< topic of a split IMU; empty: it is one
    int bits = 16;                            ///< used of images with 16
    std::int64_t inertial_shift_ns = 0;       ///< added to inertial stamps
    std::vector<std::string> remarks;         ///< the calibration's
};

/// Reads the bag twice: for its topics, and for their messages. A log needs one topic of images, or two, of which the
/// first by name is the left camera, and one of inertial samples, or two of its halves (SplitImu); choose_topics()
/// chooses. A topic of poses becomes ground truth. Without a calibration that is given the bag's own is used, if it has
/// one (bag_calibration.h). The stamps are those of the messages' headers. Messages up to kSorted behind their
/// neighbours are put in order, later ones left out. Images become 8-bit grey PNG files (grey_image.h); PNG images stay
/// as they are, unless they hold two. Memory: a chunk of the bag, an image, kSorted rows a table, and of a split IMU 32
/// bytes a reading.
/// Throws InputError if the topics are not clear, naming those there are; if images and inertial samples have no time
/// in common; if the calibration cannot be used; or if a file cannot be written.
ImportAccount import_bag(const ImportOptions& options, const std::atomic<bool>& stop);

}  // namespace facet
