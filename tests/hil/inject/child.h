// SPDX-License-Identifier: BSD-2-Clause
// The program under test, started and watched as systemd would.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/hil/inject/kernel_devices.h"

namespace facet::hil {

/// Starts a program with NOTIFY_SOCKET. Throws std::system_error; a program that still runs when its owner ends is
/// killed.
class Child {
public:
    explicit Child(const std::vector<std::string>& command);
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child();

    /// Waits until it says READY=1. @return false if it has ended instead
    bool wait_ready();
    /// SIGTERM, and its exit code; 128 + signal if it was killed.
    int stop();
    bool running();

private:
    int collect(int options);

    Descriptor socket_;
    pid_t pid_ = -1;
    int exit_code_ = -1;
};

}  // namespace facet::hil
