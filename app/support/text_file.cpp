// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/text_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "app/support/input_error.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// Where a file of this name grows: beside it, unless something is there that must not be replaced.
std::string growing_path(const std::string& path) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    const bool is_device = fs::exists(status) && !fs::is_regular_file(status);
    return is_device ? path : path + TextFile::kPartEnding;
}

/// Where a name that may be a link leads to.
std::string target_of(const std::string& path) {
    std::error_code error;
    const fs::path target = fs::canonical(path, error);
    return error ? path : target.string();
}

}  // namespace

TextFile::TextFile(const std::string& path)
    : path_(path),
      target_(target_of(path)),
      growing_(growing_path(target_)),
      file_(std::fopen(growing_.c_str(), "wb")) {
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
    if (file_ == nullptr) {
        return;
    }
    if (std::fclose(file_.release()) != 0 ||
        (growing_ != target_ && std::rename(growing_.c_str(), target_.c_str()) != 0)) {
        fail();
    }
}

void make_folder(const std::string& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error || !fs::is_directory(path)) {
        throw InputError(fmt::format("{}: cannot be created: {}", path, error ? error.message() : "not a folder"));
    }
}

}  // namespace facet
