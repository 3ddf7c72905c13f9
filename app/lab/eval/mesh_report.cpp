// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/mesh_report.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const DistanceStatistics& s) {
    if (s.count == 0) {
        return nullptr;
    }
    return {{"count", s.count}, {"median", s.median}, {"mean", s.mean},
            {"rmse", s.rmse},   {"p90", s.p90},       {"within", s.within}};
}

Json to_json(const MeshRow& row) {
    Json f1 = Json::array();
    for (std::size_t i = 0; i < kMeshTolerances.size(); ++i) {
        f1.push_back(row.f1(i));
    }
    const Se3& t = row.T_true_est;
    return {{"alignment", row.alignment},
            {"accuracy_m", to_json(row.accuracy)},
            {"completeness_m", to_json(row.completeness)},
            {"f1", f1},
            {"transform", {{"p", {t.p.x(), t.p.y(), t.p.z()}}, {"q_xyzw", {t.q.x(), t.q.y(), t.q.z(), t.q.w()}}}}};
}

std::string shares(const char* name, const std::array<double, kMeshTolerances.size()>& within) {
    std::string text = fmt::format("  {:<13}", name);
    for (const double share : within) {
        text += fmt::format(" {:7.1f}", 100.0 * share);
    }
    return text + "  %\n";
}

std::string rows(const MeshRow& row) {
    const DistanceStatistics& a = row.accuracy;
    std::array<double, kMeshTolerances.size()> f1{};
    for (std::size_t i = 0; i < f1.size(); ++i) {
        f1[i] = row.f1(i);
    }
    return fmt::format("Mesh, alignment by {}\n", row.alignment) +
           fmt::format("  distance      median {:.4f}  mean {:.4f}  RMSE {:.4f}  p90 {:.4f} m\n", a.median, a.mean,
                       a.rmse, a.p90) +
           "  within            1 cm    2 cm    5 cm   10 cm   20 cm   50 cm\n" + shares("accuracy", a.within) +
           shares("completeness", row.completeness.within) + shares("F1", f1);
}

}  // namespace

std::string text_report(const MeshEvaluation& e) {
    std::string text =
        fmt::format(
            "\nmesh         {} faces, {:.1f} m^2, longest side {:.2f} m; scene seen {:.1f} m^2; overlap {:.2f}\n",
            e.faces, e.area_m2, e.longest_side_m, e.seen_area_m2, e.overlap()) +
        rows(e.by_trajectory) + rows(e.by_icp) + (e.icp_converged ? "" : "  (ICP did not converge)\n");
    for (const auto& [name, s] : {std::pair{"floors, walls", e.flat}, std::pair{"elsewhere", e.uneven}}) {
        if (s.count > 0 && e.flat.count > 0) {
            text += fmt::format("  {:<13} median {:.4f}  mean {:.4f}  RMSE {:.4f}  p90 {:.4f} m\n", name, s.median,
                                s.mean, s.rmse, s.p90);
        }
    }
    if (e.holes.planes > 0) {
        text += fmt::format("holes        {:.2f} % of {:.1f} m^2 on {} true planes\n", 100.0 * e.holes.share(),
                            e.holes.covered_m2 + e.holes.hole_m2, e.holes.planes);
    }
    return text;
}

