// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/mcap_sample_log.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "app/support/input_error.h"
#include "app/support/png_writer.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

constexpr const char* kRoot = "mav0/";

std::size_t place_of(LogTable table) { return static_cast<std::size_t>(table); }

std::uint64_t time_of(Timestamp stamp) { return static_cast<std::uint64_t>(std::max<std::int64_t>(stamp.ns, 0)); }

std::string begin_file(const std::string& folder) {
    make_folder(folder);
    std::string path = folder + "/" + McapSampleLog::kFileName;
    if (std::filesystem::exists(path)) {
        throw InputError(path + ": there is a log already");
    }
    return path;
}

}  // namespace

void McapSampleLog::Sink::commit() {
    file_.add(pending_);
    pending_.clear();
    file_.commit();
}

McapSampleLog::McapSampleLog(const std::string& folder, bool has_right)
    : path_(begin_file(folder)),
      sink_(std::make_unique<Sink>(path_)),
      writer_(std::make_unique<McapWriter>(*sink_, Compression::kZstd, "facet", "facet")) {
    for (const LogTable table : kAllLogTables) {
        if (table != LogTable::kTruth && table != LogTable::kRanges && (table != LogTable::kRight || has_right)) {
            add_channel(table);
        }
    }
    commit();
}

void McapSampleLog::add_channel(LogTable table) {
    const LogTableNames& names = names_of(table);
    McapTexts metadata{{"table", std::string(kRoot) + names.file}, {"header", names.header}, {"line_end", "\n"}};
    if (is_camera(table)) {
        metadata["names"] = "stamp";
    }
    const std::uint16_t schema = writer_->add_schema(names.schema, "jsonschema", schema_of(table));
    channels_[place_of(table)] = writer_->add_channel(schema, names.topic, "json", metadata);
}

void McapSampleLog::add_image(LogTable table, Timestamp stamp, const ImageView& image) {
    const std::uint16_t channel = channels_[place_of(table)];
    if (image.empty() || channel == 0) {
        return;
    }
    if (!ok(encode_png(image, image_))) {
        throw InputError(path_ + ": an image cannot be written as PNG");
    }
    write_image(table, static_cast<std::int64_t>(time_of(stamp)), "", image_, message_);
    writer_->add_message(channel, time_of(stamp), message_);
}

template <std::size_t N>
void McapSampleLog::add_row(LogTable table, Timestamp stamp, const std::array<std::string, N>& fields) {
    std::array<std::string_view, N> views;
    const auto is_letter = [](char c) { return c == 'n'; };  // of nan and inf, which JSON does not know
    std::ranges::transform(fields, views.begin(), [&](const std::string& field) {
        return std::ranges::any_of(field, is_letter) ? std::string_view("null") : std::string_view(field);
    });
    write_row(table, static_cast<std::int64_t>(time_of(stamp)), views, message_);
    writer_->add_message(channels_[place_of(table)], time_of(stamp), message_);
    newest_ = std::max(newest_, stamp);
}

void McapSampleLog::add_pair(const PairOrigin& origin, const ImageView& left, const ImageView& right) {
    add_image(LogTable::kLeft, origin.stamp, left);
    add_image(LogTable::kRight, origin.stamp, right);
    add_row(LogTable::kPairs, origin.stamp, fields_of(origin));
}

void McapSampleLog::add_imu(const ImuSample& sample) { add_row(LogTable::kImu, sample.stamp, fields_of(sample)); }

void McapSampleLog::add_edge(const TriggerEdge& edge) { add_row(LogTable::kEdges, edge.stamp, fields_of(edge)); }

void McapSampleLog::add_range(const RangeSample& sample, Timestamp frame) {
    if (channels_[place_of(LogTable::kRanges)] == 0) {
        add_channel(LogTable::kRanges);
    }
    add_row(LogTable::kRanges, sample.stamp, fields_of(sample, frame));
}

void McapSampleLog::add_file(const std::string& name, const std::string& content) {
    writer_->add_attached_text(kRoot + name, "application/yaml", content);
}

void McapSampleLog::commit() {
    writer_->flush();
    sink_->commit();
}

void McapSampleLog::close() { writer_->close(); }

}  // namespace facet
