// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/mcap/mcap_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "app/support/input_error.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

constexpr std::uint64_t kRunBytes = std::uint64_t{4} << 20U;  // of messages outside chunks that are read as one
constexpr std::size_t kMostDefinitions = 4096;                // channels, schemas, texts of a channel: each
constexpr std::size_t kMostAttachments = 1'000'000;           // files of a log that no message holds
constexpr std::size_t kMostDefinitionBytes = std::size_t{16} << 20U;
constexpr std::size_t kChunkHead = 8 + 8 + 8 + 4 + 4;

McapTexts take_texts(ByteReader& bytes) {
    McapTexts texts;
    ByteReader entries(bytes.take_counted());
    while (!entries.failed() && entries.left() > 0 && texts.size() < kMostDefinitions) {
        const std::string key(entries.take_text());
        texts[key] = entries.take_text();
    }
    return texts;
}

/// @return false if the record is too short to be one
bool parse_message(std::span<const std::uint8_t> content, McapMessage& message) {
    if (content.size() < kMcapMessageHead) {
        return false;
    }
    ByteReader bytes(content);
    message.channel = bytes.take<std::uint16_t>();
    bytes.take_bytes(sizeof(std::uint32_t));  // sequence
    message.time_ns = bytes.take<std::uint64_t>();
    bytes.take_bytes(sizeof(std::uint64_t));  // published
    message.data = bytes.take_bytes(bytes.left());
    return true;
}

}  // namespace

bool McapFile::recognises(const std::string& path) {
    char begin[kMcapMagic.size()] = {};
    std::ifstream file;
    if (refuse_file(path).empty()) {
        file.open(path, std::ios::binary);
    }
    return file.read(begin, sizeof(begin)) && std::string_view(begin, sizeof(begin)) == kMcapMagic;
}

McapFile::McapFile(const std::string& path, Warn warn, const std::atomic<bool>* stop)
    : path_(path), warn_(std::move(warn)), stop_(stop) {
    const std::string refusal = refuse_file(path);
    descriptor_ = refusal.empty() ? ::open(path.c_str(), O_RDONLY | O_CLOEXEC) : -1;
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
        const std::string why = refusal.empty() ? std::strerror(errno) : refusal;
        if (descriptor_ >= 0) {
            ::close(descriptor_);
        }
        throw InputError(path + ": " + why);
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
    most_unpacked_ = most_unpacked(size_);
    if (!is_followed_by_magic(0)) {
        ::close(descriptor_);
        throw InputError(path + ": does not begin as an MCAP file");
    }
    walk();
    learn_channels();
}

McapFile::~McapFile() { ::close(descriptor_); }

bool McapFile::read_at(std::uint64_t at, std::span<std::uint8_t> out) const {
    while (!out.empty()) {
        const ssize_t got = ::pread(descriptor_, out.data(), out.size(), static_cast<off_t>(at));
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got <= 0) {
            return false;
        }
        at += static_cast<std::uint64_t>(got);
        out = out.subspan(static_cast<std::size_t>(got));
    }
    return true;
}

bool McapFile::is_followed_by_magic(std::uint64_t at) const {
    std::uint8_t magic[kMcapMagic.size()];
    return read_at(at, magic) && text_of(magic) == kMcapMagic;
}

/// @return false if the file ends before the record does
bool McapFile::read_head(std::uint64_t at, RecordHead& head) const {
    std::uint8_t bytes[kMcapRecordHead];
    if (size_ - at < sizeof(bytes) || !read_at(at, bytes)) {
        return false;
    }
    ByteReader reader(bytes);
    head.kind = static_cast<McapOp>(reader.take<std::uint8_t>());
    head.size = reader.take<std::uint64_t>();
    return head.size <= size_ - at - sizeof(bytes);
}

bool McapFile::load(std::uint64_t at, std::uint64_t size, std::vector<std::uint8_t>& out) const {
    if (size > kMostBytes || size > size_ || at > size_ - size) {
        return false;
    }
    out.resize(static_cast<std::size_t>(size));
    return read_at(at, out);
}

