// SPDX-License-Identifier: BSD-2-Clause
// What the estimator sees, live in a browser on the same computer.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "estimator/geometry/se3.h"
#include "estimator/geometry/stereo_rig.h"
#include "platform/base/timestamp.h"

namespace facet {

struct ViewOptions {
    std::uint16_t port = 0;  ///< on 127.0.0.1; 0: any that is free
    std::string page;        ///< HTML file for "/"; empty: a sentence that says how to make one
    StereoRig rig;           ///< of which the left camera is shown
};

/// What is known at a frame.
struct ViewState {
    Timestamp stamp;
    bool has_pose = true;  ///< the estimate is to be used
    Se3 T_W_B;
    const char* state = "";  ///< static text
    int quality = 0;
    int tracked = 0;
    double total_ms = 0.0;
    bool is_keyframe = false;
};

/// A triangle of the live mesh (m, in W) and its plane, -1 for none.
struct ViewFace {
    std::array<Eigen::Vector3f, 3> p_W;
    std::int32_t plane = -1;
};

/// A landmark where the picture shows it.
struct ViewPoint {
    Eigen::Vector2f px;       ///< of the picture as it is sent
    float depth_m = 0.0F;     ///< in the camera
    std::int32_t plane = -1;  ///< -1 for none
};

/// What the left camera sees, made small.
struct ViewPicture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels;  ///< grey, row by row
    std::vector<ViewPoint> points;
};

struct ViewAccount {
    std::uint64_t offered = 0;   ///< frames
    std::uint64_t skipped = 0;   ///< of these, not taken because the view was busy
    std::uint64_t replaced = 0;  ///< messages that a slow browser never got, because newer ones took their place
    std::uint64_t viewers = 0;   ///< that have connected
};

/// A small web server on the loopback interface, with a thread of its own: the page at /, and at /live a WebSocket of
/// frames, meshes and pictures. offer() copies into one buffer if that is free, and never waits: it locks nothing that
/// the thread holds while it sends. A browser has at most one message under way and the newest of each kind waiting;
/// what is older is replaced. At most kMaxViewers at once. Only pages of this server may connect (Origin). Heap, but
/// not in offer() as long as the fillers stay within the bounds below.
class LiveView {
public:
    static constexpr std::size_t kMaxViewers = 8;
    static constexpr std::size_t kMaxFaces = 8192;           ///< of a mesh; more are not shown
    static constexpr std::size_t kMaxPoints = 1024;          ///< of a picture; more are not shown
    static constexpr int kMaxPictureSide = 480;              ///< (px)
    static constexpr Duration kPicturePeriod{200'000'000};   ///< the least time between two
    static constexpr Duration kPointlessAfter{500'000'000};  ///< then one without points comes

    /// Throws InputError if the page cannot be read or the port cannot be had.
    explicit LiveView(const ViewOptions& options);
    /// Ends the connections.
    ~LiveView();
    LiveView(const LiveView&) = delete;
    LiveView& operator=(const LiveView&) = delete;

    /// Whether someone looks and the last picture is old enough for another one of a frame with this stamp.
    /// @param has_points  it will have some: those of a keyframe
    bool wants_picture(Timestamp stamp, bool has_points) const;

    /// Appends the faces of the live mesh to the empty vector; called by offer(), on its thread, or not at all.
    using FillFaces = std::function<void(std::vector<ViewFace>&)>;
    /// Fills in a picture whose vectors are empty; called in the same way.
    using FillPicture = std::function<void(ViewPicture&)>;
    /// Thread-bound, as is wants_picture().
    /// @param fill          empty: the mesh is the last one
    /// @param fill_picture  empty: so is the picture
    void offer(const ViewState& state, const FillFaces& fill, const FillPicture& fill_picture = {});

    std::uint16_t port() const;
    /// Thread-safe.
    ViewAccount account() const;

private:
    class Server;
    std::unique_ptr<Server> server_;
};

}  // namespace facet
