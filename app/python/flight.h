// SPDX-License-Identifier: BSD-2-Clause
// Estimator, mesh and planes of one flight, as Python sees them.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/pipeline/frame_pipeline.h"
#include "app/python/arrays.h"

namespace facet::python {

/// What the estimator said at a frame, or, without one, about the time in which none has come.
struct FrameEstimate {
    Status status = Status::kOk;
    Estimate estimate;
    bool is_usable = false;
    bool is_keyframe = false;
    bool has_mesh = false;
    FrameTiming timing;
};

/// The mesh over the horizon, with its indices made dense.
struct MeshArrays {
    Rows<3> vertices_W;
    Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor> faces;
    Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> normals_W;
    std::vector<std::int32_t> planes;  ///< of each face; -1: none
};

/// Space around the vehicle.
struct GridArrays {
    std::vector<std::uint8_t> states;  ///< x, y, z, the last one running fastest: 0 unknown, 1 free, 2 occupied
    Eigen::Vector3d origin_W = Eigen::Vector3d::Zero();  ///< corner of the first cell (m)
    double cell_m = 0.0;
};

/// What a flight is configured by.
struct FlightOptions {
    std::string calibration;
    std::string imu_calibration;
    std::string mode;
    std::string config;
    std::vector<std::string> settings;  ///< KEY=VALUE
    bool has_grid = false;
};

/// The calibration of a log, or of a file that facet knows. Throws InputError.
Calibration read_calibration(const std::string& path, const std::string& imu);

/// A FramePipeline behind a lock: its functions may be called without the interpreter's, from any thread, one after
/// another. Thread-safe. Heap.
class Flight {
public:
    /// Throws InputError.
    explicit Flight(const FlightOptions& options);

    /// @return what the estimator said while frames do not come
    std::vector<FrameEstimate> add_imu(std::span<const ImuSample> samples);
    /// See Mapping::add_range; refused samples are dropped.
    void add_range(std::span<const RangeSample> samples);
    FrameEstimate add_frame(const StereoFrame& frame);
    void request_reset();

    const StereoRig& rig() const { return rig_; }
    const std::vector<std::string>& remarks() const { return remarks_; }
    MeshArrays mesh() const;
    /// Three corners of each face that left the horizon at the last frame.
    std::vector<std::array<Eigen::Vector3f, 3>> departed() const;
    std::vector<TrackedPlane> planes() const;
    /// None unless it was asked for, and the configuration has one.
    std::optional<GridArrays> grid() const;

private:
    mutable std::mutex mutex_;
    StereoRig rig_;
    std::vector<std::string> remarks_;
    bool has_grid_;
    FramePipeline pipeline_;
    FrameResult result_;
};

}  // namespace facet::python
