// SPDX-License-Identifier: BSD-2-Clause
// The path so far as poses of four degrees of freedom, held together by odometry and by places met again.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "mesh/places/yaw_pose.h"

namespace facet {

/// Nodes are stations of the flight, in order of time. Each is tied to the one before by odometry, and to earlier nodes
/// or fixed poses by recognitions. relax() minimises the sum of the squared whitened errors
///   e(a, b) = [yaw_b - yaw_a - z.yaw; Rz(-yaw_a) (p_b - p_a) - z.p]
/// by Gauss-Newton; each linear system is solved by conjugate gradients with the chain of the odometry, block
/// tridiagonal and factored exactly, as the preconditioner: as many iterations as there are independent loops, each of
/// the order of the number of nodes. Work is done in slices. Thread-bound. Deterministic. Heap in configure() only.
class PlaceGraph {
public:
    static constexpr std::size_t kMaxNodes = 4096;  ///< an hour at a station a second, after thinning
    static constexpr std::size_t kMaxLoops = 8192;

    /// A pose relative to another with its information in that one's frame.
    struct Relation {
        YawPose T_a_b;
        YawPose::Covariance information = YawPose::Covariance::Identity();
    };
    struct Node {
        YawPose T_M;      ///< pose in the map
        Relation before;  ///< to it from the node before; of the first one without meaning
    };

    void configure();
    void clear();

    std::size_t size() const { return nodes_.size(); }
    const Node& node(std::size_t i) const { return nodes_[i]; }
    std::size_t loop_count() const { return loops_.size(); }

    /// Whether the poses of the first node and of all that hang on it are free to be moved as one: there is a map that
    /// gives the frame.
    void set_floating(bool is_floating) { is_floating_ = is_floating; }

    /// Places a node, and those after it where odometry has them from there; for a path without loops.
    void lay_out_from(std::size_t i, const YawPose& T_M_i);

    /// Appends a node. Contract: size() < kMaxNodes.
    void add_node(const Node& node);
    /// Replaces what odometry says of a node, as long as the window still refines it; poses follow at the next relax().
    void set_odometry(std::size_t i, const YawPose& T_before_i) { nodes_[i].before.T_a_b = T_before_i; }
    static constexpr double kUnknown = 1e-6;  ///< information of an odometry that says nothing
    /// Ties nodes a and b. When full, the oldest loop goes.
    void add_loop(std::size_t a, std::size_t b, const Relation& relation);
    /// Ties node b to a pose of the map that stays as it is.
    void add_fixed(const YawPose& T_M_a, std::size_t b, const Relation& relation);
    /// Odometry says nothing of a node's pose seen from the one before. Of the first node it does nothing.
    void loosen(std::size_t i);
    /// Moves a node and all after it as one.
    void move_from(std::size_t i, const YawPose& T_M_i);
    /// Takes out a node: the odometry to it and from it become one, its loops go. Ends a relaxation that is under way.
    /// Contract: 0 < i < size() - 1.
    void remove(std::size_t i);

    /// Begins to relax, or begins again.
    void begin();
    bool is_busy() const { return stage_ != Stage::kIdle; }
    /// A slice of the work: linearization, or one iteration. @return whether poses have changed
    bool advance();

private:
    enum class Stage : std::uint8_t { kIdle, kLinearize, kSolve };
    using Vector = YawPose::Tangent;
    using Block = YawPose::Covariance;
    struct Loop {
        std::optional<std::size_t> a;  ///< none: a fixed pose
        YawPose fixed;
        std::size_t b = 0;
        Relation relation;
        Block between = Block::Zero();  ///< of the normal matrix, from row a to column b
    };
    struct Row {
        Block diagonal;
        Block below;      ///< to the row before: block (i, i - 1)
        Block factor;     ///< Cholesky factor of the pivot, lower
        Block carried;    ///< below * inverse(pivot before)
        Vector gradient;  ///< negative
        Vector step;
        Vector residual;
        Vector direction;
        Vector image;  ///< matrix times direction
        Vector conditioned;
    };

    void push(const Loop& loop);
    void linearize();
    void factor();
    void precondition();
    void multiply();
    void iterate();
    void apply();

    std::vector<Node> nodes_;
    std::vector<Loop> loops_;
    std::vector<Row> rows_;
    bool is_floating_ = false;
    Stage stage_ = Stage::kIdle;
    std::size_t solved_ = 0;  ///< nodes that take part in the solution under way
    int rounds_ = 0;
    int iterations_ = 0;
    double start_energy_ = 0.0;  ///< of the residual, at the first iteration
    double energy_ = 0.0;
};

}  // namespace facet
