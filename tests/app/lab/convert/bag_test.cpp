// SPDX-License-Identifier: BSD-2-Clause
// Bags made here, byte by byte; bag_peer_test.py has those of other programs.
#include "app/lab/convert/bag.h"

#include <bzlib.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>

#include "app/lab/convert/ros1_bag.h"
#include "app/lab/convert/ros_messages.h"
#include "app/lab/convert/sorted_rows.h"
#include "app/mcap/bytes.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::bag_test {
namespace {

std::string field(const std::string& name, const std::string& value) {
    std::string out;
    put_text(out, name + "=" + value);
    return out;
}

template <class T>
std::string bytes_of_number(T value) {
    std::string out;
    put(out, value);
    return out;
}

std::string record(const std::string& head, const std::string& data) {
    std::string out;
    put_text(out, head);
    put_text(out, data);
    return out;
}

std::string connection() {
    return record(field("op", "\x07") + field("conn", bytes_of_number(3U)) + field("topic", "/imu"),
                  field("topic", "/imu") + field("type", "sensor_msgs/Imu"));
}

std::string message(std::uint32_t seconds, const std::string& data) {
    return record(field("op", "\x02") + field("conn", bytes_of_number(3U)) +
                      field("time", bytes_of_number(seconds) + bytes_of_number(5U)),
                  data);
}

std::string chunk(const std::string& records, std::uint32_t size) {
    return record(field("op", "\x05") + field("compression", "none") + field("size", bytes_of_number(size)), records);
}

const std::string kBegin = "#ROSBAG V2.0\n" + record(field("op", "\x03"), std::string(100, ' '));

struct Reading {
    std::vector<std::string> data;
    std::vector<std::string> warnings;
};

Reading reading_of(const std::string& bytes) {
    const test::TempDir dir;
    Reading reading;
    const auto bag =
        open_bag(dir.write("test.bag", bytes), [&](const auto& line) { reading.warnings.push_back(line); });
    for (BagMessage found; bag->next(found);) {
        CHECK(found.topic->name == "/imu");
        CHECK(found.topic->type == "sensor_msgs/Imu");
        CHECK(found.time_ns % 1'000'000'000 == 5);
        reading.data.emplace_back(text_of(found.data));
    }
    CHECK(bag->share() == 1.0);
    return reading;
}

BagMessage message_of(const BagTopic& topic, const std::string& data) { return {&topic, 0, bytes_of(data)}; }

}  // namespace

TEST_CASE("messages are found inside chunks and outside") {
    const std::string inside = connection() + message(1, "one") + message(2, "two");
    const Reading reading = reading_of(kBegin + chunk(inside, static_cast<std::uint32_t>(inside.size())) +
                                       message(3, "three") + message(4, ""));
    CHECK(reading.data == std::vector<std::string>{"one", "two", "three", ""});
    CHECK(reading.warnings.empty());
}

/// A chunk of 64 MiB in a few dozen bytes, as bzip2 packs it. It holds no record, which is warned of.
std::string bomb_chunk() {
    constexpr std::uint32_t kBytes = 64U << 20U;
    std::string packed(100'000, '\0');
    auto size = static_cast<unsigned>(packed.size());
    std::string nothing(kBytes, '\xff');
    REQUIRE(BZ2_bzBuffToBuffCompress(packed.data(), &size, nothing.data(), kBytes, 9, 0, 0) == BZ_OK);
    packed.resize(size);
    return record(field("op", "\x05") + field("compression", "bz2") + field("size", bytes_of_number(kBytes)), packed);
}

TEST_CASE("a bag that unpacks to far more than it has bytes is read up to a bound, and what is behind is left out") {
    const std::string bomb = bomb_chunk();
    std::string bytes = kBegin + connection() + message(1, "one");
    for (int i = 0; i < 40; ++i) {  // 2.7 GB of some ten kilobytes
        bytes += bomb;
    }
    const Reading reading = reading_of(bytes + message(2, "two"));
    CHECK(reading.data == std::vector<std::string>{"one"});
    REQUIRE_FALSE(reading.warnings.empty());
    CHECK(reading.warnings.back().find("unpacks to more than 10") != std::string::npos);
    CHECK(reading.warnings.size() <= 18);  // those before the bound hold no record
}

TEST_CASE("a bag of chunks without messages is left at once when it is to stop") {
    const std::string bomb = bomb_chunk();
    std::string bytes = kBegin;
    for (int i = 0; i < 12; ++i) {
        bytes += bomb;
    }
    const test::TempDir dir;
    std::atomic<bool> stop{false};
    int warnings = 0;
    const auto bag = open_bag(
        dir.write("test.bag", bytes),
        [&](const std::string&) {
            ++warnings;
            stop = true;
        },
        &stop);
    BagMessage message;
    CHECK_FALSE(bag->next(message));
    CHECK(warnings == 1);
    CHECK(bag->share() < 0.3);
}

TEST_CASE("damage costs a chunk, a cut what is behind it") {
    const std::string inside = connection() + message(1, "one");
    const std::string good = chunk(inside, static_cast<std::uint32_t>(inside.size()));
    const std::string wrong_size = chunk(inside, static_cast<std::uint32_t>(inside.size()) - 1);
    Reading reading = reading_of(kBegin + wrong_size + good + wrong_size);
    CHECK(reading.data == std::vector<std::string>{"one"});
    CHECK(reading.warnings.size() == 2);

    reading = reading_of(kBegin + good + good.substr(0, good.size() - 3));
    CHECK(reading.data == std::vector<std::string>{"one"});
    CHECK(reading.warnings.size() == 1);

    const std::string open = inside.substr(0, inside.size() - 2);  // a record that leads out of its chunk
    reading = reading_of(kBegin + chunk(open, static_cast<std::uint32_t>(open.size())) + good);
    CHECK(reading.data == std::vector<std::string>{"one"});
    CHECK(reading.warnings.size() == 1);

    reading = reading_of(kBegin + std::string(200, '\xff'));
    CHECK(reading.data.empty());
    CHECK(reading.warnings.size() == 1);
    CHECK(reading_of(kBegin + message(1, "of no connection")).data.empty());
}

TEST_CASE("refuses what is not a bag in one line") {
    const test::TempDir dir;
    const auto open = [](const std::string& path) {
        return test::input_error_text([&] { open_bag(path, [](const std::string&) {}); });
    };
    CHECK(open(dir.write("old.bag", "#ROSBAG V1.2\n")).find("neither a ROS 1 bag") != std::string::npos);
    CHECK(open(dir.file("missing")).find("neither a ROS 1 bag") != std::string::npos);
    CHECK(open(dir.path()).find("metadata.yaml") != std::string::npos);
    dir.write("metadata.yaml", "rosbag2_bagfile_information:\n  relative_file_paths: []\n");
    CHECK(open(dir.path()).find("names no file") != std::string::npos);
}

TEST_CASE("CDR is read in both orders of bytes, aligned") {
    const BagTopic topic{"/pose", "geometry_msgs/PoseStamped", WireFormat::kCdr};
    const auto check = [&](const std::string& begin, bool is_swapped) {
        std::string data = begin;
        const auto add = [&](auto value) {
            std::string bytes = bytes_of_number(value);
            data += is_swapped ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
        };
        add(std::int32_t{12});
        add(std::uint32_t{34});
        add(std::uint32_t{2});              // characters, the final zero among them
        data += std::string("w\0\0\0", 4);  // the frame's name, and padding to sixteen
        for (const double value : {1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 0.9}) {
            add(value);
        }
        RosPose pose;
        REQUIRE(read_message(message_of(topic, data), pose));
        CHECK(pose.stamp_ns == 12'000'000'034);
        CHECK(pose.values == std::array<double, 7>{1.0, 2.0, 3.0, 0.9, 0.1, 0.2, 0.3});
        CHECK_FALSE(read_message(message_of(topic, data.substr(0, data.size() - 1)), pose));
    };
    check(std::string("\0\1\0\0", 4), false);
    check(std::string("\0\0\0\0", 4), true);
    check(std::string("\0\7\0\0", 4), false);
    RosPose pose;
    CHECK_FALSE(read_message(message_of(topic, std::string("\0\3\0\0", 4) + std::string(200, '\0')), pose));
    CHECK_FALSE(read_message(message_of(topic, ""), pose));
}

TEST_CASE("lengths that lead outside a message are seen") {
    const BagTopic topic{"/image", "sensor_msgs/Image", WireFormat::kRos1};
    std::string data = bytes_of_number(1U) + bytes_of_number(2U) + bytes_of_number(3U);
    put(data, std::uint32_t{0xFFFFFFF0U});
    data += std::string(100, 'x');
    RosImage image;
    CHECK_FALSE(read_message(message_of(topic, data), image));
}

TEST_CASE("rows are put in order, late and repeated ones dropped") {
    std::string given;
    SortedRows rows(2, [&](std::int64_t stamp, const std::string& row) { given += std::to_string(stamp) + row + " "; });
    CHECK(rows.add(3, "c"));
    CHECK(rows.add(1, "a"));
    CHECK(rows.add(2, "b"));
    CHECK(given == "1a ");
    CHECK_FALSE(rows.add(1, "x"));
    CHECK_FALSE(rows.add(3, "x"));
    CHECK(rows.add(9, "d"));
    CHECK_FALSE(rows.add(2, "x"));
    rows.finish();
    CHECK(given == "1a 2b 3c 9d ");
}

}  // namespace facet::bag_test
