// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/child.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace facet::hil {
namespace {

constexpr const char* kSocket = "/run/facet-hil-notify";
constexpr int kPoll_ms = 20;

}  // namespace

Child::Child(const std::vector<std::string>& command)
    : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0), kSocket) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, kSocket, sizeof address.sun_path - 1);
    ::unlink(kSocket);
    socket_.check(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
                  "cannot be bound");
    std::vector<char*> arguments;
    for (const std::string& argument : command) {
        arguments.push_back(const_cast<char*>(argument.c_str()));
    }
    arguments.push_back(nullptr);
    pid_ = socket_.check(::fork(), "no process can be made");
    if (pid_ == 0) {
        ::setenv("NOTIFY_SOCKET", kSocket, 1);
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

bool Child::wait_ready() {
    while (running()) {
        pollfd waiting{socket_.get(), POLLIN, 0};
        if (::poll(&waiting, 1, kPoll_ms) <= 0) {
            continue;
        }
        std::array<char, 4096> text{};
        const ssize_t size = ::recv(socket_.get(), text.data(), text.size(), 0);
        if (size > 0 && std::string_view(text.data(), static_cast<std::size_t>(size)).find("READY=1") == 0) {
            return true;
        }
    }
    return false;
}

int Child::stop() {
    if (running()) {
        ::kill(pid_, SIGTERM);
    }
    return collect(0);
}

}  // namespace facet::hil
