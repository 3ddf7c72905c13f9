// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/unpack_log.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path) {
    throw InputError(path + ": cannot be written: " + std::strerror(errno));
}

void copy_stream(std::streambuf& from, const std::string& path) {
    make_folder(fs::path(path).parent_path().string());
    std::ofstream to(path, std::ios::binary);
    if (!to) {
        fail(path);
    }
    if (from.sgetc() != std::char_traits<char>::eof()) {  // to << (nothing) counts as a failure
        to << &from;
    }
    to.close();
    if (!to) {
        fail(path);
    }
}

}  // namespace

void make_empty_folder(const std::string& folder) {
    make_folder(folder);
    std::error_code error;
    if (!fs::is_empty(folder, error) || error) {
        throw InputError(folder + ": is not empty; nothing is overwritten");
    }
}

void write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
        fail(path);
    }
}

UnpackAccount unpack_log(McapLog& log, const std::string& folder, const std::function<void(std::uint64_t)>& progress,
                         const std::atomic<bool>& stop) {
    make_empty_folder(folder);
    UnpackAccount account;
    for (const std::string& name : log.names()) {
        if (stop.load()) {
            return account;
        }
        copy_stream(*log.open(name), folder + "/" + name);
        ++account.files;
    }
    McapFile::Cursor cursor;
    std::string name;
    std::vector<std::uint8_t> bytes;
    std::string made;  // the newest folder made for an image
    while (!stop.load() && log.next_image(cursor, name, bytes)) {
        const std::string path = folder + "/" + name;
        if (const std::string parent = fs::path(path).parent_path().string(); parent != made) {
            make_folder(parent);
            made = parent;
        }
        write_whole_file(path, bytes);
        progress(++account.images);
    }
    account.files += account.images;
    return account;
}

}  // namespace facet
