// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/log_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/support/input_error.h"
#include "app/support/png_writer.h"

namespace facet {
namespace {

const char* header_of(LogTable table) {
    switch (table) {
        case LogTable::kImu:
            return "#timestamp [ns],w_x [rad s^-1],w_y [rad s^-1],w_z [rad s^-1],a_x [m s^-2],a_y [m s^-2],"
                   "a_z [m s^-2]\n";
        case LogTable::kTruth: return "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
        default: return "#timestamp [ns],filename\n";
    }
}

/// Made before the table in it.
std::string made_folder(const std::string& root, LogTable table) {
    std::string folder = root + "/" + names_of(table).folder;
    make_folder(is_camera(table) ? folder + "/data" : folder);
    return folder;
}

}  // namespace

LogTableFile::LogTableFile(const std::string& root, LogTable which)
    : kind_(which),
      file_(made_folder(root, which) + "/data.csv"),
      images_(root + "/" + names_of(which).folder + "/data/"),
      rows_(kSorted, [this](auto stamp_ns, auto& row) { file_.print("{},{}\n", stamp_ns, row); }) {
    file_.write(header_of(which));
}

void LogTableFile::add_next(std::int64_t stamp_ns, const std::array<double, 6>& values) {
    file_.print("{},{}\n", stamp_ns, fmt::join(values, ","));
}

void LogTableFile::close() {
    rows_.finish();
    file_.close();
}

void take_half(const GreyImage& both, bool is_left, GreyImage& half) {
    const int width = both.width / 2;
    half.resize(width, both.height);
    for (int v = 0; v < both.height; ++v) {
        const auto row = both.pixels.begin() + std::ptrdiff_t{v} * both.width + (is_left ? 0 : width);
        std::copy(row, row + width, half.pixels.begin() + std::ptrdiff_t{v} * width);
    }
}

void write_grey_png(const std::string& path, const GreyImage& image) {
    if (!ok(write_png(path, image.view()))) {
        throw InputError(path + ": cannot be written");
    }
}

void check_cameras(const Calibration& calibration, const std::string& name, bool has_right) {
    if (calibration.rig.has_right != has_right) {
        throw InputError(fmt::format("{}: is a calibration of {}, but the log gets {}", name,
                                     calibration.rig.has_right ? "two cameras" : "one camera",
                                     has_right ? "two" : "one"));
    }
}

std::vector<std::string> give_calibration(const std::string& cameras, const std::string& imu, const ImageExtent& images,
                                          bool has_right, const std::string& root) {
    const Calibration calibration = load_calibration(root, cameras, imu, images);
    check_cameras(calibration, cameras, has_right);
    keep_calibration(calibration, root);
    return calibration.remarks;
}

std::string no_common_time_text(const std::string& source, std::int64_t images_first_ns, std::int64_t images_last_ns,
                                std::int64_t imu_first_ns, std::int64_t imu_last_ns) {
    const auto s = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
    return fmt::format(
        "{}: images run from {:.3f} to {:.3f} s and inertial samples from {:.3f} to {:.3f} s: their clocks differ, or "
        "they were not recorded together; --align-clocks brings them together",
        source, s(images_first_ns), s(images_last_ns), s(imu_first_ns), s(imu_last_ns));
}

}  // namespace facet
