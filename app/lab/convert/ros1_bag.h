// SPDX-License-Identifier: BSD-2-Clause
// Reads ROS 1 bags, format 2.0 (wiki.ros.org/Bags/Format/2.0).
#pragma once

#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "app/lab/convert/bag.h"

namespace facet {

/// Reads from the front to the end without the index, so that bags which were cut off are read as well (rosbag calls
/// them active). Memory: one chunk of at most kMostBytes, packed and unpacked. All chunks together unpack to no more
/// than most_unpacked() allows: what is behind is left out.
class Ros1Bag : public Bag {
public:
    static constexpr std::size_t kMostBytes = std::size_t{96} << 20U;  ///< of a chunk, or of a message outside chunks

    static bool recognises(const std::string& path);

    /// Throws InputError if it cannot be read or is no such bag.
    Ros1Bag(const std::string& path, Warn warn, const std::atomic<bool>* stop);

    bool next(BagMessage& message) override;
    double share() const override;

private:
    struct Record;

    bool next_record(Record& record);
    bool next_in_chunk(BagMessage& message);
    bool open_chunk(const Record& record);
    void add_connection(const Record& record);
    bool take_message(const Record& record, BagMessage& message) const;

    std::string path_;
    Warn warn_;
    const std::atomic<bool>* stop_;
    std::uint64_t unpacked_ = 0;  ///< bytes of all chunks so far
    std::ifstream file_;
    std::uint64_t size_ = 0;
    std::uint64_t at_ = 0;  ///< of the next record
    std::map<std::uint32_t, BagTopic> connections_;
    std::vector<std::uint8_t> head_;
    std::vector<std::uint8_t> data_;
    std::vector<std::uint8_t> chunk_;
    std::size_t in_chunk_ = 0;  ///< of the chunk's records that have been read
};

}  // namespace facet
