// SPDX-License-Identifier: BSD-2-Clause
// Writes the files of a made-up run's mesh into a folder, for readers that are not ours.
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "app/output/run_mesh.h"
#include "tests/mesh/keyframe_samples.h"

int main(int argc, char** argv) {
    using namespace facet;
    const auto mesher = std::make_unique<Mesher>();
    if (argc != 2 || !ok(mesher->configure({}, test::mesh_camera()))) {
        return EXIT_FAILURE;
    }
    const test::WallFlight flight;
    RunMesh run;
    for (int k = 0; k < 40; ++k) {
        mesher->update(*flight.view(k), {});
        run.collect(*mesher);
    }
    run.write(*mesher, argv[1]);
    // What a reader has to find.
    std::printf("%d %d %zu\n", mesher->mesh().vertex_count(), mesher->mesh().face_count(), run.faces());
    return EXIT_SUCCESS;
}
