// SPDX-License-Identifier: BSD-2-Clause
// Writes MCAP files.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/mcap/compression.h"
#include "app/mcap/mcap_format.h"

namespace facet {

/// Where an MCAP file's bytes go. Its functions throw InputError naming the path if it cannot be written.
class McapSink {
public:
    virtual ~McapSink() = default;
    virtual void write(const std::string& bytes) = 0;
    virtual void close() = 0;
};

/// A whole MCAP file: header, chunks of kChunkBytes with an index behind each, attachments, a summary with everything
/// repeated that readers look for there, and all checksums. Equal calls give equal bytes. Memory: one chunk, its
/// compressed form, and of index some 100 bytes a chunk and 10 a channel in it. All functions throw InputError naming
/// the path if the file cannot be written. Thread-bound. Heap.
class McapWriter {
public:
    /// A chunk is closed once it has this many bytes: enough for the compression, little for a reader that wants one
    /// message.
    static constexpr std::size_t kChunkBytes = std::size_t{4} << 20U;

    /// A file that grows beside its name and takes it in close(), as TextFile does.
    /// @param library  who writes, for people
    McapWriter(const std::string& path, Compression compression, const std::string& profile,
               const std::string& library);
    /// @param sink  borrowed; closed by close()
    McapWriter(McapSink& sink, Compression compression, const std::string& profile, const std::string& library);

    /// @return its number, from 1
    std::uint16_t add_schema(const std::string& name, const std::string& encoding, const std::string& data);
    /// @return its number, from 1
    std::uint16_t add_channel(std::uint16_t schema, const std::string& topic, const std::string& encoding,
                              const McapTexts& metadata);
    /// @param channel  as add_channel gave it
    /// @param time_ns  both when it was logged and when it was published
    void add_message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
    /// Copies a file piece by piece. Throws InputError also if it cannot be read, or changes its size meanwhile.
    void add_attachment(const std::string& name, const std::string& media_type, const std::string& path);
    /// The content itself.
    void add_attached_text(const std::string& name, const std::string& media_type, const std::string& content);

    /// Closes the chunk, so that the sink has all messages.
    void flush() { close_chunk(); }
    void close();

private:
    struct Record {
        McapOp kind = McapOp::kSchema;
        std::uint16_t id = 0;
        std::string content;
    };
    struct IndexEntry {
        std::uint64_t time = 0;
        std::uint64_t offset = 0;
    };

    void write(const std::string& bytes);
    void write_record(McapOp kind, const std::string& content);
    void write_index(McapOp kind, std::string_view content) { add_record(indices_[kind], kind, content); }
    static void add_record(std::string& out, McapOp kind, std::string_view content);
    void begin(const std::string& profile, const std::string& library);
    /// @return checksum of what comes before the data
    std::uint32_t begin_attachment(const std::string& name, const std::string& media_type, std::uint64_t size);
    void end_attachment(std::uint32_t crc);
    void close_chunk();
    void write_message_indices(std::string& chunk_index);
    std::string statistics() const;
    void write_summary();

    std::unique_ptr<McapSink> own_sink_;
    McapSink& sink_;
    Compression compression_;
    std::uint64_t position_ = 0;  ///< in the file
    std::uint32_t crc_ = 0;       ///< of the file, then of the summary

    std::vector<Record> definitions_;  ///< schemas and channels, in order
    std::uint16_t schemas_ = 0;
    std::uint16_t channels_ = 0;

    std::string chunk_;  ///< uncompressed records
    std::string packed_;
    std::size_t defined_ = 0;  ///< definitions that are in a chunk already
    std::map<std::uint16_t, std::vector<IndexEntry>> chunk_entries_;
    std::uint64_t chunk_begin_ = 0;
    std::uint64_t chunk_end_ = 0;

    std::map<McapOp, std::string> indices_;  ///< of chunks and attachments: records of the summary
    std::map<std::uint16_t, std::uint64_t> counts_;
    std::uint64_t messages_ = 0;
    std::uint64_t begin_ = 0;
    std::uint64_t end_ = 0;
    std::uint32_t attachments_ = 0;
    std::uint32_t chunks_ = 0;
};

}  // namespace facet
