// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/help_formatter.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>

namespace facet::help_formatter_test {
namespace {

TEST_CASE("help: lines that fit stay as they are, blank ones too") {
    CHECK(fit_help("") == "");
    CHECK(fit_help("one\n\ntwo\n") == "one\n\ntwo\n");
    CHECK(fit_help("twelve chars", 12) == "twelve chars");
}

TEST_CASE("help: breaks lines at blanks, indented as their second column") {
    CHECK(fit_help("a line of words", 8) == "a line\nof words");
    CHECK(fit_help("  -x  what it means", 14) == "  -x  what it\n      means");
    CHECK(fit_help("a_single_word_is_never_broken", 8) == "a_single_word_is_never_broken");
}

TEST_CASE("help: options have metavar, range, default and what is required, but no types") {
    CLI::App app("what it does", "program");
    app.formatter(std::make_shared<HelpFormatter>());
    int count = 3;
    double seconds = 0.5;
    std::string out;
    app.add_option("--count", count, "How many")->type_name("N")->check(CLI::Range(1, 9))->capture_default_str();
    app.add_option("--duration", seconds, "How long")->type_name("SECONDS")->capture_default_str();
    app.add_option("--out", out, "Where to")->type_name("DIR")->required();
    const std::string help = app.help();
    CHECK(help.find("  --count N                 How many (1 to 9, default 3)\n") != std::string::npos);
    CHECK(help.find("  --duration SECONDS        How long (default 0.5)\n") != std::string::npos);
    CHECK(help.find("  --out DIR                 Where to (required)\n") != std::string::npos);
    CHECK(help.find("INT") == std::string::npos);
    CHECK(help.find("FLOAT") == std::string::npos);
}

}  // namespace
}  // namespace facet::help_formatter_test
