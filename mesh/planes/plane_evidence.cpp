// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_evidence.h"

#include <algorithm>
#include <cmath>

#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr float kMaxLandmarkChi2 = 6.0F;  // of its sightings, as the mesh accepts it in a vertex
constexpr float kFarAway = 1e6F;          // m
constexpr double kNear = 0.30;            // m: faces this near to a plane can have two corners on it
constexpr double kRounding = 1e-3;        // m: of heights in single precision, within a hundred metres and more
constexpr double kStaySigma = 1.5;        // a landmark on a plane may be this much less certain than a new one
constexpr int kCells = 16;                // of the grid that spreads landmarks, to each side
constexpr double kGridExtents = 2.5;      // reach of the grid in standard deviations of the points

double share(int on, int off) { return on > 0 ? static_cast<double>(on) / static_cast<double>(on + off) : 0.0; }

}  // namespace

void PlaneEvidence::take(const PlaneConfig& config, const HorizonMesh& mesh, const KeyframeView& view) {
    config_ = config;
    origin_ = view.T_W_C0.p;
    points_.clear();
    state_.clear();
    point_of_vertex_.fill(kNoPoint);
    std::size_t m = 0;
    for (const LandmarkSnapshot& s : view.landmarks) {
        while (m < members_.size() && members_[m].id < s.id) {
            ++m;
        }
        PointState state;
        state.id = s.id;
        state.is_good = s.chi2 <= kMaxLandmarkChi2;
        state.is_held = s.plane.valid();
        if (m < members_.size() && members_[m].id == s.id) {
            state.former = members_[m].plane;
            state.was_chosen = members_[m].was_chosen;
        }
        if (const auto slot = mesh.find_vertex(s.id); slot.ok()) {
            point_of_vertex_[slot.value()] = static_cast<std::uint16_t>(points_.size());
        }
        add_point({s.p_W, static_cast<float>(view.observation_variance) * s.covariance_W}, state);
    }
    landmarks_ = points_.size();
    for (int i = 0; i < mesh.vertex_end() && !points_.full(); ++i) {
        const auto slot = static_cast<VertexSlot>(i);
        if (!mesh.is_vertex(i) || !mesh.vertex(slot).is_surface_point || mesh.vertex(slot).is_rehosted) {
            continue;
        }
        PointState state;
        state.id = mesh.landmark(slot);
        state.is_good = true;
        point_of_vertex_[slot] = static_cast<std::uint16_t>(points_.size());
        const MeshVertex& vertex = mesh.vertex(slot);
        add_point({vertex.measured_W, static_cast<float>(view.observation_variance) * vertex.covariance_W}, state);
    }
    take_faces(mesh);
}

void PlaneEvidence::add_point(const PlanePoint& point, const PointState& state) {
    from_origin_[points_.size()] = (point.p_W - origin_).cast<float>();
    points_.push_back(point);
    state_.push_back(state);
}

/// Variance of a face's tilt if its corners move independently along its normal with sigma s:
/// s^2 sum 1 / height_i^2, half of it about each axis.
void PlaneEvidence::take_faces(const HorizonMesh& mesh) {
    const auto base = static_cast<float>(kRadPerDeg * PlaneLimits::kFaceAngle_deg);
    const auto widest = static_cast<float>(kRadPerDeg * PlaneLimits::kMaxFaceAngle_deg);
    faces_.clear();
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i)) {
            continue;
        }
        const auto index = static_cast<FaceIndex>(i);
        const MeshFace& from = mesh.face(index);
        if (from.is_doubtful()) {
            continue;
        }
        const std::array<std::uint16_t, 3> point{point_of_vertex_[from.vertex[0]], point_of_vertex_[from.vertex[1]],
                                                 point_of_vertex_[from.vertex[2]]};
        if (point[0] == kNoPoint || point[1] == kNoPoint || point[2] == kNoPoint) {
            continue;
        }
        const Eigen::Vector3f& a = from_origin_[point[0]];
        const Eigen::Vector3f& b = from_origin_[point[1]];
        const Eigen::Vector3f& c = from_origin_[point[2]];
        const float sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
        Face& face = faces_.push_back({});
        face.point = point;
        face.normal_W = (b - a).cross(c - a).normalized();  // of the points as measured
        face.area = from.area_m2;
        face.centroid = (a + b + c) / 3.0F;
        face.sigma = from.sigma_m;
        face.tilt_sigma = from.sigma_m * std::sqrt(0.125F * sides) / std::max(from.area_m2, 1e-6F);
        face.least_cosine = std::cos(std::min(widest, base + 2.0F * face.tilt_sigma));
        face.index = index;
        face.is_fill = from.is_fill;
        // Faces that close holes are placed far from every plane.
        const Eigen::Vector3f place = from.is_fill ? Eigen::Vector3f::Constant(kFarAway) : face.centroid;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            place_[axis][faces_.size() - 1] = place(static_cast<Eigen::Index>(axis));
            facing_[axis][faces_.size() - 1] = face.normal_W(static_cast<Eigen::Index>(axis));
        }
        least_cosine_[faces_.size() - 1] = face.least_cosine;
        corner_[faces_.size() - 1] = point;
    }
}

