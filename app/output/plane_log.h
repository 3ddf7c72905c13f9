// SPDX-License-Identifier: BSD-2-Clause
// The planes of a run, and their files.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "app/output/plane_names.h"
#include "app/support/named_counter.h"
#include "app/support/text_file.h"
#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"
#include "platform/base/timestamp.h"

namespace facet {

/// The plane finder's counters, for summary.json.
std::vector<NamedCounter> named_counters(const PlaneCounters& counters);

/// planes.csv: a row for every keyframe and plane reported at it, by id. planes.json: every plane of the run as it was
/// when it was known best in the world (least product of the three reported standard deviations: at its last keyframes
/// a plane leaves the view, with few landmarks left), with the regions of its surface, in the format of mesh/README.md.
/// A plane that was found at few keyframes only, and then given up because its landmarks no longer formed one, is taken
/// back: it is in planes.csv, as it was reported, but not in planes.json. Nor is one that later turned out to be
/// another one: that has its surface.
/// planes.ply: these regions, each plane in a colour of its own. World frame of the estimate, metres; n . p = distance;
/// the normal points to the side the plane was seen from. Heap; thread-bound. Throws InputError if a file cannot be
/// written.
class PlaneLog {
public:
    explicit PlaneLog(const std::string& folder);
    /// @param planes  all planes of the finder; those that it does not propose are skipped
    /// @param claims  of each of them, its uncertainty in the world
    /// @param merges  ids that were found to be of one plane since the keyframe before
    void write(Timestamp stamp, std::span<const TrackedPlane> planes, std::span<const PlaneFit> claims,
               std::span<const PlaneMerge> merges = {});
    void flush() { file_.flush(); }
    void close() { file_.close(); }

    /// Which ids of the run are of one plane.
    const PlaneNames& names() const { return names_; }

    /// Writes folder/planes.json and folder/planes.ply.
    /// @param faces  of the whole run; those on a plane make its regions
    void write_planes(const std::string& folder, std::span<const DepartedFace> faces) const;

private:
    struct Record {
        TrackedPlane plane;  ///< as known best, its sigmas those in the world
        Timestamp first;
        Timestamp last;
        int found = 0;            ///< keyframes that had found it when last reported
        bool is_doubted = false;  ///< and whether the last one had not, because of its landmarks
    };

    void unite(const PlaneMerge& merge);
    bool is_taken_back(const Record& record) const;

    TextFile file_;
    PlaneNames names_;
    Timestamp newest_;                           ///< keyframe
    std::vector<const TrackedPlane*> reported_;  ///< while a row is written
    std::map<std::uint32_t, Record> records_;    ///< by id
};

}  // namespace facet
