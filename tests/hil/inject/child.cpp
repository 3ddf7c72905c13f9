// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/child.h"

#include <poll.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace facet::hil {
namespace {

constexpr const char* kSocket = "/run/facet-hil-notify";
constexpr int kPoll_ms = 20;
constexpr std::string_view kStatus = "STATUS=";

}  // namespace

Child::Child(std::vector<std::string> command, Duration watchdog, bool keep_states)
    : command_(std::move(command)),
      watchdog_(watchdog),
      keep_states_(keep_states),
      socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0), kSocket) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, kSocket, sizeof address.sun_path - 1);
    ::unlink(kSocket);
    socket_.check(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
                  "cannot be bound");
    start();
}

void Child::start() {
    any_fed_ = false;
    std::vector<char*> arguments;
    for (const std::string& argument : command_) {
        arguments.push_back(const_cast<char*>(argument.c_str()));
    }
    arguments.push_back(nullptr);
    pid_ = socket_.check(::fork(), "no process can be made");
    if (pid_ == 0) {
        ::setenv("NOTIFY_SOCKET", kSocket, 1);
        if (watchdog_.ns > 0) {
            ::setenv("WATCHDOG_USEC", std::to_string(watchdog_.ns / 1000).c_str(), 1);
            ::setenv("RUNTIME_DIRECTORY", "/run", 1);
        }
        ::execv(arguments[0], arguments.data());
        std::perror(arguments[0]);
        ::_exit(127);
    }
}

Child::~Child() {
    if (running()) {
        ::kill(pid_, SIGKILL);
        collect(0);
    }
}

int Child::collect(int options) {
    int status = 0;
    // Whoever holds a thread has to let it go before the process can end.
    if (hanging_ > 0 && ::waitpid(hanging_, &status, options | __WALL) == hanging_) {
        hanging_ = -1;
    }
    if (pid_ > 0 && ::waitpid(pid_, &status, options) == pid_) {
        exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        pid_ = -1;
    }
    return exit_code_;
}

bool Child::running() {
    collect(WNOHANG);
    return pid_ > 0;
}

/// What it says next; empty if nothing comes within the time.
std::string Child::heard(int timeout_ms) {
    pollfd waiting{socket_.get(), POLLIN, 0};
    if (::poll(&waiting, 1, timeout_ms) <= 0) {
        return {};
    }
    std::array<char, 4096> text{};
    const ssize_t size = ::recv(socket_.get(), text.data(), text.size(), 0);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
}

double Child::resident_mib() const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/statm");
    double whole = 0.0;
    double resident = 0.0;
    file >> whole >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

bool Child::wait_ready() {
    while (running()) {
        if (heard(kPoll_ms).starts_with("READY=1")) {
            return true;
        }
    }
    return false;
}

bool Child::tend(Timestamp now) {
    for (std::string words = heard(0); !words.empty(); words = heard(0)) {
        if (words.starts_with("WATCHDOG=1")) {
            any_fed_ = true;
            fed_at_ = now;
        } else if (words.starts_with("READY=1") && killed_at_.ns != 0) {
            ready_again_at_ = now;
        } else if (keep_states_ && words.starts_with(kStatus)) {
            states_.push_back({now, resident_mib(), words.substr(kStatus.size())});
        }
    }
    if (watchdog_.ns > 0 && any_fed_ && now - fed_at_ > watchdog_) {
        send_signal(SIGKILL);
        collect(0);
        start_again(now);
    } else if (!running() && watchdog_.ns > 0 && exit_code_ != 0) {
        start_again(now);
    }
    return running();
}

void Child::start_again(Timestamp now) {
    killed_at_ = killed_at_.ns == 0 ? now : killed_at_;
    start();
}

void Child::hang(const std::string& thread) {
    for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(pid_) + "/task")) {
        std::ifstream file(entry.path() / "comm");
        std::string name;
        std::getline(file, name);
        if (name != thread) {
            continue;
        }
        hanging_ = std::stoi(entry.path().filename().string());
        if (::ptrace(PTRACE_SEIZE, hanging_, nullptr, nullptr) != 0 ||
            ::ptrace(PTRACE_INTERRUPT, hanging_, nullptr, nullptr) != 0 ||
            ::waitpid(hanging_, nullptr, __WALL) != hanging_) {
            throw std::system_error(errno, std::generic_category(), thread + " cannot be stopped");
        }
        return;
    }
    throw std::system_error(ESRCH, std::generic_category(), thread);
}

void Child::send_signal(int signal) {
    if (running()) {
        ::kill(pid_, signal);
    }
}

int Child::stop() {
    send_signal(SIGTERM);
    return collect(0);
}

}  // namespace facet::hil
