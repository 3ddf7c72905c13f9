// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/fault_plan.h"

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace facet::hil {
namespace {

double number(std::string_view text, const std::string& whole) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < 0.0) {
        throw std::runtime_error("fault '" + whole + "': '" + std::string(text) + "' is no time");
    }
    return value;
}

}  // namespace

void FaultPlan::add(const std::string& text) {
    const std::string_view all = text;
    const std::size_t at = all.find('@');
    const std::size_t plus = all.find('+', at == std::string_view::npos ? 0 : at);
    const auto name = std::find(kFaultNames.begin(), kFaultNames.end(), all.substr(0, at));
    if (at == std::string_view::npos || plus == std::string_view::npos || name == kFaultNames.end()) {
        throw std::runtime_error("fault '" + text + "' is not KIND@START+LENGTH with a known kind");
    }
    const Duration begin = Duration::from_seconds(number(all.substr(at + 1, plus - at - 1), text));
    const Duration length = Duration::from_seconds(number(all.substr(plus + 1), text));
    faults_.push_back({static_cast<FaultKind>(name - kFaultNames.begin()), begin, begin + length});
}

bool FaultPlan::active(FaultKind kind, Duration since_first_frame) const {
    return std::any_of(faults_.begin(), faults_.end(), [&](const Fault& fault) {
        return fault.kind == kind && since_first_frame >= fault.begin && since_first_frame < fault.end;
    });
}

}  // namespace facet::hil
