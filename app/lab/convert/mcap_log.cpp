// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/mcap_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "app/support/input_error.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr std::string_view kImageEnding = ".png";
constexpr std::size_t kBlockBytes = std::size_t{1} << 16U;  // of a file that is given at a time

std::string image_name(bool by_stamp, const McapMessage& message) {
    return by_stamp ? fmt::format("{}{}", message.time_ns, kImageEnding)
                    : std::string(read_file_name(text_of(message.data)));
}

std::string text_in(const McapTexts& texts, const std::string& key) {
    const auto found = texts.find(key);
    return found == texts.end() ? "" : found->second;
}

}  // namespace

bool is_inner_path(const std::string& path) {
    if (path.empty() || path.size() > 4096 || std::ranges::any_of(path, [](unsigned char c) { return c < ' '; })) {
        return false;
    }
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('/', begin), path.size());
        const std::string_view part = std::string_view(path).substr(begin, end - begin);
        if (part.empty() || part == "." || part == "..") {
            return false;
        }
        begin = end + 1;
    }
    return true;
}

/// Rows made of messages, a block at a time.
class McapLog::TableStream : public std::streambuf {
public:
    TableStream(McapLog& log, const Table& table) : log_(log), table_(table), text_(table.header) {
        setg(text_.data(), text_.data(), text_.data() + text_.size());
    }

protected:
    int_type underflow() override {
        text_.clear();
        while (text_.size() < kBlockBytes && add_row()) {
        }
        setg(text_.data(), text_.data(), text_.data() + text_.size());
        return text_.empty() ? traits_type::eof() : traits_type::to_int_type(text_.front());
    }

private:
    /// @return false at the end
    bool add_row() {
        McapMessage message;
        if (is_camera(table_.kind) && table_.by_stamp) {
            if (next_place_ >= table_.places.size()) {
                return false;
            }
            message.time_ns = table_.places[next_place_++].time_ns;  // all that the row tells
        } else {
            do {
                if (!log_.file_.next(cursor_, message)) {
                    return false;
                }
            } while (message.channel != table_.channel);
        }
        add_row_of(message);
        return true;
    }
    /// Damaged messages give no row.
    void add_row_of(const McapMessage& message) {
        const auto out = std::back_inserter(text_);
        if (is_camera(table_.kind)) {
            const std::string name = image_name(table_.by_stamp, message);
            if (!name.empty()) {
                fmt::format_to(out, "{},{}{}", message.time_ns, name, table_.line_end);
            }
            return;
        }
        const auto fields = read_row(table_.kind, text_of(message.data));
        if (!fields.empty()) {
            fmt::format_to(out, "{},{}{}", message.time_ns, fmt::join(fields, ","), table_.line_end);
        }
    }

    McapLog& log_;
    const Table& table_;
    std::string text_;
    std::size_t next_place_ = 0;
    McapFile::Cursor cursor_;
};

class McapLog::AttachmentStream : public std::streambuf {
public:
    AttachmentStream(McapLog& log, const McapAttachment& attachment)
        : log_(log), attachment_(attachment), crc_(attachment.head_crc) {}

protected:
    int_type underflow() override {
        block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBlockBytes, attachment_.size - at_)));
        if (block_.empty()) {
            return traits_type::eof();
        }
        if (!ok(log_.file_.read_attachment(attachment_, at_, block_))) {
            log_.warn_(fmt::format("{}: {}: cannot be read", log_.file_.path(), attachment_.name));
            return traits_type::eof();
        }
        at_ += block_.size();
        crc_ = crc_of(block_, crc_);
        if (at_ == attachment_.size && attachment_.crc != 0 && crc_ != attachment_.crc) {
            log_.warn_(fmt::format("{}: {}: has a wrong checksum", log_.file_.path(), attachment_.name));
        }
        char* const begin = reinterpret_cast<char*>(block_.data());
        setg(begin, begin, begin + block_.size());
        return traits_type::to_int_type(*begin);
    }

private:
    McapLog& log_;
    const McapAttachment& attachment_;
    std::vector<std::uint8_t> block_;
    std::uint64_t at_ = 0;
    std::uint32_t crc_;
};

McapLog::McapLog(const std::string& path, McapFile::Warn warn, const std::atomic<bool>* stop)
    : warn_(std::move(warn)), file_(path, warn_, stop) {
    for (const McapAttachment& attachment : file_.attachments()) {
        if (is_inner_path(attachment.name)) {
            attachments_.try_emplace(attachment.name, &attachment);
        } else {
            warn_(fmt::format("{}: an attachment whose name is not a path inside a folder; left out", path));
        }
    }
    for (const auto& [id, channel] : file_.channels()) {
        add_table(channel);
    }
}

void McapLog::add_table(const McapChannel& channel) {
    const std::string name = text_in(channel.metadata, "table");
    const auto* const kind = std::ranges::find_if(kAllLogTables, [&](LogTable table) {
        return channel.schema == names_of(table).schema && channel.topic == names_of(table).topic;
    });
    if (channel.encoding != "json" || kind == kAllLogTables.end() || !is_inner_path(name)) {
        return;
    }
    const std::size_t slash = name.rfind('/');
    const std::string line_end = text_in(channel.metadata, "line_end");
    Table table;
    table.kind = *kind;
    table.channel = channel.id;
    table.header = text_in(channel.metadata, "header");
    table.line_end = line_end == "\r\n" ? line_end : "\n";
    table.images = slash == std::string::npos ? "data/" : name.substr(0, slash) + "/data/";
    table.by_stamp = text_in(channel.metadata, "names") != "file";
    if (is_camera(*kind)) {
        index_images(table);
    }
    tables_.try_emplace(name, std::move(table));
}

