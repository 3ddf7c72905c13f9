// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/bare_surfaces.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "platform/base/hash64.h"

namespace facet {
namespace {

constexpr double kMostSpread = 4.0;            // grey: standard deviation in a bare square, noise included
constexpr double kMostStep = 4.0;              // grey: between the means of two that hang together
constexpr int kRim = 3;                        // squares beyond a region within which its rim begins
constexpr int kPlanes = 3;                     // of a region
constexpr int kTries = 200;                    // triples of patches,
constexpr std::uint64_t kSeed = hash64(1, 0);  // drawn the same way for every plane
constexpr double kLeastApart = 1e-5;           // determinant of a triple's rays
constexpr int kFewestOnPlane = 12;             // patches on a plane
constexpr double kOnPlaneSigmas = 3.0;         // that a patch on a plane may lie off it,
constexpr double kOffPlanePx = 0.25;           // and px beyond that
constexpr double kMostBehind = 0.1;            // patches behind a plane for each one on it,
constexpr double kBehindCost = 5.0;            // and how many on it one of them outweighs
constexpr double kRimTogether = 16.0;          // patches at a rim that share samples
constexpr double kMostSigma = 0.03;            // m, along the normal: what views infer from one rim errs alike in all
constexpr double kLeastBareFacing = 0.15;      // cosine between ray and normal

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

BareSurfaces::BareSurfaces(const SquareRaster& raster, const SquareLayout& layout) : raster_(raster), layout_(layout) {
    const std::size_t count = at(layout.count());
    mean_.resize(count);
    is_bare_.resize(count);
    region_.resize(count);
    is_found_.resize(count);
    is_on_.resize(count);
    members_.reserve(count);
    found_.reserve(count);
    rim_.reserve(count);
}

void BareSurfaces::begin(const ImageView& image, std::vector<SurfacePatch>& patches) {
    patches_ = &patches;
    next_ = 0;
    std::ranges::fill(region_, -1);
    for (int i = 0; i < layout_.count(); ++i) {
        measure(image, i);
    }
}

bool BareSurfaces::advance(int squares) {
    const int end = std::min(layout_.count(), next_ + squares);
    for (; next_ < end; ++next_) {
        if (is_bare_[at(next_)] && region_[at(next_)] < 0) {
            grow(next_);
            find_rim();
            fill();
        }
    }
    return next_ < layout_.count();
}

void BareSurfaces::measure(const ImageView& image, int i) {
    const int side = layout_.side_px;
    const int u0 = i % layout_.columns * side;
    const int v0 = i / layout_.columns * side;
    double sum = 0.0;
    double squares = 0.0;
    for (int v = v0; v < v0 + side; ++v) {
        for (int u = u0; u < u0 + side; ++u) {
            const double grey = image.at(u, v);
            sum += grey;
            squares += grey * grey;
        }
    }
    const double mean = sum / (side * side);
    mean_[at(i)] = mean;
    is_bare_[at(i)] =
        !(*patches_)[at(i)].exists() && squares / (side * side) - mean * mean <= kMostSpread * kMostSpread;
    (*patches_)[at(i)].grey = static_cast<float>(mean);
}

/// The square beside one in one of eight directions around, or -1.
int BareSurfaces::beside(int i, int direction) const {
    constexpr std::array<int, 8> kRight{1, 1, 0, -1, -1, -1, 0, 1};
    constexpr std::array<int, 8> kDown{0, 1, 1, 1, 0, -1, -1, -1};
    const int column = i % layout_.columns + kRight[at(direction)];
    const int row = i / layout_.columns + kDown[at(direction)];
    return column >= 0 && row >= 0 && column < layout_.columns && row < layout_.rows ? row * layout_.columns + column
                                                                                     : -1;
}

void BareSurfaces::grow(int first) {
    members_.clear();
    members_.push_back(first);
    region_[at(first)] = first;
    for (std::size_t k = 0; k < members_.size(); ++k) {
        const int i = members_[k];
        for (int direction = 0; direction < 8; direction += 2) {
            const int j = beside(i, direction);
            if (j >= 0 && is_bare_[at(j)] && region_[at(j)] < 0 && std::abs(mean_[at(j)] - mean_[at(i)]) <= kMostStep) {
                region_[at(j)] = first;
                members_.push_back(j);
            }
        }
    }
}

/// The first measured square on the way out of a region, or -1. @param i  the first one outside it
int BareSurfaces::rim_from(int i, int direction) const {
    for (int k = 0; k < kRim && i >= 0; ++k, i = beside(i, direction)) {
        if ((*patches_)[at(i)].exists() && !(*patches_)[at(i)].is_inferred) {
            return i;
        }
    }
    return -1;
}

void BareSurfaces::find_rim() {
    for (const int i : found_) {
        is_found_[at(i)] = false;
    }
    found_.clear();
    for (const int i : members_) {
        for (int direction = 0; direction < 8; ++direction) {
            const int j = beside(i, direction);
            const int end = j < 0 || region_[at(j)] == region_[at(i)] ? -1 : rim_from(j, direction);
            if (end >= 0 && !is_found_[at(end)]) {
                is_found_[at(end)] = true;
                found_.push_back(end);
            }
        }
    }
    std::ranges::sort(found_);
    rim_.clear();
    for (const int i : found_) {
        const SurfacePatch& patch = (*patches_)[at(i)];
        const Eigen::Vector3d ray = raster_.middle(at(i)).cast<double>().homogeneous();
        rim_.push_back({i, ray, patch.n_C.cast<double>().dot(ray), static_cast<double>(patch.sigma)});
    }
}

/// How far a patch lies before a plane, in what one on it may.
double BareSurfaces::before(const RimPatch& rim, const Eigen::Vector3d& n) const {
    return (rim.rho - n.dot(rim.ray)) / (kOnPlaneSigmas * rim.sigma + kOffPlanePx * layout_.per_px);
}

/// The plane through three patches on which most lie, less those behind it.
bool BareSurfaces::find_plane(RimPlane& plane) const {
    std::uint64_t drawn = 0;
    const auto pick = [&]() -> const RimPatch& {
        const double uniform = static_cast<double>(hash64(kSeed, drawn++) >> 11U) * 0x1.0p-53;
        return rim_[at(static_cast<int>(uniform * static_cast<double>(rim_.size())))];
    };
    double best = 0.0;
    for (int t = 0; t < kTries && std::ssize(rim_) >= kFewestOnPlane; ++t) {
        const std::array<const RimPatch*, 3> triple{&pick(), &pick(), &pick()};
        Eigen::Matrix3d rays;
        rays << triple[0]->ray.transpose(), triple[1]->ray.transpose(), triple[2]->ray.transpose();
        if (std::abs(rays.determinant()) < kLeastApart) {
            continue;
        }
        const Eigen::Vector3d n = rays.inverse() * Eigen::Vector3d(triple[0]->rho, triple[1]->rho, triple[2]->rho);
        double score = 0.0;
        for (const RimPatch& rim : rim_) {
            const double d = before(rim, n);
            score += d < -1.0 ? -kBehindCost : (d <= 1.0 ? 1.0 : 0.0);
        }
        if (score > best) {
            best = score;
            plane.n = n;
        }
    }
    return best >= kFewestOnPlane && refine(plane) && refine(plane);
}

/// To all patches on the plane; false if there are few, or too many behind it.
bool BareSurfaces::refine(RimPlane& plane) const {
    Eigen::Matrix3d h = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    const double off = kOffPlanePx * layout_.per_px;
    int on = 0;
    int behind = 0;
    for (const RimPatch& rim : rim_) {
        const double d = before(rim, plane.n);
        behind += d < -1.0 ? 1 : 0;
        if (std::abs(d) <= 1.0) {
            const double w = 1.0 / (rim.sigma * rim.sigma + off * off);
            h += w * rim.ray * rim.ray.transpose();
            g += w * rim.rho * rim.ray;
            ++on;
        }
    }
    const Eigen::Matrix3d inverse = h.inverse();
    plane.n = inverse * g;
    plane.covariance = kRimTogether * inverse;
    return on >= kFewestOnPlane && behind <= kMostBehind * on;
}

void BareSurfaces::fill() {
    RimPlane plane;
    for (int k = 0; k < kPlanes; ++k) {
        if (!find_plane(plane)) {
            return;
        }
        is_on_.assign(is_on_.size(), false);
        for (const RimPatch& rim : rim_) {
            is_on_[at(rim.square)] = std::abs(before(rim, plane.n)) <= 1.0;
        }
        for (const int i : members_) {
            if (!(*patches_)[at(i)].exists() && is_enclosed(i)) {
                set(i, plane);
            }
        }
        std::erase_if(rim_, [&](const RimPatch& rim) { return is_on_[at(rim.square)]; });
    }
}

void BareSurfaces::set(int i, const RimPlane& plane) {
    const Eigen::Vector3d ray = raster_.middle(at(i)).cast<double>().homogeneous();
    const double rho = plane.n.dot(ray);
    const double sigma = std::hypot(std::sqrt(ray.dot(plane.covariance * ray)), kOffPlanePx * layout_.per_px);
    if (rho <= kLeastBareFacing * plane.n.norm() * ray.norm() || sigma > kMostSigma * rho * plane.n.norm()) {
        return;
    }
    SurfacePatch& patch = (*patches_)[at(i)];
    patch.n_C = plane.n.cast<float>();
    patch.sigma = static_cast<float>(sigma);
    patch.is_inferred = true;
}

/// Whether the way through the region ends at a patch on the plane.
bool BareSurfaces::finds_plane(int i, int direction) const {
    const int region = region_[at(i)];
    while (i >= 0 && region_[at(i)] == region) {
        i = beside(i, direction);
    }
    const int end = rim_from(i, direction);
    return end >= 0 && is_on_[at(end)];
}

/// Whether the directions in which the plane is found are nowhere more than half a turn apart.
bool BareSurfaces::is_enclosed(int i) const {
    std::array<bool, 8> is_found{};
    for (int direction = 0; direction < 8; ++direction) {
        is_found[at(direction)] = finds_plane(i, direction);
    }
    int apart = 0;
    for (int direction = 0; direction < 16 && apart < 4; ++direction) {
        apart = is_found[at(direction % 8)] ? 0 : apart + 1;
    }
    return apart < 4;
}

}  // namespace facet
