// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/ros1_bag.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <utility>

#include "app/mcap/bytes.h"
#include "app/mcap/compression.h"
#include "app/support/input_error.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMostHead = 1U << 20U;

enum class BagOp : std::uint8_t { kMessage = 0x02, kChunk = 0x05, kConnection = 0x07 };

/// A field of a record's head: length, name, '=', value.
std::string_view field(std::span<const std::uint8_t> head, std::string_view name) {
    ByteReader bytes(head);
    while (bytes.left() > 0 && !bytes.failed()) {
        const std::string_view entry = bytes.take_text();
        const std::size_t equals = entry.find('=');
        if (equals != std::string_view::npos && entry.substr(0, equals) == name) {
            return entry.substr(equals + 1);
        }
    }
    return {};
}

template <class T>
std::optional<T> number(std::span<const std::uint8_t> head, std::string_view name) {
    const std::string_view value = field(head, name);
    return value.size() == sizeof(T) ? std::optional(ByteReader(bytes_of(value)).take<T>()) : std::nullopt;
}

}  // namespace

struct Ros1Bag::Record {
    std::span<const std::uint8_t> head;
    std::span<const std::uint8_t> data;

    bool is(BagOp op) const { return number<std::uint8_t>(head, "op") == static_cast<std::uint8_t>(op); }
};

bool Ros1Bag::recognises(const std::string& path) {
    char begin[kMagic.size()] = {};
    std::ifstream file;
    if (refuse_file(path).empty()) {
        file.open(path, std::ios::binary);
    }
    return file.read(begin, sizeof(begin)) && std::string_view(begin, sizeof(begin)) == kMagic;
}

Ros1Bag::Ros1Bag(const std::string& path, Warn warn, const std::atomic<bool>* stop)
    : path_(path), warn_(std::move(warn)), stop_(stop), file_(path, std::ios::binary), at_(kMagic.size()) {
    std::error_code error;
    size_ = std::filesystem::file_size(path, error);
    if (!recognises(path) || !file_ || error) {
        throw InputError(path + ": is no ROS bag of format 2.0");
    }
    file_.seekg(static_cast<std::streamoff>(at_));
}

double Ros1Bag::share() const { return size_ == 0 ? 1.0 : static_cast<double>(at_) / static_cast<double>(size_); }

/// @return false at the end of the file, or where it is cut off or damaged
bool Ros1Bag::next_record(Record& record) {
    const auto read = [this](std::vector<std::uint8_t>& bytes, std::size_t most) {
        std::uint8_t prefix[4];
        if (size_ - at_ < sizeof(prefix) || !file_.read(reinterpret_cast<char*>(prefix), sizeof(prefix))) {
            return false;
        }
        at_ += sizeof(prefix);
        const auto size = ByteReader(prefix).take<std::uint32_t>();
        if (size > most || size > size_ - at_) {
            return false;
        }
        bytes.resize(size);
        at_ += size;
        return static_cast<bool>(file_.read(reinterpret_cast<char*>(bytes.data()), size));
    };
    if (at_ == size_) {
        return false;
    }
    const std::uint64_t begin = at_;
    if (!read(head_, kMostHead) || !read(data_, kMostBytes)) {
        warn_(fmt::format("{}: was cut off, or is damaged, at byte {}", path_, begin));
        at_ = size_;
        return false;
    }
    record = {head_, data_};
    return true;
}

void Ros1Bag::add_connection(const Record& record) {
    constexpr std::size_t kMost = 65536;
    const auto id = number<std::uint32_t>(record.head, "conn");
    if (id.has_value() && connections_.size() < kMost) {
        connections_.try_emplace(*id, BagTopic{std::string(field(record.head, "topic")),
                                               std::string(field(record.data, "type")), WireFormat::kRos1});
    }
}

bool Ros1Bag::take_message(const Record& record, BagMessage& message) const {
    const auto id = number<std::uint32_t>(record.head, "conn");
    const auto time = number<std::uint64_t>(record.head, "time");
    const auto connection = id.has_value() ? connections_.find(*id) : connections_.end();
    if (connection == connections_.end() || !time.has_value()) {
        return false;
    }
    message = {&connection->second, (*time & 0xFFFFFFFFU) * 1'000'000'000U + (*time >> 32U), record.data};
    return true;
}

bool Ros1Bag::open_chunk(const Record& record) {
    const auto size = number<std::uint32_t>(record.head, "size");
    const auto method = find_compression(field(record.head, "compression"));
    in_chunk_ = 0;
    unpacked_ += size.value_or(0);
    if (unpacked_ > most_unpacked(size_)) {
        warn_(fmt::format("{}: unpacks to more than {} MB up to byte {}; left out from there on", path_,
                          most_unpacked(size_) / 1'000'000, at_));
        at_ = size_;
        chunk_.clear();
        return false;
    }
    if (!size.has_value() || *size > kMostBytes || !method.has_value() ||
        !ok(decompress(*method, record.data, *size, chunk_))) {
        warn_(fmt::format("{}: the chunk before byte {} is damaged; left out", path_, at_));
        chunk_.clear();
        return false;
    }
    return true;
}

/// @return false at the end of the chunk
bool Ros1Bag::next_in_chunk(BagMessage& message) {
    while (in_chunk_ < chunk_.size()) {
        ByteReader bytes{std::span(chunk_).subspan(in_chunk_)};
        Record record;
        record.head = bytes.take_counted();
        record.data = bytes.take_counted();
        if (bytes.failed()) {
            warn_(fmt::format("{}: the chunk before byte {} has a record that leads outside", path_, at_));
            break;
        }
        in_chunk_ = chunk_.size() - bytes.left();
        if (record.is(BagOp::kConnection)) {
            add_connection(record);
        } else if (record.is(BagOp::kMessage) && take_message(record, message)) {
            return true;
        }
    }
    chunk_.clear();
    in_chunk_ = 0;
    return false;
}

bool Ros1Bag::next(BagMessage& message) {
    while (stop_ == nullptr || !stop_->load()) {
        if (next_in_chunk(message)) {
            return true;
        }
        Record record;
        if (!next_record(record)) {
            return false;
        }
        if (record.is(BagOp::kChunk)) {
            (void)open_chunk(record);  // one that is damaged has no records
        } else if (record.is(BagOp::kConnection)) {
            add_connection(record);
        } else if (record.is(BagOp::kMessage) && take_message(record, message)) {
            return true;
        }
    }
    return false;
}

}  // namespace facet
