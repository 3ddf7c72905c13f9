// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/distance_field.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr int kMostReach = DistanceField::kMaxReach;

/// into[i] <- min(into[i], from[i] + more): a handful of vector instructions for a row.
void take_less(const std::uint16_t* from, std::uint16_t more, std::size_t count, std::uint16_t* into) {
    for (std::size_t i = 0; i < count; ++i) {
        into[i] = std::min(into[i], static_cast<std::uint16_t>(from[i] + more));
    }
}

}  // namespace

void DistanceField::clear() {
    cell_m_ = 0.0;
    reach_ = 0;
}

Status DistanceField::update(std::span<const std::uint8_t, OccupancyGrid::kPackedBytes> states,
                             const Eigen::Vector3i& lowest_cell, double cell_m, double reach_m, FieldTarget target) {
    if (!(cell_m > 0.0) || !(reach_m > 0.0)) {
        return Status::kInvalidArgument;
    }
    static_assert((kMostReach + 1) * (kMostReach + 1) + kMostReach * kMostReach < 1 << (16 - kOffsetBits));
    static_assert(kMostReach < kMiddle);
    std::copy(states.begin(), states.end(), states_.begin());
    low_ = lowest_cell;
    cell_m_ = cell_m;
    reach_ = static_cast<int>(std::clamp(std::ceil(reach_m / cell_m), 1.0, static_cast<double>(kMostReach)));
    mark_targets(target);
    sweep_z();
    reduce_y();
    reduce_x();
    return Status::kOk;
}

Status DistanceField::update(const OccupancyGrid& grid, double reach_m, FieldTarget target) {
    if (!(reach_m > 0.0)) {
        return Status::kInvalidArgument;
    }
    grid.pack(states_);
    return update(states_, grid.lowest_cell(), grid.cell_m(), reach_m, target);
}

/// As at its place in states_.
Space DistanceField::space_at(const Eigen::Vector3i& relative) const {
    const Eigen::Vector3i c = low_ + relative;
    const std::size_t place =
        index_of({c.x() & (kX - 1), c.y() & (kY - 1), c.z() & (kZ - 1)});  // sizes are powers of two
    const unsigned code = (static_cast<unsigned>(states_[place / 4]) >> (2 * (place % 4))) & 3U;
    return code == 1U ? Space::kFree : code == 2U ? Space::kOccupied : Space::kUnknown;
}

/// 0 in offset_z_ at targets, else reach_ + 1.
void DistanceField::mark_targets(FieldTarget target) {
    const auto none = static_cast<std::int8_t>(reach_ + 1);
    std::array<std::int8_t, 4> of_code{};
    for (unsigned code = 0; code < of_code.size(); ++code) {
        of_code[code] = (target == FieldTarget::kOccupied ? code == 2U : code != 1U) ? std::int8_t{0} : none;
    }
    std::array<std::int8_t, kX> row{};
    for (int z = 0; z < kZ; ++z) {
        for (int y = 0; y < kY; ++y) {
            const std::size_t place = index_of({0, (low_.y() + y) & (kY - 1), (low_.z() + z) & (kZ - 1)});
            for (std::size_t i = 0; i < kX / 4; ++i) {
                const unsigned four = states_[place / 4 + i];
                for (unsigned k = 0; k < 4; ++k) {
                    row[4 * i + k] = of_code[(four >> (2 * k)) & 3U];
                }
            }
            // The row begins at low_.x() and goes round.
            const auto first = row.begin() + (low_.x() & (kX - 1));
            std::rotate_copy(row.begin(), first, row.end(), offset_z_.begin() + static_cast<long>(index_of({0, y, z})));
        }
    }
    if (target != FieldTarget::kNotFree) {
        return;
    }
    for (int z = 0; z < kZ; ++z) {
        for (int y = 0; y < kY; ++y) {
            const auto from = offset_z_.begin() + static_cast<long>(index_of({0, y, z}));
            if (z == 0 || z == kZ - 1 || y == 0 || y == kY - 1) {
                std::fill(from, from + kX, std::int8_t{0});
            }
            from[0] = from[kX - 1] = 0;
        }
    }
}

/// The nearest target of each column: upwards the one below, then downwards whichever is nearer.
void DistanceField::sweep_z() {
    const auto none = static_cast<std::int8_t>(reach_ + 1);
    for (std::size_t i = kPlane; i < kCells; ++i) {
        const int below = -offset_z_[i - kPlane] + 1;  // offsets found so far point downwards, or are `none`
        const int up = offset_z_[i - kPlane] > 0 ? none : std::min<int>(below, none);
        offset_z_[i] = offset_z_[i] == 0 || up == none ? offset_z_[i] : static_cast<std::int8_t>(-up);
    }
    for (std::size_t i = kCells - kPlane; i-- > 0;) {
        const int above = std::abs(offset_z_[i + kPlane]) + 1;
        const bool leads_up = offset_z_[i + kPlane] >= 0;
        const bool is_nearer = leads_up && above < std::abs(offset_z_[i]);
        offset_z_[i] = is_nearer ? static_cast<std::int8_t>(above) : offset_z_[i];
    }
}

