// SPDX-License-Identifier: BSD-2-Clause
// A loop over independent items on several threads.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace facet::sim {

/// Calls body(i) once for each i in [0, count), in any order, on `threads` threads. body must not throw.
template <class Body>
void parallel_for(int count, int threads, const Body& body) {
    std::atomic<int> next{0};
    const auto work = [&] {
        for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) {
            body(i);
        }
    };
    std::vector<std::thread> helpers;
    for (int i = 1; i < threads; ++i) {
        helpers.emplace_back(work);
    }
    work();
    for (std::thread& helper : helpers) {
        helper.join();
    }
}

}  // namespace facet::sim
