// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/details.h"

#include "app/lab/eval/evaluation.h"
#include "app/lab/eval/pose_difference.h"
#include "app/support/text_file.h"

namespace facet {

void write_absolute_errors(std::span<const PosePair> pairs, const Se3& T_true_est, const std::string& path) {
    TextFile file(path);
    file.write("stamp_ns,true_x,true_y,true_z,x,y,z,error_m,error_deg\n");
    for (const PosePair& pair : pairs) {
        const Se3 aligned = T_true_est * pair.estimate;
        const PoseDifference error = pose_difference(pair.truth, aligned);
        const Eigen::Vector3d& t = pair.truth.p;
        const Eigen::Vector3d& e = aligned.p;
        file.print("{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.9g},{:.9g}\n", pair.stamp.ns, t.x(), t.y(), t.z(),
                   e.x(), e.y(), e.z(), error.distance_m(), error.angle_deg());
    }
    file.close();
}

void write_relative_errors(std::span<const PosePair> pairs, std::span<const double> lengths_m,
                           const std::string& path) {
    TextFile file(path);
    file.write("length_m,stamp_ns,translation_m,translation_percent,rotation_deg,yaw_deg\n");
    for (const double length : lengths_m) {
        for (const RelativeSample& s : relative_samples(pairs, length)) {
            file.print("{:g},{},{:.9g},{:.9g},{:.9g},{:.9g}\n", length, s.stamp.ns, s.translation_m,
                       s.translation_percent(), s.rotation_deg, s.yaw_deg);
        }
    }
    file.close();
}

void write_mesh_distances(const TriangleSoup& mesh, const TriangleSoup& surface, const Se3& T_true_est, double limit_m,
                          const std::string& path) {
    const TriangleTree tree(surface);
    const auto distance = [&](const Eigen::Vector3d& p) { return tree.nearest(T_true_est * p, limit_m).distance; };
    TextFile file(path);
    file.write("corner_0,corner_1,corner_2,side_01,side_12,side_20\n");
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Eigen::Vector3d& a = mesh.corner(i, 0);
        const Eigen::Vector3d& b = mesh.corner(i, 1);
        const Eigen::Vector3d& c = mesh.corner(i, 2);
        file.print("{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", distance(a), distance(b), distance(c),
                   distance(0.5 * (a + b)), distance(0.5 * (b + c)), distance(0.5 * (c + a)));
    }
    file.close();
}

}  // namespace facet
