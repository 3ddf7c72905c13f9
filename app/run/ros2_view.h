// SPDX-License-Identifier: BSD-2-Clause
// Mesh, planes, landmarks, path and grid of a flight, for the topics of ROS 2.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <vector>

#include "app/view/flight_path.h"
#include "app/view/flight_viewer.h"
#include "drivers/ros2/ros2_output.h"

namespace facet {

/// offer() copies what somebody listens to into one buffer if that is free, and never waits; take() exchanges that
/// buffer for an empty one and makes messages of it on the output's thread. What is not taken before the next one comes
/// is replaced. offer() and take() belong to one thread each. Heap in the constructor and in take().
class Ros2View final : public FlightViewer, public Ros2SceneSource {
public:
    static constexpr Duration kPathPeriod = Duration::from_seconds(1.0);  ///< the least time between two

    Ros2View();

    bool wants_picture(Timestamp /*stamp*/, bool /*has_points*/) const override { return false; }
    bool wants_calibration() const override { return false; }
    void offer(const ViewState& state, const Fillers& fillers) override;
    bool take(const Ros2Wishes& wishes, Ros2Scene& scene) override;

private:
    struct Box {
        Timestamp stamp;  ///< of the newest frame of which there is anything
        bool has_mesh = false;
        ViewMesh mesh;
        bool has_landmarks = false;
        std::vector<Eigen::Vector3f> landmarks;
        bool has_grid = false;
        ViewGrid grid;
        std::optional<Se3> T_M_W;
        std::vector<ViewState> keyframes;
    };
    static constexpr std::size_t kMaxKeyframes = 32;  ///< that wait for the thread; more are left out of the path

    void add_path(const Ros2Wishes& wishes, Ros2Scene& scene);

    std::atomic<bool> wants_mesh_{false};
    std::atomic<bool> wants_landmarks_{false};
    std::atomic<bool> wants_grid_{false};
    std::mutex mutex_;
    Box inbox_;
    Box taken_;        ///< of the output's thread
    FlightPath path_;  ///< of the output's thread
    bool path_is_new_ = false;
    Timestamp next_path_;
};

}  // namespace facet
