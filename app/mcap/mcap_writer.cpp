// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/mcap_writer.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "app/mcap/bytes.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"
#include "platform/base/assert.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

const char* mcap_name(Compression compression) {
    switch (compression) {
        case Compression::kLz4: return "lz4";
        case Compression::kZstd: return "zstd";
        default: return "";
    }
}

void put_texts(std::string& out, const McapTexts& texts) {
    std::string entries;
    for (const auto& [key, value] : texts) {
        put_text(entries, key);
        put_text(entries, value);
    }
    put_text(out, entries);
}

class TextFileSink final : public McapSink {
public:
    explicit TextFileSink(const std::string& path) : file_(path) {}
    void write(const std::string& bytes) override { file_.write(bytes); }
    void close() override { file_.close(); }

private:
    TextFile file_;
};

}  // namespace

McapWriter::McapWriter(const std::string& path, Compression compression, const std::string& profile,
                       const std::string& library)
    : own_sink_(std::make_unique<TextFileSink>(path)), sink_(*own_sink_), compression_(compression) {
    begin(profile, library);
}

McapWriter::McapWriter(McapSink& sink, Compression compression, const std::string& profile, const std::string& library)
    : sink_(sink), compression_(compression) {
    begin(profile, library);
}

void McapWriter::begin(const std::string& profile, const std::string& library) {
    write(std::string(kMcapMagic));
    std::string header;
    put_text(header, profile);
    put_text(header, library);
    write_record(McapOp::kHeader, header);
}

void McapWriter::write(const std::string& bytes) {
    crc_ = crc_of(bytes_of(bytes), crc_);
    position_ += bytes.size();
    sink_.write(bytes);
}

void McapWriter::add_record(std::string& out, McapOp kind, std::string_view content) {
    put(out, static_cast<std::uint8_t>(kind));
    put(out, static_cast<std::uint64_t>(content.size()));
    out += content;
}

void McapWriter::write_record(McapOp kind, const std::string& content) {
    std::string head;
    put(head, static_cast<std::uint8_t>(kind));
    put(head, static_cast<std::uint64_t>(content.size()));
    write(head);
    write(content);
}

std::uint16_t McapWriter::add_schema(const std::string& name, const std::string& encoding, const std::string& data) {
    Record record{McapOp::kSchema, ++schemas_, {}};
    put(record.content, record.id);
    put_text(record.content, name);
    put_text(record.content, encoding);
    put_text(record.content, data);
    definitions_.push_back(std::move(record));
    return schemas_;
}

std::uint16_t McapWriter::add_channel(std::uint16_t schema, const std::string& topic, const std::string& encoding,
                                      const McapTexts& metadata) {
    Record record{McapOp::kChannel, ++channels_, {}};
    put(record.content, record.id);
    put(record.content, schema);
    put_text(record.content, topic);
    put_text(record.content, encoding);
    put_texts(record.content, metadata);
    definitions_.push_back(std::move(record));
    counts_[channels_] = 0;
    return channels_;
}

void McapWriter::add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data) {
    FACET_ASSERT(channel >= 1 && channel <= channels_);
    for (; defined_ < definitions_.size(); ++defined_) {
        add_record(chunk_, definitions_[defined_].kind, definitions_[defined_].content);
    }
    if (chunk_entries_.empty()) {
        chunk_begin_ = chunk_end_ = time_ns;
    }
    chunk_begin_ = std::min(chunk_begin_, time_ns);
    chunk_end_ = std::max(chunk_end_, time_ns);
    chunk_entries_[channel].push_back({time_ns, chunk_.size()});
    put(chunk_, static_cast<std::uint8_t>(McapOp::kMessage));
    put(chunk_, static_cast<std::uint64_t>(kMcapMessageHead + data.size()));
    put(chunk_, channel);
    put(chunk_, static_cast<std::uint32_t>(counts_[channel]++));
    put(chunk_, time_ns);
    put(chunk_, time_ns);
    chunk_ += data;
    begin_ = messages_ == 0 ? time_ns : std::min(begin_, time_ns);
    end_ = std::max(end_, time_ns);
    ++messages_;
    if (chunk_.size() >= kChunkBytes) {
        close_chunk();
    }
}

void McapWriter::close_chunk() {
    if (chunk_.empty()) {
        return;
    }
    packed_.clear();
    compress(compression_, chunk_, packed_);
    std::string head;
    put(head, chunk_begin_);
    put(head, chunk_end_);
    put(head, static_cast<std::uint64_t>(chunk_.size()));
    put(head, crc_of(bytes_of(chunk_)));
    put_text(head, mcap_name(compression_));
    put(head, static_cast<std::uint64_t>(packed_.size()));

    std::string record;
    put(record, static_cast<std::uint8_t>(McapOp::kChunk));
    put(record, static_cast<std::uint64_t>(head.size() + packed_.size()));
    std::string index;
    put(index, chunk_begin_);
    put(index, chunk_end_);
    put(index, position_);
    put(index, static_cast<std::uint64_t>(record.size() + head.size() + packed_.size()));
    write(record + head);
    write(packed_);
    write_message_indices(index);
    put_text(index, mcap_name(compression_));
    put(index, static_cast<std::uint64_t>(packed_.size()));
    put(index, static_cast<std::uint64_t>(chunk_.size()));
    write_index(McapOp::kChunkIndex, index);
    ++chunks_;
    chunk_.clear();
    chunk_entries_.clear();
}

