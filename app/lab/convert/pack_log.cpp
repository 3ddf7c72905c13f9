// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/pack_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <vector>

#include "app/lab/convert/raw_table.h"
#include "app/mcap/json_fields.h"
#include "app/mcap/log_messages.h"
#include "app/mcap/mcap_writer.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "drivers/replay_asl/csv_file.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostImageBytes = std::uintmax_t{64} << 20U;  // as PngDecoder

/// Fields that are no JSON numbers, such as +0.5 or 1., written so that they are.
class JsonFields {
public:
    /// @return false if one is no finite number
    bool take(const std::vector<std::string_view>& fields) {
        texts_.clear();
        views_.assign(fields.begin(), fields.end());
        is_same_ = true;
        texts_.reserve(fields.size());
        for (std::string_view& field : views_) {
            double number = 0.0;
            if (is_json_number(field)) {
                continue;
            }
            if (!parse_double(field, number) || !std::isfinite(number)) {
                return false;
            }
            is_same_ = false;
            field = texts_.emplace_back(fmt::format("{}", number));
        }
        return true;
    }
    const std::vector<std::string_view>& views() const { return views_; }
    bool is_same() const { return is_same_; }

private:
    std::vector<std::string> texts_;
    std::vector<std::string_view> views_;
    bool is_same_ = true;
};

bool read_whole(const std::string& path, std::string& bytes) {
    std::error_code error;
    if (!refuse_file(path, kMostImageBytes).empty() || !fs::is_regular_file(path, error)) {
        return false;
    }
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
    return file.is_open() && !file.bad();
}

bool is_called_by_stamp(std::string_view name, std::int64_t stamp_ns) {
    return name == fmt::format("{}.png", stamp_ns);
}

