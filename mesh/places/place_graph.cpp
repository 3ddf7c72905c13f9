// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/place_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr int kMaxRounds = 3;        ///< Gauss-Newton: yaw changes by a degree or two at most
constexpr int kMaxIterations = 60;   ///< of conjugate gradients in each
constexpr double kAccuracy = 1e-10;  ///< of the residual's energy: a hundred-thousandth of the step
constexpr double kStill = 1e-4;      ///< a change in yaw (rad) that asks for no further round
constexpr double kHeld = 1e10;       ///< information of what gives the frame
constexpr double kLoose = 1e-6;      ///< and of what merely keeps the matrix definite

/// The error of a relation and its derivatives.
struct Linear {
    YawPose::Tangent e;
    YawPose::Covariance d_a;
    YawPose::Covariance d_b;
};

Linear linearized(const YawPose& a, const YawPose& b, const YawPose& z) {
    const Eigen::Matrix3d r = yaw_matrix(-a.yaw);
    const Eigen::Vector3d p_a_b = r * (b.p - a.p);
    Linear l;
    l.e << wrapped(b.yaw - a.yaw - z.yaw), p_a_b - z.p;
    l.d_a = -turned_by(-a.yaw);
    l.d_a(1, 0) = p_a_b.y();
    l.d_a(2, 0) = -p_a_b.x();
    l.d_b = turned_by(-a.yaw);
    return l;
}

/// (L L^T)^-1 x.
template <int kColumns>
Eigen::Matrix<double, 4, kColumns> solved(const Eigen::Matrix4d& lower, Eigen::Matrix<double, 4, kColumns> x) {
    lower.triangularView<Eigen::Lower>().solveInPlace(x);
    lower.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
    return x;
}

}  // namespace

void PlaceGraph::configure() {
    nodes_.reserve(kMaxNodes);
    loops_.reserve(kMaxLoops);
    rows_.resize(kMaxNodes);
    clear();
}

void PlaceGraph::clear() {
    nodes_.clear();
    loops_.clear();
    is_floating_ = false;
    stage_ = Stage::kIdle;
}

void PlaceGraph::add_node(const Node& node) {
    FACET_ASSERT(nodes_.size() < kMaxNodes);
    nodes_.push_back(node);
}

void PlaceGraph::add_loop(std::size_t a, std::size_t b, const Relation& relation) {
    push({a, {}, b, relation, Block::Zero()});
}

void PlaceGraph::add_fixed(const YawPose& T_M_a, std::size_t b, const Relation& relation) {
    push({std::nullopt, T_M_a, b, relation, Block::Zero()});
}

void PlaceGraph::push(const Loop& loop) {
    if (loops_.size() == kMaxLoops) {
        loops_.erase(loops_.begin());
    }
    loops_.push_back(loop);
}

void PlaceGraph::loosen(std::size_t i) {
    if (i > 0) {
        nodes_[i].before = {nodes_[i - 1].T_M.inverse() * nodes_[i].T_M, kUnknown * Block::Identity()};
    }
}

void PlaceGraph::move_from(std::size_t i, const YawPose& T_M_i) {
    const YawPose moved = T_M_i * nodes_[i].T_M.inverse();
    for (std::size_t k = i; k < nodes_.size(); ++k) {
        nodes_[k].T_M = moved * nodes_[k].T_M;
    }
}

void PlaceGraph::lay_out_from(std::size_t i, const YawPose& T_M_i) {
    nodes_[i].T_M = T_M_i;
    for (std::size_t k = i + 1; k < nodes_.size(); ++k) {
        nodes_[k].T_M = nodes_[k - 1].T_M * nodes_[k].before.T_a_b;
    }
}

void PlaceGraph::remove(std::size_t i) {
    FACET_ASSERT(i > 0 && i + 1 < nodes_.size());
    const Relation& first = nodes_[i].before;
    Relation& second = nodes_[i + 1].before;
    // Covariances add, the first one carried to the second one's end, in the frame of the node before.
    const Block j = carried_by(first.T_a_b.R() * second.T_a_b.p);
    const Block turn = turned_by(first.T_a_b.yaw);
    const Block covariance =
        j * first.information.inverse() * j.transpose() + turn * second.information.inverse() * turn.transpose();
    second = {first.T_a_b * second.T_a_b, covariance.inverse()};
    nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(i));
    std::erase_if(loops_, [i](const Loop& loop) { return loop.a == i || loop.b == i; });
    for (Loop& loop : loops_) {
        loop.b -= loop.b > i ? 1 : 0;
        if (loop.a && *loop.a > i) {
            --*loop.a;
        }
    }
    stage_ = Stage::kIdle;
}

void PlaceGraph::begin() {
    rounds_ = 0;
    stage_ = nodes_.empty() ? Stage::kIdle : Stage::kLinearize;
}

bool PlaceGraph::advance() {
    if (stage_ == Stage::kLinearize) {
        linearize();
        factor();
        return false;
    }
    if (stage_ != Stage::kSolve) {
        return false;
    }
    const bool is_solved = energy_ <= kAccuracy * start_energy_ || iterations_ == kMaxIterations || energy_ <= 0.0;
    if (is_solved) {
        apply();
        return true;
    }
    iterate();
    return false;
}

