// SPDX-License-Identifier: BSD-2-Clause
// --places, --map FILE and --save-map FILE of run and replay.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "mesh/places/place_memory.h"

namespace facet {

/// What the user typed.
struct PlaceArguments {
    bool keep = false;
    std::string load;  ///< file of a map; empty: none
    std::string save;

    bool any() const { return keep || !load.empty() || !save.empty(); }
    /// The places of the map, or none. Throws InputError if it cannot be read.
    std::vector<MappedPlace> known() const;
};

/// @param purpose  what --places is for here
void add_place_options(CLI::App& command, const char* purpose, PlaceArguments& arguments);

/// Writes the map if one is to be saved. Throws InputError if it cannot be written.
void save_places(const PlaceArguments& arguments, const PlaceMemory* places);

}  // namespace facet
