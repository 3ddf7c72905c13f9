// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_worker.h"

#include <pthread.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>

namespace facet::linux_worker_test {
namespace {

TEST_CASE("a worker runs under its name until it is asked to stop, and again after that") {
    LinuxWorker worker;
    for (int round = 0; round < 2; ++round) {
        std::string name;
        int passes = 0;
        WorkerReport report;
        REQUIRE(worker.start(
                    {"facet-imu", 0, 0},
                    [&](const std::atomic<bool>& stopping) {
                        std::array<char, 16> text{};
                        pthread_getname_np(pthread_self(), text.data(), text.size());
                        name = text.data();
                        while (!stopping.load()) {
                            ++passes;
                            std::this_thread::sleep_for(std::chrono::milliseconds(1));
                        }
                    },
                    report) == Status::kOk);
        CHECK(report.named);
        CHECK(report.pinned == report.refusals.empty());
        CHECK_FALSE(report.realtime);
        WorkerReport other;
        CHECK(worker.start(
                  {}, [](const std::atomic<bool>&) {}, other) == Status::kInvalidArgument);
        worker.request_stop();
        worker.join();
        CHECK(name == "facet-imu");
    }
}

TEST_CASE("a core that does not exist is refused in words, and the thread runs anyway") {
    LinuxWorker worker;
    WorkerReport report;
    std::atomic<bool> ran{false};
    REQUIRE(worker.start(
                {"w", 1000, 0}, [&](const std::atomic<bool>&) { ran = true; }, report) == Status::kOk);
    worker.join();
    CHECK(ran);
    CHECK_FALSE(report.pinned);
    CHECK(report.refusals.find("w: not pinned to its core") == 0);
}

TEST_CASE("options out of range start no thread") {
    LinuxWorker worker;
    WorkerReport report;
    const Worker::Body body = [](const std::atomic<bool>&) {};
    CHECK(worker.start({"a name that is too long", -1, 0}, body, report) == Status::kInvalidArgument);
    CHECK(worker.start({"w", -1, 100}, body, report) == Status::kInvalidArgument);
    CHECK(worker.start({"w", -1, 0}, nullptr, report) == Status::kInvalidArgument);
    CHECK(worker.start({"w", -1, 1, true}, body, report) == Status::kInvalidArgument);  // both before and behind others
}

TEST_CASE("a worker in the background has the time that nothing else wants") {
    LinuxWorker worker;
    WorkerReport report;
    std::atomic<int> policy{-1};
    REQUIRE(worker.start(
                {.name = "w", .is_background = true}, [&](const std::atomic<bool>&) { policy = sched_getscheduler(0); },
                report) == Status::kOk);
    worker.join();
    CHECK(policy == SCHED_IDLE);
    CHECK(report.refusals.empty());
}

}  // namespace
}  // namespace facet::linux_worker_test
