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

/// What a table of a log holds. The last three are of logs that facet recorded: what the synchroniser knew of a pair
/// of images, edges of the trigger, and readings of a range finder.
enum class LogTable : std::uint8_t { kLeft, kRight, kImu, kTruth, kPairs, kEdges, kRanges };
/// Those of any log.
inline constexpr std::array<LogTable, 4> kLogTables{LogTable::kLeft, LogTable::kRight, LogTable::kImu,
                                                    LogTable::kTruth};
inline constexpr std::array<LogTable, 7> kAllLogTables{LogTable::kLeft,  LogTable::kRight, LogTable::kImu,
                                                       LogTable::kTruth, LogTable::kPairs, LogTable::kEdges,
                                                       LogTable::kRanges};

/// How a table is called in each place.
struct LogTableNames {
    const char* folder;  ///< below the log's root
    const char* topic;
    const char* frame;   ///< frame_id of its messages
    const char* schema;  ///< name; the encoding is jsonschema
    const char* file;    ///< below the log's root
    const char* header;  ///< its first line in logs that facet writes
};
const LogTableNames& names_of(LogTable table);
inline bool is_camera(LogTable table) { return table == LogTable::kLeft || table == LogTable::kRight; }

/// The schemas: foxglove.CompressedImage, foxglove.PoseInFrame, and facet.Imu, facet.ImagePair, facet.TriggerEdge
/// and facet.Range, for which Foxglove has none. Members
/// beyond Foxglove's are what a row of a log needs: `file` of an image that is not called by its stamp; `velocity`
/// (m/s), `gyroscope_bias` (rad/s) and `accelerometer_bias` (m/s^2) of a true pose.
const char* schema_of(LogTable table);

// Messages; each replaces `out`. Numbers are texts, which must be JSON numbers and are kept digit by digit, or null for
// what is NaN. A stamp is not negative. Reentrant. Heap: what `out` needs.
/// @param file  empty if the image is called by its stamp
void write_image(LogTable table, std::int64_t stamp_ns, std::string_view file, std::span<const std::uint8_t> image,
                 std::string& out);
/// A row of numbers, of a table that has no images.
/// @param fields  behind the stamp, in the order of the table's header. kTruth: position x y z, quaternion w x y z; or
/// with velocity, biases of gyroscope and accelerometer behind
void write_row(LogTable table, std::int64_t stamp_ns, std::span<const std::string_view> fields, std::string& out);

/// The other way: a row's fields behind the stamp, as views of the message, or "nan" for null. Empty if one is missing
/// or something else.
std::vector<std::string_view> read_row(LogTable table, std::string_view message);
/// The `file` of an image; empty if it has none.
std::string_view read_file_name(std::string_view message);
/// Replaces `image` by the bytes of an image's `data`. @return false if they are missing or damaged
bool read_image(std::string_view message, std::vector<std::uint8_t>& image);

}  // namespace facet
