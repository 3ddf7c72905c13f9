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

/// A frame's estimate.
struct ViewState {
    Timestamp stamp;
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

struct ViewAccount {
    std::uint64_t offered = 0;   ///< frames
    std::uint64_t skipped = 0;   ///< of these, not taken because the view was busy
    std::uint64_t replaced = 0;  ///< messages that a slow browser never got, because newer ones took their place
    std::uint64_t viewers = 0;   ///< that have connected
};

/// A small web server on the loopback interface, with a thread of its own: the page at /, and at /live a WebSocket of
/// frames and meshes. offer() copies into one buffer if that is free, and never waits: it locks nothing that the thread
/// holds while it sends. A browser has at most one message under way and the newest frame and mesh waiting; what is
/// older is replaced. At most kMaxViewers at once. Only pages of this server may connect (Origin). Heap.
class LiveView {
public:
    static constexpr std::size_t kMaxViewers = 8;
    static constexpr std::size_t kMaxFaces = 8192;  ///< of a mesh; more are not shown

    /// Throws InputError if the page cannot be read or the port cannot be had.
    explicit LiveView(const ViewOptions& options);
    /// Ends the connections.
    ~LiveView();
    LiveView(const LiveView&) = delete;
    LiveView& operator=(const LiveView&) = delete;

    /// Appends the faces of the live mesh to the empty vector; called by offer(), on its thread, or not at all.
    using FillFaces = std::function<void(std::vector<ViewFace>&)>;
    /// Thread-bound. @param fill  empty: the mesh is the last one
    void offer(const ViewState& state, const FillFaces& fill);

    std::uint16_t port() const;
    /// Thread-safe.
    ViewAccount account() const;

private:
    class Server;
    std::unique_ptr<Server> server_;
};

}  // namespace facet
