// SPDX-License-Identifier: BSD-2-Clause
// Whether inertial readings or images are believed where they contradict each other.
#pragma once

#include <span>

#include "estimator/api/belief.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/imu_limits.h"
#include "estimator/values/nav_state.h"
#include "estimator/window/frame_update.h"
#include "estimator/window/window_state.h"

namespace facet {

/// A sensor that reads nonsense, or what belongs to another time, contradicts the images by tens of standard
/// deviations. Inertial factors are the stronger ones, so that without a judgement it is the images that go. The judge:
///   * With the readings as they are, the images of a frame do not fit (`wrong_chi2`), and next to none of the tracks.
///   * With nothing known of the motion since the newest keyframe they fit well (`good_chi2`), and most of them: they
///     show one rigid motion, another one.
/// Then the readings are wrong. A scene of which a part moves fails the first condition, a camera that shows nonsense
/// the second: then the readings are believed, as ever.
///
/// After a longer interval the readings are known so much less well that images bend them instead: images fit, and what
/// contradicts is the inertial term (kBentChi2). Then nearly all tracks have to fit with nothing known of the motion.
///
/// A sensor that hangs (StuckReadings) is probably the one that is wrong, or nothing is, and it gives what it should.
/// Then images need not throw it out: it is suspected by what makes a frame DEGRADED (`good_chi2`) or is beyond three
/// standard deviations of the inertial term (kStuckChi2), if nearly all tracks fit with nothing known of the motion.
///
/// The readings of the sensor that is wrong, or of both, are replaced by those of a steady motion, at the rate that the
/// last two frames tell, with the noise of what the motion has differed from that by (inertial_error at keyframes). The
/// suspicion ends when at two keyframes in a row the readings have agreed with what the images showed; not while the
/// sensor hangs, and at the first agreement after that, because then the reason for it is gone.
/// Thread-bound. No heap.
class InertialFault {
public:
    /// White noise of readings without information: anywhere within their ranges.
    static StepNoise unlimited(const ImuLimits& limits);

    /// Variance of a frame's residuals over the expected one (HealthConfig).
    struct Limits {
        double good_chi2 = 0.0;   ///< images that fit stay below it
        double wrong_chi2 = 0.0;  ///< images that the readings leave unexplained go beyond it
    };
    /// @param usual     of the frame with the readings as they are
    /// @param is_stuck  a sensor hangs that is not suspected
    static bool is_called_for(const FrameEstimate& usual, const Limits& limits, bool is_stuck);
    /// @param free  of the frame with nothing known of the motion
    static bool is_justified(const FrameEstimate& usual, const FrameEstimate& free, const Limits& limits,
                             bool is_stuck);

    bool is_active() const { return axes_ != 0; }
    ImuAxisMask axes() const { return axes_; }
    /// A sensor that hangs is among them.
    bool has_hung() const { return has_hung_; }
    /// The readings are believed again.
    void end();
    /// Rate of the body between the last two frames (rad/s).
    const Eigen::Vector3d& rate_B() const { return w_B_; }

    /// After each frame: notes the rate of the body.
    void see(Timestamp stamp, const NavState& state);
    /// What goes on from a state at the rate of the last two frames. @param gravity_m_per_s2  its strength
    SteadyMotion steady(const NavState& from, double gravity_m_per_s2) const;

    /// What readings after this state shall be taken for.
    ReplacedReadings readings(const NavState& from, double gravity_m_per_s2) const;

    /// The readings from the newest keyframe i were found wrong at a frame j.
    /// @param ij     as read
    /// @param stuck  axes of the sensors that hang
    void begin(const NavState& i, const NavState& j, const Preintegration& ij, ImuAxisMask stuck);
    /// What readings that have been replaced leave. @param ij  as replaced
    void measure(const NavState& i, const NavState& j, const Preintegration& ij);
    StepNoise noise() const;
    /// Of suspected readings as they are, if those are all there is: what separates them from the replaced ones.
    static StepNoise noise_between(const Preintegration& as_read, const Preintegration& as_replaced);

    /// After a keyframe, with the two before it: measures what replaced readings leave, and may end the suspicion by
    /// what was read in their place. @param last  oldest first, with inertial factors  @param empty  to integrate with
    void follow(std::span<const Keyframe, 3> last, ImuBuffer& imu, const ImuNoise& noise, const Preintegration& empty);
    /// The first half. @param ij, jk  as replaced
    void measure(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
                 const Preintegration& jk);
    /// The second half. @param ij, jk  as read
    void judge(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
               const Preintegration& jk);

private:
    /// Seven standard deviations; four logs with flight vibration and calibration error have at most 4.3.
    static constexpr double kBentChi2 = 50.0;
    static constexpr double kStuckChi2 = 9.0;  ///< of a sensor that hangs

    ImuAxisMask axes_ = 0;    ///< of the sensors that are not believed
    double gyro_left_ = 0.0;  ///< deviation of the true readings from the replaced ones (rad/s)
    double accel_left_ = 0.0;
    bool has_hung_ = false;  ///< what is suspected, since it was
    int agreements_ = 0;     ///< keyframes in a row
    bool has_seen_ = false;
    Timestamp seen_;  ///< the last frame
    Eigen::Quaterniond q_W_B_ = Eigen::Quaterniond::Identity();
    Eigen::Vector3d w_B_ = Eigen::Vector3d::Zero();
};

}  // namespace facet
