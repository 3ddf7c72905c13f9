// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "app/lab/eval/evaluation.h"
#include "app/python/arrays.h"
#include "app/python/bindings.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/ground_truth.h"

namespace facet::python {
namespace {

/// Stamps, positions and quaternions (x y z w) as three arrays.
py::tuple arrays_of(const Trajectory& trajectory) {
    const auto count = static_cast<Eigen::Index>(trajectory.size());
    py::array_t<std::int64_t> stamps(count);
    Rows<3> positions(count, 3);
    Rows<4> quaternions(count, 4);
    for (Eigen::Index i = 0; i < count; ++i) {
        const StampedPose& pose = trajectory[static_cast<std::size_t>(i)];
        stamps.mutable_at(i) = pose.stamp.ns;
        positions.row(i) = pose.T_W_B.p;
        quaternions.row(i) = pose.T_W_B.q.coeffs();
    }
    return py::make_tuple(stamps, positions, quaternions);
}

Trajectory trajectory_of(const py::tuple& arrays, const char* name) {
    const std::vector<Timestamp> stamps = stamps_of(arrays[0], "stamps_ns");
    if (stamps.empty()) {
        return {};
    }
    const Rows<3> positions = rows3_of(arrays[1], "positions");
    const Rows<4> quaternions = rows4_of(arrays[2], "quaternions");
    const auto count = static_cast<Eigen::Index>(stamps.size());
    if (positions.rows() != count || quaternions.rows() != count) {
        throw py::value_error(fmt::format("{}: {} stamps, {} positions and {} quaternions", name, count,
                                          positions.rows(), quaternions.rows()));
    }
    Trajectory trajectory;
    for (Eigen::Index i = 0; i < count; ++i) {
        const Eigen::Vector4d q = quaternions.row(i);
        const Timestamp stamp = stamps[static_cast<std::size_t>(i)];
        if (!trajectory.empty() && stamp <= trajectory.back().stamp) {
            throw py::value_error(fmt::format("{}: stamp {} does not increase", name, i));
        }
        constexpr double kTolerance = 0.01;
        if (std::abs(q.norm() - 1.0) > kTolerance) {
            throw py::value_error(fmt::format("{}: quaternion {} has length {:.3f}", name, i, q.norm()));
        }
        trajectory.push_back({stamp, {Eigen::Quaterniond(q).normalized(), positions.row(i)}});
    }
    return trajectory;
}

Trajectory read_truth(const std::string& path) {
    const std::string table = find_ground_truth(path);
    if (table.empty()) {
        throw InputError(path + ": no state_groundtruth_estimate0/data.csv in it");
    }
    std::vector<GroundTruthState> states;
    std::string error;
    if (!ok(read_ground_truth(table, {}, states, error))) {
        throw InputError(error);
    }
    Trajectory truth;
    for (const GroundTruthState& s : states) {
        truth.push_back({s.stamp, {s.q_W_B, s.p_W_B}});
    }
    return truth;
}

Evaluation evaluate_arrays(const py::tuple& truth, const py::tuple& estimate, std::vector<double> lengths_m) {
    const Trajectory true_poses = trajectory_of(truth, "truth");
    const Trajectory estimated = trajectory_of(estimate, "estimate");
    for (const double length_m : lengths_m) {
        if (!(length_m > 0.0)) {
            throw py::value_error(fmt::format("rpe_lengths: {} is not a positive length", length_m));
        }
    }
    EvaluationOptions options;
    options.rpe_lengths_m = std::move(lengths_m);
    const py::gil_scoped_release released;
    return evaluate(true_poses, estimated, {}, options);
}

void add_errors(py::module_& module) {
    py::class_<ErrorStatistics>(module, "ErrorStatistics", "A set of errors in figures.")
        .def_readonly("count", &ErrorStatistics::count)
        .def_readonly("median", &ErrorStatistics::median)
        .def_readonly("mean", &ErrorStatistics::mean)
        .def_readonly("rmse", &ErrorStatistics::rmse)
        .def_readonly("max", &ErrorStatistics::max)
        .def("__repr__", [](const ErrorStatistics& e) {
            return fmt::format("<facet.ErrorStatistics of {}: rmse {:.4f}, median {:.4f}, max {:.4f}>", e.count, e.rmse,
                               e.median, e.max);
        });
    py::class_<RelativeError>(module, "RelativeError", "Errors over stretches of the true path of one length (m).")
        .def_readonly("length", &RelativeError::length_m)
        .def_readonly("translation", &RelativeError::translation_m)
        .def_readonly("translation_percent", &RelativeError::translation_percent)
        .def_readonly("rotation_deg", &RelativeError::rotation_deg);
}

}  // namespace

void add_evaluation(py::module_& module) {
    add_errors(module);
    py::class_<Evaluation>(module, "Evaluation",
                           "Errors of a trajectory: ate, the absolute ones (m) after the best alignment by rotation "
                           "and translation, ate_yaw after that by yaw and translation; relative ones by length; path "
                           "(m) and duration of what was matched; scale is what would fit best, not applied.")
        .def_readonly("matched", &Evaluation::matched)
        .def_readonly("path", &Evaluation::path_m)
        .def_readonly("duration_s", &Evaluation::duration_s)
        .def_readonly("scale", &Evaluation::scale)
        .def_readonly("end_drift", &Evaluation::end_drift_m)
        .def_readonly("relative", &Evaluation::relative)
        .def_property_readonly("ate", [](const Evaluation& e) { return e.se3.translation_m; })
        .def_property_readonly("ate_rotation_deg", [](const Evaluation& e) { return e.se3.rotation_deg; })
        .def_property_readonly("ate_yaw", [](const Evaluation& e) { return e.yaw4.translation_m; })
        .def("__repr__", [](const Evaluation& e) {
            return fmt::format("<facet.Evaluation of {} poses: ATE {:.4f} m rmse after SE(3)>", e.matched,
                               e.se3.translation_m.rmse);
        });
    module.def(
        "read_tum", [](const std::string& path) { return arrays_of(read_tum(path)); }, py::arg("path"));
    module.def(
        "read_truth", [](const std::string& path) { return arrays_of(read_truth(path)); }, py::arg("path"));
    module.def("evaluate", &evaluate_arrays, py::arg("truth"), py::arg("estimate"), py::arg("rpe_lengths"));
}

}  // namespace facet::python
