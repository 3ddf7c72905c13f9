// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/flight_folders.h"

#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <vector>

#include "app/support/folder_lock.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFlightPrefix = "flight_";

struct OldFlight {
    std::uint64_t number = 0;
    fs::path path;
};

/// Of a flight's folder; zero for anything else.
std::uint64_t flight_number(const fs::directory_entry& entry) {
    std::error_code ignored;
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kFlightPrefix) || !entry.is_directory(ignored) || entry.is_symlink(ignored)) {
        return 0;
    }
    std::uint64_t number = 0;
    const char* const end = name.data() + name.size();
    const auto [read, error] = std::from_chars(name.data() + kFlightPrefix.size(), end, number);
    return error == std::errc() && read == end ? number : 0;
}

/// Newest first.
std::vector<OldFlight> list_flights(const std::string& parent) {
    std::vector<OldFlight> flights;
    std::error_code error;
    for (fs::directory_iterator i(parent, error), end; !error && i != end; i.increment(error)) {
        if (const std::uint64_t number = flight_number(*i); number != 0) {
            flights.push_back({number, i->path()});
        }
    }
    std::sort(flights.begin(), flights.end(),
              [](const OldFlight& a, const OldFlight& b) { return a.number > b.number; });
    return flights;
}

/// Of the blocks that a file or folder takes up, without what a folder holds.
std::uint64_t disc_bytes(const fs::path& path) {
    constexpr std::uint64_t kBlock = 512;  // of st_blocks, whatever the file system's own
    struct stat info {};
    return lstat(path.c_str(), &info) == 0 ? static_cast<std::uint64_t>(info.st_blocks) * kBlock : 0;
}

std::uint64_t flight_bytes(const fs::path& flight) {
    std::uint64_t bytes = disc_bytes(flight);
    std::error_code error;
    for (fs::recursive_directory_iterator i(flight, error), end; !error && i != end; i.increment(error)) {
        bytes += disc_bytes(i->path());
    }
    return bytes;
}

/// File by file, so that a flight of an hour of images does not keep the program from stopping.
bool remove_flight(const fs::path& flight, const std::atomic<bool>& stopping) {
    std::error_code error;
    std::vector<fs::path> files;
    for (fs::recursive_directory_iterator i(flight, error), end; !error && i != end; i.increment(error)) {
        if (!i->is_directory(error) || i->is_symlink(error)) {
            files.push_back(i->path());
        }
    }
    for (const fs::path& file : files) {
        if (stopping.load(std::memory_order_relaxed)) {
            return false;
        }
        fs::remove(file, error);
    }
    fs::remove_all(flight, error);
    return !error;
}

}  // namespace

std::string begin_flight(const std::string& parent) {
    make_folder(parent);
    const std::vector<OldFlight> flights = list_flights(parent);
    std::uint64_t number = flights.empty() ? 0 : flights.front().number;
    for (;;) {
        std::string path = fmt::format("{}/{}{:05}", parent, kFlightPrefix, ++number);
        if (mkdir(path.c_str(), 0755) == 0) {
            return path;
        }
        if (errno != EEXIST) {
            throw InputError(fmt::format("{}: cannot be created: {}", path, std::strerror(errno)));
        }
    }
}

int remove_old_flights(const std::string& parent, const FlightLimit& limit, const std::atomic<bool>& stopping) {
    const std::vector<OldFlight> flights = list_flights(parent);
    const fs::path current(limit.current);
    const auto is_current = [&](const OldFlight& f) { return f.path.filename() == current.filename(); };
    const auto at_current = std::find_if(flights.begin(), flights.end(), is_current);
    std::uint64_t bytes = 0;
    std::vector<const OldFlight*> surplus;
    for (auto flight = flights.begin(); flight != flights.end(); ++flight) {
        bytes += flight_bytes(flight->path);
        const bool is_kept = at_current == flights.end() || flight <= at_current + 1;
        if (bytes > limit.bytes && !is_kept) {
            surplus.push_back(&*flight);
        }
    }
    int removed = 0;
    for (auto oldest = surplus.rbegin(); oldest != surplus.rend(); ++oldest) {
        try {
            const FolderLock lock((*oldest)->path.string());
            removed += remove_flight((*oldest)->path, stopping) ? 1 : 0;
        } catch (const InputError&) {  // somebody is writing into it
        }
        if (stopping.load(std::memory_order_relaxed)) {
            break;
        }
    }
    return removed;
}

}  // namespace facet