void DistanceField::reduce_y() {
    std::array<bool, static_cast<std::size_t>(kY + 2 * kMostReach)> is_used{};
    const auto none = static_cast<Key>(((reach_ + 1) * (reach_ + 1)) << kOffsetBits);
    squares_.fill(none);
    for (int z = 0; z < kZ; ++z) {
        for (int y = 0; y < kY; ++y) {
            const std::int8_t* const offset = &offset_z_[index_of({0, y, z})];
            Key* const square = &squares_[static_cast<std::size_t>(y + kMostReach) * kX];
            int least = reach_ + 1;
            for (int x = 0; x < kX; ++x) {
                const int distance = std::abs(offset[x]);
                square[x] = static_cast<Key>((distance * distance) << kOffsetBits);
                least = std::min(least, distance);
            }
            is_used[static_cast<std::size_t>(y + kMostReach)] = least <= reach_;
        }
        for (int y = 0; y < kY; ++y) {
            Key* const key = &key_yz_[index_of({0, y, z})];
            const auto row = static_cast<std::size_t>(y + kMostReach);
            for (std::size_t x = 0; x < kX; ++x) {
                key[x] = static_cast<Key>(squares_[row * kX + x] + kMiddle);
            }
            for (int d = 1; d <= reach_; ++d) {
                const auto before = row - static_cast<std::size_t>(d);
                const auto behind = row + static_cast<std::size_t>(d);
                if (is_used[before] || is_used[behind]) {
                    const auto more = static_cast<Key>((d * d) << kOffsetBits);
                    take_less(&squares_[before * kX], static_cast<Key>(more + kMiddle - d), kX, key);
                    take_less(&squares_[behind * kX], static_cast<Key>(more + kMiddle + d), kX, key);
                }
            }
        }
    }
}

void DistanceField::reduce_x() {
    std::array<Key, static_cast<std::size_t>(kX + 2 * kMostReach)> squares;
    const auto most = static_cast<Key>((reach_ + 1) * (reach_ + 1));
    squares.fill(static_cast<Key>(most << kOffsetBits));
    for (std::size_t at = 0; at < kCells; at += kX) {
        for (std::size_t x = 0; x < kX; ++x) {
            squares[x + kMostReach] =
                static_cast<Key>(std::min(static_cast<Key>(key_yz_[at + x] >> kOffsetBits), most) << kOffsetBits);
        }
        Key* const key = &key_[at];
        for (std::size_t x = 0; x < kX; ++x) {
            key[x] = static_cast<Key>(squares[x + kMostReach] + kMiddle);
        }
        for (int d = 1; d <= reach_; ++d) {
            const auto more = static_cast<Key>((d * d) << kOffsetBits);
            take_less(&squares[static_cast<std::size_t>(kMostReach - d)], static_cast<Key>(more + kMiddle - d), kX,
                      key);
            take_less(&squares[static_cast<std::size_t>(kMostReach + d)], static_cast<Key>(more + kMiddle + d), kX,
                      key);
        }
    }
}

/// Between centres; the reach if nothing is within it.
double DistanceField::cell_distance_m(const Eigen::Vector3i& relative) const {
    const int square = key_[index_of(relative)] >> kOffsetBits;
    return std::min(std::sqrt(static_cast<double>(square)), static_cast<double>(reach_)) * cell_m_;
}

FieldPoint DistanceField::at(const Eigen::Vector3d& p_W) const {
    FieldPoint point;
    point.distance_m = reach_m();
    const Eigen::Vector3i size(kX, kY, kZ);
    const Eigen::Vector3d in_cells = p_W / cell_m_ - low_.cast<double>();  // from the lowest cell's corner
    if (!(cell_m_ > 0.0) || !(in_cells.minCoeff() >= 0.0) || !((size.cast<double>() - in_cells).minCoeff() > 0.0)) {
        return point;
    }
    const Eigen::Vector3i cell = in_cells.array().floor().cast<int>();
    point.space = space_at(cell);
    const Key key = key_[index_of(cell)];
    if ((key >> kOffsetBits) <= reach_ * reach_) {
        constexpr int kMask = (1 << kOffsetBits) - 1;
        Eigen::Vector3i target = cell;
        target.x() += (key & kMask) - kMiddle;
        target.y() += (key_yz_[index_of(target)] & kMask) - kMiddle;
        target.z() += offset_z_[index_of(target)];
        point.has_target = true;
        point.target_W = cell_m_ * ((low_ + target).cast<double>().array() + 0.5).matrix();
        point.target = space_at(target);
    }
    // Trilinear between the eight centres around the point.
    const Eigen::Vector3d from_centre = in_cells.array() - 0.5;
    const Eigen::Vector3i base = from_centre.array().floor().cast<int>();
    const Eigen::Vector3d part = from_centre - base.cast<double>();
    point.distance_m = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3i step(corner & 1, (corner >> 1) & 1, corner >> 2);
        const Eigen::Vector3i at = (base + step).cwiseMax(0).cwiseMin(size - Eigen::Vector3i::Ones());
        const double distance = cell_distance_m(at);
        const Eigen::Vector3d weight =
            (step.cast<double>().array() * part.array() + (1 - step.array()).cast<double>() * (1.0 - part.array()));
        const Eigen::Vector3d slope = (2 * step.array() - 1).cast<double>() / cell_m_;
        point.distance_m += weight.prod() * distance;
        point.gradient +=
            distance * Eigen::Vector3d(slope.x() * weight.y() * weight.z(), weight.x() * slope.y() * weight.z(),
                                       weight.x() * weight.y() * slope.z());
    }
    return point;
}

}  // namespace facet
