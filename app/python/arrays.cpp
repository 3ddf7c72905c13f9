// SPDX-License-Identifier: BSD-2-Clause
#include "app/python/arrays.h"

#include <fmt/format.h>

namespace facet::python {
namespace {

/// As an array, whatever it is.
py::array array_of(const py::object& object, const char* name) {
    py::array array = py::array::ensure(object);
    if (!array) {
        PyErr_Clear();
        throw py::value_error(fmt::format("{} cannot be read as an array", name));
    }
    return array;
}

template <int Columns>
Rows<Columns> rows_of(const py::object& object, const char* name) {
    const py::array given = array_of(object, name);
    const char kind = given.dtype().kind();
    const bool is_single = given.ndim() == 1;
    if ((kind != 'f' && kind != 'i' && kind != 'u') || (!is_single && given.ndim() != 2) ||
        given.shape(given.ndim() - 1) != Columns) {
        throw py::value_error(fmt::format("{} must be numbers of shape ({},) or (N, {}), not {}", name, Columns,
                                          Columns, describe(given)));
    }
    const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
    Rows<Columns> rows(is_single ? 1 : given.shape(0), Columns);
    std::copy_n(array.data(), rows.size(), rows.data());
    if (!rows.allFinite()) {
        throw py::value_error(fmt::format("{} must be finite", name));
    }
    return rows;
}

}  // namespace

std::string describe(const py::array& array) {
    std::string text;
    for (py::ssize_t i = 0; i < array.ndim(); ++i) {
        text += fmt::format("{}{}", i == 0 ? "" : " x ", array.shape(i));
    }
    return fmt::format("{}{}{}", text, text.empty() ? "" : " of ", std::string(py::str(array.dtype())));
}

ImageView image_of(const py::object& object, const char* name, const CameraIntrinsics& camera) {
    if (object.is_none()) {
        return {};
    }
    if (!py::isinstance<py::array>(object)) {
        throw py::value_error(fmt::format("{} must be an array of numpy, or None", name));
    }
    const auto array = py::reinterpret_borrow<py::array>(object);
    if (array.ndim() != 2 || array.dtype().kind() != 'u' || array.itemsize() != 1) {
        throw py::value_error(
            fmt::format("{} must be a grey image, rows x columns of uint8, not {}", name, describe(array)));
    }
    if (array.shape(1) != camera.width || array.shape(0) != camera.height) {
        throw py::value_error(fmt::format("{} is {}; the calibration's camera has {} x {}", name, describe(array),
                                          camera.height, camera.width));
    }
    if (array.strides(1) != 1 || array.strides(0) < camera.width) {
        throw py::value_error(
            fmt::format("{} must have its rows in order and without gaps: numpy.ascontiguousarray makes such", name));
    }
    return {static_cast<const std::uint8_t*>(array.data()), camera.width, camera.height, array.strides(0)};
}

std::vector<Timestamp> stamps_of(const py::object& object, const char* name) {
    const py::array given = array_of(object, name);
    const char kind = given.dtype().kind();
    if ((kind != 'i' && kind != 'u') || given.ndim() > 1) {
        throw py::value_error(
            fmt::format("{} must be whole nanoseconds, one or a row of them, not {}", name, describe(given)));
    }
    const auto array = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(given);
    std::vector<Timestamp> stamps(static_cast<std::size_t>(array.size()));
    for (std::size_t i = 0; i < stamps.size(); ++i) {
        stamps[i].ns = array.data()[i];
    }
    return stamps;
}

Rows<3> rows3_of(const py::object& array, const char* name) { return rows_of<3>(array, name); }
Rows<4> rows4_of(const py::object& array, const char* name) { return rows_of<4>(array, name); }

}  // namespace facet::python
