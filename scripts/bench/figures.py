# SPDX-License-Identifier: BSD-2-Clause
"""Figures of one flight that the columns of a benchmark name. Each is a function of a Run (flying.py) and gives a
number, a text, or None if the flight has none."""
import bisect
import math

from bench.benchmark_lib import state_durations

LEAST_PATH_M = 0.5  # below it a scale means nothing
USED = ("TRACKING", "DEGRADED")


def at(place, factor=1.0, source="eval"):
    """The figure at a place in the evaluation, or in the summary: keys with dots between."""
    def figure(run):
        value = getattr(run, source)
        for key in place.split("."):
            value = value[key]
        return factor * value if isinstance(value, (int, float)) else value
    return figure


def rpe(length_m, part="translation_m", kind="rmse", factor=1e3):
    """A relative error over a length of path."""
    def figure(run):
        entry = next(entry for entry in run.eval["rpe"] if entry["length_m"] == length_m)
        return factor * entry[part][kind]
    return figure


def within(what, tolerance_m):
    """Percent of the mesh, or of the surface, within a tolerance."""
    def figure(run):
        values = run.eval
        for key in what.split("."):
            values = values[key]
        return 100 * values[run.eval["mesh"]["tolerances_m"].index(tolerance_m)]
    return figure


def scale_percent(run):
    return 100 * (run.eval["sim3_scale"] - 1) if run.eval["path_m"] > LEAST_PATH_M else None


def extent(trajectory):
    """Rms distance of a trajectory's places from their centroid (m)."""
    places = [list(map(float, line.split()[1:4])) for line in trajectory.read_text().splitlines()
              if line and not line.startswith("#")]
    centre = [sum(column) / len(places) for column in zip(*places)]
    return math.sqrt(sum((p - c) ** 2 for place in places for p, c in zip(place, centre)) / len(places))


def unscaled_mm(run):
    """ATE without what the best scale s would take away: rmse^2 - (1 - s)^2 extent^2 is left."""
    rmse = run.eval["ate_se3"]["translation_m"]["rmse"]
    lost = (1.0 - run.eval["sim3_scale"]) * extent(run.folder / "trajectory.tum")
    return 1e3 * math.sqrt(max(0.0, rmse * rmse - lost * lost))


def first_s(run):
    """From the first frame to the first estimate to be used."""
    used = next(row for row in run.health if row["state"] in USED)
    return 1e-9 * (int(used["stamp_ns"]) - int(run.health[0]["stamp_ns"]))


def lost_before(run):
    """Frames that were LOST before the first estimate to be used."""
    states = [row["state"] for row in run.health]
    first = next((i for i, state in enumerate(states) if state in USED), len(states))
    return states[:first].count("LOST")


def residual_mean_px(run):
    """The largest absolute mean of the four histograms of residuals.csv."""
    rows = [[float(cell) for cell in row.values()] for row in run.table("residuals.csv")]
    means = [abs(sum(row[0] * row[column] for row in rows) / count) for column in range(1, 5)
             if (count := sum(row[column] for row in rows)) > 0]
    return max(means)


def within_3_sigma(run):
    nees = run.eval["consistency"]["nees"]
    return 100 * (2 * nees["pose"]["within_3_sigma"] + nees["velocity"]["within_3_sigma"]) / 3


def states_s(run):
    """Every state with the time spent in it."""
    return " ".join(f"{state}:{seconds:.1f}" for state, seconds in state_durations(run.health).items())