/// Tests are ordered by what they cost; the plane's own uncertainty is asked for only if that decides.
bool PlaneEvidence::test(std::uint16_t point, const Examined& examined) {
    if (std::abs(examined.normal_W.dot(from_origin_[point]) - examined.from_origin_m) > examined.farthest_m) {
        return false;
    }
    const PointState& state = state_[point];
    const PlaneSerial plane = examined.plane;
    if (state.owner != 0 || (state.former != 0 && state.former != plane) || !state.is_good) {
        return false;
    }
    const bool is_member = plane != 0 && state.former == plane;
    const PlaneGate& gate = is_member ? examined.stay : examined.join;
    const PlanePoint& p = points_[point];
    const double r = examined.fit.residual(p.p_W);
    if (std::abs(r) > gate.distance_m) {
        return false;
    }
    const auto across = static_cast<double>(p.variance_along(examined.normal_W));
    const double most = (is_member ? kStaySigma : 1.0) * PlaneLimits::kMaxPointSigma_m;
    if (across > most * most) {
        return false;
    }
    const double variance = across + config_.surface_sigma_m * config_.surface_sigma_m;
    const double sigmas2 = gate.sigmas * gate.sigmas;
    if (r * r > sigmas2 * variance) {
        const double own = examined.fit.sigma_at(p.p_W);
        if (r * r > sigmas2 * (variance + own * own)) {
            return false;
        }
    }
    residual_[point] = static_cast<float>(r);
    variance_[point] = variance;
    return true;
}

/// Most faces are far from most planes, or turned otherwise: a loop of its own looks at all of them with vector
/// instructions.
void PlaneEvidence::find_parallel_near(const Examined& examined) {
    const Eigen::Vector3f n = examined.normal_W;
    const float d = examined.from_origin_m;
    const std::size_t count = faces_.size();
    for (std::size_t i = 0; i < count; ++i) {
        height_[i] = n.x() * place_[0][i] + n.y() * place_[1][i] + n.z() * place_[2][i] - d;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const float cosine = n.x() * facing_[0][i] + (n.y() * facing_[1][i] + n.z() * facing_[2][i]);
        const bool is_turned = cosine < least_cosine_[i];
        const bool is_near = std::abs(height_[i]) <= static_cast<float>(kNear);
        is_along_[i] = static_cast<std::uint8_t>(is_near & !is_turned);
    }
    std::fill_n(is_along_.begin() + static_cast<std::ptrdiff_t>(count), (8 - count % 8) % 8, std::uint8_t{0});
}

