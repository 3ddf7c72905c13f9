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

}  // namespace

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
