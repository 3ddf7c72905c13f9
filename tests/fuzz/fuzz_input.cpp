// SPDX-License-Identifier: BSD-2-Clause
#include "tests/fuzz/fuzz_input.h"

#include <sys/mman.h>
#include <unistd.h>

namespace facet::test {

MemoryFile::MemoryFile(std::span<const std::uint8_t> content)
    : descriptor_(memfd_create("facet_fuzz", MFD_CLOEXEC)), path_("/proc/self/fd/" + std::to_string(descriptor_)) {
    require(descriptor_ >= 0);
    require(write(descriptor_, content.data(), content.size()) == static_cast<ssize_t>(content.size()));
}

MemoryFile::~MemoryFile() { close(descriptor_); }

}  // namespace facet::test
