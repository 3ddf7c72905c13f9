// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "app/python/bindings.h"
#include "app/python/flight.h"

namespace facet::python {
namespace {

std::vector<std::string> reasons_of(const Health& health) {
    std::vector<std::string> names;
    std::string text = reason_names(health.reasons);
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('|', begin), text.size());
        names.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return names;
}

Eigen::Vector4d xyzw(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

Eigen::Matrix4d matrix_of(const Se3& pose) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = pose.q.toRotationMatrix();
    matrix.topRightCorner<3, 1>() = pose.p;
    return matrix;
}

void add_health(py::module_& module) {
    py::class_<Health>(module, "Health",
                       "What the estimator says of itself: state is 'INIT', 'TRACKING', 'DEGRADED' or 'LOST', reasons "
                       "are names as in health.csv, quality goes from 0 (not to be used) to 100. When reset_counter "
                       "rises, place or yaw may have jumped.")
        .def_property_readonly("state", [](const Health& h) { return to_string(h.state); })
        .def_property_readonly("reasons", &reasons_of)
        .def_readonly("quality", &Health::quality)
        .def_readonly("reset_counter", &Health::reset_counter)
        .def_readonly("is_still", &Health::is_still)
        .def_readonly("tracked", &Health::tracked)
        .def_readonly("stereo", &Health::stereo)
        .def_readonly("keyframes", &Health::keyframes)
        .def_readonly("landmarks", &Health::landmarks)
        .def_readonly("time_offset_s", &Health::time_offset_s)
        .def("__repr__", [](const Health& h) {
            return fmt::format("<facet.Health {}, quality {}, {}>", to_string(h.state), h.quality,
                               reason_names(h.reasons));
        });
}

}  // namespace

void add_estimate(py::module_& module) {
    add_health(module);
    using E = FrameEstimate;
    py::class_<E>(module, "Estimate",
                  "State at a frame, to be used if is_usable: pose (4, 4) of body B in world W, or position (m) and "
                  "quaternion (x y z w); velocity (m/s, W), biases of the IMU (rad/s, m/s^2); covariance (9, 9) of "
                  "[theta p v], theta a turn in B (rad), p and v in W. time_ms is what it took.")
        .def_property_readonly("status", [](const E& e) { return to_string(e.status); })
        .def_readonly("is_usable", &E::is_usable)
        .def_readonly("is_keyframe", &E::is_keyframe)
        .def_readonly("has_mesh", &E::has_mesh)
        .def_property_readonly("stamp_ns", [](const E& e) { return e.estimate.stamp.ns; })
        .def_property_readonly("pose", [](const E& e) { return matrix_of(e.estimate.state.T_W_B()); })
        .def_property_readonly("position", [](const E& e) { return e.estimate.state.p_W_B; })
        .def_property_readonly("quaternion", [](const E& e) { return xyzw(e.estimate.state.q_W_B); })
        .def_property_readonly("velocity", [](const E& e) { return e.estimate.state.v_W_B; })
        .def_property_readonly("gyro_bias", [](const E& e) { return e.estimate.state.bias.gyro; })
        .def_property_readonly("accel_bias", [](const E& e) { return e.estimate.state.bias.accel; })
        .def_property_readonly("covariance", [](const E& e) { return e.estimate.covariance; })
        .def_property_readonly("health", [](const E& e) { return e.estimate.health; })
        .def_property_readonly("time_ms", [](const E& e) { return e.timing.total.wall_ms; })
        .def("__repr__", [](const E& e) {
            const Eigen::Vector3d& p = e.estimate.state.p_W_B;
            return fmt::format("<facet.Estimate at {} ns, {}, ({:.3f}, {:.3f}, {:.3f}) m>", e.estimate.stamp.ns,
                               to_string(e.estimate.health.state), p.x(), p.y(), p.z());
        });
}

}  // namespace facet::python