def rms_of(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def plane_sigmas(run):
    """Errors over reported sigmas of the planes that have a true one: position along the normal, two tilts."""
    return [plane["sigmas"] for plane in run.eval["planes"]["strict"]["planes"] if plane.get("sigmas")]


def planes_within(run):
    """Percent of these planes with all three errors within 3 sigma."""
    planes = plane_sigmas(run)
    return 100 * sum(max(map(abs, sigmas)) <= 3 for sigmas in planes) / len(planes) if planes else None


def frame_errors(run, settle_s=3.0):
    """Rows of errors.csv later than some seconds after the first, each behind whether it is a keyframe: its row of
    health.csv is the nearest in time, as estimates have the IMU's time and health has the stamp of the image."""
    health = sorted((int(row["stamp_ns"]), row["is_keyframe"] == "1") for row in run.health)
    stamps = [stamp for stamp, _ in health]
    frames = []
    for row in run.errors:
        stamp = int(row["stamp_ns"])
        if stamp >= int(run.errors[0]["stamp_ns"]) + settle_s * 1e9:
            place = bisect.bisect(stamps, stamp)
            nearest = min(range(max(0, place - 1), min(len(stamps), place + 1)), key=lambda i: abs(stamps[i] - stamp))
            frames.append((health[nearest][1], row))
    return frames


STRICT = "planes.strict."
MESH = "mesh.by_trajectory."
FIGURES = {
    "path_m": at("path_m"), "drift_percent": at("end_drift_percent"),
    "ate_mm": at("ate_se3.translation_m.rmse", 1e3), "ate_median_mm": at("ate_se3.translation_m.median", 1e3),
    "ate_max_mm": at("ate_se3.translation_m.max", 1e3), "ate_yaw_mm": at("ate_yaw4.translation_m.rmse", 1e3),
    "ate_percent": lambda run: 100 * run.eval["ate_se3"]["translation_m"]["rmse"] / run.eval["path_m"],
    "unscaled_mm": unscaled_mm, "scale_percent": scale_percent,
    "scale_off_percent": lambda run: abs(scale_percent(run)), "scale": at("sim3_scale"),
    "rotation_deg": at("ate_yaw4.rotation_deg.rmse"), "rotation_se3_deg": at("ate_se3.rotation_deg.rmse"),
    "rotation_max_deg": at("ate_se3.rotation_deg.max"),
    "rpe_1m_mm": rpe(1), "rpe_2m_mm": rpe(2), "rpe_5m_percent": rpe(5, "translation_percent", factor=1),
    "rpe_5m_deg_per_m": rpe(5, "rotation_deg_per_m", factor=1),
    "rpe_1m_median_mm": rpe(1, kind="median"), "rpe_2m_median_mm": rpe(2, kind="median"),
    "rpe_5m_median_mm": rpe(5, kind="median"),
    "nees_pose": at("consistency.nees.pose.mean"), "nees_orientation": at("consistency.nees.orientation.mean"),
    "nees_position": at("consistency.nees.position.mean"), "nees_velocity": at("consistency.nees.velocity.mean"),
    "position_lag_ms": at("truth_fit.position_lag_s.value", 1e3),
    "position_lag_sigma_ms": at("truth_fit.position_lag_s.sigma", 1e3),
    "orientation_lag_ms": at("truth_fit.orientation_lag_s.value", 1e3),
    "orientation_lag_sigma_ms": at("truth_fit.orientation_lag_s.sigma", 1e3),
    "position_fitted_mm": at("truth_fit.position_rmse_m", 1e3),
    "position_swift_mm": at("truth_fit.position_swift_rmse_m", 1e3),
    "rotation_fitted_deg": at("truth_fit.orientation_rmse_rad", math.degrees(1)),
    "rotation_swift_deg": at("truth_fit.orientation_swift_rmse_rad", math.degrees(1)),
    "nees_pose_fitted": at("consistency_with_fit.nees.pose.mean"),
    "within_3_sigma": within_3_sigma, "residual_mean_px": residual_mean_px,
    "time_percent": at("coverage.time", 100), "frames_percent": at("coverage.frame_share", 100),
    "first_s": first_s, "init_s": lambda run: state_durations(run.health).get("INIT", 0.0), "lost_before": lost_before,
    "resets": lambda run: int(run.health[-1]["reset_counter"]), "end": at("final.state", source="summary"),
    "states_s": states_s,
    "mesh_cm": at(MESH + "accuracy_m.median", 100), "mesh_p90_cm": at(MESH + "accuracy_m.p90", 100),
    "mesh_5cm": within(MESH + "accuracy_m.within", 0.05), "mesh_10cm": within(MESH + "accuracy_m.within", 0.1),
    "complete_5cm": within(MESH + "completeness_m.within", 0.05),
    "complete_10cm": within(MESH + "completeness_m.within", 0.1), "f1_10cm": within(MESH + "f1", 0.1),
    "icp_cm": at("mesh.by_icp.accuracy_m.median", 100), "icp_10cm": within("mesh.by_icp.accuracy_m.within", 0.1),
    "holes_percent": lambda run: 100 * run.eval["mesh"]["flat_holes"]["share"]
    if run.eval["mesh"]["flat_holes"]["planes"] else None,
    "longest_m": at("mesh.longest_side_m"), "faces": at("mesh.faces"), "area_m2": at("mesh.area_m2"),
    "overlap": at("mesh.overlap"), "live_faces": at("mesh.faces_max", source="summary"),
    "frame_ms": at("timing.processor.all.mean", source="summary"),
    "frame_p99_ms": at("timing.processor.all.p99", source="summary"),
    "flat_median_mm": at("mesh.flat_accuracy_m.median", 1e3), "flat_mean_mm": at("mesh.flat_accuracy_m.mean", 1e3),
    "uneven_median_mm": at("mesh.uneven_accuracy_m.median", 1e3),
    "planes_right": at(STRICT + "right"), "planes_found": at(STRICT + "found"),
    "plane_position_rms": lambda run: rms_of([sigmas[0] for sigmas in plane_sigmas(run)]),
    "plane_tilt_rms": lambda run: rms_of([value for sigmas in plane_sigmas(run) for value in sigmas[1:]]),
    "planes_within_percent": planes_within,
    "planes_recall": lambda run: run.eval["planes"]["strict"]["recall"]
    if run.eval["planes"]["strict"]["wanted"] else None,
    "planes_area_recall": lambda run: run.eval["planes"]["strict"]["area_recall"]
    if run.eval["planes"]["strict"]["wanted"] else None,
}
for _part in ("all", "in_view"):
    for _share in ("missed", "false_obstacle", "phantom", "unknown"):
        FIGURES[f"rays_{_part}_{_share}"] = at(f"obstacles.{_part}.{_share}", 100)
for _share in ("missed", "false_obstacle", "unknown"):
    FIGURES[f"sweeps_{_share}"] = at(f"sweeps.{_share}", 100)
for _kind in ("obstacles", "sweeps"):
    for _share in ("median", "p90"):
        FIGURES[f"{_kind}_{_share}_cm"] = at(f"{_kind}.{_share}_error_m", 100)


def figure_of(run, figure):
    """What a figure is of this flight; None where its files have nothing of it."""
    if run is None or not run.has_result:
        return None
    try:
        value = figure(run)
    except (KeyError, TypeError, IndexError, StopIteration, ValueError, ZeroDivisionError, FileNotFoundError):
        return None
    return None if isinstance(value, float) and not math.isfinite(value) else value
