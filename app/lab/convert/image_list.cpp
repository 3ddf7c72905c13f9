// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/image_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>

#include "app/lab/convert/plain_table.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/image_decoder.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastFrameStep_s = 0.002;
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

std::string_view first_bytes(const std::string& path, std::span<char> buffer) {
    std::ifstream stream(path, std::ios::binary);
    stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    return {buffer.data(), static_cast<std::size_t>(stream.gcount())};
}

/// Of a row: which columns hold numbers, and which names of files.
struct ListColumns {
    std::size_t stamp = kNone;
    std::size_t left = kNone;
    std::size_t right = kNone;
    bool names_are_stamps = false;
};

std::string name_of(const PlainTable& table, std::size_t column) {
    return column < table.names().size() ? table.names()[column] : "";
}

/// The column of stamps among those with numbers.
std::size_t stamp_column(const PlainTable& table, const std::vector<std::string_view>& first,
                         const std::vector<std::string_view>& second) {
    std::vector<std::size_t> numeric;
    for (std::size_t i = 0; i < first.size(); ++i) {
        if (WrittenStamp::parse(first[i]).has_value()) {
            numeric.push_back(i);
        }
    }
    for (const std::size_t i : numeric) {
        if (is_stamp_name(name_of(table, i))) {
            return i;
        }
    }
    for (const std::size_t i : numeric) {
        const std::optional<WrittenStamp> a = WrittenStamp::parse(first[i]);
        const std::optional<WrittenStamp> b =
            i < second.size() ? WrittenStamp::parse(second[i]) : std::optional<WrittenStamp>{};
        const bool counts = numeric.size() > 1 && a->whole <= 1 && b.has_value() && b->whole == a->whole + 1 &&
                            a->billionths == 0 && b->billionths == 0;
        if (!counts) {
            return i;
        }
    }
    return kNone;
}

bool is_called(const std::string& name, std::initializer_list<const char*> parts) {
    return std::ranges::any_of(parts, [&](const char* part) { return name.find(part) != std::string::npos; });
}

/// A name that is a number with the ending of a file: "1403636579763555584.png".
std::optional<WrittenStamp> stamp_in_name(std::string_view name) {
    name = name.substr(name.find_last_of("/\\") + 1);
    return WrittenStamp::parse(name.substr(0, name.rfind('.')));
}

bool is_file_name(std::string_view field) {
    const std::size_t point = field.rfind('.');
    return point != std::string_view::npos && point + 1 < field.size() &&
           std::ranges::any_of(field.substr(point + 1), [](unsigned char c) { return std::isalpha(c) != 0; }) &&
           !WrittenStamp::parse(field).has_value();
}

ListColumns find_columns(const PlainTable& table, const std::vector<std::string_view>& first,
                         const std::vector<std::string_view>& second) {
    ListColumns columns;
    columns.stamp = stamp_column(table, first, second);
    for (std::size_t i = 0; i < first.size(); ++i) {
        const bool is_depth = is_called(name_of(table, i), {"depth"}) || first[i].starts_with("depth");
        if (!is_file_name(first[i]) || is_depth || columns.right != kNone) {
            continue;
        }
        (columns.left == kNone ? columns.left : columns.right) = i;
    }
    if (columns.left == kNone) {
        table.fail("has no column with names of image files");
    }
    if (columns.right != kNone && is_called(name_of(table, columns.left), {"right", "cam1"}) &&
        !is_called(name_of(table, columns.right), {"right", "cam1"})) {
        std::swap(columns.left, columns.right);
    }
    columns.names_are_stamps = columns.stamp == kNone;
    if (columns.names_are_stamps && !stamp_in_name(first[columns.left]).has_value()) {
        table.fail(
            "has no column with stamps, and the names of the files are none: --stamps FILE names a table of them");
    }
    return columns;
}

/// Where a file of the list is; the first place if it is nowhere.
std::string place_of(const fs::path& folder, std::string name) {
    std::ranges::replace(name, '\\', '/');
    std::error_code ignored;
    if (const fs::path below = folder / "data" / name;
        !fs::exists(folder / name, ignored) && fs::exists(below, ignored)) {
        return below.string();
    }
    return (folder / name).string();
}

/// Sorted by their stamps in one unit.
void set_stamps(const std::vector<WrittenStamp>& stamps, const std::string& name, const std::string& path,
                std::vector<StampedFile>& files) {
    const std::int64_t unit_ns = unit_of_stamps(stamps, name, kLeastFrameStep_s, path);
    for (std::size_t i = 0; i < files.size(); ++i) {
        files[i].stamp_ns = stamps[i].ns(unit_ns);
    }
    std::ranges::stable_sort(files, {}, &StampedFile::stamp_ns);
}

