// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/flight_mark.h"

#include <filesystem>
#include <fstream>
#include <system_error>

namespace facet {

FlightMark::FlightMark(const std::string& folder) : path_(folder.empty() ? "" : folder + "/in_flight") {
    std::error_code ignored;
    is_continued_ = !path_.empty() && std::filesystem::exists(path_, ignored);
}

void FlightMark::set() const {
    if (!path_.empty()) {
        std::ofstream(path_, std::ios::app).flush();
    }
}

void FlightMark::clear() const {
    std::error_code ignored;
    if (!path_.empty()) {
        (void)std::filesystem::remove(path_, ignored);
    }
}

}  // namespace facet
