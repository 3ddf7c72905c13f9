// SPDX-License-Identifier: BSD-2-Clause
// The files of a log that pack_log has put into an MCAP file.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <streambuf>
#include <string>
#include <vector>

#include "app/lab/mcap/mcap_file.h"
#include "app/mcap/log_messages.h"

namespace facet {

/// A folder that is not there: its files as they were, byte for byte. Paths are relative to the folder packed, with
/// slashes; those that would lead out of a folder are left out with a warning. A file cut off lacks what came behind
/// the cut. Memory: McapFile's and 32 bytes an image, and its name
/// if it is not called by its stamp. Thread-bound. Heap.
class McapLog {
public:
    /// Throws InputError if it is no MCAP file. @param warn  called also later, while files are read
    /// @param stop  see McapFile
    McapLog(const std::string& path, McapFile::Warn warn, const std::atomic<bool>* stop = nullptr);

    /// Whether pack_log made it: it has at least one table.
    bool is_log() const { return !tables_.empty(); }
    const McapFile& file() const { return file_; }

    bool has_folder(const std::string& folder) const;
    bool is_table(const std::string& name) const { return tables_.contains(name); }
    /// Attachments and tables; nullptr if there is none of that name. Valid as long as the object.
    std::unique_ptr<std::streambuf> open(const std::string& name);
    /// An image that is a message, an attachment or a table, as a whole.
    /// @return kNotFound if there is none, kCorrupt if it is damaged, kFull if it has more bytes than that
    Status read(const std::string& name, std::size_t most_bytes, std::vector<std::uint8_t>& bytes);

    /// Names of attachments and tables, in order.
    std::vector<std::string> names() const;
    std::size_t image_count() const;
    /// Gives every image in file order: name and bytes. @return false at the end
    bool next_image(McapFile::Cursor& cursor, std::string& name, std::vector<std::uint8_t>& bytes);

private:
    struct Table {
        LogTable kind = LogTable::kLeft;
        std::uint16_t channel = 0;
        std::string header;
        std::string line_end;
        std::string images;                        ///< folder of them
        bool by_stamp = true;                      ///< images are called by their stamps
        std::vector<McapPlace> places;             ///< of images, in file order
        std::vector<McapPlace> by_stamp_order;     ///< the same, if they are called by their stamps
        std::map<std::string, McapPlace> by_name;  ///< those that are not called by their stamps
    };
    class TableStream;
    class AttachmentStream;

    void add_table(const McapChannel& channel);
    void index_images(Table& table);
    std::optional<McapPlace> find_image(const Table& table, const std::string& name) const;

    McapFile::Warn warn_;
    McapFile file_;
    std::map<std::string, Table> tables_;                       ///< by name
    std::map<std::string, const McapAttachment*> attachments_;  ///< by name
};

/// Whether a relative path stays in its folder: no empty, . or .. part, no leading slash, nothing unprintable.
bool is_inner_path(const std::string& path);

}  // namespace facet
