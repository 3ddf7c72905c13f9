// SPDX-License-Identifier: BSD-2-Clause
// Standard output and standard error of a program that must not die of either.
#pragma once

#include <fmt/core.h>

#include <string>
#include <string_view>
#include <utility>

namespace facet {

/// To be called first: a descriptor among 0, 1 and 2 that is closed becomes /dev/null, so that no file opened later
/// takes its place and gets what is printed; a pipe whose reader has gone becomes an error instead of a signal.
void prepare_console();

/// Whether all that was printed to standard output has arrived; true if its reader went away, who wants no more. To be
/// asked before anything else flushes it.
bool finish_console();

/// Text of foreign origin, such as a file's name, as one line that no terminal takes for commands: control characters
/// (C0, DEL, and C1 in UTF-8) and what is no UTF-8 become \xNN. Reentrant. Heap.
std::string printable(std::string_view text);

void put_out(const std::string& text);  ///< see print_out
void put_err(const std::string& text);  ///< see print_err

/// Text to standard output, as fmt::print but never throwing for it: a full disk or a reader who has gone does not end
/// the run. finish_console() tells.
template <class... Args>
void print_out(fmt::format_string<Args...> format, Args&&... args) {
    put_out(fmt::format(format, std::forward<Args>(args)...));
}

/// Text to standard error, likewise; if it cannot be written, nobody can be informed.
template <class... Args>
void print_err(fmt::format_string<Args...> format, Args&&... args) {
    put_err(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace facet
