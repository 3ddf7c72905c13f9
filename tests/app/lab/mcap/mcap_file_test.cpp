// SPDX-License-Identifier: BSD-2-Clause
// Files of McapWriter read by McapFile, whole and damaged; tests/app/lab/convert has other programs' files.
#include "app/lab/mcap/mcap_file.h"

#include <fmt/format.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <random>

#include "app/mcap/mcap_writer.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::mcap_file_test {
namespace {

constexpr int kMessages = 60;

/// 150 kB each: several chunks.
std::string content(int number) {
    return fmt::format("{:05}", number) + std::string(150'000, static_cast<char>('a' + number % 26));
}

std::string write_example(const test::TempDir& dir, Compression compression) {
    const std::string path = dir.file("example.mcap");
    McapWriter writer(path, compression, "facet", "test");
    const auto schema = writer.add_schema("facet.Thing", "jsonschema", "{}");
    const auto first = writer.add_channel(schema, "/first", "json", {{"key", "value"}, {"other", ""}});
    const auto second = writer.add_channel(0, "/second", "", {});
    writer.add_attachment("folder/file.txt", "text/plain", dir.write("attached", std::string(200'000, 'z') + "end"));
    for (int i = 0; i < kMessages; ++i) {
        writer.add_message(i % 3 == 0 ? second : first, 1000 + static_cast<std::uint64_t>(i), content(i));
    }
    writer.close();
    return path;
}

struct Reading {
    std::vector<std::string> warnings;
    std::vector<int> numbers;
    bool is_whole = false;
};

/// All messages in order; each is checked to be the one it says it is.
Reading read_all(const std::string& path) {
    Reading reading;
    McapFile file(path, [&](const std::string& line) { reading.warnings.push_back(line); });
    reading.is_whole = file.is_whole();
    McapFile::Cursor cursor;
    for (McapMessage message; file.next(cursor, message);) {
        const std::string text(text_of(message.data));
        const int number = std::stoi(text.substr(0, 5));
        CHECK(text == content(number));
        CHECK(message.time_ns == 1000 + static_cast<std::uint64_t>(number));
        reading.numbers.push_back(number);
    }
    return reading;
}

}  // namespace

TEST_CASE("a file comes back with all that was put into it") {
    const test::TempDir dir;
    const auto compression = GENERATE(Compression::kNone, Compression::kLz4, Compression::kZstd);
    const std::string path = write_example(dir, compression);
    CHECK(McapFile::recognises(path));
    const Reading reading = read_all(path);
    CHECK(reading.warnings.empty());
    CHECK(reading.is_whole);
    REQUIRE(reading.numbers.size() == kMessages);
    for (int i = 0; i < kMessages; ++i) {
        CHECK(reading.numbers[static_cast<std::size_t>(i)] == i);
    }

    McapFile file(path, [](const std::string& line) { FAIL(line); });
    CHECK(file.profile() == "facet");
    REQUIRE(file.channels().size() == 2);
    const McapChannel& first = file.channels().at(1);
    CHECK(first.topic == "/first");
    CHECK(first.encoding == "json");
    CHECK(first.schema == "facet.Thing");
    CHECK(first.metadata == McapTexts{{"key", "value"}, {"other", ""}});
    CHECK(file.channels().at(2).schema.empty());
    REQUIRE(file.attachments().size() == 1);
    std::vector<std::uint8_t> end(3);
    CHECK(file.attachments()[0].name == "folder/file.txt");
    CHECK(file.read_attachment(file.attachments()[0], 200'000, end) == Status::kOk);
    CHECK(text_of(end) == "end");
    CHECK(file.read_attachment(file.attachments()[0], 200'001, end) == Status::kIo);

    const std::vector<McapPlace> places = file.index(2);
    REQUIRE(places.size() == kMessages / 3);
    for (std::size_t i = places.size(); i-- > 0;) {
        McapMessage message;
        REQUIRE(file.read(places[i], 2, message) == Status::kOk);
        CHECK(text_of(message.data) == content(static_cast<int>(3 * i)));
        CHECK(file.read(places[i], 1, message) == Status::kCorrupt);
    }
    McapPlace beside = places[1];
    beside.offset += 1;
    McapMessage message;
    CHECK(file.read(beside, 2, message) == Status::kCorrupt);
}

TEST_CASE("the same calls give the same bytes") {
    const test::TempDir dir;
    const std::string once = test::read_file(write_example(dir, Compression::kZstd));
    CHECK(test::read_file(write_example(dir, Compression::kZstd)) == once);
}

TEST_CASE("of a file that was cut off, what came before is read") {
    const test::TempDir dir;
    const std::string whole = test::read_file(write_example(dir, Compression::kLz4));
    std::size_t last = 0;
    for (const double share : {0.1, 0.4, 0.9, 0.999}) {
        const auto size = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
        const Reading reading = read_all(dir.write("cut.mcap", whole.substr(0, size)));
        CHECK_FALSE(reading.is_whole);
        CHECK_FALSE(reading.warnings.empty());
        CHECK(reading.numbers.size() >= last);
        last = reading.numbers.size();
    }
    CHECK(last == kMessages);
    McapFile file(dir.file("cut.mcap"), [](const std::string&) {});
    CHECK(file.channels().at(1).topic == "/first");  // learnt from the chunks
    CHECK(file.channels().at(1).schema == "facet.Thing");
}

TEST_CASE("a damaged chunk costs itself alone") {
    const test::TempDir dir;
    std::string bytes = test::read_file(write_example(dir, Compression::kNone));
    bytes[bytes.find("00003ddd") + 1000] ^= 1;
    const Reading reading = read_all(dir.write("damaged.mcap", bytes));
    REQUIRE(reading.warnings.size() == 1);
    CHECK(reading.warnings[0].find("wrong checksum") != std::string::npos);
    CHECK(reading.numbers.size() > kMessages / 2);
    CHECK(reading.numbers.front() > 3);

    McapFile file(dir.file("damaged.mcap"), [](const std::string&) {});
    McapMessage message;
    CHECK(file.read(file.index(1).front(), 1, message) == Status::kCorrupt);
}

TEST_CASE("a file that unpacks to far more than it has bytes is read up to a bound") {
    const test::TempDir dir;
    const std::string path = dir.file("bomb.mcap");
    constexpr int kCount = 50;
    constexpr std::size_t kSize = std::size_t{32} << 20U;
    {
        McapWriter writer(path, Compression::kZstd, "facet", "test");
        const auto channel = writer.add_channel(0, "/nothing", "", {});
        const std::string nothing(kSize, '\0');
        for (int i = 0; i < kCount; ++i) {
            writer.add_message(channel, static_cast<std::uint64_t>(i), nothing);
        }
        writer.close();
    }
    const std::uint64_t most = most_unpacked(std::filesystem::file_size(path));
    REQUIRE(most < kCount * kSize);
    std::vector<std::string> warnings;
    McapFile file(path, [&](const std::string& line) { warnings.push_back(line); });
    McapFile::Cursor cursor;
    std::uint64_t bytes = 0;
    for (McapMessage message; file.next(cursor, message);) {
        bytes += message.data.size();
    }
    CHECK(bytes > most - 2 * kSize);
    CHECK(bytes <= most);
    REQUIRE_FALSE(warnings.empty());
    CHECK(warnings[0].find("unpacks to more than a file of this size may; left out") != std::string::npos);
}

TEST_CASE("nothing more is unpacked once the reader is to stop") {
    const test::TempDir dir;
    std::atomic<bool> stop{false};
    McapFile file(
        write_example(dir, Compression::kZstd), [](const std::string& line) { FAIL(line); }, &stop);
    McapFile::Cursor cursor;
    McapMessage message;
    REQUIRE(file.next(cursor, message));
    stop = true;
    CHECK_FALSE(file.next(cursor, message));
    stop = false;
    McapFile::Cursor again;
    CHECK(file.next(again, message));
}

TEST_CASE("no damage makes the reader fail") {
    const test::TempDir dir;
    const std::string whole = test::read_file(write_example(dir, Compression::kNone));
    std::mt19937 random(7);
    for (int round = 0; round < 40; ++round) {
        std::string bytes = whole;
        for (int i = 0; i < 30; ++i) {
            // Most of the file is messages: half of the damage goes to its ends, where the structure is.
            const std::size_t span = i % 2 == 0 ? bytes.size() : 2000;
            const std::size_t at = random() % span;
            bytes[i % 4 == 1 ? bytes.size() - 1 - at : std::max<std::size_t>(at, 8)] = static_cast<char>(random());
        }
        McapFile file(dir.write("random.mcap", bytes), [](const std::string&) {});
        McapFile::Cursor cursor;
        std::size_t count = 0;
        for (McapMessage message; file.next(cursor, message);) {
            ++count;
        }
        CHECK(count <= kMessages);
        for (const auto& [id, channel] : file.channels()) {
            for (const McapPlace& place : file.index(id)) {
                McapMessage message;
                (void)file.read(place, id, message);
            }
        }
    }
}

TEST_CASE("other files are refused in one line") {
    const test::TempDir dir;
    const auto open = [&](const std::string& path) {
        return test::input_error_text([&] { McapFile(path, [](const std::string&) {}); });
    };
    CHECK(open(dir.write("text", "no MCAP at all")).find("does not begin as an MCAP file") != std::string::npos);
    CHECK(open(dir.write("empty", "")).find("does not begin as an MCAP file") != std::string::npos);
    CHECK(open(dir.file("missing")).find("No such file") != std::string::npos);
    CHECK(open("/dev/zero").find("not a regular file") != std::string::npos);
    CHECK(open(dir.path()) != "no error");
    CHECK_FALSE(McapFile::recognises(dir.file("text")));
    CHECK_FALSE(McapFile::recognises("/dev/zero"));
}

}  // namespace facet::mcap_file_test
