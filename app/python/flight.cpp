// SPDX-License-Identifier: BSD-2-Clause
#include "app/python/flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/config/calibrated_config.h"
#include "app/config/config_file.h"
#include "app/lab/convert/opened_log.h"
#include "app/support/input_error.h"

namespace facet::python {
namespace {

RegularityMode mode_of(const std::string& text) {
    const auto* const name = std::ranges::find(kRegularityModeNames, text);
    if (name == kRegularityModeNames.end()) {
        throw InputError(fmt::format("mode '{}' is unknown; one of: {}", text, fmt::join(kRegularityModeNames, ", ")));
    }
    return static_cast<RegularityMode>(name - kRegularityModeNames.begin());
}

FrameEstimate estimate_of(const FrameResult& result) {
    return {result.status, result.estimate, result.is_usable, result.is_keyframe, result.has_mesh, result.timing};
}

}  // namespace

Calibration read_calibration(const std::string& path, const std::string& imu) {
    namespace fs = std::filesystem;
    if (fs::is_directory(path) || path.ends_with(".mcap")) {
        const OpenedLog log(path, [](const std::string&) {});
        return load_calibration(log.root(), "", imu);
    }
    return load_calibration(fs::path(path).parent_path().string(), path, imu);
}

Flight::Flight(const FlightOptions& options) : has_grid_(options.has_grid) {
    const RegularityMode mode = mode_of(options.mode);
    const Calibration calibration = read_calibration(options.calibration, options.imu_calibration);
    ProgramConfig config;
    take_calibration(calibration, config);
    if (!options.config.empty()) {
        load_config(options.config, config);
    }
    for (const std::string& setting : options.settings) {
        set_config(setting, config);
    }
    config.regularity.mode = mode;
    pipeline_.configure(config, calibration);
    if (has_grid_) {
        pipeline_.keep_grid();
    }
    rig_ = calibration.rig;
    remarks_ = calibration.remarks;
}

std::vector<FrameEstimate> Flight::add_imu(std::span<const ImuSample> samples) {
    const std::lock_guard lock(mutex_);
    std::vector<FrameEstimate> carried;
    for (const ImuSample& sample : samples) {
        pipeline_.add_imu(sample);
        if (pipeline_.take_carried(result_)) {
            carried.push_back(estimate_of(result_));
        }
    }
    return carried;
}

void Flight::add_range(std::span<const RangeSample> samples) {
    const std::lock_guard lock(mutex_);
    for (const RangeSample& sample : samples) {
        pipeline_.add_range(sample);
    }
}

FrameEstimate Flight::add_frame(const StereoFrame& frame) {
    const std::lock_guard lock(mutex_);
    pipeline_.add_frame(frame, frame.stamp, result_);
    return estimate_of(result_);
}

void Flight::request_reset() {
    const std::lock_guard lock(mutex_);
    pipeline_.request_reset();
}

MeshArrays Flight::mesh() const {
    const std::lock_guard lock(mutex_);
    const HorizonMesh& mesh = pipeline_.mesher().mesh();
    MeshArrays arrays;
    std::vector<std::int32_t> number(static_cast<std::size_t>(mesh.vertex_end()), -1);
    arrays.vertices_W.resize(mesh.vertex_count(), 3);
    std::int32_t count = 0;
    for (int v = 0; v < mesh.vertex_end(); ++v) {
        if (mesh.is_vertex(v)) {
            arrays.vertices_W.row(count) = mesh.vertex(static_cast<VertexSlot>(v)).shown_W();
            number[static_cast<std::size_t>(v)] = count++;
        }
    }
    arrays.faces.resize(mesh.face_count(), 3);
    arrays.normals_W.resize(mesh.face_count(), 3);
    int row = 0;
    for (int f = 0; f < mesh.face_end(); ++f) {
        if (!mesh.is_face(f)) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(f));
        for (int k = 0; k < 3; ++k) {
            arrays.faces(row, k) = number[face.vertex[static_cast<std::size_t>(k)]];
        }
        // Of the corners as shown: the face's own is of before they were drawn to their plane.
        const Eigen::Vector3d a = mesh.corner(face, 0);
        const Eigen::Vector3d normal = (mesh.corner(face, 1) - a).cross(mesh.corner(face, 2) - a);
        arrays.normals_W.row(row) =
            normal.norm() > 0.0 ? Eigen::Vector3f(normal.normalized().cast<float>()) : face.normal_W;
        arrays.planes.push_back(face.plane.valid() ? static_cast<std::int32_t>(face.plane.value) : -1);
        ++row;
    }
    return arrays;
}

std::vector<std::array<Eigen::Vector3f, 3>> Flight::departed() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::array<Eigen::Vector3f, 3>> faces;
    for (const DepartedFace& face : pipeline_.departed()) {
        faces.push_back(face.p_W);
    }
    return faces;
}

std::vector<TrackedPlane> Flight::planes() const {
    const std::lock_guard lock(mutex_);
    std::vector<TrackedPlane> planes;
    for (const TrackedPlane& plane : pipeline_.planes().planes()) {
        if (plane.is_reported) {
            planes.push_back(plane);
        }
    }
    return planes;
}

std::optional<GridArrays> Flight::grid() const {
    const std::lock_guard lock(mutex_);
    const OccupancyGrid* const grid = pipeline_.grid();
    if (!has_grid_ || grid == nullptr) {
        return std::nullopt;
    }
    std::vector<std::uint8_t> packed(OccupancyGrid::kPackedBytes);
    grid->pack(std::span<std::uint8_t, OccupancyGrid::kPackedBytes>(packed));
    const Eigen::Vector3i low = grid->lowest_cell();
    GridArrays arrays;
    arrays.cell_m = grid->cell_m();
    arrays.origin_W = arrays.cell_m * low.cast<double>();
    arrays.states.reserve(4 * packed.size());
    const auto wrapped = [](int cell, int size) { return static_cast<std::size_t>(cell & (size - 1)); };
    for (int x = low.x(); x < low.x() + OccupancyGrid::kGridX; ++x) {
        for (int y = low.y(); y < low.y() + OccupancyGrid::kGridY; ++y) {
            for (int z = low.z(); z < low.z() + OccupancyGrid::kGridZ; ++z) {
                const std::size_t place =
                    (wrapped(z, OccupancyGrid::kGridZ) * OccupancyGrid::kGridY + wrapped(y, OccupancyGrid::kGridY)) *
                        OccupancyGrid::kGridX +
                    wrapped(x, OccupancyGrid::kGridX);
                arrays.states.push_back((packed[place / 4] >> (2 * (place % 4))) & 3U);
            }
        }
    }
    return arrays;
}

}  // namespace facet::python
