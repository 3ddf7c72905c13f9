// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/place_argument.h"

#include "app/output/map_file.h"

namespace facet {

std::vector<MappedPlace> PlaceArguments::known() const {
    return load.empty() ? std::vector<MappedPlace>() : read_map(load);
}

void add_place_options(CLI::App& command, const char* purpose, PlaceArguments& arguments) {
    command.add_flag("--places", arguments.keep, purpose);
    command
        .add_option("--map", arguments.load,
                    "Places of an earlier flight (--save-map), in whose frame this one is located; implies --places")
        ->type_name("FILE");
    command.add_option("--save-map", arguments.save, "Write the places at the end into this file; implies --places")
        ->type_name("FILE");
}

void save_places(const PlaceArguments& arguments, const PlaceMemory* places) {
    if (!arguments.save.empty() && places != nullptr) {
        write_map(arguments.save, *places);
    }
}

}  // namespace facet
