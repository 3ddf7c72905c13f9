// SPDX-License-Identifier: BSD-2-Clause
// Velocity, gravity and biases from bearings at a few keyframes and the inertial samples between them.
#pragma once

#include <Eigen/Core>
#include <boost/container/static_vector.hpp>
#include <span>

#include "platform/base/status.h"

namespace facet {

/// One keyframe in the body frame B0 of the oldest one, by inertial samples alone: what velocity and gravity at the
/// oldest one add is left out.
struct MotionPlace {
    double t_s = 0.0;  ///< since the oldest keyframe
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d d_theta_d_bg = Eigen::Matrix3d::Zero();
    Eigen::Vector3d d_theta_d_delay = Eigen::Vector3d::Zero();  ///< rad/s: the rate, less that of the oldest one
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 3, 6> d_p_d_b = Eigen::Matrix<double, 3, 6>::Zero();  ///< [bg ba]
    Eigen::Matrix<double, 3, 6> d_v_d_b = Eigen::Matrix<double, 3, 6>::Zero();
};

/// One sighting of a point. What it points to belongs to the caller.
struct MotionSight {
    const Eigen::Vector3d* d_B = nullptr;    ///< bearing in the body frame at its keyframe, of unit length
    const Eigen::Vector3d* p_B_C = nullptr;  ///< of the camera
    std::size_t place = 0;                   ///< of its keyframe
};

/// A small bundle adjustment whose poses have 13 unknowns together: x = [v g ba bg td], velocity and gravity in B0, td
/// the delay of images behind their stamps, to first order and by rotation alone. The camera centre of a sighting at
/// keyframe k is
///   c_k(x) = v t_k + 1/2 g t_k^2 + p_k(ba, bg) + R_k(bg) p_B_C,
/// a point is a direction w and an inverse depth rho at its first sighting, so that the ray of sighting k is
/// r_k = w + rho (c_0 - c_k) and its residual r_k / (d_k.r_k) - d_k, d_k = R_k d_B: the tangent of the angle between
/// them. Points are eliminated one by one; Cauchy's loss; |g| is known.
///
/// Where it begins (begin()): with (I - d d^T)(X - c_k), linear in a point X and in z = [v g s], s a factor on
/// p_k + R_k p_B_C. With matches between two cameras s = 1, and v and g follow. With one camera the minimum is zero or
/// next to it: noise makes small scenes cheap. So the shape of the path is that of the smallest ratio of residuals to
/// length of path (a generalized eigenvector), and its scale, velocity and gravity follow from the accelerometer:
/// [Martinelli14] for the equations, [Qin17] for the order, shape first and then scale.
///
/// About 90 KiB. Thread-bound. No heap.
///
/// [Martinelli14] Closed-form Solution of Visual-Inertial Structure from Motion, IJCV 2014.
/// [Qin17] Robust Initialization of Monocular Visual-Inertial Estimation on Aerial Robots, IROS 2017.
class MotionProblem {
public:
    static constexpr std::size_t kMostKeyframes = 12;
    static constexpr std::size_t kMostPoints = 128;
    static constexpr std::size_t kMostSights = 2 * kMostKeyframes;  // of a point
    static constexpr int kUnknowns = 13;
    static constexpr int kVelocityAt = 0;
    static constexpr int kGravityAt = 3;
    static constexpr int kAccelBiasAt = 6;
    static constexpr int kGyroBiasAt = 9;
    static constexpr int kDelayAt = 12;
    using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
    using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
    using Places = boost::container::static_vector<MotionPlace, kMostKeyframes>;

    /// What is known of the biases without images, order [ba bg] (m/s^2, rad/s).
    struct BiasPrior {
        Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
        Eigen::Matrix<double, 6, 1> sigma = Eigen::Matrix<double, 6, 1>::Ones();
    };

    /// At one x.
    struct Sums {
        Normal information = Normal::Zero();  ///< priors included
        Unknowns gradient = Unknowns::Zero();
        double cost = 0.0;  ///< twice the negative log likelihood, without constants
        int points = 0;
        int behind = 0;  ///< of these, behind a camera that has seen them
        int sightings = 0;
        int misfits = 0;  ///< of these, off by more than 3 sigma
    };

