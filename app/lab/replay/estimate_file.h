// SPDX-License-Identifier: BSD-2-Clause
// The estimates of a replay in a file, for Foxglove and its like.
#pragma once

#include <memory>
#include <string>

#include "app/pipeline/estimate_channels.h"
#include "app/view/flight_viewer.h"

namespace facet {

/// An MCAP file with what the live view shows: EstimateChannels, and pictures of the left camera made small, with
/// LiveView's pauses between two. The file grows beside its name and takes it in close(). Thread-bound. Heap. All
/// functions throw InputError naming the path if it cannot be written.
class EstimateFile final : public FlightViewer {
public:
    explicit EstimateFile(const std::string& path);

    bool wants_picture(Timestamp stamp, bool has_points) const override;
    bool wants_calibration() const override { return true; }
    void offer(const ViewState& state, const Fillers& fillers) override;

    /// Nothing may follow.
    void close() { writer_.close(); }

private:
    McapWriter writer_;
    EstimateChannels channels_;
    ViewMesh mesh_;
    ViewPicture picture_;
    Timestamp last_picture_;
};

}  // namespace facet
