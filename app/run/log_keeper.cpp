// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/log_keeper.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "app/output/flight_folders.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

constexpr Duration kKeeperPoll = Duration::from_seconds(0.1);

}  // namespace

LogKeeper::LogKeeper(Clock& clock, LogKeeping keeping)
    : clock_(clock),
      keeping_(std::move(keeping)),
      folder_(::open(keeping_.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (folder_ < 0) {
        throw InputError(keeping_.folder + ": cannot be opened: " + std::strerror(errno));
    }
}

LogKeeper::~LogKeeper() { ::close(folder_); }

void LogKeeper::sync() {
    // One call for all files, those of other threads and new names included.
    if (::syncfs(folder_) != 0 && failure_.empty()) {
        failure_ = keeping_.folder + ": cannot be brought to the disk: " + std::strerror(errno);
    }
}

void LogKeeper::keep(const std::atomic<bool>& stopping) {
    Timestamp next_sync = clock_.now();
    Timestamp next_remove = next_sync;
    while (!stopping.load(std::memory_order_acquire)) {
        const Timestamp now = clock_.now();
        if (now >= next_sync) {
            sync();
            next_sync = now + kSyncPeriod;
        }
        if (now >= next_remove && !keeping_.parent.empty() && keeping_.limit_bytes > 0) {
            (void)remove_old_flights(keeping_.parent, {keeping_.limit_bytes, keeping_.folder}, stopping);
            next_remove = now + kRemovePeriod;
        }
        clock_.sleep(kKeeperPoll);
    }
}

}  // namespace facet
