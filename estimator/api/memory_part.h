// SPDX-License-Identifier: BSD-2-Clause
// How much memory a part takes.
#pragma once

#include <cstddef>

namespace facet {

/// One part of an object's own storage.
struct MemoryPart {
    const char* name;
    std::size_t bytes;
};

/// What estimator, mesher and plane finder may take together, image buffers included.
inline constexpr std::size_t kMemoryBudget = std::size_t{64} << 20U;

}  // namespace facet
