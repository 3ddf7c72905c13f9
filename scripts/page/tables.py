# SPDX-License-Identifier: BSD-2-Clause
"""The tables of the report, as HTML."""
import bisect
import html
import json
import pathlib
import statistics

CM = 100.0
OPTIMIZATION = ("triangulation", "linearization", "solve", "marginalization")
PLANES = ((0, 0), (1, 9), (10, 1000))
PUBLISHED = pathlib.Path(__file__).resolve().parent / "published.json"


def cell(value, digits, factor=1.0):
    """A number, or a dash if there is none."""
    return "\u2013" if value is None else f"{factor * value:.{digits}f}"


def table(columns, rows, caption, left=1, head=None):
    """A table whose first `left` columns hold text; `head` is a row of (text, columns) above the headings."""
    def tag(index):
        return ' class="left"' if index < left else ""
    above = "" if head is None else "<tr>" + "".join(f'<th colspan="{span}" class="group">{html.escape(text)}</th>'
                                                     for text, span in head) + "</tr>"
    names = "".join(f"<th{tag(i)}>{html.escape(name)}</th>" for i, name in enumerate(columns))
    lines = "".join("<tr>" + "".join(f"<td{tag(i)}>{html.escape(text)}</td>" for i, text in enumerate(row)) + "</tr>"
                    for row in rows)
    return (f'<figure class="table"><figcaption>{caption}</figcaption><div class="scroll"><table>'
            f"<thead>{above}<tr>{names}</tr></thead><tbody>{lines}</tbody></table></div></figure>")


def runs_of(sequences):
    """Every run with its sequence."""
    return [(sequence, run) for sequence in sequences for run in sequence.runs]


def is_evaluated(sequences):
    """Whether any run was compared with ground truth."""
    return any(run.figure("ate_se3") for _, run in runs_of(sequences))


def paper_table(sequences):
    """Median and RMSE of the ATE for each mode, in the form of the paper's table."""
    labels = list(dict.fromkeys(run.label for _, run in runs_of(sequences)))
    rows = []
    for sequence in sequences:
        by_label = {run.label: run for run in sequence.runs}
        errors = [by_label[label].figure("ate_se3", "translation_m") if label in by_label else None
                  for label in labels]
        path = next((run.figure("path_m") for run in sequence.runs if run.figure("path_m")), None)
        rows.append([sequence.name, cell(path, 1)] + [
            cell(error.get(key) if error else None, 2, CM) for error in errors for key in ("median", "rmse")])
    columns = ["sequence", "path (m)"] + [name for _ in labels for name in ("median (cm)", "RMSE (cm)")]
    return table(columns, rows, "<b>Absolute translation error</b> after alignment by SE(3), without scale; every "
                 "frame as it came out, nothing smoothed afterwards", head=[("", 2)] + [(label, 2) for label in labels])


def published_table(sequences):
    """Our figures and those of others, for the sequences that are EuRoC's as a whole; nothing if none is.

    A run whose euroc.txt names a sequence is of that one: scripts/evaluate writes it.
    """
    published = json.loads(PUBLISHED.read_text(encoding="utf-8"))
    real = {run.euroc: sequence for sequence, run in runs_of(sequences) if run.euroc in published["sequences"]}
    names = [name for name in published["sequences"] if name in real]
    if not names:
        return ""
    rows = []
    for label in dict.fromkeys(run.label for sequence in real.values() for run in sequence.runs):
        by_name = {name: next((run for run in real[name].runs if run.label == label), None) for name in names}
        errors = [run.figure("ate_se3", "translation_m", "rmse") if run else None for run in by_name.values()]
        rows.append([f"facet, {label}"] + [cell(error, 3) for error in errors])
    places = [published["sequences"].index(name) for name in names]
    rows += [[f"{system['name']} [{system['source']}]"] + [cell(system["rmse_m"][place], 3) for place in places]
             for system in published["systems"]]
    sources = "; ".join(f"[{number}] {html.escape(source)}" for number, source in
                        enumerate(published["sources"], start=1))
    return table(["ATE RMSE (m)", *names], rows, "<b>EuRoC, beside what others have published</b>: whole sequences, "
                 f"alignment by SE(3); ours causal. {sources}")


def accuracy_table(sequences):
    """Other figures of the trajectory."""
    rows = []
    for sequence, run in runs_of(sequences):
        if not run.figure("ate_se3"):
            continue
        share = run.figure("coverage", "frame_share")
        nees = run.figure("consistency", "nees")
        parts = [(nees.get(part) or {}).get("mean") if nees else None for part in ("pose", "velocity")]
        rows.append([sequence.name, run.label, cell(run.figure("ate_se3", "translation_m", "max"), 2, CM),
                     cell(run.figure("ate_yaw4", "rotation_deg", "rmse"), 2), cell(run.figure("end_drift_percent"), 3),
                     cell(share if share is not None else run.figure("coverage", "time"), 1, 100.0),
                     cell(parts[0], 1), cell(parts[1], 1)])
    traps = json.loads(PUBLISHED.read_text(encoding="utf-8"))["traps"]
    notes = "".join(f"; {name}: {html.escape(trap)}" for name, trap in traps.items()
                    if any(run.euroc == name for _, run in runs_of(sequences)))
    return table(["sequence", "mode", "ATE max (cm)", "rotation RMSE (deg)", "drift (% of path)", "coverage (%)",
                  "pose NEES", "velocity NEES"], rows, "<b>Trajectory</b>; NEES is 6 for the pose and 3 for the "
                 f"velocity if the reported covariance is honest, more if it is too small{notes}", left=2)


