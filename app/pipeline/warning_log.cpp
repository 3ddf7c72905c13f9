// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/warning_log.h"

#include <cstdio>

#include "app/support/console.h"

namespace facet {
namespace {

constexpr std::size_t kShownPerKind = 10;

}  // namespace

void WarningLog::add(const std::string& kind, const std::string& text) {
    file_.print("{}: {}\n", kind, printable(text));
    const std::size_t count = ++counts_[kind];
    if (quiet_ || count > kShownPerKind + 1) {
        return;
    }
    const std::string line =
        count <= kShownPerKind ? "warning: " + text : "warning: more of kind " + kind + " follow; see warnings.txt";
    if (progress_ != nullptr) {
        progress_->note(line);
    } else {
        print_err("{}\n", printable(line));
    }
}

}  // namespace facet
