// SPDX-License-Identifier: BSD-2-Clause
// The parts of the Python module: each adds its classes and functions. Their types are in package/__init__.pyi.
#pragma once

#include <pybind11/pybind11.h>

namespace facet::python {

void add_estimate(pybind11::module_& module);
void add_flight(pybind11::module_& module);
void add_log(pybind11::module_& module);
void add_evaluation(pybind11::module_& module);
void add_simulator(pybind11::module_& module);

}  // namespace facet::python