void PlaneEvidence::collect(const PlaneFit& fit, PlaneSerial plane, const PlaneGate& join, const PlaneGate& stay,
                            PlaneSupport& support) {
    std::fill_n(fits_.begin(), points_.size(), Fits::kUnknown);
    std::fill_n(is_on_.begin(), std::min(points_.size() + 8, is_on_.size()), std::uint8_t{0});
    support.points.clear();
    support.surface.clear();
    support.area_m2 = 0.0;
    normal_W_ = fit.normal_W.cast<float>();
    const auto from_origin_m = static_cast<float>(fit.distance_m - fit.normal_W.dot(origin_));
    const auto farthest_m = static_cast<float>(std::max(join.distance_m, stay.distance_m) + kRounding);
    const Examined examined{fit, normal_W_, from_origin_m, farthest_m, plane, join, stay};
    find_parallel_near(examined);
    for_set(is_along_.data(), faces_.size(), [&](std::size_t i) {
        const auto& corner = corner_[i];
        if (fits(corner[0], examined) && fits(corner[1], examined) && fits(corner[2], examined)) {
            support.area_m2 += static_cast<double>(faces_[i].area);
            for (const std::uint16_t p : corner) {
                is_on_[p] = 1;
            }
        }
    });
    for (std::size_t i = 0; i < landmarks_ && plane != 0; ++i) {
        if (state_[i].former == plane && is_on_[i] == 0) {
            is_on_[i] = fits(static_cast<std::uint16_t>(i), examined) ? 1 : 0;
        }
    }
    for_set(is_on_.data(), points_.size(), [&](std::size_t i) {
        const auto p = static_cast<std::uint16_t>(i);
        if (i < landmarks_) {
            support.points.push_back(p);
        } else {
            support.surface.push_back(p);
        }
    });
}

/// Coherence and roughness.
void PlaneEvidence::weigh(PlaneSupport& support) {
    const auto know_sigma = [&](std::uint16_t p) { sigma_[p] = static_cast<float>(std::sqrt(variance_[p])); };
    std::for_each(support.points.begin(), support.points.end(), know_sigma);
    std::for_each(support.surface.begin(), support.surface.end(), know_sigma);
    const double most = PlaneLimits::kMaxPointSigma_m * PlaneLimits::kMaxPointSigma_m;
    int on = 0;
    int across = 0;
    int unknown = 0;
    double products = 0.0;
    double weights = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < faces_.size(); ++i) {
        near_[count] = static_cast<std::uint16_t>(i);
        count += std::abs(height_[i]) <= static_cast<float>(kNear) ? 1 : 0;
    }
    for (std::size_t i = 0; i < count; ++i) {
        const auto& p = corner_[near_[i]];
        const int corners = is_on_[p[0]] + is_on_[p[1]] + is_on_[p[2]];
        on += corners == 3 ? 1 : 0;
        if (corners == 2) {
            const std::uint16_t off = is_on_[p[0]] == 0 ? p[0] : (is_on_[p[1]] == 0 ? p[1] : p[2]);
            ++across;
            unknown += static_cast<double>(points_[off].variance_along(normal_W_)) > most ? 1 : 0;
        }
        if (corners != 3) {
            continue;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t a = p[k];
            const std::size_t b = p[(k + 1) % 3];
            const double w = 1.0 / static_cast<double>(sigma_[a] * sigma_[b]);
            products += w * static_cast<double>(residual_[a] * residual_[b]);
            weights += w;
        }
    }
    support.coherence = share(on, across);
    support.known_coherence = share(on, across - unknown);
    support.roughness_m = weights > 0.0 ? std::sqrt(std::max(0.0, products / weights)) : 0.0;
}

void PlaneEvidence::collect_former(PlaneSerial plane, FixedVector<std::uint16_t, kMaxLandmarks>& points) const {
    points.clear();
    for (std::size_t i = 0; i < landmarks_; ++i) {
        if (state_[i].former == plane && state_[i].owner == 0) {
            points.push_back(static_cast<std::uint16_t>(i));
        }
    }
}

void PlaneEvidence::collect_owned(PlaneSerial plane, FixedVector<std::uint16_t, kMaxLandmarks>& points) const {
    points.clear();
    for (std::size_t i = 0; i < landmarks_; ++i) {
        if (state_[i].owner == plane) {
            points.push_back(static_cast<std::uint16_t>(i));
        }
    }
}

void PlaneEvidence::own(const PlaneSupport& support, PlaneSerial plane) {
    for (const std::uint16_t p : support.points) {
        state_[p].owner = plane;
    }
    for (const std::uint16_t p : support.surface) {
        state_[p].owner = plane;
    }
}

void PlaneEvidence::hand_over(PlaneSerial from, PlaneSerial to) {
    for (PointState& s : state_) {
        s.owner = s.owner == from ? to : s.owner;
    }
}

void PlaneEvidence::forget_former() {
    for (PointState& s : state_) {
        s.former = s.owner;
    }
}

