// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/map_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <memory>
#include <string>

#include "app/commands/run_guarded.h"
#include "app/output/map_file.h"
#include "app/support/console.h"

namespace facet {
namespace {

int show_map(const std::string& path) {
    const std::vector<MappedPlace> places = read_map(path);
    std::size_t points = 0;
    Eigen::Vector3d least = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector3d most = -least;
    Timestamp first{std::numeric_limits<std::int64_t>::max()};
    Timestamp last{std::numeric_limits<std::int64_t>::min()};
    for (const MappedPlace& place : places) {
        points += place.view.points.size();
        least = least.cwiseMin(place.T_M_K.p);
        most = most.cwiseMax(place.T_M_K.p);
        first = std::min(first, place.view.stamp);
        last = std::max(last, place.view.stamp);
    }
    print_out("places       {} of at most {}, {} points\n", places.size(), kMaxPlaces, points);
    if (!places.empty()) {
        print_out("extent       x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m, z {:.2f} to {:.2f} m\n", least.x(),
                  most.x(), least.y(), most.y(), least.z(), most.z());
        print_out("views        from {} to {} ns\n", first.ns, last.ns);
    }
    return kExitDone;
}

}  // namespace

void add_map_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("map", "Show what a map of places holds (facet replay --save-map)");
    auto path = std::make_shared<std::string>();
    command->add_option("FILE", *path, "Map of places")->required();
    command->footer("Exit codes: 0 done; 2 bad usage or input.");
    command->callback([path, &exit_code] { exit_code = run_guarded([&] { return show_map(*path); }); });
}

}  // namespace facet
