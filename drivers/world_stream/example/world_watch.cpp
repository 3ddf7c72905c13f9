// SPDX-License-Identifier: BSD-2-Clause
// Example of a planner's end of the world stream: prints a line for every state that arrives.
// Usage: facet_world_watch PATH       while `facet run --stream PATH` or `facet replay --stream PATH` runs
#include <algorithm>
#include <array>
#include <cstdio>

#include "drivers/world_stream/world_reader.h"

int main(int argc, char** argv) {
    facet::WorldReader reader;
    if (argc != 2 || !ok(reader.open(argv[1]))) {
        (void)std::fprintf(stderr, "usage: facet_world_watch PATH, where a program streams\n");
        return 2;
    }
    for (;;) {
        const facet::Status status = reader.wait(1000);
        if (status == facet::Status::kNotReady) {
            continue;
        }
        if (!ok(status)) {
            return status == facet::Status::kEndOfStream ? 0 : 1;
        }
        const facet::WorldState& world = reader.state();
        const auto faces =
            std::count_if(world.faces.begin(), world.faces.end(), [](const facet::WorldFace& f) { return f.is_used; });
        std::array<int, 4> cells{};
        for (const std::uint8_t four : world.cells) {
            for (int shift = 0; shift < 8; shift += 2) {
                ++cells[(four >> shift) & 3U];
            }
        }
        (void)std::printf("%llu at %.3f s: %d faces, %d planes, %d cells free, %d occupied; %llu keyframes missed\n",
                          static_cast<unsigned long long>(world.sequence), 1e-9 * static_cast<double>(world.stamp_ns),
                          static_cast<int>(faces), static_cast<int>(world.planes.size()), cells[1], cells[2],
                          static_cast<unsigned long long>(reader.missed()));
        (void)std::fflush(stdout);
    }
}
