// SPDX-License-Identifier: BSD-2-Clause
// What the estimator sees, live in a browser on the same computer.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "app/view/flight_viewer.h"
#include "app/view/live_surface.h"
#include "app/view/view_place.h"
#include "app/view/view_snapshot.h"
#include "estimator/geometry/stereo_rig.h"
#include "platform/base/timestamp.h"

namespace facet {

struct ViewOptions {
    ViewPlace place;    ///< loopback by default
    std::string token;  ///< without which nobody is shown anything; must be given if the place is not loopback
    std::string page;   ///< HTML file for "/"; empty: a sentence that says how to make one
    StereoRig rig;      ///< of which the left camera is shown
    std::chrono::milliseconds idle = std::chrono::seconds(20);  ///< after which a client that answers no ping is gone
};

struct ViewAccount {
    std::uint64_t offered = 0;   ///< frames
    std::uint64_t skipped = 0;   ///< of these, not taken because the view was busy, or had too many already
    std::uint64_t replaced = 0;  ///< messages that a slow client never got, because newer ones took their place
    std::uint64_t viewers = 0;   ///< browsers that have connected
    std::uint64_t foxglove = 0;  ///< clients of Foxglove's protocol that have connected
};

/// A small web server with a thread of its own: the page at /, at /live a WebSocket of frames, meshes, pictures and the
/// changes of the map's surface for it, and at any place the WebSocket protocol of Foxglove (foxglove_hub.h) for
/// clients that ask for that. offer() copies into one buffer if that is free, and never waits: it locks nothing that
/// the thread holds while it sends. A browser has at most one message under way and the newest of each kind waiting, a
/// client of Foxglove's a few more; what is older is replaced. At most kMaxViewers of both at once, who have been let
/// in; of those who have not, the one that has waited longest makes room for the newest when there are kMaxStrangers,
/// or kMaxOfAddress of its address, so that nobody is locked out by requests that are never finished. With a token,
/// only who has it is shown the flight; without, only who reaches the server under a name of this computer (Host), and
/// of pages its own and Foxglove's (Origin). Heap, but not in offer() as long as the fillers stay within the bounds
/// below.
class LiveView final : public FlightViewer {
public:
    static constexpr std::size_t kMaxViewers = 8;
    static constexpr std::size_t kMaxStrangers = 32;
    static constexpr std::size_t kMaxOfAddress = 8;          ///< browsers open six at once
    static constexpr std::size_t kMaxStates = 32;            ///< of frames that wait for the thread
    static constexpr Duration kPicturePeriod{200'000'000};   ///< the least time between two
    static constexpr Duration kPointlessAfter{500'000'000};  ///< then one without points comes

    /// Throws InputError if the page cannot be read, the port cannot be had, or others could look without a token.
    explicit LiveView(const ViewOptions& options);
    /// Ends the connections.
    ~LiveView() override;
    LiveView(const LiveView&) = delete;
    LiveView& operator=(const LiveView&) = delete;

    /// Whether someone looks and the last one is old enough.
    bool wants_picture(Timestamp stamp, bool has_points) const override;
    /// Whether someone looks at it.
    bool wants_calibration() const override;
    void offer(const ViewState& state, const Fillers& fillers) override;
    void offer(const ViewState& state) { offer(state, {}); }

    /// Takes the surface of the map, for the page. Thread-safe; heap.
    SurfaceSink& surface();

    /// Where it listens: with the port that was free if any would do.
    const ViewPlace& place() const;
    /// Thread-safe.
    ViewAccount account() const;

private:
    class Server;
    std::unique_ptr<Server> server_;
};

}  // namespace facet
