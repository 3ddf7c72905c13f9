// SPDX-License-Identifier: BSD-2-Clause
// A number that something counted, under the name it has in files.
#pragma once

#include <cstdint>
#include <string>

namespace facet {

struct NamedCounter {
    std::string name;
    std::uint64_t value = 0;
};

}  // namespace facet
