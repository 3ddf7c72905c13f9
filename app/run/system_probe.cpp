// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/system_probe.h"

#include <fmt/core.h>

#include <string>
#include <utility>

#include "platform/linux/linux_worker.h"
#include "platform/linux/memory_lock.h"

namespace facet {

ProbeLine probe_system(const VehicleRealtime& wanted) {
    std::string doubts;
    if (wanted.lock_memory) {
        std::string words;
        (void)lock_memory(words);
        doubts += words.empty() ? "" : words + ". ";
    }
    const std::pair<const char*, ThreadOptions> threads[] = {{"estimator", wanted.estimator},
                                                             {"cameras", wanted.cameras},
                                                             {"imu", wanted.imu},
                                                             {"trigger", wanted.trigger},
                                                             {"output", wanted.output}};
    std::string above;
    for (const auto& [name, options] : threads) {
        LinuxWorker worker;
        WorkerReport report;
        if (ok(worker.start(
                {name, options.cpu, options.priority}, [](const std::atomic<bool>&) {}, report))) {
            doubts += report.refusals;
        }
        if (options.priority >= kInterruptPriority) {
            above += fmt::format("{}{}", above.empty() ? "" : ", ", name);
        }
    }
    if (!above.empty()) {
        doubts += fmt::format(
            "priority of {} is not below {}, which the kernel's interrupt threads have: edges that "
            "they hold up are merged",
            above, kInterruptPriority);
    }
    return doubts.empty() ? ProbeLine{Finding::kGood, "system", "grants what 'realtime' asks for"}
                          : ProbeLine{Finding::kDoubtful, "system", doubts};
}

}  // namespace facet
