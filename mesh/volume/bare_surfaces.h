// SPDX-License-Identifier: BSD-2-Clause
// Planes through the parts of an image that have no texture.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/volume/surface_patches.h"
#include "platform/base/image_view.h"

namespace facet {

/// Gives squares without texture, in which nothing can be matched, the plane that their surroundings speak for. Squares
/// of even grey that run on without a step in it are taken for one region, since few edges in depth show none in grey.
/// A plane is laid through the patches at the region's rim; others of them may lie before it (what stands before a
/// wall), but hardly any behind. A square is filled if, seen from it across the region, rim patches on that plane lie
/// to opposite sides. Filled patches are marked as inferred, and report no more than how far the rim may lie off it.
/// What is less certain than the mesh demands is not filled, since views that infer from one rim err alike.
/// Heap in the constructor only. Thread-bound. Deterministic.
class BareSurfaces {
public:
    /// @param raster  borrowed
    BareSurfaces(const SquareRaster& raster, const SquareLayout& layout);

    /// Sets the patches' grey. @param image    from which the patches come
    /// @param patches  of each square, row by row; borrowed until advance() is false
    void begin(const ImageView& image, std::vector<SurfacePatch>& patches);
    /// Regions whose first square is among the next. @return whether there are more squares
    bool advance(int squares);

private:
    /// A measured square beside a region.
    struct RimPatch {
        int square = 0;
        Eigen::Vector3d ray = Eigen::Vector3d::Zero();  ///< (x, y, 1)
        double rho = 0.0;                               ///< 1 / Z
        double sigma = 0.0;                             ///< of that
    };
    /// n . (x, y, 1) = 1 / Z.
    struct RimPlane {
        Eigen::Vector3d n = Eigen::Vector3d::Zero();
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    };

    void measure(const ImageView& image, int i);
    int beside(int i, int direction) const;
    void grow(int first);
    int rim_from(int i, int direction) const;
    void find_rim();
    double before(const RimPatch& rim, const Eigen::Vector3d& n) const;
    bool find_plane(RimPlane& plane) const;
    bool refine(RimPlane& plane) const;
    void fill();
    void set(int i, const RimPlane& plane);
    bool finds_plane(int i, int direction) const;
    bool is_enclosed(int i) const;

    const SquareRaster& raster_;
    SquareLayout layout_;
    std::vector<SurfacePatch>* patches_ = nullptr;
    int next_ = 0;
    std::vector<double> mean_;  ///< grey of each square
    std::vector<bool> is_bare_;
    std::vector<int> region_;     ///< the first square of each one's; -1: none
    std::vector<int> members_;    ///< of the region that is looked at,
    std::vector<int> found_;      ///< the squares at its rim,
    std::vector<bool> is_found_;  ///< each once,
    std::vector<RimPatch> rim_;
    std::vector<bool> is_on_;  ///< the plane that is looked at
};

}  // namespace facet