void McapLog::index_images(Table& table) {
    table.places = file_.index(table.channel);
    if (table.by_stamp) {
        table.by_stamp_order = table.places;
        std::ranges::stable_sort(table.by_stamp_order, {}, &McapPlace::time_ns);
        return;
    }
    for (const McapPlace& place : table.places) {
        McapMessage message;
        if (ok(file_.read(place, table.channel, message))) {
            const std::string name = image_name(false, message);
            if (is_inner_path(name) && name.find('/') == std::string::npos) {
                table.by_name.try_emplace(name, place);
            }
        }
    }
}

bool McapLog::has_folder(const std::string& folder) const {
    const std::string begin = folder + "/";
    const auto is_inside = [&](const auto& names) {
        const auto at = names.lower_bound(begin);
        return at != names.end() && at->first.starts_with(begin);
    };
    return is_inside(tables_) || is_inside(attachments_);
}

std::unique_ptr<std::streambuf> McapLog::open(const std::string& name) {
    if (const auto attachment = attachments_.find(name); attachment != attachments_.end()) {
        return std::make_unique<AttachmentStream>(*this, *attachment->second);
    }
    const auto table = tables_.find(name);
    return table == tables_.end() ? nullptr : std::make_unique<TableStream>(*this, table->second);
}

std::optional<McapPlace> McapLog::find_image(const Table& table, const std::string& name) const {
    if (!name.starts_with(table.images)) {
        return std::nullopt;
    }
    const std::string_view inner = std::string_view(name).substr(table.images.size());
    if (!table.by_stamp) {
        const auto found = table.by_name.find(std::string(inner));
        return found == table.by_name.end() ? std::nullopt : std::optional(found->second);
    }
    std::int64_t stamp_ns = 0;
    if (!inner.ends_with(kImageEnding) || !parse_stamp(inner.substr(0, inner.size() - kImageEnding.size()), stamp_ns) ||
        stamp_ns < 0) {
        return std::nullopt;
    }
    const auto found =
        std::ranges::lower_bound(table.by_stamp_order, static_cast<std::uint64_t>(stamp_ns), {}, &McapPlace::time_ns);
    return found == table.by_stamp_order.end() || found->time_ns != static_cast<std::uint64_t>(stamp_ns)
               ? std::nullopt
               : std::optional(*found);
}

Status McapLog::read(const std::string& name, std::size_t most_bytes, std::vector<std::uint8_t>& bytes) {
    for (const auto& [table_name, table] : tables_) {
        const std::optional<McapPlace> place = is_camera(table.kind) ? find_image(table, name) : std::nullopt;
        if (!place.has_value()) {
            continue;
        }
        McapMessage message;
        if (!ok(file_.read(*place, table.channel, message)) || !read_image(text_of(message.data), bytes)) {
            return Status::kCorrupt;
        }
        return bytes.size() > most_bytes ? Status::kFull : Status::kOk;
    }
    const std::unique_ptr<std::streambuf> stream = open(name);
    if (stream == nullptr) {
        return Status::kNotFound;
    }
    bytes.clear();
    for (int c = stream->sgetc(); c != std::char_traits<char>::eof(); c = stream->snextc()) {
        if (bytes.size() >= most_bytes) {
            return Status::kFull;
        }
        bytes.push_back(static_cast<std::uint8_t>(c));
    }
    const auto attachment = attachments_.find(name);
    const bool is_cut = attachment != attachments_.end() && bytes.size() != attachment->second->size;
    return is_cut ? Status::kCorrupt : Status::kOk;
}

std::vector<std::string> McapLog::names() const {
    std::vector<std::string> all;
    for (const auto& [name, attachment] : attachments_) {
        all.push_back(name);
    }
    for (const auto& [name, table] : tables_) {
        if (!attachments_.contains(name)) {
            all.push_back(name);
        }
    }
    std::sort(all.begin(), all.end());
    return all;
}

std::size_t McapLog::image_count() const {
    std::size_t count = 0;
    for (const auto& [name, table] : tables_) {
        count += table.places.size();
    }
    return count;
}

bool McapLog::next_image(McapFile::Cursor& cursor, std::string& name, std::vector<std::uint8_t>& bytes) {
    for (McapMessage message; file_.next(cursor, message);) {
        const auto table = std::ranges::find_if(tables_, [&](const auto& entry) {
            return is_camera(entry.second.kind) && entry.second.channel == message.channel;
        });
        if (table == tables_.end()) {
            continue;
        }
        const std::string inner = image_name(table->second.by_stamp, message);
        name = table->second.images + inner;
        if (inner.find('/') == std::string::npos && is_inner_path(name) && read_image(text_of(message.data), bytes)) {
            return true;
        }
        warn_(fmt::format("{}: an image of {} is damaged; left out", file_.path(), table->first));
    }
    return false;
}

}  // namespace facet
