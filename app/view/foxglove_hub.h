// SPDX-License-Identifier: BSD-2-Clause
// The flight for clients of Foxglove's WebSocket protocol: what there is, and who gets it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/foxglove/schemas.h"
#include "app/view/flight_path.h"
#include "app/view/foxglove_client.h"
#include "app/view/view_snapshot.h"

namespace facet {

/// Gives every client what it has subscribed to. Messages are made once, and only if somebody wants them; whoever
/// subscribes late is given the newest mesh, planes, path, image, calibration and place of the camera at once. Bound to
/// the server's thread but for wants(), replaced() and seen(). Heap.
class FoxgloveHub final : public FoxgloveSource {
public:
    FoxgloveHub();

    /// Takes over a connection that has asked for the protocol.
    void adopt(FoxgloveClient::Stream stream, FoxgloveClient::Request request);
    /// Connections that are open.
    std::size_t clients();
    /// Passes on what is new.
    void take(const ViewSnapshot& snapshot);

    /// Whether any client has subscribed to it. Thread-safe.
    bool wants(FoxgloveTopic topic) const { return subscriptions_[place(topic)] > 0; }
    /// Messages that a slow client never got. Thread-safe.
    std::uint64_t replaced() const { return replaced_; }
    /// Clients that have connected. Thread-safe.
    std::uint64_t seen() const { return seen_; }

    const std::string& greeting() const override { return greeting_; }
    const std::string& channels() const override { return channels_; }
    SharedFoxgloveMessage newest(FoxgloveTopic topic) override;
    void count_subscription(FoxgloveTopic topic, int change) override { subscriptions_[place(topic)] += change; }
    void count_replaced() override { ++replaced_; }
    void count_client() override { ++seen_; }

private:
    static std::size_t place(FoxgloveTopic topic) { return static_cast<std::size_t>(topic); }
    void extend_path(const ViewState& state);
    void give_state(const ViewState& state);
    void give(const SharedFoxgloveMessage& message);
    void renew(FoxgloveTopic topic, Timestamp stamp);
    std::string encode(FoxgloveTopic topic, Timestamp stamp) const;

    std::string greeting_;
    std::string channels_;
    std::vector<std::weak_ptr<FoxgloveClient>> clients_;
    /// What is known, for those who come late; without stamp: nothing.
    std::array<std::optional<Timestamp>, kFoxgloveTopics> known_{};
    ViewMesh mesh_;
    ViewPicture picture_;
    CalibrationEstimate calibration_;
    Se3 T_B_C_;
    FlightPath path_;
    std::array<SharedFoxgloveMessage, kFoxgloveTopics> messages_;  ///< made of what is known, or null
    std::array<std::atomic<int>, kFoxgloveTopics> subscriptions_{};
    std::atomic<std::uint64_t> replaced_{0};
    std::atomic<std::uint64_t> seen_{0};
};

}  // namespace facet
