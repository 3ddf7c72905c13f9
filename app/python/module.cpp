// SPDX-License-Identifier: BSD-2-Clause
#include "app/python/bindings.h"
#include "app/support/input_error.h"

PYBIND11_MODULE(_facet, module) {
    namespace py = pybind11;
    module.doc() = "Compiled part of facet; import facet instead.";
    module.attr("__version__") = FACET_VERSION;
    // What the user gave cannot be used: the sentence that the program would print.
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) {
                std::rethrow_exception(thrown);
            }
        } catch (const facet::InputError& error) {
            PyErr_SetString(PyExc_ValueError, error.what());
        }
    });
    facet::python::add_estimate(module);
    facet::python::add_flight(module);
    facet::python::add_log(module);
    facet::python::add_evaluation(module);
    facet::python::add_simulator(module);
}
