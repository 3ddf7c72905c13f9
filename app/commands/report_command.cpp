// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/report_command.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "app/commands/run_guarded.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// scripts/report beside the program: below the prefix it is installed in, or in its source tree.
fs::path find_report_script() {
    std::error_code error;
    const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
    for (const char* const place : {"../share/facet/scripts/report", "../../../scripts/report"}) {
        if (fs::path script = (folder / place).lexically_normal(); fs::is_regular_file(script, error)) {
            return script;
        }
    }
    throw InputError("report: no scripts/report beside the program: neither in ../share/facet nor in its source tree");
}

/// Does not return but by throwing.
int become_report(const std::vector<std::string>& arguments) {
    std::vector<std::string> words{find_report_script().string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (std::string& word : words) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    ::setenv("PYTHONDONTWRITEBYTECODE", "1", 1);  // NOLINT(concurrency-mt-unsafe): there is one thread
    ::execv(pointers.front(), pointers.data());
    throw InputError(
        fmt::format("report: {} cannot be run, which needs /usr/bin/python3: {}", words.front(), std::strerror(errno)));
}

}  // namespace

void add_report_command(CLI::App& app, int& exit_code) {
    CLI::App* command =
        app.add_subcommand("report", "Make one page (HTML) of the results of runs and show how good they were");
    command->set_help_flag();  // the script explains itself
    command->prefix_command();
    command->callback(
        [command, &exit_code] { exit_code = run_guarded([&] { return become_report(command->remaining()); }); });
}

}  // namespace facet