std::string json_report(const MeshEvaluation& e, const std::string& mesh, const std::string& scene) {
    Json json = {{"mesh", mesh},
                 {"scene", scene},
                 {"faces", e.faces},
                 {"area_m2", e.area_m2},
                 {"longest_side_m", e.longest_side_m},
                 {"seen_area_m2", e.seen_area_m2},
                 {"covered_m2", e.covered_m2},
                 {"overlap", e.overlap()},
                 {"tolerances_m", kMeshTolerances},
                 {"by_trajectory", to_json(e.by_trajectory)},
                 {"by_icp", to_json(e.by_icp)},
                 {"icp_converged", e.icp_converged},
                 {"flat_accuracy_m", to_json(e.flat)},
                 {"uneven_accuracy_m", to_json(e.uneven)},
                 {"flat_holes",
                  {{"planes", e.holes.planes},
                   {"covered_m2", e.holes.covered_m2},
                   {"hole_m2", e.holes.hole_m2},
                   {"share", e.holes.share()}}}};
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string text_report(const PlaneEvaluation& e) {
    std::string text =
        fmt::format("\nplanes       {} found, {} right: precision {:.3f}; {} of {} true ones found: recall {:.3f}\n",
                    e.found.size(), e.right, e.precision(), e.wanted_found, e.wanted, e.recall()) +
        fmt::format(
            "             reported {} times, {} correct; of these normal median {:.2f}, p90 {:.2f} deg, {:.1f} % good; "
            "offset median {:.1f}, p90 {:.1f} cm, {:.1f} % good\n",
            e.told, e.told_right, e.median_angle_deg, e.p90_angle_deg, 100.0 * e.good_angle, 100.0 * e.median_offset_m,
            100.0 * e.p90_offset_m, 100.0 * e.good_offset) +
        fmt::format(
            "    strictly {} of {} right, {} wrong by more than 3 sigmas, {} taken back: precision {:.3f}; {} of {} "
            "true ones found: recall "
            "{:.3f}, by area {:.3f}\n",
            e.strict.right, e.strict.found, e.strict.confident, e.strict.taken_back, e.strict.precision(),
            e.strict.wanted_found, e.strict.wanted, e.strict.recall(), e.strict.area_recall()) +
        "  true plane           in view m^2  for s  keyframes  ids\n";
    for (const TruePlaneResult& t : e.truths) {
        if (t.is_wanted || t.keyframes > 0) {
            text +=
                fmt::format("  {:<20} {:11.1f} {:6.1f} {:10} {:4}{}\n", t.name, t.area_m2, t.seen_s, t.keyframes, t.ids,
                            !t.is_wanted       ? "  not asked for"
                            : t.keyframes == 0 ? "  MISSED"
                                               : "");
        }
    }
    text += "  found id  keyframes  right  true plane            angle deg  offset cm\n";
    for (const FoundPlaneResult& f : e.found) {
        const bool is_right = f.last.truth >= 0;
        const std::string name = is_right ? e.truths[static_cast<std::size_t>(f.last.truth)].name : "-";
        text += fmt::format("  {:8} {:10} {:6}  {:<20} {:10.2f} {:10.1f}\n", f.id, f.keyframes, f.right, name,
                            f.last.angle_deg, 100.0 * f.last.offset_m);
    }
    return text;
}

namespace {

/// What was found of each plane.
Json strict_planes(const PlaneEvaluation& e) {
    Json planes = Json::array();
    for (const StrictVerdict& v : e.strict.verdicts) {
        Json plane = {{"id", v.id},       {"verdict", to_string(v.cause)}, {"true_plane", v.truth},
                      {"share", v.share}, {"keyframes", v.keyframes},      {"right", v.right}};
        if (v.truth >= 0) {
            plane["name"] = e.truths[static_cast<std::size_t>(v.truth)].name;
            plane["seen_m2"] = e.truths[static_cast<std::size_t>(v.truth)].seen_m2;
        }
        if (v.error.has_value()) {
            plane["angle_deg"] = v.error->angle_deg;
            plane["offset_m"] = v.error->offset_m;
            plane["sigmas"] = {v.error->sigmas[0], v.error->sigmas[1], v.error->sigmas[2]};
        }
        planes.push_back(std::move(plane));
    }
    return planes;
}

}  // namespace

std::string json_report(const PlaneEvaluation& e, const std::string& planes) {
    Json truths = Json::array();
    for (const TruePlaneResult& t : e.truths) {
        if (t.is_wanted || t.keyframes > 0) {
            truths.push_back({{"name", t.name},
                              {"area_in_view_m2", t.area_m2},
                              {"seen_s", t.seen_s},
                              {"is_wanted", t.is_wanted},
                              {"keyframes", t.keyframes},
                              {"ids", t.ids}});
        }
    }
    Json found = Json::array();
    for (const FoundPlaneResult& f : e.found) {
        const bool is_right = f.last.truth >= 0;
        found.push_back({{"id", f.id},
                         {"keyframes", f.keyframes},
                         {"right", f.right},
                         {"true_plane", is_right ? e.truths[static_cast<std::size_t>(f.last.truth)].name : ""},
                         {"angle_deg", f.last.angle_deg},
                         {"offset_m", f.last.offset_m}});
    }
    const Json json = {
        {"planes", planes},
        {"found", e.found.size()},
        {"right", e.right},
        {"precision", e.precision()},
        {"wanted", e.wanted},
        {"wanted_found", e.wanted_found},
        {"recall", e.recall()},
        {"strict",
         {{"found", e.strict.found},
          {"right", e.strict.right},
          {"precision", e.strict.precision()},
          {"wanted", e.strict.wanted},
          {"wanted_found", e.strict.wanted_found},
          {"recall", e.strict.recall()},
          {"area_recall", e.strict.area_recall()},
          {"confident", e.strict.confident},
          {"taken_back", e.strict.taken_back},
          {"planes", strict_planes(e)}}},
        {"told", e.told},
        {"told_right", e.told_right},
        {"angle_deg", {{"median", e.median_angle_deg}, {"p90", e.p90_angle_deg}, {"good", e.good_angle}}},
        {"offset_m", {{"median", e.median_offset_m}, {"p90", e.p90_offset_m}, {"good", e.good_offset}}},
        {"true_planes", truths},
        {"found_planes", found}};
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace facet
