// SPDX-License-Identifier: BSD-2-Clause
// How --help looks: what is wider than 100 columns is broken.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace facet {

inline constexpr std::size_t kHelpColumns = 100;

/// Breaks lines at blanks so that they fit. What goes on is indented as the second column of its line, where there is
/// one: two blanks within a line begin it.
std::string fit_help(const std::string& text, std::size_t columns = kHelpColumns);

/// Options with their metavar (Option::type_name), in one column with what they mean, range and default behind that.
class HelpFormatter : public CLI::Formatter {
public:
    std::string make_option(const CLI::Option* option, bool is_positional) const override;
    std::string make_subcommand(const CLI::App* command) const override;
    std::string make_footer(const CLI::App* app) const override;
    std::string make_description(const CLI::App* app) const override;
};

}  // namespace facet
