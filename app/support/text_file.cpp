// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/text_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/support/input_error.h"

namespace facet {

TextFile::TextFile(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "wb")) {
    if (file_ == nullptr) {
        fail();
    }
}

void TextFile::fail() const { throw InputError(fmt::format("{}: cannot be written: {}", path_, std::strerror(errno))); }

void TextFile::write(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) {
        fail();
    }
}

void TextFile::flush() {
    if (std::fflush(file_.get()) != 0) {
        fail();
    }
}

void TextFile::close() {
    if (file_ != nullptr && std::fclose(file_.release()) != 0) {
        fail();
    }
}

void make_folder(const std::string& path) {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error || !std::filesystem::is_directory(path)) {
        throw InputError(fmt::format("{}: cannot be created: {}", path, error ? error.message() : "not a folder"));
    }
}

}  // namespace facet