/// Files in a folder whose names are stamps, or that get those of a table in the order of their names.
std::vector<StampedFile> read_folder(const std::string& path, const std::string& stamps) {
    std::vector<StampedFile> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
        if (entry.is_regular_file() && is_image_file(entry.path().string())) {
            files.push_back({0, entry.path().string()});
        }
    }
    const auto by_length = [](const StampedFile& a, const StampedFile& b) {  // 9.png before 10.png
        return a.path.size() != b.path.size() ? a.path.size() < b.path.size() : a.path < b.path;
    };
    const auto stamp_of = [](const StampedFile& file) { return stamp_in_name(file.path); };
    const bool are_numbers = std::ranges::all_of(files, [&](const auto& file) { return stamp_of(file).has_value(); });
    if (are_numbers) {
        std::ranges::sort(files, by_length);
    } else {
        std::ranges::sort(files, {}, &StampedFile::path);
    }
    if (files.empty()) {
        throw InputError(path + ": holds no image");
    }
    if (!stamps.empty()) {
        const std::vector<std::int64_t> all = read_stamps(stamps);
        if (all.size() != files.size()) {
            throw InputError(
                fmt::format("{}: has {} stamps, but {} has {} images", stamps, all.size(), path, files.size()));
        }
        for (std::size_t i = 0; i < files.size(); ++i) {
            files[i].stamp_ns = all[i];
        }
        return files;
    }
    if (!are_numbers) {
        throw InputError(path + ": the names of its images are not stamps: --stamps FILE names a table of them");
    }
    std::vector<WrittenStamp> written;
    std::ranges::transform(files, std::back_inserter(written), [&](const auto& file) { return *stamp_of(file); });
    set_stamps(written, "", path, files);
    return files;
}

}  // namespace

bool is_image_file(const std::string& path) {
    std::array<char, 4> buffer{};
    const std::string_view begin = first_bytes(path, buffer);
    return ImageDecoder::recognises({reinterpret_cast<const std::uint8_t*>(begin.data()), begin.size()});
}

bool is_text_file(const std::string& path) {
    std::array<char, 1024> buffer{};
    const std::string_view begin = first_bytes(path, buffer);
    return !begin.empty() && std::ranges::none_of(begin, [](unsigned char c) { return c < 9 || (c > 13 && c < 32); });
}

bool is_image_list(const std::string& path) {
    if (!is_text_file(path)) {
        return false;
    }
    PlainTable table(path);
    std::vector<std::string_view> fields;
    return table.next(fields) && std::ranges::any_of(fields, is_file_name);
}

std::vector<std::int64_t> read_stamps(const std::string& path) {
    PlainTable table(path);
    std::vector<std::string> first;
    std::size_t column = kNone;
    std::vector<WrittenStamp> written;
    std::vector<std::string_view> fields;
    while (table.next(fields)) {
        if (first.empty()) {
            first.assign(fields.begin(), fields.end());
            column = stamp_column(table, fields, {});
        } else if (written.size() == 1) {
            const std::vector<std::string_view> views(first.begin(), first.end());
            column = stamp_column(table, views, fields);
            written = {column == kNone ? WrittenStamp{} : WrittenStamp::parse(first[column]).value_or(WrittenStamp{})};
        }
        const std::optional<WrittenStamp> stamp =
            column < fields.size() ? WrittenStamp::parse(fields[column]) : std::optional<WrittenStamp>{};
        if (!stamp.has_value()) {
            table.fail("has no stamp");
        }
        written.push_back(*stamp);
    }
    const std::int64_t unit_ns =
        unit_of_stamps(written, column == kNone ? "" : name_of(table, column), kLeastFrameStep_s, path);
    std::vector<std::int64_t> stamps;
    std::ranges::transform(written, std::back_inserter(stamps), [&](const auto& stamp) { return stamp.ns(unit_ns); });
    return stamps;
}

ImageList read_image_list(const std::string& path, const std::string& stamps) {
    if (fs::is_directory(path)) {
        return {read_folder(path, stamps), {}};
    }
    if (!stamps.empty()) {
        throw InputError(stamps + ": a list of images has its own stamps; --stamps is for videos and folders");
    }
    PlainTable table(path);
    std::vector<std::vector<std::string>> rows;
    std::vector<std::string_view> fields;
    while (table.next(fields)) {
        rows.emplace_back(fields.begin(), fields.end());
    }
    if (rows.empty()) {
        throw InputError(path + ": has no row");
    }
    const std::vector<std::string_view> first(rows.front().begin(), rows.front().end());
    const std::vector<std::string>& behind = rows.size() > 1 ? rows[1] : rows[0];
    const ListColumns columns = find_columns(table, first, {behind.begin(), behind.end()});
    const fs::path folder = fs::path(path).parent_path();
    ImageList list;
    std::vector<WrittenStamp> written;
    for (const std::vector<std::string>& row : rows) {
        const std::size_t needed = std::max(columns.left, columns.right == kNone ? 0 : columns.right);
        const std::optional<WrittenStamp> stamp =
            needed >= row.size() ? std::nullopt
            : columns.names_are_stamps
                ? stamp_in_name(row[columns.left])
                : WrittenStamp::parse(columns.stamp < row.size() ? std::string_view(row[columns.stamp]) : "");
        if (!stamp.has_value()) {
            throw InputError(fmt::format("{}: the row '{}' lacks a stamp or a name", path, fmt::join(row, " ")));
        }
        written.push_back(*stamp);
        list.left.push_back({0, place_of(folder, row[columns.left])});
        if (columns.right != kNone) {
            list.right.push_back({0, place_of(folder, row[columns.right])});
        }
    }
    const std::string name = columns.names_are_stamps ? "" : name_of(table, columns.stamp);
    set_stamps(written, name, path, list.left);
    if (columns.right != kNone) {
        set_stamps(written, name, path, list.right);
    }
    return list;
}

}  // namespace facet