/// Behind the chunk an index for each channel in it; the chunk's index learns where they are.
void McapWriter::write_message_indices(std::string& chunk_index) {
    const std::uint64_t begin = position_;
    std::string places;
    for (const auto& [channel, entries] : chunk_entries_) {
        put(places, channel);
        put(places, position_);
        std::string content;
        put(content, channel);
        put(content, static_cast<std::uint32_t>(entries.size() * sizeof(IndexEntry)));
        for (const IndexEntry& entry : entries) {
            put(content, entry.time);
            put(content, entry.offset);
        }
        write_record(McapOp::kMessageIndex, content);
    }
    put_text(chunk_index, places);
    put(chunk_index, position_ - begin);
}

std::uint32_t McapWriter::begin_attachment(const std::string& name, const std::string& media_type, std::uint64_t size) {
    close_chunk();
    std::string head;
    put(head, std::uint64_t{0});  // no times: the same folder gives the same bytes
    put(head, std::uint64_t{0});
    put_text(head, name);
    put_text(head, media_type);
    put(head, size);
    std::string record;
    put(record, static_cast<std::uint8_t>(McapOp::kAttachment));
    put(record, head.size() + size + sizeof(std::uint32_t));
    std::string index;
    put(index, position_);
    put(index, record.size() + head.size() + size + sizeof(std::uint32_t));
    put(index, std::uint64_t{0});
    put(index, std::uint64_t{0});
    put(index, size);
    put_text(index, name);
    put_text(index, media_type);
    write(record + head);
    write_index(McapOp::kAttachmentIndex, index);
    ++attachments_;
    return crc_of(bytes_of(head));
}

void McapWriter::end_attachment(std::uint32_t crc) {
    std::string end;
    put(end, crc);
    write(end);
}

void McapWriter::add_attached_text(const std::string& name, const std::string& media_type, const std::string& content) {
    const std::uint32_t crc = begin_attachment(name, media_type, content.size());
    write(content);
    end_attachment(crc_of(bytes_of(content), crc));
}

void McapWriter::add_attachment(const std::string& name, const std::string& media_type, const std::string& path) {
    const std::string refusal = refuse_file(path);
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    std::ifstream source(path, std::ios::binary);
    if (!refusal.empty() || error || !source) {
        throw InputError(path + ": " + (refusal.empty() ? "cannot be read" : refusal));
    }
    std::uint32_t crc = begin_attachment(name, media_type, size);
    std::string piece;
    for (std::uint64_t left = size; left > 0; left -= piece.size()) {
        piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(std::uint64_t{1} << 16U, left)));
        source.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        piece.resize(static_cast<std::size_t>(source.gcount()));
        if (piece.empty()) {
            throw InputError(path + ": cannot be read to its end");
        }
        crc = crc_of(bytes_of(piece), crc);
        write(piece);
    }
    end_attachment(crc);
}

std::string McapWriter::statistics() const {
    std::string content;
    put(content, messages_);
    put(content, schemas_);
    put(content, std::uint32_t{channels_});
    put(content, attachments_);
    put(content, std::uint32_t{0});  // metadata
    put(content, chunks_);
    put(content, begin_);
    put(content, end_);
    std::string counts;
    for (const auto& [channel, count] : counts_) {
        put(counts, channel);
        put(counts, count);
    }
    put_text(content, counts);
    return content;
}

void McapWriter::write_summary() {
    std::map<McapOp, std::string> groups = std::move(indices_);
    for (const Record& record : definitions_) {
        add_record(groups[record.kind], record.kind, record.content);
    }
    add_record(groups[McapOp::kStatistics], McapOp::kStatistics, statistics());
    const std::uint64_t begin = position_;
    crc_ = 0;  // the summary has a checksum of its own
    std::string offsets;
    for (const auto& [kind, records] : groups) {
        std::string content;
        put(content, static_cast<std::uint8_t>(kind));
        put(content, position_);
        put(content, static_cast<std::uint64_t>(records.size()));
        add_record(offsets, McapOp::kSummaryOffset, content);
        write(records);
    }
    const std::uint64_t offsets_begin = position_;
    write(offsets);
    std::string footer;
    put(footer, static_cast<std::uint8_t>(McapOp::kFooter));
    put(footer, std::uint64_t{8 + 8 + 4});
    put(footer, begin);
    put(footer, offsets_begin);
    write(footer);  // its checksum covers it up to here
    std::string end;
    put(end, crc_);
    end += kMcapMagic;
    write(end);
}

void McapWriter::close() {
    close_chunk();
    std::string crc;
    put(crc, crc_);
    write_record(McapOp::kDataEnd, crc);
    write_summary();
    sink_.close();
}

}  // namespace facet
