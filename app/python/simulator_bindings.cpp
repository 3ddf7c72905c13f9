// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/simulate.h"
#include "app/python/bindings.h"
#include "app/support/input_error.h"

namespace facet::python {
namespace {

int simulate_flight(const std::string& out, const std::string& scene, std::uint64_t seed, double duration_s,
                    int samples, double calibration_error, bool force) {
    sim::SimOptions options;
    options.out = out;
    options.scene = scene;
    options.seed = seed;
    options.duration_s = duration_s;
    options.samples = samples;
    options.calibration_error = calibration_error;
    options.force = force;
    sim::SimSummary summary;
    std::string error;
    if (!ok(sim::simulate(options, {}, summary, error))) {
        throw InputError(error);
    }
    return summary.frames;
}

}  // namespace

void add_simulator(pybind11::module_& module) {
    namespace py = pybind11;
    module.def("simulate", &simulate_flight, py::arg("out"), py::kw_only(), py::arg("scene") = "room",
               py::arg("seed") = 1, py::arg("duration_s") = 30.0, py::arg("samples") = 3,
               py::arg("calibration_error") = 0.0, py::arg("force") = false,
               "Writes a flight with its ground truth as a log into a folder, as 'facet sim' does, and returns the "
               "number of its frames. Equal arguments give equal bytes.",
               py::call_guard<py::gil_scoped_release>());
}

}  // namespace facet::python
