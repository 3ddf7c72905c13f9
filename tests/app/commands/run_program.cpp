// SPDX-License-Identifier: BSD-2-Clause
#include "tests/app/commands/run_program.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>

namespace facet::test {
namespace {

int exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -1; }

}  // namespace

Outcome run(const TempDir& dir, const std::string& arguments) {
    const std::string command =
        std::string(FACET_PROGRAM) + " " + arguments + " >" + dir.file("stdout") + " 2>" + dir.file("stderr");
    const int code = exit_code(std::system(command.c_str()));
    return {code, read_file(dir.file("stdout")), read_file(dir.file("stderr"))};
}

int shell(const TempDir& dir, const std::string& line) {
    return exit_code(std::system(("FACET='" FACET_PROGRAM "'; cd '" + dir.path() + "'; " + line).c_str()));
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::size_t count_lines(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace facet::test
