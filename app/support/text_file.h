// SPDX-License-Identifier: BSD-2-Clause
// A text file being written, whose failures are not silent, and which is there as a whole or not at all.
#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

namespace facet {

/// Buffered output file. It grows beside its name, with kPartEnding behind it, and takes its name in close(): until
/// then an older file of that name stays as it was, and a writer that is killed leaves what it had beside it. What is
/// no regular file (a pipe, /dev/stdout) is written directly. Constructor, write and close throw InputError naming the
/// path (disk full, no permission). The destructor closes without complaint and leaves the name alone. Locale-free.
class TextFile {
public:
    static constexpr const char* kPartEnding = ".part";

    explicit TextFile(const std::string& path);

    template <class... Args>
    void print(fmt::format_string<Args...> format, Args&&... args) {
        line_.clear();
        fmt::format_to(std::back_inserter(line_), format, std::forward<Args>(args)...);
        write(line_);
    }
    void write(const std::string& text);
    void flush();
    void close();

private:
    struct Closer {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    [[noreturn]] void fail() const;

    std::string path_;
    std::string target_;   ///< the same without links
    std::string growing_;  ///< what is written
    std::string line_;
    std::unique_ptr<std::FILE, Closer> file_;
};

/// Creates a folder and its parents; throws InputError if it cannot be.
void make_folder(const std::string& path);

}  // namespace facet
