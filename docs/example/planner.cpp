// SPDX-License-Identifier: BSD-2-Clause
// A planner's end of `facet run --stream PATH`: after each keyframe, how far the vehicle is from what is not known to
// be free, and which way leads away from it.
#include <cstdio>
#include <memory>

#include "drivers/world_stream/world_reader.h"
#include "mesh/distance_field.h"

int main(int argc, char** argv) {
    facet::WorldReader reader;
    if (argc != 2 || !ok(reader.open(argv[1]))) {
        (void)std::fprintf(stderr, "usage: facet_planner PATH, where a program streams\n");
        return 2;
    }
    const auto field = std::make_unique<facet::DistanceField>();
    for (;;) {
        const facet::Status status = reader.wait(1000);
        if (status == facet::Status::kNotReady) {
            continue;
        }
        if (!ok(status)) {
            return status == facet::Status::kEndOfStream ? 0 : 1;
        }
        const facet::WorldState& world = reader.state();
        const std::span<const std::uint8_t, facet::OccupancyGrid::kPackedBytes> cells(world.cells);
        const Eigen::Vector3i low(world.low[0], world.low[1], world.low[2]);
        if (!ok(field->update(cells, low, world.cell_m, 2.0, facet::FieldTarget::kNotFree))) {
            continue;  // the program keeps no grid
        }
        // The grid is centred on the vehicle's camera, to within a cell.
        const Eigen::Vector3i middle = low + Eigen::Vector3i(facet::OccupancyGrid::kGridX, facet::OccupancyGrid::kGridY,
                                                             facet::OccupancyGrid::kGridZ) /
                                                 2;
        const facet::FieldPoint here = field->at(world.cell_m * (middle.cast<double>().array() + 0.5).matrix());
        (void)std::printf("keyframe %llu: %.2f m from %s, away along (%.1f, %.1f, %.1f)\n",
                          static_cast<unsigned long long>(world.sequence), here.distance_m,
                          here.target == facet::Space::kOccupied ? "an obstacle" : "unknown space", here.gradient.x(),
                          here.gradient.y(), here.gradient.z());
        (void)std::fflush(stdout);
    }
}
