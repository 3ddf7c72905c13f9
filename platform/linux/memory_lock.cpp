// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/memory_lock.h"

#include <alloca.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace facet {

Status lock_memory(std::string& refusal) {
    // First all that there is, touched or not: what the estimator allocates at its start is first written at a reset in
    // flight. Then what is still to come, when it is touched.
    if (::mlockall(MCL_CURRENT) == 0 && ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) {
        return Status::kOk;
    }
    refusal = std::string("memory not locked: ") + std::strerror(errno) +
              "; needs CAP_IPC_LOCK or a large enough memlock limit (LimitMEMLOCK= in the unit)";
    return Status::kIo;
}

__attribute__((noinline)) void prefault_stack(std::size_t bytes) {
    if (bytes == 0) {
        return;
    }
    constexpr std::size_t kPage = 4096;
    auto* const below = static_cast<volatile unsigned char*>(alloca(bytes));
    // From the top downwards, as a stack grows: its guard page must not be jumped over.
    for (std::size_t at = bytes; at > 0; at -= at < kPage ? at : kPage) {
        below[at - 1] = 0;
    }
}

}  // namespace facet
