// SPDX-License-Identifier: BSD-2-Clause
// MCAP files, and the log that pack_log may have put into one.
#include "app/lab/convert/mcap_log.h"
#include "app/support/input_error.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

/// All messages, in order and by their indices.
void read_messages(const std::string& path) {
    McapFile file(path, [](const std::string& line) { test::require(line.find('\n') == std::string::npos); });
    McapFile::Cursor cursor;
    std::size_t read = 0;
    for (McapMessage message; file.next(cursor, message); ++read) {
        test::require(message.data.size() <= McapFile::kMostBytes);
    }
    for (const auto& [id, channel] : file.channels()) {
        test::require(channel.id == id);
        for (const McapPlace& place : file.index(id)) {
            McapMessage message;
            if (ok(file.read(place, id, message))) {
                test::require(message.channel == id && message.time_ns == place.time_ns);
            }
        }
    }
}

void read_log(const std::string& path) {
    McapLog log(path, [](const std::string&) {});
    std::vector<std::uint8_t> bytes;
    for (const std::string& name : log.names()) {
        test::require(is_inner_path(name));
        const std::unique_ptr<std::streambuf> stream = log.open(name);
        test::require(stream != nullptr);
        while (stream->sbumpc() != std::char_traits<char>::eof()) {
        }
    }
    McapFile::Cursor cursor;
    for (std::string name; log.next_image(cursor, name, bytes);) {
        test::require(is_inner_path(name));
        static_cast<void>(log.read(name, std::size_t{1} << 20U, bytes));
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const test::MemoryFile file({data, size});
    try {
        read_messages(file.path());
        read_log(file.path());
    } catch (const InputError& e) {
        test::require(std::string_view(e.what()).find('\n') == std::string_view::npos);
    }
    return 0;
}