void McapFile::walk() {
    std::uint64_t at = kMcapMagic.size();
    RecordHead head;
    while (read_head(at, head)) {
        if (!take_record(head, at + kMcapRecordHead)) {
            return;
        }
        at += kMcapRecordHead + head.size;
    }
    warn_(fmt::format("{}: was cut off: {} bytes at its end are not a whole record", path_, size_ - at));
}

/// @param at  of its content. @return false at the end of the file
bool McapFile::take_record(RecordHead record, std::uint64_t at) {
    const auto load_small = [&] { return record.size <= kMostDefinitionBytes && load(at, record.size, packed_); };
    switch (record.kind) {
        case McapOp::kHeader:
            if (load_small()) {
                profile_ = ByteReader(packed_).take_text();
            }
            break;
        case McapOp::kSchema:
            if (load_small()) {
                add_schema(packed_);
            }
            break;
        case McapOp::kChannel:
            if (load_small()) {
                add_channel(packed_);
            }
            break;
        case McapOp::kMessage: add_message(at, record.size); break;
        case McapOp::kChunk: add_chunk(at, record.size); break;
        case McapOp::kMessageIndex:
            if (!blocks_.empty() && blocks_.back().indices == 0) {
                blocks_.back().indices = at - kMcapRecordHead;
            }
            break;
        case McapOp::kAttachment: add_attachment(at, record.size); break;
        case McapOp::kFooter: is_whole_ = is_followed_by_magic(at + record.size); return false;
        default: break;  // what only hastens readers, and what later versions bring
    }
    return true;
}

void McapFile::add_schema(std::span<const std::uint8_t> content) {
    ByteReader bytes(content);
    const auto id = bytes.take<std::uint16_t>();
    const std::string name(bytes.take_text());
    if (!bytes.failed() && schemas_.size() < kMostDefinitions) {
        schemas_.try_emplace(id, name);
    }
}

void McapFile::add_channel(std::span<const std::uint8_t> content) {
    ByteReader bytes(content);
    McapChannel channel;
    channel.id = bytes.take<std::uint16_t>();
    channel.schema_id = bytes.take<std::uint16_t>();
    channel.topic = bytes.take_text();
    channel.encoding = bytes.take_text();
    channel.metadata = take_texts(bytes);
    if (!bytes.failed() && channels_.size() < kMostDefinitions) {
        channels_.try_emplace(channel.id, std::move(channel));
    }
}

/// Messages outside chunks: neighbours become a run that is read as a chunk would be.
void McapFile::add_message(std::uint64_t at, std::uint64_t size) {
    const std::uint64_t begin = at - kMcapRecordHead;
    const std::uint64_t whole = kMcapRecordHead + size;
    if (whole > kMostBytes) {
        warn_(fmt::format("{}: a message of {} MiB; left out", path_, whole >> 20U));
        return;
    }
    Block* const last = blocks_.empty() ? nullptr : &blocks_.back();
    if (last != nullptr && last->is_run && last->offset + last->size == begin && last->size + whole <= kRunBytes) {
        last->size += whole;
        last->unpacked = last->size;
        return;
    }
    Block run{.offset = begin, .size = whole, .unpacked = whole};
    run.is_run = true;
    blocks_.push_back(run);
}

void McapFile::add_chunk(std::uint64_t at, std::uint64_t size) {
    std::vector<std::uint8_t> bytes;
    const std::uint64_t head_size = std::min<std::uint64_t>(size, kChunkHead + 64 + sizeof(std::uint64_t));
    Block block;
    std::optional<Compression> compression;
    std::uint64_t head = 0;
    if (load(at, head_size, bytes)) {
        ByteReader reader(bytes);
        reader.take_bytes(16);  // times
        block.unpacked = reader.take<std::uint64_t>();
        block.crc = reader.take<std::uint32_t>();
        compression = find_compression(reader.take_text());
        block.size = reader.take<std::uint64_t>();
        head = bytes.size() - reader.left();
        compression = reader.failed() ? std::nullopt : compression;
    }
    block.offset = at + head;
    if (!compression.has_value() || block.size != size - head || block.size > kMostBytes ||
        block.unpacked > kMostBytes) {
        warn_(fmt::format("{}: the chunk at byte {} is damaged, too large or compressed in an unknown way; left out",
                          path_, at));
        return;
    }
    if (block.unpacked > most_unpacked_) {
        warn_(
            fmt::format("{}: the chunk at byte {} unpacks to more than a file of this size may; left out", path_, at));
        return;
    }
    most_unpacked_ -= block.unpacked;
    block.compression = *compression;
    blocks_.push_back(block);
}

