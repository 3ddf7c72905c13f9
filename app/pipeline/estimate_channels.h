// SPDX-License-Identifier: BSD-2-Clause
// The estimates of a flight in an MCAP file, for Foxglove and its like.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "app/foxglove/schemas.h"
#include "app/mcap/mcap_writer.h"
#include "app/view/flight_path.h"
#include "app/view/view_snapshot.h"

namespace facet {

/// Channels for the topics of schemas.h, which the live view has too: pose, transforms, health and times of each frame;
/// the path so far at keyframes, every kPathPeriod at most; mesh, planes, calibration and pictures as they are given.
/// Stamps before the epoch become zero. All functions throw InputError if the file cannot be written. Thread-bound.
class EstimateChannels {
public:
    static constexpr Duration kPathPeriod = Duration::from_seconds(1.0);

    /// @param writer  borrowed
    /// @param has_pictures  there will be some
    explicit EstimateChannels(McapWriter& writer, bool has_pictures = false);

    void add(const ViewState& state);
    void add(Timestamp stamp, const ViewMesh& mesh);
    void add(Timestamp stamp, const CalibrationEstimate& calibration);
    void add(Timestamp stamp, const ViewPicture& picture);

private:
    void write(FoxgloveTopic topic, Timestamp stamp, const std::string& message);

    McapWriter& writer_;
    std::array<std::uint16_t, kFoxgloveTopics> channels_{};  ///< by topic; zero: there is none
    FlightPath path_;
    Timestamp next_path_;
};

}  // namespace facet