/// A name that can stand in JSON as it is, and below data/.
bool is_plain_name(std::string_view name) {
    return !name.empty() && name != "." && name != ".." &&
           std::ranges::all_of(name, [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\' && c != '/'; });
}

const char* media_type(const std::string& ending) {
    return ending == ".csv"    ? "text/csv"
           : ending == ".yaml" ? "application/yaml"
           : ending == ".png"  ? "image/png"
                               : "application/octet-stream";
}

/// One table on its way into the file.
struct Source {
    LogTable kind = LogTable::kLeft;
    std::string folder;  ///< that it lies in
    RawTable rows;
    std::uint16_t channel = 0;
    bool has_row = false;
    bool by_stamp = true;          ///< all images are called by their stamps
    std::set<std::string> images;  ///< names that have become messages
    std::int64_t first_ns = 0;
};

class Packer {
public:
    Packer(const PackOptions& options, const std::string& root)
        : options_(options), root_(root), writer_(options.file, options.compression, "facet", options.library) {}

    PackAccount run(const std::atomic<bool>& stop);

private:
    std::string in_folder(const fs::path& path) const { return fs::path(path).lexically_relative(options_.folder); }
    void open_tables();
    void add_channel(Source& source);
    static bool next_row(Source& source);
    bool add_message(Source& source);
    bool add_image(Source& source);
    void add_files(bool early);
    void report(std::int64_t stamp_ns);

    const PackOptions& options_;
    std::string root_;
    McapWriter writer_;
    std::vector<Source> sources_;
    std::int64_t begin_ns_ = std::numeric_limits<std::int64_t>::max();
    std::int64_t end_ns_ = 0;
    JsonFields fields_;
    std::string message_;
    std::string image_;
    PackAccount account_;
};

/// Whether every image of a table is called by its stamp; also the table's last stamp.
bool are_called_by_stamp(const std::string& path, std::int64_t& last_ns) {
    RawTable rows;
    bool all = true;
    if (rows.open(path)) {
        while (rows.next(2, 2)) {
            all = all && is_called_by_stamp(rows.fields()[0], rows.stamp_ns());
            last_ns = std::max(last_ns, rows.stamp_ns());
        }
    }
    return all;
}

void Packer::open_tables() {
    for (const LogTable kind : kLogTables) {
        Source source;
        source.kind = kind;
        source.folder = (fs::path(root_) / names_of(kind).folder).string();
        const std::string path = source.folder + "/data.csv";
        std::error_code error;
        if (!fs::is_regular_file(path, error) || !source.rows.open(path)) {
            continue;
        }
        if (is_camera(kind)) {
            source.by_stamp = are_called_by_stamp(path, end_ns_);
        }
        add_channel(source);
        source.has_row = next_row(source);
        if (source.has_row) {
            begin_ns_ = std::min(begin_ns_, source.rows.stamp_ns());
        }
        sources_.push_back(std::move(source));
    }
    if (sources_.empty()) {
        throw InputError(options_.folder + ": holds no cam0, cam1 or imu0 with a data.csv");
    }
}

void Packer::add_channel(Source& source) {
    const LogTableNames& names = names_of(source.kind);
    McapTexts metadata{{"table", in_folder(source.folder + "/data.csv")},
                       {"header", source.rows.header()},
                       {"line_end", source.rows.line_end()}};
    if (is_camera(source.kind)) {
        metadata["names"] = source.by_stamp ? "stamp" : "file";
    }
    const std::uint16_t schema = writer_.add_schema(names.schema, "jsonschema", schema_of(source.kind));
    source.channel = writer_.add_channel(schema, names.topic, "json", metadata);
}

bool Packer::next_row(Source& source) {
    switch (source.kind) {
        case LogTable::kImu: return source.rows.next(7, 7);
        case LogTable::kTruth: return source.rows.next(8, 17);
        default: return source.rows.next(2, 2);
    }
}

bool Packer::add_image(Source& source) {
    const std::string name(source.rows.fields()[0]);
    if (!is_plain_name(name) || !read_whole(source.folder + "/data/" + name, image_)) {
        return false;
    }
    const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(image_.data()), image_.size());
    write_image(source.kind, source.rows.stamp_ns(), source.by_stamp ? "" : name, bytes, message_);
    source.images.insert(name);
    return true;
}

/// @return false if the row gives no message, or one that does not make it again
bool Packer::add_message(Source& source) {
    bool is_same = true;
    if (is_camera(source.kind)) {
        if (!add_image(source)) {
            return false;
        }
    } else {
        if (!fields_.take(source.rows.fields())) {
            return false;
        }
        is_same = fields_.is_same();
        write_row(source.kind, source.rows.stamp_ns(), fields_.views(), message_);
    }
    writer_.add_message(source.channel, static_cast<std::uint64_t>(source.rows.stamp_ns()), message_);
    ++account_.messages[static_cast<std::size_t>(source.kind)];
    return is_same;
}

void Packer::report(std::int64_t stamp_ns) {
    if (options_.progress && end_ns_ > begin_ns_) {
        const double share = static_cast<double>(stamp_ns - begin_ns_) / static_cast<double>(end_ns_ - begin_ns_);
        options_.progress(std::clamp(share, 0.0, 1.0));
    }
}

/// Attaches what the messages do not hold.
/// @param early  what no message can hold, calibration above all, so that a file cut off has it; else the rest
void Packer::add_files(bool early) {
    std::set<fs::path> held;     // by messages
    std::set<fs::path> pending;  // until the messages are known
    for (const Source& source : sources_) {
        const fs::path folder(source.folder);
        pending.insert({folder / "data.csv", folder / "data"});
        if (source.rows.is_regular()) {
            held.insert(folder / "data.csv");
        } else if (!early) {
            options_.warn(source.folder + "/data.csv: attached as well: its rows alone do not make it again");
        }
        for (const std::string& name : source.images) {
            held.insert(folder / "data" / name);
        }
    }
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(options_.folder)) {
        const fs::path& path = entry.path();
        std::error_code error;
        const bool is_pending = pending.contains(path) || pending.contains(path.parent_path());
        if (is_pending == early || held.contains(path) || entry.is_directory(error)) {
            continue;
        }
        if (entry.is_regular_file(error)) {
            files.push_back(path);
        } else {
            options_.warn(path.string() + ": is not a regular file; left out");
        }
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
        writer_.add_attachment(in_folder(file), media_type(file.extension().string()), file);
        ++account_.attachments;
    }
}

PackAccount Packer::run(const std::atomic<bool>& stop) {
    open_tables();
    add_files(true);
    for (;;) {
        Source* next = nullptr;
        for (Source& source : sources_) {
            if (source.has_row && (next == nullptr || source.rows.stamp_ns() < next->rows.stamp_ns())) {
                next = &source;
            }
        }
        if (next == nullptr || stop.load()) {
            break;
        }
        if (!add_message(*next)) {
            next->rows.set_irregular();
        }
        report(next->rows.stamp_ns());
        next->has_row = next_row(*next);
    }
    if (stop.load()) {
        std::error_code ignored;
        fs::remove(options_.file + TextFile::kPartEnding, ignored);
        return {};
    }
    add_files(false);
    writer_.close();
    return account_;
}

}  // namespace

PackAccount pack_log(const PackOptions& options, const std::atomic<bool>& stop) {
    PackOptions clean = options;
    clean.folder = fs::path(options.folder).lexically_normal().string();
    while (clean.folder.size() > 1 && clean.folder.ends_with('/')) {
        clean.folder.pop_back();
    }
    const std::string root = AslDataset::find_root(clean.folder);
    if (root.empty()) {
        throw InputError(options.folder + ": no such folder");
    }
    return Packer(clean, root).run(stop);
}

}  // namespace facet