void McapFile::add_attachment(std::uint64_t at, std::uint64_t size) {
    constexpr std::uint64_t kMostHead = std::uint64_t{64} << 10U;
    std::vector<std::uint8_t> bytes;
    if (attachments_.size() >= kMostAttachments || !load(at, std::min(size, kMostHead), bytes)) {
        warn_(fmt::format("{}: the attachment at byte {} is one too many; left out", path_, at));
        return;
    }
    ByteReader reader(bytes);
    McapAttachment attachment;
    reader.take_bytes(16);  // times
    attachment.name = reader.take_text();
    attachment.media_type = reader.take_text();
    attachment.size = reader.take<std::uint64_t>();
    const std::size_t head = bytes.size() - reader.left();
    if (reader.failed() || size < head + sizeof(std::uint32_t) ||
        attachment.size != size - head - sizeof(std::uint32_t)) {
        warn_(fmt::format("{}: the attachment at byte {} is damaged; left out", path_, at));
        return;
    }
    attachment.offset = at + head;
    attachment.head_crc = crc_of(std::span(bytes).first(head));
    std::uint8_t crc[sizeof(std::uint32_t)];
    if (read_at(attachment.offset + attachment.size, crc)) {
        attachment.crc = ByteReader(crc).take<std::uint32_t>();
        attachments_.push_back(std::move(attachment));
    }
}

/// Writers that were interrupted, or are sparing, leave schemas and channels in the chunks alone.
void McapFile::learn_channels() {
    if (!is_whole_ || channels_.empty()) {
        for (std::size_t block = 0; block < blocks_.size(); ++block) {
            const std::vector<std::uint8_t>* const records = unpack(block);
            ByteReader bytes(records == nullptr ? std::span<const std::uint8_t>()
                                                : std::span<const std::uint8_t>(*records));
            while (bytes.left() > 0 && !bytes.failed()) {
                const auto kind = static_cast<McapOp>(bytes.take<std::uint8_t>());
                const auto content = bytes.take_bytes(bytes.take<std::uint64_t>());
                if (kind == McapOp::kSchema) {
                    add_schema(content);
                } else if (kind == McapOp::kChannel) {
                    add_channel(content);
                }
            }
        }
    }
    for (auto& [id, channel] : channels_) {
        const auto schema = schemas_.find(channel.schema_id);
        channel.schema = schema == schemas_.end() ? "" : schema->second;
    }
}

void McapFile::refuse(std::size_t block, const char* why) {
    blocks_[block].is_bad = true;
    warn_(fmt::format("{}: the chunk at byte {} {}; left out", path_, blocks_[block].offset, why));
}

/// The records of a block, valid until kBlocks others have been asked for. @return nullptr if it is damaged
const std::vector<std::uint8_t>* McapFile::unpack(std::size_t number) {
    if (blocks_[number].is_bad || (stop_ != nullptr && stop_->load())) {
        return nullptr;
    }
    auto* const known = std::ranges::find(unpacked_, number, &Unpacked::block);
    auto* const slot = known != unpacked_.end() ? known : std::ranges::min_element(unpacked_, {}, &Unpacked::used);
    slot->used = ++uses_;
    if (slot->block == number) {
        return &slot->records;
    }
    slot->block = SIZE_MAX;
    const Block& block = blocks_[number];
    if (!load(block.offset, block.size, packed_)) {
        refuse(number, "cannot be read");
        return nullptr;
    }
    if (!ok(decompress(block.compression, packed_, static_cast<std::size_t>(block.unpacked), slot->records))) {
        refuse(number, "cannot be unpacked");
        return nullptr;
    }
    if (block.crc != 0 && crc_of(slot->records) != block.crc) {
        refuse(number, "has a wrong checksum");
        return nullptr;
    }
    slot->block = number;
    return &slot->records;
}

bool McapFile::next(Cursor& cursor, McapMessage& message) { return next_before(blocks_.size(), cursor, message); }

