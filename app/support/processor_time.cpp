// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/processor_time.h"

#include <ctime>

namespace facet {

double thread_processor_s() {
    std::timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace facet
