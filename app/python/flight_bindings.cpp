// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "app/python/bindings.h"
#include "app/python/flight.h"

namespace facet::python {
namespace {

constexpr const char* kFlightDoc =
    "Estimator, mesh and planes of one flight.\n\n"
    "calibration: a log (folder or MCAP file), or a file of Kalibr, OpenVINS, Basalt, ORB-SLAM3, OKVIS2, VINS-Fusion,\n"
    "RealSense or OAK; imu_calibration: Kalibr's or OpenVINS's imu.yaml. mode: 's', or 'spr' with planes in the\n"
    "estimate. config: a file of parameters as 'facet info --config' prints them; settings: single ones on top.\n"
    "grid: also keeps the grid of free and occupied space.\n\n"
    "Samples are given in order of time, and each frame once inertial samples reach its stamp. All functions may be\n"
    "called from any thread; they run without the interpreter's lock, one after another. ValueError: what was given\n"
    "cannot be used; its sentence names file, line or argument.";
constexpr const char* kAddImuDoc =
    "Takes one inertial sample, or N: stamps in nanoseconds (N,), angular rates in rad/s and specific forces in "
    "m/s^2,\n"
    "both (N, 3), in the body frame B as the calibration has it. Returns what the estimator says of the time in which\n"
    "no frames come, usually nothing.";
constexpr const char* kAddRangeDoc =
    "Takes one reading of a range finder that looks down, or N: stamps in nanoseconds (N,), and where the beam met\n"
    "the ground (N, 3), in metres and B. A frame uses those at or before its stamp that were given before it. Ignored\n"
    "without the setting range.enabled; a reading whose stamp does not increase is dropped.";
constexpr const char* kAddFrameDoc =
    "Estimates the state at a frame: grey images (rows x columns of uint8, without copies) stamped at the middle of\n"
    "the exposure. One may be None. The estimate's status is 'ok'; 'not ready': inertial samples do not reach the\n"
    "stamp, offer the frame again after the next ones; 'out of order': the stamp does not increase.";

/// "KEY=VALUE" of a dictionary; true and false as YAML has them.
std::vector<std::string> settings_of(const py::dict& dictionary) {
    std::vector<std::string> settings;
    for (const auto& [key, value] : dictionary) {
        const std::string text =
            py::isinstance<py::bool_>(value) ? (value.cast<bool>() ? "true" : "false") : std::string(py::str(value));
        settings.push_back(std::string(py::str(key)) + "=" + text);
    }
    return settings;
}

std::unique_ptr<Flight> make_flight(const std::string& calibration, const std::string& imu_calibration,
                                    const std::string& mode, const std::string& config, const py::dict& settings,
                                    bool grid) {
    const FlightOptions options{calibration, imu_calibration, mode, config, settings_of(settings), grid};
    const py::gil_scoped_release released;
    return std::make_unique<Flight>(options);
}

std::vector<FrameEstimate> add_imu(Flight& flight, const py::object& stamps_ns, const py::object& rates,
                                   const py::object& forces) {
    const std::vector<Timestamp> stamps = stamps_of(stamps_ns, "stamps_ns");
    const Rows<3> w = rows3_of(rates, "rates");
    const Rows<3> a = rows3_of(forces, "forces");
    if (w.rows() != static_cast<Eigen::Index>(stamps.size()) || a.rows() != w.rows()) {
        throw py::value_error(fmt::format("stamps_ns, rates and forces must have equal lengths, not {}, {} and {}",
                                          stamps.size(), w.rows(), a.rows()));
    }
    std::vector<ImuSample> samples(stamps.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        samples[i] = {stamps[i], w.row(row), a.row(row)};
    }
    const py::gil_scoped_release released;
    return flight.add_imu(samples);
}

void add_range(Flight& flight, const py::object& stamps_ns, const py::object& points) {
    const std::vector<Timestamp> stamps = stamps_of(stamps_ns, "stamps_ns");
    const Rows<3> p = rows3_of(points, "points");
    if (p.rows() != static_cast<Eigen::Index>(stamps.size())) {
        throw py::value_error(
            fmt::format("stamps_ns and points must have equal lengths, not {} and {}", stamps.size(), p.rows()));
    }
    std::vector<RangeSample> samples(stamps.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        samples[i] = {stamps[i], p.row(static_cast<Eigen::Index>(i))};
    }
    const py::gil_scoped_release released;
    flight.add_range(samples);
}

FrameEstimate add_frame(Flight& flight, std::int64_t stamp_ns, const py::object& left, const py::object& right) {
    const StereoRig& rig = flight.rig();
    StereoFrame frame;
    frame.stamp = {stamp_ns};
    frame.left = image_of(left, "left", rig.left.intrinsics());
    frame.right = image_of(right, "right", rig.right.intrinsics());
    if (frame.left.empty() && frame.right.empty()) {
        throw py::value_error("left and right are None: a frame has one image at least");
    }
    if (!rig.has_right && !frame.right.empty()) {
        throw py::value_error("right must be None: the calibration has one camera");
    }
    const py::gil_scoped_release released;
    return flight.add_frame(frame);
}

py::array_t<float> departed_faces(const Flight& flight) {
    const auto faces = flight.departed();
    py::array_t<float> array({static_cast<py::ssize_t>(faces.size()), py::ssize_t{3}, py::ssize_t{3}});
    float* at = array.mutable_data();
    for (const auto& face : faces) {
        for (const Eigen::Vector3f& corner : face) {
            at = std::copy_n(corner.data(), 3, at);
        }
    }
    return array;
}

py::array_t<std::uint8_t> states_of(const GridArrays& grid) {
    py::array_t<std::uint8_t> array({OccupancyGrid::kGridX, OccupancyGrid::kGridY, OccupancyGrid::kGridZ});
    std::copy(grid.states.begin(), grid.states.end(), array.mutable_data());
    return array;
}

template <class Member>
py::array_t<Member> copy_of(const std::vector<Member>& values) {
    return py::array_t<Member>(static_cast<py::ssize_t>(values.size()), values.data());
}

void add_mesh(py::module_& module) {
    py::class_<MeshArrays>(
        module, "Mesh",
        "The mesh over the horizon: vertices (N, 3) in metres and W, faces (M, 3) as indices of them, counterclockwise "
        "as seen from the side they were observed from, their unit normals (M, 3), and the id of the plane that each "
        "lies on (M,), -1 for none. Arrays are copies.")
        .def_property_readonly("vertices", [](const MeshArrays& m) { return m.vertices_W; })
        .def_property_readonly("faces", [](const MeshArrays& m) { return m.faces; })
        .def_property_readonly("normals", [](const MeshArrays& m) { return m.normals_W; })
        .def_property_readonly("planes", [](const MeshArrays& m) { return copy_of(m.planes); })
        .def("__repr__", [](const MeshArrays& m) {
            return fmt::format("<facet.Mesh of {} vertices and {} faces>", m.vertices_W.rows(), m.faces.rows());
        });
    py::class_<TrackedPlane>(module, "Plane",
                             "A plane that was found: normal . p = distance (m) in W; sigma (m) is the standard "
                             "deviation of its distance at the centroid, area (m^2) that of its faces in the mesh. "
                             "is_held: it is a variable of the estimator.")
        .def_property_readonly("id", [](const TrackedPlane& p) { return p.id.value; })
        .def_property_readonly("kind", [](const TrackedPlane& p) { return to_string(p.kind); })
        .def_property_readonly("normal", [](const TrackedPlane& p) { return p.fit.normal_W; })
        .def_property_readonly("distance", [](const TrackedPlane& p) { return p.fit.distance_m; })
        .def_property_readonly("centroid", [](const TrackedPlane& p) { return p.fit.centroid_W; })
        .def_property_readonly("sigma", [](const TrackedPlane& p) { return p.fit.sigma_m; })
        .def_property_readonly("area", [](const TrackedPlane& p) { return p.area_m2; })
        .def_readonly("landmarks", &TrackedPlane::landmarks)
        .def_readonly("is_held", &TrackedPlane::is_held)
        .def("__repr__", [](const TrackedPlane& p) {
            return fmt::format("<facet.Plane {}, {}, normal ({:.3f}, {:.3f}, {:.3f}), distance {:.3f} m>", p.id.value,
                               to_string(p.kind), p.fit.normal_W.x(), p.fit.normal_W.y(), p.fit.normal_W.z(),
                               p.fit.distance_m);
        });
    py::class_<GridArrays>(module, "Grid",
                           "Space around the vehicle: states[x, y, z] (uint8) is 0 for unknown, 1 for free and 2 for "
                           "occupied cells; cell [0, 0, 0] begins at origin (m, W), and each has an edge of cell (m).")
        .def_property_readonly("states", &states_of)
        .def_property_readonly("origin", [](const GridArrays& g) { return g.origin_W; })
        .def_property_readonly("cell", [](const GridArrays& g) { return g.cell_m; });
}

}  // namespace

void add_flight(py::module_& module) {
    add_mesh(module);
    using Released = py::call_guard<py::gil_scoped_release>;
    py::class_<Flight>(module, "Flight", kFlightDoc)
        .def(py::init(&make_flight), py::arg("calibration"), py::kw_only(), py::arg("imu_calibration") = "",
             py::arg("mode") = "s", py::arg("config") = "", py::arg("settings") = py::dict(), py::arg("grid") = false)
        .def("add_imu", &add_imu, py::arg("stamps_ns"), py::arg("rates"), py::arg("forces"), kAddImuDoc)
        .def("add_range", &add_range, py::arg("stamps_ns"), py::arg("points"), kAddRangeDoc)
        .def("add_frame", &add_frame, py::arg("stamp_ns"), py::arg("left"), py::arg("right") = py::none(), kAddFrameDoc)
        .def("request_reset", &Flight::request_reset, Released(),
             "Begins a new window at the next frame that allows it; health.reset_counter rises then.")
        .def("mesh", &Flight::mesh, Released(), "The mesh as it is now; empty before the second keyframe.")
        .def("departed_faces", &departed_faces,
             "Corners (N, 3, 3) in metres and W of the faces that left the mesh at the last frame: gathered, and with "
             "those of mesh() at the end, they are the mesh of the whole flight.")
        .def("planes", &Flight::planes, Released(), "The planes that the estimator is given now, by age.")
        .def("grid", &Flight::grid, Released(), "Space around the vehicle; None unless it was asked for.")
        .def_property_readonly("remarks", &Flight::remarks,
                               "What the calibration's files hold and is not used, and what is assumed instead.")
        .def_property_readonly(
            "image_size",
            [](const Flight& flight) {
                const CameraIntrinsics& camera = flight.rig().left.intrinsics();
                return py::make_tuple(camera.height, camera.width);
            },
            "Rows and columns of the left image.");
}

}  // namespace facet::python
