// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/log_keeper.h"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>

#include "app/output/flight_folders.h"
#include "tests/support/input_error_text.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace {

/// What the keeper asks of the kernel.
struct SyncCalls {
    int count = 0;
    ino_t inode = 0;  ///< of the newest one's folder
    int error = 0;    ///< to be given back
};
SyncCalls sync_calls;

}  // namespace

/// Takes the place of the C library's in this program.
extern "C" int syncfs(int descriptor) noexcept {
    struct stat info {};
    (void)fstat(descriptor, &info);
    ++sync_calls.count;
    sync_calls.inode = info.st_ino;
    errno = sync_calls.error;
    return sync_calls.error == 0 ? 0 : -1;
}

namespace facet::log_keeper_test {
namespace {

/// Goes on until a given time, then says stop.
class EndingClock final : public Clock {
public:
    EndingClock(Timestamp end, std::atomic<bool>& stopping) : end_(end), stopping_(stopping) {}
    Timestamp now() const override { return inner_.now(); }
    ClockPair read_pair() const override { return inner_.read_pair(); }
    void sleep_until(Timestamp until) override {
        inner_.sleep_until(until);
        stopping_ = inner_.now() >= end_;
    }

private:
    ManualClock inner_;
    Timestamp end_;
    std::atomic<bool>& stopping_;
};

ino_t inode_of(const std::string& path) {
    struct stat info {};
    REQUIRE(stat(path.c_str(), &info) == 0);
    return info.st_ino;
}

TEST_CASE("the log is brought to the disk once a second") {
    const test::TempDir dir;
    std::atomic<bool> stopping{false};
    EndingClock clock({10'050'000'000}, stopping);
    LogKeeper keeper(clock, {dir.path(), "", 0});
    sync_calls = {};
    keeper.keep(stopping);
    CHECK(sync_calls.count == 11);
    CHECK(sync_calls.inode == inode_of(dir.path()));
    CHECK(keeper.failure().empty());
}

TEST_CASE("a disk that fails is reported with the folder's name, and asked again") {
    const test::TempDir dir;
    std::atomic<bool> stopping{false};
    EndingClock clock({3'050'000'000}, stopping);
    LogKeeper keeper(clock, {dir.path(), "", 0});
    sync_calls = {.error = EIO};
    keeper.keep(stopping);
    CHECK(sync_calls.count == 4);
    CHECK(keeper.failure() == dir.path() + ": cannot be brought to the disk: Input/output error");
    sync_calls = {};
}

TEST_CASE("flights that grow in the air make older ones give way") {
    const test::TempDir dir;
    const std::string oldest = begin_flight(dir.path());
    const std::string before = begin_flight(dir.path());
    const std::string current = begin_flight(dir.path());
    dir.write("flight_00001/log", std::string(1'000'000, 'x'));
    constexpr std::uint64_t kLimit = 2'000'000;
    std::atomic<bool> stopping{false};
    {
        EndingClock clock({1'000'000'000}, stopping);
        LogKeeper keeper(clock, {current, dir.path(), kLimit});
        keeper.keep(stopping);
        CHECK(std::filesystem::exists(oldest));
    }
    dir.write("flight_00003/log", std::string(1'500'000, 'x'));
    stopping = false;
    EndingClock clock({1'000'000'000}, stopping);
    LogKeeper keeper(clock, {current, dir.path(), kLimit});
    keeper.keep(stopping);
    CHECK_FALSE(std::filesystem::exists(oldest));
    CHECK(std::filesystem::exists(before));
}

TEST_CASE("a folder that is not there cannot be kept") {
    ManualClock clock;
    CHECK(test::input_error_text([&] {
              const LogKeeper keeper(clock, {"/no/such/folder", "", 0});
          }) == "/no/such/folder: cannot be opened: No such file or directory");
}

}  // namespace
}  // namespace facet::log_keeper_test
