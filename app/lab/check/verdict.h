// SPDX-License-Identifier: BSD-2-Clause
// The outcome of one check of a calibration, in a word and a sentence.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace facet {

enum class CheckLevel : std::uint8_t {
    kOk,
    kCannotTell,  ///< the log does not show it
    kSuspicious,  ///< worth a look; the estimator will probably cope
    kWrong,       ///< the estimator cannot work with this
};

struct CheckVerdict {
    std::string name;  ///< of the check, such as "gravity"
    CheckLevel level = CheckLevel::kCannotTell;
    std::string sentence;
    std::vector<std::pair<std::string, double>> figures;  ///< what the verdict rests on; names carry the unit
};

/// "ok", "cannot tell", "suspicious" or "wrong".
constexpr const char* to_string(CheckLevel level) {
    switch (level) {
        case CheckLevel::kOk: return "ok";
        case CheckLevel::kCannotTell: return "cannot tell";
        case CheckLevel::kSuspicious: return "suspicious";
        case CheckLevel::kWrong: break;
    }
    return "wrong";
}

/// The level of a figure that should be small.
constexpr CheckLevel level_of(double figure, double ok_limit, double wrong_limit) {
    return figure <= ok_limit ? CheckLevel::kOk
                              : (figure <= wrong_limit ? CheckLevel::kSuspicious : CheckLevel::kWrong);
}

}  // namespace facet
