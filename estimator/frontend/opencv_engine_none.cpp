// SPDX-License-Identifier: BSD-2-Clause
// Takes the place of opencv_engine.cpp in builds without OpenCV.
#include "estimator/frontend/feature_engine.h"

namespace facet {

bool has_opencv_engine() { return false; }

std::unique_ptr<FeatureEngine> make_opencv_engine() { return nullptr; }

}  // namespace facet