void PlaneEvidence::choose_spread(const PlaneFit& fit, std::span<const std::uint16_t> points,
                                  FixedVector<LandmarkId, kMaxPlaneLandmarks>& chosen) {
    ranked_.clear();
    const auto cell_of = [](double x, double extent) {
        const double at = kCells * (0.5 + 0.5 * x / (kGridExtents * std::max(extent, 1e-3)));
        return std::clamp(static_cast<int>(std::floor(at)), 0, kCells - 1);
    };
    const Eigen::Vector3f n = fit.normal_W.cast<float>();
    for (const std::uint16_t p : points) {
        const Eigen::Vector3d q = points_[p].p_W - fit.centroid_W;
        const int u = cell_of(std::clamp(fit.along_W.dot(q), -1e3, 1e3), fit.extent_along_m);
        const int v = cell_of(std::clamp(fit.across_W.dot(q), -1e3, 1e3), fit.extent_across_m);
        ranked_.push_back(
            {p, static_cast<std::uint16_t>(kCells * v + u), 0, state_[p].was_chosen, points_[p].sigma_along(n)});
    }
    if (ranked_.size() > kMaxPlaneLandmarks) {
        std::sort(ranked_.begin(), ranked_.end(), [](const Ranked& a, const Ranked& b) {
            if (a.cell != b.cell) {
                return a.cell < b.cell;
            }
            if (a.was_chosen != b.was_chosen) {
                return a.was_chosen;
            }
            return a.sigma != b.sigma ? a.sigma < b.sigma : a.point < b.point;
        });
        for (std::size_t i = 1; i < ranked_.size(); ++i) {
            ranked_[i].rank = ranked_[i].cell == ranked_[i - 1].cell
                                  ? static_cast<std::uint16_t>(ranked_[i - 1].rank + 1)
                                  : std::uint16_t{0};
        }
        std::sort(ranked_.begin(), ranked_.end(), [](const Ranked& a, const Ranked& b) {
            return a.rank != b.rank ? a.rank < b.rank : a.cell < b.cell;
        });
        ranked_.resize(kMaxPlaneLandmarks);
        std::sort(ranked_.begin(), ranked_.end(), [](const Ranked& a, const Ranked& b) { return a.point < b.point; });
    }
    chosen.clear();
    for (const std::uint16_t p : points) {
        state_[p].was_chosen = false;
    }
    for (const Ranked& r : ranked_) {
        state_[r.point].was_chosen = true;
        chosen.push_back(state_[r.point].id);
    }
}

void PlaneEvidence::remember() {
    members_.clear();
    for (std::size_t i = 0; i < landmarks_; ++i) {
        const PointState& s = state_[i];
        if (s.owner != 0) {
            members_.push_back({s.id, s.owner, s.was_chosen});
        }
    }
}

/// Mean of the point given n . p = d within the surface's flatness: p - Sigma n (n' Sigma n + s^2)^-1 (n . p - d).
Eigen::Vector3d PlaneEvidence::shift_to(const PlaneFit& fit, const PlanePoint& point) const {
    const Eigen::Vector3d along = point.covariance_W.cast<double>() * fit.normal_W;
    const double variance = fit.normal_W.dot(along) + config_.surface_sigma_m * config_.surface_sigma_m;
    return -fit.residual(point.p_W) / variance * along;
}

/// The plane of at least two corners.
PlaneSerial PlaneEvidence::majority(const Face& face) const {
    const PlaneSerial a = state_[face.point[0]].owner;
    const PlaneSerial b = state_[face.point[1]].owner;
    const PlaneSerial c = state_[face.point[2]].owner;
    return a == b || a == c ? a : (b == c ? b : 0);
}

bool PlaneEvidence::lies_on(const Face& face, PlaneSerial plane, const PlaneFit& fit) const {
    if (fit.normal_W.cast<float>().dot(face.normal_W) < face.least_cosine) {
        return false;
    }
    return std::all_of(face.point.begin(), face.point.end(), [&](std::uint16_t p) {
        return state_[p].owner == plane || std::abs(fit.residual(points_[p].p_W)) <= PlaneLimits::kJoin_m;
    });
}

}  // namespace facet
