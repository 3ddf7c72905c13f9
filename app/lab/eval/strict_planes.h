// SPDX-License-Identifier: BSD-2-Clause
// Planes found in a run, judged strictly: is there what they say, where they say it, once?
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"
#include "app/lab/eval/plane_surface.h"

namespace facet {

struct StrictOptions {
    double angle_deg = 2.0;       ///< most between the normals of estimate and truth
    double offset_m = 0.03;       ///< most between the estimate and the true surface
    double overlap = 0.5;         ///< least share of the estimate's surface that is true surface
    double wanted_seen_m2 = 0.5;  ///< a true plane of any tilt has to be found from so much seen surface on
};

enum class StrictCause : std::uint8_t {
    kRight,
    kNoSurface,  ///< less of its surface than `overlap` is true
    kOff,        ///< no plane of the scene under it, or at half of its keyframes and more beyond the limits
    kDuplicate,  ///< an estimate with a lower id is of the same plane
};

const char* to_string(StrictCause cause);

/// What was found of one estimate.
struct StrictVerdict {
    std::uint32_t id = 0;
    StrictCause cause = StrictCause::kRight;
    int truth = -1;  ///< the true plane that it is of, or else comes nearest to within 10 degrees and 15 cm; -1: none
    double share = 0.0;  ///< of its surface that is true
    int keyframes = 0;   ///< at which it was reported,
    int right = 0;       ///< and within the limits of the plane that it is right at most often
    /// As known best, in planes.json, against `truth`; none without either.
    std::optional<PlaneError> error;
};

/// A true plane that is found is right once: all but one of several estimates of it are wrong.
struct StrictPlanes {
    int found = 0;
    int right = 0;
    int taken_back = 0;  ///< reported during the run, but not in its planes.json: neither found nor wrong
    int wanted = 0;
    int wanted_found = 0;
    double wanted_m2 = 0.0;  ///< seen area of the target planes,
    double found_m2 = 0.0;   ///< and of those found
    int confident = 0;       ///< wrong ones that are off by more than three of their own sigmas, or near no plane
    std::vector<StrictVerdict> verdicts;  ///< of all found, by id
    double precision() const { return found > 0 ? static_cast<double>(right) / found : 0.0; }
    double recall() const { return wanted > 0 ? static_cast<double>(wanted_found) / wanted : 0.0; }
    double area_recall() const { return wanted_m2 > 0.0 ? found_m2 / wanted_m2 : 0.0; }
};

/// An estimate is right if
///   * at least `overlap` of its surface lies within `offset_m` of true surface that is turned like it, and some of
///     that belongs to a plane of the scene: surface in one plane, such as the backs of a row of books or a wall on
///     both sides of a door, may be several of these;
///   * at more than half of its keyframes its normal and the centroid of its landmarks are within the limits of one of
///     them, always the same;
///   * no other estimate is of that plane.
/// A plane without regions, or of a run without planes.json, is taken for a disc of its area; one that is not in that
/// file has been taken back. @param surfaces  by planes.json, if there is one
/// @param tree     of the scene's surface
/// @param seen_m2  area of each true plane that the flight has seen. Heap. Reentrant.
StrictPlanes judge_strictly(const std::vector<PlaneRow>& rows, const std::optional<PlaneSurfaces>& surfaces,
                            const SceneTruth& truth, const TriangleTree& tree, const Se3& T_true_est,
                            const std::vector<double>& seen_m2, const StrictOptions& options = {});

}  // namespace facet