void PlaceGraph::linearize() {
    solved_ = nodes_.size();
    for (std::size_t i = 0; i < solved_; ++i) {
        rows_[i].diagonal = Block::Identity() * kLoose;
        rows_[i].below.setZero();
        rows_[i].gradient.setZero();
        rows_[i].step.setZero();
    }
    rows_[0].diagonal.diagonal().array() += is_floating_ ? kLoose : kHeld;
    for (std::size_t i = 1; i < solved_; ++i) {
        const Relation& r = nodes_[i].before;
        const Linear l = linearized(nodes_[i - 1].T_M, nodes_[i].T_M, r.T_a_b);
        const Block wa = r.information * l.d_a;
        const Block wb = r.information * l.d_b;
        rows_[i - 1].diagonal += l.d_a.transpose() * wa;
        rows_[i].diagonal += l.d_b.transpose() * wb;
        rows_[i].below = l.d_b.transpose() * wa;
        rows_[i - 1].gradient -= wa.transpose() * l.e;
        rows_[i].gradient -= wb.transpose() * l.e;
    }
    for (Loop& loop : loops_) {
        const Relation& r = loop.relation;
        const Linear l = linearized(loop.a ? nodes_[*loop.a].T_M : loop.fixed, nodes_[loop.b].T_M, r.T_a_b);
        const Block wb = r.information * l.d_b;
        rows_[loop.b].diagonal += l.d_b.transpose() * wb;
        rows_[loop.b].gradient -= wb.transpose() * l.e;
        if (loop.a) {
            rows_[*loop.a].diagonal += l.d_a.transpose() * r.information * l.d_a;
            rows_[*loop.a].gradient -= l.d_a.transpose() * r.information * l.e;
            loop.between = l.d_a.transpose() * wb;
        }
    }
}

/// The chain's Cholesky factors, and the first direction of the iteration.
void PlaceGraph::factor() {
    for (std::size_t i = 0; i < solved_; ++i) {
        Row& row = rows_[i];
        Block pivot = row.diagonal;
        if (i > 0) {
            // carried = below * pivot_before^-1
            row.carried = solved<4>(rows_[i - 1].factor, row.below.transpose()).transpose();
            pivot -= row.carried * row.below.transpose();
        }
        row.factor = pivot.llt().matrixL();
        row.residual = row.gradient;
    }
    precondition();
    energy_ = 0.0;
    for (std::size_t i = 0; i < solved_; ++i) {
        rows_[i].direction = rows_[i].conditioned;
        energy_ += rows_[i].residual.dot(rows_[i].conditioned);
    }
    start_energy_ = energy_;
    iterations_ = 0;
    stage_ = Stage::kSolve;
}

/// conditioned = chain^-1 residual.
void PlaceGraph::precondition() {
    for (std::size_t i = 0; i < solved_; ++i) {
        rows_[i].conditioned = rows_[i].residual;
        if (i > 0) {
            rows_[i].conditioned -= rows_[i].carried * rows_[i - 1].conditioned;
        }
    }
    for (std::size_t i = solved_; i-- > 0;) {
        rows_[i].conditioned = solved<1>(rows_[i].factor, rows_[i].conditioned);
        if (i + 1 < solved_) {
            rows_[i].conditioned -= rows_[i + 1].carried.transpose() * rows_[i + 1].conditioned;
        }
    }
}

/// image = matrix * direction.
void PlaceGraph::multiply() {
    for (std::size_t i = 0; i < solved_; ++i) {
        rows_[i].image = rows_[i].diagonal * rows_[i].direction;
        if (i > 0) {
            rows_[i].image += rows_[i].below * rows_[i - 1].direction;
            rows_[i - 1].image += rows_[i].below.transpose() * rows_[i].direction;
        }
    }
    for (const Loop& loop : loops_) {
        if (loop.a && loop.b < solved_) {
            rows_[*loop.a].image += loop.between * rows_[loop.b].direction;
            rows_[loop.b].image += loop.between.transpose() * rows_[*loop.a].direction;
        }
    }
}

void PlaceGraph::iterate() {
    multiply();
    double curvature = 0.0;
    for (std::size_t i = 0; i < solved_; ++i) {
        curvature += rows_[i].direction.dot(rows_[i].image);
    }
    const double length = curvature > 0.0 ? energy_ / curvature : 0.0;
    for (std::size_t i = 0; i < solved_; ++i) {
        rows_[i].step += length * rows_[i].direction;
        rows_[i].residual -= length * rows_[i].image;
    }
    precondition();
    double energy = 0.0;
    for (std::size_t i = 0; i < solved_; ++i) {
        energy += rows_[i].residual.dot(rows_[i].conditioned);
    }
    const double ratio = length > 0.0 ? energy / energy_ : 0.0;
    for (std::size_t i = 0; i < solved_; ++i) {
        rows_[i].direction = rows_[i].conditioned + ratio * rows_[i].direction;
    }
    energy_ = length > 0.0 ? energy : 0.0;
    ++iterations_;
}

/// Nodes that came meanwhile follow the last one that took part.
void PlaceGraph::apply() {
    double turn = 0.0;
    for (std::size_t i = 0; i < solved_; ++i) {
        nodes_[i].T_M = nodes_[i].T_M.box_plus(rows_[i].step);
        turn = std::max(turn, std::abs(rows_[i].step[0]));
    }
    for (std::size_t i = solved_; i < nodes_.size(); ++i) {
        nodes_[i].T_M = nodes_[i - 1].T_M * nodes_[i].before.T_a_b;
    }
    ++rounds_;
    stage_ = turn > kStill && rounds_ < kMaxRounds ? Stage::kLinearize : Stage::kIdle;
}

}  // namespace facet
