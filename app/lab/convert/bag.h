// SPDX-License-Identifier: BSD-2-Clause
// Recorded messages of other programs, one after the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace facet {

/// How a message's fields are laid out: ROS 1's own way, or CDR as ROS 2 writes it.
enum class WireFormat : std::uint8_t { kRos1, kCdr };

struct BagTopic {
    std::string name;
    std::string type;  ///< package/Name, also where ROS 2 says package/msg/Name
    WireFormat wire = WireFormat::kRos1;
};

/// package/msg/Name as package/Name.
std::string short_type(std::string type);

/// Data and topic are valid until the next message is read.
struct BagMessage {
    const BagTopic* topic = nullptr;
    std::uint64_t time_ns = 0;  ///< when it was recorded
    std::span<const std::uint8_t> data;
};

/// A source of messages in the order of the file. Thread-bound. Heap.
class Bag {
public:
    using Warn = std::function<void(const std::string&)>;

    Bag() = default;
    virtual ~Bag() = default;
    Bag(const Bag&) = delete;
    Bag& operator=(const Bag&) = delete;

    /// @return false at the end, or where nothing more can be read, which is warned of, or when it is to stop
    virtual bool next(BagMessage& message) = 0;
    /// Share of the file that has been read, from 0 to 1.
    virtual double share() const = 0;
};

/// Whether open_bag() would take it, by how it begins.
bool is_bag(const std::string& path);

/// Opens a ROS 1 bag (format 2.0), a ROS 2 bag in MCAP or sqlite3 form, or the folder of one, in the order of its
/// metadata.yaml or without it in that of the names. Messages that are compressed one by one come decompressed; a file
/// that is compressed as a whole (zstd) is decompressed into a temporary one. Topics whose messages are in another form
/// are passed over. Throws InputError if it is none of these.
/// @param stop  ends what next() does when it becomes true; may be nullptr
std::unique_ptr<Bag> open_bag(const std::string& path, const Bag::Warn& warn, const std::atomic<bool>* stop = nullptr);

}  // namespace facet
