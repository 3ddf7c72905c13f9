// SPDX-License-Identifier: BSD-2-Clause
// Makes a log folder of image files or videos and a table of inertial samples.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace facet {

struct FilesOptions {
    /// Left and right: a list or a folder of images (read_image_list), or a video (VideoFile). The right one is empty
    /// if there is none, or if the left one holds both.
    std::array<std::string, 2> images;
    std::array<std::string, 2> stamps;  ///< tables of stamps for videos and folders; empty: none, and as the left one's
    std::string imu;                    ///< see read_inertial_table
    std::string folder;                 ///< for the log, new or empty
    std::string cameras;                ///< calibration, as load_calibration has it; empty: the log will have none
    std::string imu_calibration;
    bool is_side_by_side = false;  ///< each image holds the left one and the right one
    bool align_clocks = false;     ///< lets both begin together if they have no time in common
    std::function<void(double)> progress;
    std::function<void(const std::string&)> warn;
};

struct FilesAccount {
    std::array<std::uint64_t, 2> images{};    ///< written
    std::array<std::uint64_t, 2> left_out{};  ///< missing, damaged, or with a stamp that was there
    std::uint64_t samples = 0;
    std::uint64_t samples_left_out = 0;
    bool has_calibration = false;
    bool is_video = false;
    std::vector<std::string> remarks;  ///< the calibration's
};

/// Whether this is a source of images: a list of them, a folder that holds some, or a video.
bool is_image_source(const std::string& path);

/// The first one, by name, in a folder; empty if there is none.
std::string image_source_in(const std::string& folder);

/// Image files are copied as they are, under their stamps; halves of images, and frames of a video, become grey PNG
/// files. A video's frames get the rows of `stamps` in order, of which there must be as many, else the container's
/// stamps. Memory: a few images, and 64 bytes a stamp or inertial sample.
/// Throws InputError if a source has no stamps, if images and inertial samples have no time in common, if the
/// calibration cannot be used, or if a file cannot be written.
FilesAccount import_files(const FilesOptions& options, const std::atomic<bool>& stop);

}  // namespace facet