/// @param end  the block before which the message must lie
bool McapFile::next_before(std::size_t end, Cursor& cursor, McapMessage& message) {
    for (; cursor.block < end; ++cursor.block, cursor.offset = 0) {
        const std::vector<std::uint8_t>* const records = unpack(cursor.block);
        if (records == nullptr) {
            continue;
        }
        ByteReader bytes{std::span(*records).subspan(cursor.offset)};
        while (bytes.left() > 0) {
            const auto kind = static_cast<McapOp>(bytes.take<std::uint8_t>());
            const std::span<const std::uint8_t> content = bytes.take_bytes(bytes.take<std::uint64_t>());
            if (bytes.failed()) {
                refuse(cursor.block, "has a record that leads outside");
                break;
            }
            cursor.offset = records->size() - bytes.left();
            if (kind == McapOp::kMessage && parse_message(content, message)) {
                return true;
            }
        }
    }
    return false;
}

Status McapFile::read(const McapPlace& place, std::uint16_t channel, McapMessage& message) {
    const std::vector<std::uint8_t>* const records = place.block < blocks_.size() ? unpack(place.block) : nullptr;
    if (records == nullptr || place.offset >= records->size()) {
        return Status::kCorrupt;
    }
    ByteReader bytes{std::span(*records).subspan(place.offset)};
    const auto kind = static_cast<McapOp>(bytes.take<std::uint8_t>());
    McapMessage found;
    if (kind != McapOp::kMessage || !parse_message(bytes.take_bytes(bytes.take<std::uint64_t>()), found) ||
        found.channel != channel || found.time_ns != place.time_ns) {
        return Status::kCorrupt;
    }
    message = found;
    return Status::kOk;
}

/// @return false unless the file has a usable index of this block
bool McapFile::index_of_block(std::size_t number, std::uint16_t channel, std::vector<McapPlace>& places) const {
    std::uint64_t at = blocks_[number].indices;
    std::vector<std::uint8_t> bytes;
    RecordHead head;
    for (bool any = false; at != 0 && read_head(at, head); at += kMcapRecordHead + head.size, any = true) {
        if (head.kind != McapOp::kMessageIndex) {
            return any;
        }
        if (!load(at + kMcapRecordHead, head.size, bytes)) {
            return false;
        }
        ByteReader reader(bytes);
        if (reader.take<std::uint16_t>() != channel) {
            continue;
        }
        ByteReader entries(reader.take_counted());
        const std::size_t begin = places.size();
        while (entries.left() >= 16) {
            const auto time = entries.take<std::uint64_t>();
            const auto offset = entries.take<std::uint64_t>();
            if (offset >= blocks_[number].unpacked) {
                places.resize(begin);
                return false;
            }
            places.push_back({time, static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(offset)});
        }
        std::sort(places.begin() + static_cast<std::ptrdiff_t>(begin), places.end(),
                  [](const McapPlace& a, const McapPlace& b) { return a.offset < b.offset; });
    }
    return false;
}

void McapFile::scan_block(std::size_t number, std::uint16_t channel, std::vector<McapPlace>& places) {
    Cursor cursor{number, 0};
    for (McapMessage message; next_before(number + 1, cursor, message);) {
        if (message.channel == channel) {
            const std::size_t size = kMcapRecordHead + kMcapMessageHead + message.data.size();
            places.push_back({message.time_ns, static_cast<std::uint32_t>(number),
                              static_cast<std::uint32_t>(cursor.offset - size)});
        }
    }
}

std::vector<McapPlace> McapFile::index(std::uint16_t channel) {
    std::vector<McapPlace> places;
    for (std::size_t number = 0; number < blocks_.size(); ++number) {
        const std::size_t before = places.size();
        if (!blocks_[number].is_bad && !index_of_block(number, channel, places)) {
            places.resize(before);
            scan_block(number, channel, places);
        }
    }
    return places;
}

Status McapFile::read_attachment(const McapAttachment& attachment, std::uint64_t from,
                                 std::span<std::uint8_t> out) const {
    const bool fits = from <= attachment.size && out.size() <= attachment.size - from;
    return fits && read_at(attachment.offset + from, out) ? Status::kOk : Status::kIo;
}

}  // namespace facet
