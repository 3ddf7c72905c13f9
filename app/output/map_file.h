// SPDX-License-Identifier: BSD-2-Clause
// Files of remembered places.
#pragma once

#include <string>
#include <vector>

#include "mesh/places/place_memory.h"

namespace facet {

/// A map's file: "facetmap", a version, the number of places, the places, and a checksum of all that (FNV-1a, 64 bits).
/// Numbers are little-endian. A place is the stamp of its view (ns), its yaw (rad) and position (m) in the map, the
/// camera's attitude (x y z w) and median depth (m), the number of points, and for each its position in the place's
/// frame (m), the relative sigma of its distance, the octave, two codes of 32 bytes and a patch of 144.

/// Places whose pose in the map is known. Throws InputError naming the path if it cannot be written; an older file then
/// stays as it was. Heap.
void write_map(const std::string& path, const PlaceMemory& places);

/// Throws InputError naming the path if it cannot be read, is no map, is of another version, is damaged (length,
/// checksum), has more than kMaxPlaces places, or has a value that no map can have. Heap: at most 62 MB.
std::vector<MappedPlace> read_map(const std::string& path);

}  // namespace facet
