// SPDX-License-Identifier: BSD-2-Clause
// Where a run's warnings go: counted by kind, kept in a file, and shown without flooding the screen.
#pragma once

#include <map>
#include <string>

#include "app/support/progress.h"
#include "app/support/text_file.h"

namespace facet {

/// Writes every warning to folder/warnings.txt and the first ten of each kind to stderr. Throws InputError if the file
/// cannot be written. Thread-bound.
class WarningLog {
public:
    explicit WarningLog(const std::string& folder) : file_(folder + "/warnings.txt") {}

    /// Warnings from here on are shown through the progress bar; nullptr for plain stderr.
    void set_progress(Progress* progress) { progress_ = progress; }
    /// Shows nothing from here on, but keeps the file.
    void set_quiet() { quiet_ = true; }
    void add(const std::string& kind, const std::string& text);
    void flush() { file_.flush(); }
    void close() { file_.close(); }

    const std::map<std::string, std::size_t>& counts() const { return counts_; }

private:
    TextFile file_;
    Progress* progress_ = nullptr;
    bool quiet_ = false;
    std::map<std::string, std::size_t> counts_;
};

}  // namespace facet
