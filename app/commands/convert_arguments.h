// SPDX-License-Identifier: BSD-2-Clause
// The arguments of facet convert, and how it reports its progress.
#pragma once

#include <array>
#include <atomic>
#include <string>
#include <vector>

#include "app/support/console.h"
#include "app/support/progress.h"

namespace facet {

/// What the user typed.
struct ConvertArguments {
    std::string input;
    std::string output;
    std::string compression = "zstd";
    std::array<std::string, 4> topics;  ///< by LogTable; files, if the input is no bag
    std::vector<std::string> videos;
    std::string stamps;
    std::string cameras;
    std::string imu;
    int bits = 0;
    bool is_side_by_side = false;
    bool align_clocks = false;
    bool quiet = false;
};

inline constexpr std::size_t kPermille = 1000;  ///< of the work, for the progress

/// Progress and warnings on stderr; warnings beyond kMost are only counted.
class Narrator {
public:
    explicit Narrator(bool quiet) : progress_("convert", "", kPermille, kQuiet_s), quiet_(quiet) {}

    void update(std::size_t done) {
        if (!quiet_) {
            progress_.update(done);
        }
    }
    void warn(const std::string& line) {
        if (++warnings_ <= kMost) {
            progress_.note("warning: " + line);
        }
    }
    void finish() {
        if (!quiet_) {
            progress_.finish();
        }
        if (warnings_ > kMost) {
            print_err("warning: and {} more\n", warnings_ - kMost);
        }
    }

private:
    static constexpr std::size_t kMost = 20;
    static constexpr double kQuiet_s = 2.0;
    Progress progress_;
    bool quiet_;
    std::size_t warnings_ = 0;
};

/// Makes a log folder of images or videos and a table of inertial samples. @return an exit code. Throws InputError.
int convert_files(const ConvertArguments& args, const std::atomic<bool>& stop);

}  // namespace facet
