// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/trajectory_writer.h"

namespace facet {
namespace {

constexpr const char* kEurocHeader =
    "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
    "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
    "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";

constexpr int kCovarianceDim = 9;
constexpr std::uint64_t kNsPerS = 1'000'000'000;

}  // namespace

std::string tum_line(Timestamp stamp, const Se3& pose) {
    const Eigen::Vector3d& p = pose.p;
    const Eigen::Quaterniond& q = pose.q;
    const bool is_negative = stamp.ns < 0;
    const auto stamp_ns = static_cast<std::uint64_t>(stamp.ns);
    const std::uint64_t ns = is_negative ? 0 - stamp_ns : stamp_ns;
    return fmt::format("{}{}.{:09} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", is_negative ? "-" : "",
                       ns / kNsPerS, ns % kNsPerS, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

TrajectoryWriter::TrajectoryWriter(const std::string& folder)
    : tum_(folder + "/trajectory.tum"), csv_(folder + "/trajectory.csv"), covariance_(folder + "/covariance.csv") {
    csv_.write(kEurocHeader);
    covariance_.write("stamp_ns");
    for (int i = 0; i < kCovarianceDim; ++i) {
        for (int j = i; j < kCovarianceDim; ++j) {
            covariance_.print(",c{}{}", i, j);
        }
    }
    covariance_.write("\n");
}

void TrajectoryWriter::write(const Estimate& estimate) {
    const NavState& s = estimate.state;
    const Eigen::Vector3d& p = s.p_W_B;
    const Eigen::Quaterniond& q = s.q_W_B;
    const Eigen::Vector3d& v = s.v_W_B;
    const Eigen::Vector3d& bg = s.bias.gyro;
    const Eigen::Vector3d& ba = s.bias.accel;
    tum_.write(tum_line(estimate.stamp, {q, p}));
    csv_.print("{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}", estimate.stamp.ns, p.x(), p.y(), p.z(), q.w(),
               q.x(), q.y(), q.z());
    csv_.print(",{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", v.x(), v.y(), v.z(), bg.x(), bg.y(),
               bg.z(), ba.x(), ba.y(), ba.z());
    covariance_.print("{}", estimate.stamp.ns);
    for (int i = 0; i < kCovarianceDim; ++i) {
        for (int j = i; j < kCovarianceDim; ++j) {
            covariance_.print(",{:.6e}", estimate.covariance(i, j));
        }
    }
    covariance_.write("\n");
}

void TrajectoryWriter::flush() {
    tum_.flush();
    csv_.flush();
    covariance_.flush();
}

void TrajectoryWriter::close() {
    tum_.close();
    csv_.close();
    covariance_.close();
}

}  // namespace facet
