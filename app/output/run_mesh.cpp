// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/run_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <tuple>

#include "app/output/ply_file.h"

namespace facet {
namespace {

/// Faces with shared vertices and their normals, weighted by area.
class IndexedMesh {
public:
    IndexedMesh(std::span<const DepartedFace> faces, const PlaneNames& names) {
        for (const DepartedFace& face : faces) {
            Eigen::Vector3i triangle;
            for (std::size_t k = 0; k < 3; ++k) {
                triangle[static_cast<int>(k)] = index_of(face.landmark[k], face.p_W[k]);
            }
            const Eigen::Vector3f normal = (face.p_W[1] - face.p_W[0]).cross(face.p_W[2] - face.p_W[0]);
            for (int k = 0; k < 3; ++k) {
                normals_[static_cast<std::size_t>(triangle[k])] += normal;
            }
            triangles_.push_back(triangle);
            observations_.push_back(face.observations);
            sigmas_.push_back(face.sigma_m);
            planes_.push_back(face.plane.valid() ? static_cast<std::int32_t>(names.now(face.plane).value) : -1);
        }
        for (Eigen::Vector3f& n : normals_) {
            n = n.norm() > 0.0F ? n.normalized() : Eigen::Vector3f(0.0F, 0.0F, 1.0F);
        }
    }

    void write(const std::string& path) const {
        PlyMesh mesh;
        mesh.vertices = vertices_;
        mesh.normals = normals_;
        mesh.triangles = triangles_;
        mesh.planes = planes_;
        mesh.observations = observations_;
        mesh.sigmas = sigmas_;
        replace_ply(path, "facet: world frame of the estimate, metres", mesh);
    }

private:
    int index_of(LandmarkId landmark, const Eigen::Vector3f& p) {
        const auto [at, is_new] =
            indices_.try_emplace({landmark.value, p.x(), p.y(), p.z()}, static_cast<int>(vertices_.size()));
        if (is_new) {
            vertices_.push_back(p);
            normals_.push_back(Eigen::Vector3f::Zero());
        }
        return at->second;
    }

    std::pmr::monotonic_buffer_resource nodes_;
    std::pmr::map<std::tuple<std::uint32_t, float, float, float>, int> indices_{&nodes_};
    std::vector<Eigen::Vector3f> vertices_;
    std::vector<Eigen::Vector3f> normals_;
    std::vector<Eigen::Vector3i> triangles_;
    std::vector<std::int32_t> planes_;
    std::vector<std::int32_t> observations_;
    std::vector<float> sigmas_;
};

}  // namespace

void RunMesh::add(const DepartedFace& face) {
    std::array<std::uint32_t, 3> key{face.landmark[0].value, face.landmark[1].value, face.landmark[2].value};
    std::sort(key.begin(), key.end());
    const auto at = by_landmarks_.find(key);
    if (at != by_landmarks_.end()) {
        faces_[at->second] = face;
    } else if (faces_.size() < max_faces_) {
        by_landmarks_.emplace(key, faces_.size());
        faces_.push_back(face);
    } else {
        ++dropped_;
    }
}

void RunMesh::collect(std::span<const DepartedFace> departed) {
    for (const DepartedFace& face : departed) {
        add(face);
    }
}

void RunMesh::write(const Mesher& mesher, const std::string& folder, const PlaneNames& names) {
    const HorizonMesh& mesh = mesher.mesh();
    std::vector<DepartedFace> live;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
            live.push_back(mesher.describe(face));
            if (!face.is_fill) {
                add(live.back());
            }
        }
    }
    IndexedMesh(live, names).write(folder + "/mesh_live.ply");
    write_all(folder + "/mesh_horizon.ply", names);
}

void RunMesh::write_all(const std::string& path, const PlaneNames& names) const {
    IndexedMesh(faces_, names).write(path);
}

}  // namespace facet
