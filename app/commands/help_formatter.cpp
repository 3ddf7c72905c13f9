// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/help_formatter.h"

#include <fmt/format.h>

#include <algorithm>

namespace facet {
namespace {

constexpr std::size_t kMeaningColumn = 28;

/// Where what a line says goes on in the next one.
std::size_t hanging_indent(const std::string& line) {
    const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t gap = line.find("  ", first);
    const std::size_t second = gap == std::string::npos ? gap : line.find_first_not_of(' ', gap);
    return second == std::string::npos || second > kHelpColumns / 2 ? first : second;
}

/// A line of two columns; the second one begins a line of its own if the first one is too wide.
std::string in_two_columns(const std::string& first, const std::string& second) {
    const std::string left = "  " + first;
    if (left.size() + 2 <= kMeaningColumn) {
        return fit_help(fmt::format("{:<{}}{}", left, kMeaningColumn, second)) + "\n";
    }
    return left + "\n" + fit_help(std::string(kMeaningColumn, ' ') + second) + "\n";
}

/// Of "N:INT in [1 - 9]", as a validator describes it, "1 to 9"; else empty.
std::string allowed_range(const std::string& type) {
    const std::size_t begin = type.rfind(" in [");
    const std::size_t middle = type.find(" - ", begin == std::string::npos ? type.size() : begin);
    if (middle == std::string::npos || type.back() != ']') {
        return "";
    }
    const std::size_t low = begin + 5;
    return type.substr(low, middle - low) + " to " + type.substr(middle + 3, type.size() - middle - 4);
}

/// What is known of an option's values besides its meaning, in brackets; else empty.
std::string notes(const CLI::Option& option) {
    std::string text = allowed_range(option.get_type_name());
    const auto add = [&](const std::string& note) { text += (text.empty() ? "" : ", ") + note; };
    if (option.get_required()) {
        add("required");
    } else if (!option.get_default_str().empty()) {
        add("default " + option.get_default_str());
    }
    return text.empty() ? text : " (" + text + ")";
}

}  // namespace

std::string fit_help(const std::string& text, std::size_t columns) {
    std::string result;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        const std::size_t indent = hanging_indent(line);
        while (line.size() > columns) {
            const std::size_t blank = line.rfind(' ', columns);
            if (blank == std::string::npos || blank <= indent) {
                break;  // one word, wider than all there is
            }
            result += line.substr(0, line.find_last_not_of(' ', blank) + 1) + "\n";
            line = std::string(indent, ' ') + line.substr(blank + 1);
        }
        result += line + (end < text.size() ? "\n" : "");
        begin = end + 1;
    }
    return result;
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
    const bool has_value = option->get_type_size() != 0;
    std::string name = make_option_name(option, is_positional);
    name.resize(std::min(name.size(), name.find('{')));  // of a flag that sets false
    if (has_value && !is_positional) {
        const std::string type = option->get_type_name();
        name += " " + type.substr(0, type.find(':'));
    }
    return in_two_columns(name, option->get_description() + (has_value ? notes(*option) : ""));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
    return in_two_columns(command->get_name(), command->get_description());
}

std::string HelpFormatter::make_footer(const CLI::App* app) const {
    return app->get_footer().empty() ? "" : fit_help(app->get_footer()) + "\n";
}

std::string HelpFormatter::make_description(const CLI::App* app) const {
    return fit_help(app->get_description()) + "\n";
}

}  // namespace facet
