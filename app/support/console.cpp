// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/console.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>

namespace facet {
namespace {

std::atomic<bool> g_output_failed{false};

/// Failures other than that of a reader who has gone.
bool is_loss(bool done) { return !done && errno != EPIPE; }

/// Bytes of the character that begins the text, if it is UTF-8 that may be shown; else 0.
std::size_t printable_bytes(std::string_view text) {
    const auto at = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    const unsigned lead = at(0);
    if (lead < 0x80) {
        return lead >= 0x20 && lead != 0x7F ? 1 : 0;
    }
    const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    bool good = lead >= 0xC2 && lead <= 0xF4 && !(lead == 0xC2 && at(1) < 0xA0);
    for (std::size_t i = 1; i < bytes; ++i) {
        good = good && (at(i) & 0xC0U) == 0x80;
    }
    return good ? bytes : 0;
}

}  // namespace

std::string printable(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const std::size_t bytes = printable_bytes(text);
        if (bytes > 0) {
            out += text.substr(0, bytes);
        } else {
            out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
        }
        text.remove_prefix(bytes > 0 ? bytes : 1);
    }
    return out;
}

void prepare_console() {
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
        if (fcntl(descriptor, F_GETFD) == -1 && errno == EBADF) {
            (void)open("/dev/null", descriptor == STDIN_FILENO ? O_RDONLY : O_WRONLY);  // takes the lowest that is free
        }
    }
    std::signal(SIGPIPE, SIG_IGN);
}

bool finish_console() {
    const bool done = std::fflush(stdout) == 0;
    return !is_loss(done) && !g_output_failed.load();
}

void put_out(const std::string& text) {
    const bool done = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    if (is_loss(done)) {
        g_output_failed.store(true);
    }
}

void put_err(const std::string& text) { (void)std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace facet
