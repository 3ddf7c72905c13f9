// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/truth/true_planes.h"

#include <algorithm>
#include <cmath>

#include "app/lab/eval/plane_file.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

PlaneKind kind_of(const Eigen::Vector3d& normal) {
    if (!is_level_or_upright(normal)) {
        return PlaneKind::kSlanted;
    }
    return std::abs(normal.z()) > 0.5 ? PlaneKind::kHorizontal : PlaneKind::kVertical;
}

}  // namespace

TruePlanes::TruePlanes(const std::string& path) : planes_(load_planes(path)) {
    if (planes_.empty()) {
        throw InputError("--truth planes: no plane in " + path);
    }
}

void TruePlanes::see(LandmarkId landmark, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W) {
    if (const int plane = plane_at(planes_, p_W, n_W); plane >= 0) {
        plane_of_.try_emplace(landmark.value, plane);
    }
}

const PlaneProposals& TruePlanes::propose(const KeyframeView& view, const Se3& T_W_C0) {
    std::vector<std::vector<LandmarkId>> on(planes_.size());
    for (const LandmarkSnapshot& s : view.landmarks) {
        if (const auto at = plane_of_.find(s.id.value); at != plane_of_.end()) {
            on[static_cast<std::size_t>(at->second)].push_back(s.id);
        }
    }
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < on.size(); ++k) {
        if (on[k].size() >= kMinLandmarks) {
            order.push_back(k);
        }
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return on[a].size() > on[b].size(); });
    order.resize(std::min<std::size_t>(order.size(), kMaxPlanes));
    std::sort(order.begin(), order.end());
    const Se3 T_est_true = view.T_W_C0 * T_W_C0.inverse();
    proposals_.clear();
    for (const std::size_t k : order) {
        PlaneProposal& proposal = proposals_.push_back({});
        proposal.id.value = kFirstId + static_cast<std::uint32_t>(k);
        proposal.kind = kind_of(planes_[k].normal);
        proposal.normal_W = T_est_true.q * planes_[k].normal;
        proposal.distance_m = planes_[k].distance + proposal.normal_W.dot(T_est_true.p);
        const std::size_t count = std::min<std::size_t>(on[k].size(), kMaxPlaneLandmarks);
        for (std::size_t i = 0; i < count; ++i) {
            proposal.landmarks.push_back(on[k][i * on[k].size() / count]);
        }
    }
    return proposals_;
}

}  // namespace facet