    /// @param bearing_sigma  of a sighting, rad
    void configure(double gravity_m_per_s2, double bearing_sigma);
    void clear();
    void set_bias_prior(const BiasPrior& prior) { bias_prior_ = prior; }
    /// Of the delay, around zero (s).
    void set_delay_sigma(double sigma_s) { delay_sigma_s_ = sigma_s; }
    /// @return false when full
    bool add_point(std::span<const MotionSight> sights);
    std::size_t points() const { return points_.size(); }

    /// Velocity and gravity without an initial guess; biases zero.
    /// @param has_scale  there are matches between two cameras
    Status begin(const Places& places, bool has_scale, Unknowns& x);
    /// The same for a vehicle that has stood at the oldest keyframe: where the shape of most of the path is noise.
    void begin_at_rest(const Places& places, Unknowns& x);
    /// Normal equations at x, where points are; H dx = -gradient is a Gauss-Newton step. After begin().
    /// @param places  with the gyroscope bias and the delay of x, the accelerometer bias as it was
    Sums linearize(const Places& places, const Unknowns& x);
    /// Of the factor on the path that a change of x stands for, by least squares over the keyframes. Very large
    /// without a path.
    static Unknowns d_scale_d_x(const Places& places, const Unknowns& x);

private:
    static constexpr int kShape = 7;  // v g s
    using Shape = Eigen::Matrix<double, kShape, 1>;
    using Form = Eigen::Matrix<double, kShape, kShape>;
    using Centre = Eigen::Matrix<double, 3, kUnknowns>;
    using ShapeCentre = Eigen::Matrix<double, 3, kShape>;

    struct Point {
        std::size_t first = 0;  ///< of its sights
        std::size_t count = 0;
        Eigen::Vector3d state = Eigen::Vector3d::Zero();  ///< direction across the first bearing, and inverse depth
    };
    using Sights = std::span<const MotionSight>;
    using Values = boost::container::static_vector<double, kMostSights>;
    using Centres = boost::container::static_vector<Eigen::Vector3d, kMostSights>;
    struct PointSums {
        Eigen::Matrix3d pp = Eigen::Matrix3d::Zero();
        Centre px = Centre::Zero();
        Normal xx = Normal::Zero();
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        Unknowns x = Unknowns::Zero();
        double cost = 0.0;
        int misfits = 0;
        bool is_behind = false;
    };

    Sights sights_of(const Point& point) const { return {&sights_[point.first], point.count}; }
    /// The point nearest to all rays, each over its weight.
    static Eigen::Vector3d meet(Sights sights, const Places& places, const Centres& centres, const Values& weights);
    static ShapeCentre shape_centre(const MotionPlace& place, const Eigen::Vector3d& p_B_C);
    static Centres centres_of(Sights sights, const Places& places, const Shape& z);
    static Centres centres_of(Sights sights, const Places& places, const Unknowns& x);
    static Centre d_centre_d_x(const MotionSight& sight, const MotionPlace& place);
    /// (I - d d^T)(X - c) over depth, as a form of z. @param z  where depths are taken; nullptr: all are alike
    Form shape_form(const Places& places, const Shape* z) const;
    static Form path_form(const Places& places);
    /// Most points of the shape lie behind.
    bool is_mirrored(const Places& places, const Shape& z) const;
    Status find_shape(const Places& places, Shape& z) const;
    void place_points(const Places& places, const Unknowns& x);
    /// @param with_x  not only what the point itself needs
    PointSums sum(const Point& point, const Places& places, const Centres& centres, bool with_x) const;
    void add(Point& point, const Places& places, const Unknowns& x, Sums& sums) const;
    void add_priors(const Places& places, const Unknowns& x, Sums& sums) const;

    double gravity_m_per_s2_ = 0.0;
    double bearing_sigma_ = 2e-3;
    double delay_sigma_s_ = 1e-6;
    BiasPrior bias_prior_;
    boost::container::static_vector<Point, kMostPoints> points_;
    boost::container::static_vector<MotionSight, kMostPoints * kMostSights> sights_;
};

}  // namespace facet
