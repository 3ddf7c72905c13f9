// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/patch_window.h"

#include <cmath>

#include "estimator/frontend/simd.h"

namespace facet {
namespace {

constexpr float kSigma = 0.8F;  // of the window's half width

}  // namespace

float PatchWindow::weight(int u, int v) const {
    const float reach = static_cast<float>(half()) + 0.5F;
    const float sigma = kSigma * (static_cast<float>(half()) + 1.0F);
    const float r2 = static_cast<float>(u * u + v * v);
    return r2 <= reach * reach ? std::exp(-r2 / (2.0F * sigma * sigma)) : 0.0F;
}

void PatchWindow::configure(int side_px) {
    side_ = side_px;
    u_.clear();
    v_.clear();
    weights_.clear();
    rows_.clear();
    weight_sum_ = 0.0F;
    for (int v = -half(); v <= half(); ++v) {
        int reach = half();
        while (!(weight(reach, v) > 0.0F)) {
            --reach;
        }
        rows_.push_back({v, reach, count()});
        for (int u = -reach; u <= reach; ++u) {
            u_.push_back(static_cast<float>(u));
            v_.push_back(static_cast<float>(v));
            weights_.push_back(weight(u, v));
            weight_sum_ += weights_.back();
        }
    }
    while (count() % simd::kLanes != 0) {
        u_.push_back(0.0F);
        v_.push_back(0.0F);
        weights_.push_back(0.0F);
    }
}

}  // namespace facet
