// SPDX-License-Identifier: BSD-2-Clause
// The program under test, started and watched as systemd would.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "platform/base/timestamp.h"
#include "tests/hil/inject/kernel_devices.h"

namespace facet::hil {

/// What the program said of its state, and its memory then.
struct ChildState {
    Timestamp at;
    double resident_mib = 0.0;
    std::string words;
};

/// Starts a program with NOTIFY_SOCKET and, if it is watched, WATCHDOG_USEC. Throws std::system_error; a program that
/// still runs when its owner ends is killed.
class Child {
public:
    /// @param watchdog  zero: it is not watched, and not started again
    /// @param keep_states  keeps what it says of its state while it is tended
    Child(std::vector<std::string> command, Duration watchdog, bool keep_states);
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child();

    /// Waits until it says READY=1. @return false if it has ended instead
    bool wait_ready();
    /// A program that is watched is started again if it has ended with a failure; or has not fed the watchdog in time,
    /// after it was killed. @return whether it runs, perhaps again
    bool tend(Timestamp now);
    void send_signal(int signal);
    /// One of its threads runs no more from now on. Throws std::system_error.
    void hang(const std::string& thread);
    /// SIGTERM, and its exit code; 128 + signal if it was killed.
    int stop();
    bool running();

    /// When it ended first, or was killed by the watchdog, and when the one that was started then was ready; zero if it
    /// did not.
    Timestamp killed_at() const { return killed_at_; }
    Timestamp ready_again_at() const { return ready_again_at_; }
    const std::vector<ChildState>& states() const { return states_; }

private:
    void start();
    std::string heard(int timeout_ms);
    double resident_mib() const;
    int collect(int options);
    void start_again(Timestamp now);

    std::vector<std::string> command_;
    Duration watchdog_;
    bool keep_states_;
    Descriptor socket_;
    pid_t pid_ = -1;
    pid_t hanging_ = -1;  ///< its thread that runs no more
    int exit_code_ = -1;
    bool any_fed_ = false;
    Timestamp fed_at_;
    Timestamp killed_at_;
    Timestamp ready_again_at_;
    std::vector<ChildState> states_;
};

}  // namespace facet::hil