def mesh_table(sequences):
    """Mesh and planes against the true scene, or their counts without one."""
    rows = []
    for sequence, run in runs_of(sequences):
        accuracy = run.figure("mesh", "by_trajectory", "accuracy_m")
        completeness = run.figure("mesh", "by_trajectory", "completeness_m")
        within = dict(zip(run.figure("mesh", "tolerances_m") or [], zip(*(
            part["within"] for part in (accuracy, completeness) if part)))) if accuracy else {}
        at = within.get(0.05, (None, None))
        planes = run.evaluation.get("planes") if run.evaluation else None
        found = len(set(run.planes["id"])) if run.planes else None
        rows.append([sequence.name, run.label, str(run.summary.get("mesh", {}).get("run_faces", "\u2013")),
                     cell(accuracy and accuracy["median"], 2, CM), cell(accuracy and accuracy["p90"], 1, CM),
                     cell(at[0], 1, 100.0), cell(at[1], 1, 100.0), "\u2013" if found is None else str(found),
                     cell(planes["precision"] if planes and planes["found"] else None, 2),
                     cell(planes and planes["recall"], 2)])
    return table(["sequence", "mode", "faces", "median (cm)", "p90 (cm)", "within 5 cm (%)", "complete to 5 cm (%)",
                  "planes", "precision", "recall"], rows,
                 "<b>Mesh and planes</b>: distance to the true surface, aligned by the trajectory", left=2)


def time_table(sequences):
    """Times of a frame and what the run was."""
    rows = []
    for sequence, run in runs_of(sequences):
        timing = run.summary.get("timing", {})
        figures = [(timing.get(kind) or {}).get(key) for kind in ("tracked", "keyframe") for key in ("median", "p99")]
        states = run.summary.get("frames_by_state", {})
        bad = sum(states.get(name, 0) for name in ("DEGRADED", "LOST"))
        rows.append([sequence.name, run.label, str(run.summary.get("frames", "\u2013")),
                     str(run.summary.get("keyframes", "\u2013")), *(cell(value, 1) for value in figures), str(bad),
                     str(run.summary.get("warnings", "\u2013"))])
    return table(["sequence", "mode", "frames", "keyframes", "frame median (ms)", "p99", "keyframe median (ms)", "p99",
                  "degraded or lost", "warnings"], rows, "<b>Time and health</b>; times are of this computer under the "
                 "load that it had", left=2)


def optimization_times(run):
    """CPU times of optimizations (ms), each with the number of planes that the window held then."""
    held = {}
    for stamp, is_held in zip(run.planes["stamp_ns"], run.planes["is_held"]) if run.planes else []:
        held[stamp] = held.get(stamp, 0) + int(is_held)
    stamps = sorted(held)
    spent = zip(*(run.timing[f"{stage}_cpu_ms"] for stage in OPTIMIZATION))
    return [(held[stamps[at - 1]] if (at := bisect.bisect_left(stamps, stamp)) else 0, sum(parts))
            for stamp, parts in zip(run.timing["stamp_ns"], spent) if sum(parts) > 0.0]


def optimization_table(sequences):
    """Time of an optimization by the number of planes in it; nothing if no run holds planes."""
    rows = []
    for sequence, run in runs_of(sequences):
        if not run.timing or f"{OPTIMIZATION[0]}_cpu_ms" not in run.timing:
            continue
        times = optimization_times(run)
        row = [sequence.name, run.label]
        for least, most in PLANES:
            part = [ms for planes, ms in times if least <= planes <= most]
            row += [str(len(part)), cell(statistics.median(part) if part else None, 1)]
        rows.append(row)
    if not any(row[4] != "0" or row[6] != "0" for row in rows):
        return ""
    heads = ["no plane", f"1 to {PLANES[1][1]} planes", f"{PLANES[2][0]} planes and more"]
    return table(["sequence", "mode", *("keyframes", "median (ms)") * 3], rows, "<b>Time of an optimization by the "
                 "planes in it</b>: CPU time of triangulation, linearization, solution and marginalization",
                 left=2, head=[("", 2), *((name, 2) for name in heads)])


def corrections_table(run):
    """What the calibration was corrected by, with its standard deviation, at the end of a run."""
    given = run.summary.get("calibration_corrections")
    if not given:
        return ""
    rows = []
    for side in ("left", "right"):
        for key, names in (("focal_relative", ("fx", "fy")), ("principal_point_px", ("cx", "cy")),
                           ("distortion", ("k1", "k2", "p1", "p2"))):
            values, sigmas = (given.get(part, {}).get(key, []) for part in (side, side + "_sigma"))
            factor, unit = {"focal_relative": (100.0, "%"), "principal_point_px": (1.0, "px"),
                            "distortion": (1e4, "1e-4")}[key]
            rows += [[f"{side} {name}", unit, f"{factor * v:+.4f}", f"{factor * s:.4f}"]
                     for name, v, s in zip(names, values, sigmas)]
    final = run.summary.get("final", {})
    for name, source, key, factor, unit in (
            ("cameras turned", final, "camera_turned", 1.0, "deg"), ("cameras moved", final, "camera_moved", 1e3, "mm"),
            ("right turned", given, "right_turned", 1.0, "deg"), ("right moved", given, "right_moved", 1e3, "mm")):
        ending = "_deg" if unit == "deg" else "_m"
        rows += [[f"{name} {axis}", unit, f"{factor * v:+.4f}", f"{factor * s:.4f}"] for axis, v, s in
                 zip("xyz", source.get(key + ending, []), source.get(key + "_sigma" + ending, []))]
    return table(["parameter", "unit", "correction", "sigma"], rows,
                 f"<b>Calibration at the end</b>, {html.escape(run.label)}: corrections of what was given", left=2)
