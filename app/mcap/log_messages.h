// SPDX-License-Identifier: BSD-2-Clause
// The messages in JSON that a log's tables become in an MCAP file.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// What a table of a log holds.
enum class LogTable : std::uint8_t { kLeft, kRight, kImu, kTruth };
inline constexpr std::array<LogTable, 4> kLogTables{LogTable::kLeft, LogTable::kRight, LogTable::kImu,
                                                    LogTable::kTruth};

/// How a table is called in each place.
struct LogTableNames {
    const char* folder;  ///< below the log's root; data.csv is in it
    const char* topic;
    const char* frame;   ///< frame_id of its messages
    const char* schema;  ///< name; the encoding is jsonschema
};
const LogTableNames& names_of(LogTable table);
inline bool is_camera(LogTable table) { return table == LogTable::kLeft || table == LogTable::kRight; }

/// The schemas: foxglove.CompressedImage, foxglove.PoseInFrame, and facet.Imu, for which Foxglove has none. Members
/// beyond Foxglove's are what a row of a log needs: `file` of an image that is not called by its stamp; `velocity`
/// (m/s), `gyroscope_bias` (rad/s) and `accelerometer_bias` (m/s^2) of a true pose.
const char* schema_of(LogTable table);

// Messages; each replaces `out`. Numbers are texts, which must be JSON numbers and are kept digit by digit. A stamp is
// not negative. Reentrant. Heap: what `out` needs.
/// @param file  empty if the image is called by its stamp
void write_image(LogTable table, std::int64_t stamp_ns, std::string_view file, std::span<const std::uint8_t> image,
                 std::string& out);
/// @param fields  angular rate x y z, specific force x y z
void write_imu(std::int64_t stamp_ns, std::span<const std::string_view> fields, std::string& out);
/// @param fields  position x y z, quaternion w x y z; or with velocity, biases of gyroscope and accelerometer behind
void write_pose(std::int64_t stamp_ns, std::span<const std::string_view> fields, std::string& out);

/// The other way: a row's fields behind the stamp, as views of the message. Empty if one is missing or is no number.
std::vector<std::string_view> read_imu(std::string_view message);
std::vector<std::string_view> read_pose(std::string_view message);
/// The `file` of an image; empty if it has none.
std::string_view read_file_name(std::string_view message);
/// Replaces `image` by the bytes of an image's `data`. @return false if they are missing or damaged
bool read_image(std::string_view message, std::vector<std::uint8_t>& image);

}  // namespace facet
