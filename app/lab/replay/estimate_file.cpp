// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/estimate_file.h"

#include "app/view/live_view.h"

namespace facet {

EstimateFile::EstimateFile(const std::string& path)
    : writer_(path, Compression::kZstd, "", "facet"), channels_(writer_, true) {}

bool EstimateFile::wants_picture(Timestamp stamp, bool has_points) const {
    return stamp - last_picture_ >= (has_points ? LiveView::kPicturePeriod : LiveView::kPointlessAfter);
}

void EstimateFile::offer(const ViewState& state, const Fillers& fillers) {
    channels_.add(state);
    if (fillers.mesh) {
        refill(fillers.mesh, mesh_);
        channels_.add(state.stamp, mesh_);
    }
    if (fillers.calibration) {
        CalibrationEstimate calibration;
        fillers.calibration(calibration);
        channels_.add(state.stamp, calibration);
    }
    if (fillers.picture) {
        refill(fillers.picture, picture_);
        channels_.add(state.stamp, picture_);
        last_picture_ = state.stamp;
    }
}

}  // namespace facet
