// SPDX-License-Identifier: BSD-2-Clause
// Reports the state of the service to systemd.
#pragma once

#include <optional>
#include <string>

#include "platform/port/clock.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// The protocol of sd_notify(3): datagrams of NAME=value lines to the Unix socket of $NOTIFY_SOCKET, a path or, after
/// '@', an abstract name. Without a socket it does nothing. Never blocks; what the socket does not take at once is
/// dropped. Thread-bound. Heap.
class ServiceNotifier {
public:
    /// @param socket        content of NOTIFY_SOCKET; empty: nobody is listening
    /// @param watchdog_us   content of WATCHDOG_USEC; empty or not a number: no watchdog
    /// @param watchdog_pid  content of WATCHDOG_PID; a watchdog meant for another process is ignored
    ServiceNotifier(KernelIo& io, const Clock& clock, const std::string& socket, const std::string& watchdog_us,
                    const std::string& watchdog_pid, int own_pid);
    ~ServiceNotifier();
    ServiceNotifier(const ServiceNotifier&) = delete;
    ServiceNotifier& operator=(const ServiceNotifier&) = delete;

    /// Somebody starts this process again if it ends, or is not heard of.
    bool is_watched() const { return watchdog_.has_value(); }
    void ready() { send("READY=1"); }
    void stopping() { send("STOPPING=1"); }
    void status(const std::string& text) { send("STATUS=" + text); }
    /// Feeds the watchdog, at most four times in its period. To be called while everything is at work.
    void feed();

private:
    void send(const std::string& text);

    KernelIo& io_;
    const Clock& clock_;
    int fd_ = -1;
    std::optional<Duration> watchdog_;
    Timestamp next_feed_;
};

}  // namespace facet
