// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/live_surface.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr float kStep_m = 1e-4F;
constexpr float kFarthest = 2e9F;  // steps
constexpr float kUnit = 127.0F;

void add(std::string& to, std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
        to.push_back(static_cast<char>((value >> (8 * i)) & 0xffU));
    }
}

/// A number of steps that fits into signed integers of that many bytes.
std::uint32_t rounded(float steps, float most) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(steps, -most, most)));
}

std::string packed(const SurfacePiece& piece) {
    std::string to;
    to.reserve(20 + 10 * piece.vertices.size() + 6 * piece.triangles.size() + 3);
    for (int axis = 0; axis < 3; ++axis) {
        add(to, rounded(piece.corner_W[axis] / kStep_m, kFarthest), 4);
    }
    add(to, static_cast<std::uint32_t>(piece.vertices.size()), 4);
    add(to, static_cast<std::uint32_t>(piece.triangles.size()), 4);
    for (const SurfaceVertex& v : piece.vertices) {
        for (int axis = 0; axis < 3; ++axis) {
            add(to, rounded((v.p_W[axis] - piece.corner_W[axis]) / kStep_m, 32767.0F), 2);
        }
        for (int axis = 0; axis < 3; ++axis) {
            add(to, rounded(kUnit * v.normal_W[axis], kUnit), 1);
        }
        add(to, static_cast<std::uint32_t>(std::clamp(v.grey, 0.0F, 255.0F)), 1);
    }
    for (const SurfaceTriangle& t : piece.triangles) {
        for (const std::uint16_t vertex : t.vertex) {
            add(to, vertex, 2);
        }
    }
    to.resize((to.size() + 3) / 4 * 4, '\0');
    return to;
}

}  // namespace

void LiveSurface::take(const SurfacePiece& piece, std::uint32_t restart) {
    const Key key{piece.at.x(), piece.at.y(), piece.at.z()};
    std::string bytes = packed(piece);
    const std::lock_guard lock(mutex_);
    if (restart != restart_) {
        restart_ = restart;
        ++surface_;
        pieces_.clear();
        by_version_.clear();
        bytes_ = 0;
    }
    const auto known = pieces_.find(key);
    if (known == pieces_.end()) {
        if (piece.triangles.empty()) {
            return;
        }
        if (bytes_ + bytes.size() > kMaxBytes) {
            ++dropped_;
            return;
        }
    }
    Piece& kept = known != pieces_.end() ? known->second : pieces_[key];
    by_version_.erase(kept.version);
    bytes_ += bytes.size();
    bytes_ -= kept.packed.size();
    kept = {++version_, std::move(bytes)};
    by_version_[version_] = key;
}

bool LiveSurface::append_changes(Position& position, std::size_t bytes, std::string& body) const {
    const std::lock_guard lock(mutex_);
    const bool is_other = position.surface != surface_ && position.surface != 0;
    if (position.surface != surface_) {
        position = {surface_, 0};
    }
    const std::size_t begin = body.size();
    for (auto next = by_version_.upper_bound(position.version);
         next != by_version_.end() && body.size() - begin < bytes; ++next) {
        body += pieces_.at(next->second).packed;
        position.version = next->first;
    }
    return is_other || body.size() > begin;
}

std::uint64_t LiveSurface::dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
}

}  // namespace facet
