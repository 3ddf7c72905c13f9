// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/signing_time.h"

#include <fstream>

#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

constexpr std::uint64_t kUnit_ns = 10'000;
constexpr std::uint64_t kMost = std::uint64_t{1} << 48U;  // what a signature has room for
/// Two periods: the file of the last one may not have reached the disc when the power failed.
constexpr std::uint64_t kSigningAhead = 2 * static_cast<std::uint64_t>(SigningTime::kPeriod.ns) / kUnit_ns;

}  // namespace

SigningTime::SigningTime(const std::string& folder, const Clock& clock)
    : path_(folder.empty() ? "" : folder + "/signing_time"), clock_(clock), next_(clock.now()) {
    std::uint64_t last = 0;
    if (!path_.empty() && std::ifstream(path_) >> last && last < kMost - kSigningAhead) {
        first_ = last + kSigningAhead;
    }
}

std::string SigningTime::keep(std::uint64_t time) {
    if (path_.empty() || time == 0 || clock_.now() < next_) {
        return {};
    }
    next_ = clock_.now() + kPeriod;
    try {
        make_folder(path_.substr(0, path_.rfind('/')));
        TextFile file(path_);
        file.print("{}\n", time);
        file.close();
    } catch (const InputError& e) {
        path_.clear();
        return e.what();
    }
    return {};
}

}  // namespace facet
