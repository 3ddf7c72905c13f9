// SPDX-License-Identifier: BSD-2-Clause
// Tables and images of a log folder that is being made of something else.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "app/calibration/calibration.h"
#include "app/lab/convert/sorted_rows.h"
#include "app/mcap/log_messages.h"
#include "app/support/text_file.h"
#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Rows that are held back to be put in order.
inline constexpr std::size_t kSorted = 512;

/// The data.csv of a sensor below a log's root, with its header, whose rows come nearly in order. Folders are made. All
/// throw InputError if a file cannot be written. Thread-bound.
class LogTableFile {
public:
    LogTableFile(const std::string& root, LogTable which);

    LogTable kind() const { return kind_; }
    /// Folder of a camera's images, with a slash behind it.
    const std::string& images() const { return images_; }

    /// @return false if the stamp has been there already, or is more than kSorted rows behind: the row is dropped
    bool add(std::int64_t stamp_ns, const std::string& row) { return rows_.add(stamp_ns, row); }
    /// For rows that are in order; not to be mixed with add().
    void add_next(std::int64_t stamp_ns, const std::array<double, 6>& values);
    void close();

private:
    LogTable kind_;
    TextFile file_;
    std::string images_;
    SortedRows rows_;
};

/// Left or right half of an image of even width. Reentrant; storage is reused.
void take_half(const GreyImage& both, bool is_left, GreyImage& half);

/// Writes a PNG file. Throws InputError if it cannot be written.
void write_grey_png(const std::string& path, const GreyImage& image);

/// Reads a calibration for such a log and writes it below its root. @param name  for messages
/// @return its remarks. Throws InputError if it is not for that many cameras, or as load_calibration.
std::vector<std::string> give_calibration(const std::string& cameras, const std::string& imu, const ImageExtent& images,
                                          bool has_right, const std::string& root);
/// Throws InputError if the numbers of cameras differ.
void check_cameras(const Calibration& calibration, const std::string& name, bool has_right);

/// The sentence for images and inertial samples without time in common. @param source  it begins with this
std::string no_common_time_text(const std::string& source, std::int64_t images_first_ns, std::int64_t images_last_ns,
                                std::int64_t imu_first_ns, std::int64_t imu_last_ns);

}  // namespace facet
