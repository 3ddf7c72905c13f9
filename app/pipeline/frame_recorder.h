// SPDX-License-Identifier: BSD-2-Clause
// What a run leaves behind: the files of its frames, its mesh and planes, and the account of it.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/output/frame_log.h"
#include "app/output/mesh_log.h"
#include "app/output/plane_log.h"
#include "app/output/run_mesh.h"
#include "app/output/run_surface.h"
#include "app/output/summary.h"
#include "app/output/trajectory_writer.h"
#include "app/pipeline/frame_pipeline.h"
#include "app/pipeline/warning_log.h"
#include "app/support/folder_lock.h"

namespace facet {

/// How much a recorder keeps in memory; a run of hours must not grow.
struct RecorderLimits {
    std::size_t timed_frames = std::numeric_limits<std::size_t>::max();  ///< the newest count
    std::size_t mesh_faces = std::numeric_limits<std::size_t>::max();    ///< see RunMesh
    std::size_t map_faces = std::numeric_limits<std::size_t>::max();     ///< see RunSurface
};

/// Writes trajectory.tum, trajectory.csv, covariance.csv, timing.csv, health.csv, mesh.csv and planes.csv row by row,
/// and mesh.ply (of the map; of the horizon if there is none), mesh_horizon.ply, mesh_live.ply, planes.json,
/// planes.ply, residuals.csv and summary.json at the end. Until then all of them have TextFile::kPartEnding behind
/// their names, and the files of an earlier run in the folder stay as they are; in finish() an old summary.json goes
/// first and the new one comes last. Thread-bound; heap. Throws InputError if a file cannot be written.
class FrameRecorder {
public:
    /// @param folder  to write; empty: keep the account only
    explicit FrameRecorder(std::string folder, const RecorderLimits& limits = {});
    ~FrameRecorder();
    FrameRecorder(const FrameRecorder&) = delete;
    FrameRecorder& operator=(const FrameRecorder&) = delete;

    /// Makes the folder, if it is not there, locks it against other runs and begins its files: once it is clear that
    /// there will be a run. Warnings from before are not lost.
    void open();
    /// The same in another folder than the constructor's.
    void open(std::string folder);

    /// @param departed  faces that left the horizon at this frame
    void write(const FrameResult& frame, std::span<const DepartedFace> departed);
    /// The trajectory's files have the estimates at inertial samples, instead of those at frames: one line a sample.
    void write_trajectory_at_samples() { trajectory_at_samples_ = true; }
    /// An estimate carried on to an inertial sample.
    void write_carried(const Estimate& estimate);
    void collect(std::span<const DepartedFace> departed) { run_mesh_.collect(departed); }
    void warn(const std::string& kind, const std::string& text);
    /// Brings all files up to here to the system.
    void flush();

    /// Completes the account from the pipeline and closes all files. Nothing may follow.
    /// @param map  whose surface() this has, finished; nullptr: none was kept
    void finish(const FramePipeline& pipeline, const SurfaceMap* map);

    /// Keeps a map's surface for mesh.ply. Until finish() it is bound to the thread of the map.
    RunSurface& surface() { return surface_; }

    /// After open().
    WarningLog* warnings() { return files_ ? &files_->warnings : nullptr; }
    RunSummary& summary() { return summary_; }

private:
    struct Files {
        explicit Files(const std::string& folder);
        FolderLock lock;
        WarningLog warnings;
        TrajectoryWriter trajectory;
        TimingWriter timing;
        HealthWriter health;
        MeshLog mesh;
        PlaneLog planes;
    };
    struct EarlyWarning {
        std::string kind;
        std::string text;
    };
    void keep(const Estimate& estimate);
    void keep_timing(const FrameResult& frame);

    std::string folder_;
    RecorderLimits limits_;
    std::vector<EarlyWarning> early_;  ///< before open()
    std::optional<Files> files_;
    bool trajectory_at_samples_ = false;
    RunMesh run_mesh_;
    RunSurface surface_;
    RunSummary summary_;
    std::size_t oldest_timed_ = 0;
};

}  // namespace facet
