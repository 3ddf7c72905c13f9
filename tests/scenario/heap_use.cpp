// SPDX-License-Identifier: BSD-2-Clause
#include "tests/scenario/heap_use.h"

#include <catch2/catch.hpp>
#include <memory>

#include "app/pipeline/frame_pipeline.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "tests/support/allocation_guard.h"

namespace facet::test {

HeapUse measure_heap(const std::string& log, RegularityMode mode, FrontendBackend backend) {
    const Calibration calibration = load_euroc_calibration(log + "/mav0");
    ProgramConfig config;
    config.imu_noise = calibration.noise;
    config.regularity.mode = mode;
    config.frontend.backend = static_cast<int>(backend);
    FramePipeline pipeline;
    pipeline.configure(config, calibration);
    AslOptions options;
    options.frame_delay = Duration::from_seconds(0.02);  // more than any time offset that is found
    AslDataset dataset;
    std::string error;
    REQUIRE(ok(dataset.open(
        log, options, [](const AslWarning&) {}, error)));

    HeapUse use;
    const auto result = std::make_unique<FrameResult>();
    ImuSample sample;
    StereoFrame frame;
    for (;;) {
        const AslDataset::Event event = dataset.next(sample, frame);  // decodes images: not looked at
        if (event == AslDataset::Event::kEnd) {
            return use;
        }
        AllocationGuard guard;
        if (event == AslDataset::Event::kImu) {
            pipeline.add_imu(sample);
        } else {
            pipeline.add_frame(frame, frame.stamp, *result);
            ++use.frames;
            use.keyframes += result->is_keyframe ? 1 : 0;
            use.planes = result->has_mesh ? static_cast<int>(result->planes.size()) : use.planes;
        }
        const std::uint64_t allocations = guard.allocations();
        if (allocations != 0 && use.allocations == 0) {
            use.first = guard.first_allocation();
        }
        use.allocations += allocations;
    }
}

}  // namespace facet::test
