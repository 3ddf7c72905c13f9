// SPDX-License-Identifier: BSD-2-Clause
// Reads MCAP files, also cut and damaged ones.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/mcap/bytes.h"
#include "app/mcap/compression.h"
#include "app/mcap/mcap_format.h"
#include "platform/base/status.h"

namespace facet {

struct McapChannel {
    std::uint16_t id = 0;
    std::uint16_t schema_id = 0;
    std::string topic;
    std::string encoding;  ///< of the messages, such as json, cdr, ros1
    std::string schema;    ///< name, such as foxglove.CompressedImage; empty if the file does not say
    McapTexts metadata;
};

/// Its data are valid until the next read from the file.
struct McapMessage {
    std::uint16_t channel = 0;
    std::uint64_t time_ns = 0;  ///< when it was logged
    std::span<const std::uint8_t> data;
};

/// Where a message lies.
struct McapPlace {
    std::uint64_t time_ns = 0;
    std::uint32_t block = 0;
    std::uint32_t offset = 0;  ///< within the block's records
};

struct McapAttachment {
    std::string name;
    std::string media_type;
    std::uint64_t offset = 0;  ///< of its data in the file
    std::uint64_t size = 0;
    std::uint32_t head_crc = 0;  ///< of what its checksum covers before the data
    std::uint32_t crc = 0;       ///< 0: there is none
};

/// A file whose records have been found from its front to its end, or to where it was cut off; the summary serves only
/// to know the channels. What is damaged (a checksum, a length that leads outside, an unknown compression) costs the
/// chunk that holds it, and a warning. Memory: 40 bytes a chunk, kBlocks chunks of at most kMostBytes, and the index
/// that index() gives. Thread-bound. Heap.
class McapFile {
public:
    using Warn = std::function<void(const std::string&)>;
    static constexpr std::size_t kMostBytes = std::size_t{96} << 20U;  ///< of a record, or of a chunk unpacked
    static constexpr std::size_t kBlocks = 3;                          ///< unpacked at a time: tables and images

    /// Position of a reader of all messages in file order.
    struct Cursor {
        std::size_t block = 0;
        std::size_t offset = 0;
    };

    /// Whether a file begins as MCAP files do.
    static bool recognises(const std::string& path);

    /// Throws InputError if it cannot be read or does not begin as an MCAP file.
    /// @param stop  once it is true nothing more is unpacked, as if the messages ended there; may be nullptr
    McapFile(const std::string& path, Warn warn, const std::atomic<bool>* stop = nullptr);
    ~McapFile();
    McapFile(const McapFile&) = delete;
    McapFile& operator=(const McapFile&) = delete;

    const std::string& path() const { return path_; }
    const std::string& profile() const { return profile_; }
    const std::map<std::uint16_t, McapChannel>& channels() const { return channels_; }
    const std::vector<McapAttachment>& attachments() const { return attachments_; }
    /// Whether it has the end that a writer leaves which was not interrupted.
    bool is_whole() const { return is_whole_; }

    /// The next message in file order. @return false at the end
    bool next(Cursor& cursor, McapMessage& message);
    /// Share of the messages before a position, from 0 to 1.
    double share(const Cursor& cursor) const {
        return blocks_.empty() ? 1.0 : static_cast<double>(cursor.block) / static_cast<double>(blocks_.size());
    }
    /// @return kCorrupt if there is no such message of this channel at that place
    Status read(const McapPlace& place, std::uint16_t channel, McapMessage& message);
    /// All messages of a channel in file order: from the indices behind the chunks, or, where one is missing, from the
    /// chunk itself.
    std::vector<McapPlace> index(std::uint16_t channel);
    /// Reads `count` bytes of an attachment from `from` on. @return kIo if they cannot be read
    Status read_attachment(const McapAttachment& attachment, std::uint64_t from, std::span<std::uint8_t> out) const;

private:
    /// A chunk, or a run of messages outside chunks.
    struct Block {
        std::uint64_t offset = 0;  ///< of its records in the file
        std::uint64_t size = 0;
        std::uint64_t unpacked = 0;
        std::uint64_t indices = 0;  ///< where those of its messages begin, 0: there are none
        std::uint32_t crc = 0;
        Compression compression = Compression::kNone;
        bool is_run = false;  ///< of messages outside chunks
        bool is_bad = false;  ///< known to be damaged: not read again
    };
    struct Unpacked {
        std::size_t block = SIZE_MAX;
        std::uint64_t used = 0;
        std::vector<std::uint8_t> records;
    };
    struct RecordHead {
        McapOp kind = McapOp::kHeader;
        std::uint64_t size = 0;
    };

    void walk();
    bool take_record(RecordHead record, std::uint64_t at);
    bool is_followed_by_magic(std::uint64_t at) const;
    bool read_at(std::uint64_t at, std::span<std::uint8_t> out) const;
    bool read_head(std::uint64_t at, RecordHead& head) const;
    bool load(std::uint64_t at, std::uint64_t size, std::vector<std::uint8_t>& out) const;
    void add_chunk(std::uint64_t at, std::uint64_t size);
    void add_message(std::uint64_t at, std::uint64_t size);
    void add_attachment(std::uint64_t at, std::uint64_t size);
    void add_schema(std::span<const std::uint8_t> content);
    void add_channel(std::span<const std::uint8_t> content);
    void learn_channels();
    const std::vector<std::uint8_t>* unpack(std::size_t block);
    bool index_of_block(std::size_t block, std::uint16_t channel, std::vector<McapPlace>& places) const;
    bool next_before(std::size_t end, Cursor& cursor, McapMessage& message);
    void scan_block(std::size_t block, std::uint16_t channel, std::vector<McapPlace>& places);
    void refuse(std::size_t block, const char* why);

    std::string path_;
    Warn warn_;
    const std::atomic<bool>* stop_;
    std::uint64_t most_unpacked_ = 0;  ///< bytes that further chunks may unpack to
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
    std::string profile_;
    std::map<std::uint16_t, std::string> schemas_;
    std::map<std::uint16_t, McapChannel> channels_;
    std::vector<McapAttachment> attachments_;
    std::vector<Block> blocks_;
    bool is_whole_ = false;
    std::vector<std::uint8_t> packed_;
    std::array<Unpacked, kBlocks> unpacked_;
    std::uint64_t uses_ = 0;
};

}  // namespace facet
