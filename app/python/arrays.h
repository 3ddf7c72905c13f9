// SPDX-License-Identifier: BSD-2-Clause
// What is checked of the arrays that Python gives; each function throws py::value_error with a sentence.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/geometry/camera_model.h"
#include "platform/base/image_view.h"
#include "platform/base/timestamp.h"

namespace facet::python {

namespace py = pybind11;

/// Rows of N numbers, as numpy has them.
template <int Columns>
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Columns, Eigen::RowMajor>;

/// A view of a grey image without a copy: two dimensions, uint8, rows without gaps between their pixels, the camera's
/// size. None: an empty view.
/// @param name  of the argument, for the sentence
ImageView image_of(const py::object& array, const char* name, const CameraIntrinsics& camera);

/// One whole number of nanoseconds, or an array of them.
std::vector<Timestamp> stamps_of(const py::object& stamps, const char* name);

/// One row of numbers, or an array of rows; all finite.
Rows<3> rows3_of(const py::object& array, const char* name);
Rows<4> rows4_of(const py::object& array, const char* name);

/// "3 x 4 x uint8", for sentences.
std::string describe(const py::array& array);

}  // namespace facet::python
