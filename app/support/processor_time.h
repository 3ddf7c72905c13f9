// SPDX-License-Identifier: BSD-2-Clause
// What work costs, whatever else the machine does meanwhile.
#pragma once

namespace facet {

/// CPU time that the calling thread has used since it began (s): CLOCK_THREAD_CPUTIME_ID, one system call. No
/// heap.
double thread_processor_s();

}  // namespace facet
