# SPDX-License-Identifier: BSD-2-Clause
"""The charts of one sequence, all runs in each. A figure that its files are missing for is left out."""
import dataclasses
import statistics

from page.chart import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Chart, padded, picture

STAGES = ["propagation", "tracking", "frame_update", "triangulation", "linearization", "solve", "marginalization",
          "landmarks", "mesh", "planes", "depth"]
STATES = {"INIT": "state-init", "TRACKING": "state-tracking", "DEGRADED": "state-degraded", "LOST": "state-lost"}
CM, DEG = 100.0, 57.29577951308232
TIME = "time (s)"
BAR_HEIGHT = 12  # at least, so that the figures behind neighbours stay apart


@dataclasses.dataclass
class Figure:
    """A picture with its caption; `scale` is the unit and the upper end of the colour scale, if it has one."""
    title: str
    note: str
    svg: str
    scale: str = ""
    legend: bool = True


def runs_with(sequence, attribute):
    """Index and run of those that have a table."""
    return [(index, run) for index, run in enumerate(sequence.runs) if getattr(run, attribute)]


def quantile(ordered, share):
    """Quantile of sorted values, interpolated linearly."""
    place = share * (len(ordered) - 1)
    low = int(place)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (place - low) * (ordered[high] - ordered[low])


def time_range(sequence):
    """From the first estimate to the last."""
    last = max(run.trajectory["stamp_ns"][-1] for run in sequence.runs)
    return 0.0, max(1e-9 * (last - sequence.begin_ns), 0.1)


def fitted(xs, ys, width, height):
    """Ranges of x and y with one scale, whose picture is `width` by `height`."""
    (x0, x1), (y0, y1) = padded(xs), padded(ys)
    scale = max((x1 - x0) / width, (y1 - y0) / height)
    return tuple(((low + high - scale * size) / 2, (low + high + scale * size) / 2)
                 for low, high, size in ((x0, x1, width), (y0, y1, height)))


def colour_limit(sequence):
    """Upper end of the colour scale of errors (cm): what 98 % of all samples are below."""
    errors = sorted(error for _, run in runs_with(sequence, "ate") for error in run.ate["error_m"])
    return max(CM * quantile(errors, 0.98), 0.01) if errors else None


def draw_view(run, index, axes, limit):
    """The path from one side, coloured by its error if that is known."""
    if run.ate:
        true = [run.ate["true_" + axis] for axis in axes]
        path = [run.ate[axis] for axis in axes]
    else:
        true, path = None, [run.trajectory["p" + axis] for axis in axes]
    x, y = fitted(path[0], path[1], WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM)
    chart = Chart(x, y, f"{axes[0]} (m)", f"{axes[1]} (m)")
    if true:
        chart.line(*true, "truth", thin=False)
        chart.coloured_line(*path, [CM * error / limit for error in run.ate["error_m"]])
    else:
        chart.line(*path, f"run{index}", thin=False)
    chart.dot(path[0][0], path[1][0], "start")
    return chart


def paths(sequence):
    """Trajectory from above and from the side."""
    limit = colour_limit(sequence)
    for index, run in enumerate(sequence.runs):
        for axes, name in (("xy", "from above"), ("xz", "from the side")):
            note = ("error after alignment by SE(3), grey: truth" if run.ate else "no ground truth") + "; dot: start"
            yield Figure(f"Trajectory {name}, {run.label}", note,
                         picture([draw_view(run, index, axes, limit)], f"trajectory {name}"),
                         f"{limit:.2g} cm" if run.ate else "", legend=False)


def error_over_time(sequence):
    """ATE over time."""
    runs = runs_with(sequence, "ate")
    if not runs:
        return
    top = max(CM * error for _, run in runs for error in run.ate["error_m"])
    chart = Chart(time_range(sequence), (0.0, 1.06 * top or 1.0), TIME, "error (cm)", time=True)
    for index, run in runs:
        chart.line(sequence.seconds(run.ate["stamp_ns"]), [CM * error for error in run.ate["error_m"]], f"run{index}")
    yield Figure("Position error over time", "ATE: distance to the truth after alignment by SE(3), without scale",
                 picture([chart], "absolute trajectory error over time"))


def three_axes(sequence, runs, series, settled=0.15):
    """Charts of x, y and z above each other; series(run, axis) gives stamps, values and 3-sigma bounds (or None).

    Bounds are wide before the first motion: what comes after the first `settled` of the time decides the scale.
    """
    charts = []
    for row, axis in enumerate("xyz"):
        curves = [(index, *series(run, axis)) for index, run in runs]
        shown = []
        for _, stamps, values, bounds in curves:
            shown += values
            shown += [sign * b for b in (bounds or [])[int(settled * len(stamps)):] for sign in (-1.0, 1.0)]
        chart = Chart(time_range(sequence), padded(shown), TIME if row == 2 else "", axis,
                      top=66 * row, height=HEIGHT - 132 if row == 2 else 74, time=True,
                      x_names=None if row == 2 else [])
        for index, stamps, values, bounds in curves:
            seconds = sequence.seconds(stamps)
            if bounds:
                chart.band(seconds, [-b for b in bounds], bounds, f"run{index}")
            chart.line(seconds, values, f"run{index}")
        charts.append(chart)
    return picture(charts, "three components over time")


def claims(sequence):
    """Errors of position, attitude and velocity with the 3-sigma bounds that the estimator reports."""
    runs = runs_with(sequence, "errors")
    groups = [("Position", "p", "cm", CM), ("Attitude", "theta", "deg", DEG), ("Velocity", "v", "cm/s", CM)]
    for name, key, unit, factor in groups if runs else []:
        if not any(error == error for _, run in runs for error in run.errors[f"error_{key}_x"]):
            continue  # not a number: the ground truth has no velocities

        def series(run, axis, key=key, factor=factor):
            table = run.errors
            return (table["stamp_ns"], [factor * e for e in table[f"error_{key}_{axis}"]],
                    [3.0 * factor * s for s in table[f"sigma_{key}_{axis}"]])
        yield Figure(f"{name} error within its 3-sigma bound ({unit})",
                     "bound: as reported by the estimator; position and yaw made equal at the first common stamp",
                     three_axes(sequence, runs, series))


def normalised_errors(sequence):
    """NEES of the pose over time."""
    runs = runs_with(sequence, "errors")
    if not runs:
        return
    values = sorted(value for _, run in runs for value in run.errors["nees_pose"])
    chart = Chart(time_range(sequence), (0.0, max(16.0, 1.3 * quantile(values, 0.98))), TIME, "NEES", time=True)
    chart.bar(chart.x[0], 1.237, chart.x[1], 14.449, "expected")  # chi-square of 6 degrees of freedom: 2.5 and 97.5 %
    for index, run in runs:
        chart.line(sequence.seconds(run.errors["stamp_ns"]), run.errors["nees_pose"], f"run{index}")
    yield Figure("Pose error over its reported covariance", "NEES, 6 on average if honest; shaded: where 95 % of the "
                 "samples of an honest estimator are", picture([chart], "NEES of the pose over time"))


def relative_errors(sequence):
    """RPE box plots by length, the paper's figure."""
    runs = runs_with(sequence, "rpe")
    if not runs:
        return
    lengths = sorted({length for _, run in runs for length in run.rpe["length_m"]})
    for key, unit, name, factor in (("translation_m", "cm", "translation", CM), ("yaw_deg", "deg", "yaw", 1.0),
                                    ("rotation_deg", "deg", "rotation", 1.0)):
        boxes = []
        for place, length in enumerate(lengths):
            for number, (index, run) in enumerate(runs):
                values = sorted(factor * value for value, of in zip(run.rpe[key], run.rpe["length_m"]) if of == length)
                if values:
                    middle = place + (number - (len(runs) - 1) / 2) * 0.8 / len(runs)
                    boxes.append((middle, index, [quantile(values, q) for q in (0.05, 0.25, 0.5, 0.75, 0.95)]))
        if not boxes:
            continue
        top = max(box[2][-1] for box in boxes)
        chart = Chart((-0.6, len(lengths) - 0.4), (0.0, 1.06 * top or 1.0), "length of the stretch (m)",
                      f"{name} ({unit})", x_names=[(place, f"{length:g}") for place, length in enumerate(lengths)])
        for middle, index, quantiles in boxes:
            chart.box_plot(middle, 0.62 / len(runs), quantiles, f"run{index}")
        yield Figure(f"Relative error by length: {name}", "RPE; box: quartiles and median, whiskers: 5 to 95 %",
                     picture([chart], f"relative {name} error by length"))


def mesh_accuracy(sequence):
    """Shares of the mesh within tolerances."""
    runs = [(index, run) for index, run in enumerate(sequence.runs) if run.figure("mesh")]
    if not runs:
        return
    tolerances = [CM * t for t in runs[0][1].figure("mesh", "tolerances_m")]
    places = list(range(len(tolerances)))
    chart = Chart((-0.2, len(places) - 0.8), (0.0, 104.0), "tolerance (cm)", "share (%)",
                  x_names=[(place, f"{t:g}") for place, t in zip(places, tolerances)])
    for index, run in runs:
        for key, style in (("accuracy_m", ""), ("completeness_m", " dashed")):
            shares = [100.0 * share for share in run.figure("mesh", "by_trajectory", key, "within")]
            chart.line(places, shares, f"run{index}{style}")
            for place, share in zip(places, shares):
                chart.dot(place, share, f"run{index}", 2.5)
    yield Figure("Mesh within a tolerance",
                 "line: share of the mesh that near to the truth; dashed: share of the seen surface it covers",
                 picture([chart], "mesh accuracy and completeness"))


def stage_means(run, keyframes):
    """Mean time of each stage (ms) over keyframes, or over the other frames; 0 of stages that the run does not have."""
    chosen = [i for i, flag in enumerate(run.timing["is_keyframe"]) if bool(flag) == keyframes]
    return [statistics.fmean([run.timing[f"{stage}_ms"][i] for i in chosen])
            if chosen and f"{stage}_ms" in run.timing else 0.0 for stage in STAGES]


def times(sequence):
    """Time by stage and of each frame."""
    runs = runs_with(sequence, "timing")
    if not runs:
        return
    for keyframes, name in ((True, "keyframes"), (False, "frames between keyframes")):
        means = [(index, stage_means(run, keyframes)) for index, run in runs]
        shown = [k for k in range(len(STAGES)) if any(of[k] > 0.004 for _, of in means)]
        most = max([of[k] for _, of in means for k in shown], default=1.0)
        rows = len(shown)
        height = max(HEIGHT, TOP + BOTTOM + BAR_HEIGHT * rows * len(means))
        chart = Chart((0.0, 1.17 * most), (-0.5, rows - 0.5), "mean time (ms)", left=104, height=height,
                      y_names=[(rows - 1 - row, STAGES[k].replace("_", " ")) for row, k in enumerate(shown)])
        for number, (index, of) in enumerate(means):
            for row, k in enumerate(shown):
                thickness = 0.76 / len(means)
                y = rows - 1 - row + 0.38 - number * thickness
                chart.bar(0.0, y - 0.92 * thickness, of[k], y, f"run{index}", f"{STAGES[k]}: {of[k]:.2f} ms")
                chart.text(of[k], y - 0.46 * thickness, f"{of[k]:.2f}", dx=4, style="tiny" if rows > 4 else "")
        yield Figure(f"Time by stage, {name}", "the computer's own load is part of it",
                     picture([chart], f"time by stage at {name}", height))
    every = sorted(ms for _, run in runs for ms in run.timing["total_ms"])
    chart = Chart(time_range(sequence), (0.0, 1.3 * quantile(every, 0.99) or 1.0), TIME, "time of a frame (ms)",
                  time=True)
    for index, run in runs:
        chart.points(sequence.seconds(run.timing["stamp_ns"]), run.timing["total_ms"], f"run{index}")
    yield Figure("Time of each frame", "the upper band is of keyframes", picture([chart], "time of each frame"))


def draw_states(chart, sequence, run, low, high):
    """A strip of the states between two heights."""
    seconds = sequence.seconds(run.health["stamp_ns"])
    states = run.health["state"]
    begin = 0
    for i in range(1, len(states) + 1):
        if i == len(states) or states[i] != states[begin]:
            end = seconds[min(i, len(states) - 1)]
            chart.bar(max(seconds[begin], chart.x[0]), low, end, high, STATES.get(states[begin], "state-init"),
                      f"{states[begin]} from {seconds[begin]:.2f} to {end:.2f} s")
            begin = i


def health(sequence):
    """State, quality and features over time."""
    runs = runs_with(sequence, "health")
    if not runs:
        return
    strip = 9.0
    chart = Chart(time_range(sequence), (-strip * len(runs) - 3.0, 104.0), TIME, "quality", time=True,
                  y_names=[(v, str(v)) for v in (0, 25, 50, 75, 100)])
    for number, (index, run) in enumerate(runs):
        chart.line(sequence.seconds(run.health["stamp_ns"]), run.health["quality"], f"run{index}")
        draw_states(chart, sequence, run, -strip * (number + 1), -strip * number - 2.0)
    yield Figure("Health", "quality, 100 is best; strips below, a run each: "
                 + " ".join(f'<span class="keyed"><i class="key {STATES[state]}"></i>{state.lower()}</span>'
                            for state in ("TRACKING", "DEGRADED", "LOST", "INIT")),
                 picture([chart], "health over time"))
    most = max(value for _, run in runs for value in run.health["tracked"] + run.health["landmarks"])
    chart = Chart(time_range(sequence), (0.0, 1.06 * most or 1.0), TIME, "number", time=True)
    for index, run in runs:
        seconds = sequence.seconds(run.health["stamp_ns"])
        chart.line(seconds, run.health["tracked"], f"run{index}")
        held = [(t, n) for t, n, is_keyframe in
                zip(seconds, run.health["landmarks"], run.health["is_keyframe"]) if is_keyframe]
        if held:
            chart.line(*zip(*held), f"run{index} dashed")
    yield Figure("Features", "line: tracked from the frame before; dashed: landmarks of the last optimization",
                 picture([chart], "features over time"))


def biases(sequence):
    """Biases of gyroscope and accelerometer."""
    runs = [(index, run) for index, run in enumerate(sequence.runs)]
    for name, key, unit, factor in (("Gyroscope bias", "g", "mrad/s", 1e3),
                                    ("Accelerometer bias", "a", "mm/s\u00b2", 1e3)):
        def series(run, axis, key=key, factor=factor):
            return run.trajectory["stamp_ns"], [factor * value for value in run.trajectory[key + axis]], None
        yield Figure(f"{name} ({unit})", "as estimated at each frame", three_axes(sequence, runs, series))


def calibration(sequence):
    """The time offset with its 3-sigma bound, and how far the calibration had to be corrected."""
    runs = runs_with(sequence, "health")
    if not runs:
        return
    after = {index: len(run.health["stamp_ns"]) // 7 for index, run in runs}
    spans = [1e3 * (value + sign * 3.0 * sigma) for index, run in runs for value, sigma in
             list(zip(run.health["time_offset_s"], run.health["time_offset_sigma_s"]))[after[index]:]
             for sign in (-1, 1)]
    chart = Chart(time_range(sequence), padded(spans), TIME, "offset (ms)", time=True)
    for index, run in runs:
        seconds = sequence.seconds(run.health["stamp_ns"])
        pairs = list(zip(run.health["time_offset_s"], run.health["time_offset_sigma_s"]))
        chart.band(seconds, [1e3 * (v - 3 * s) for v, s in pairs], [1e3 * (v + 3 * s) for v, s in pairs],
                   f"run{index}")
        chart.line(seconds, [1e3 * v for v, _ in pairs], f"run{index}")
    yield Figure("Time offset of the cameras", "with its 3-sigma bound; added to image stamps it gives the IMU's time",
                 picture([chart], "time offset over time"))
    values = [v for _, run in runs for v in run.health["calibration_stretch"] + run.health["calibration_scale"]]
    chart = Chart(time_range(sequence), (0.0, 1.06 * max(values) or 1.0), TIME, "standard deviations", time=True)
    for index, run in runs:
        seconds = sequence.seconds(run.health["stamp_ns"])
        chart.line(seconds, run.health["calibration_stretch"], f"run{index}")
        chart.line(seconds, run.health["calibration_scale"], f"run{index} dashed")
    yield Figure("Corrections of the calibration", "line: the largest, in standard deviations of what was given; "
                 "dashed: the errors' size by what has been seen, as a multiple of the stated one",
                 picture([chart], "corrections of the calibration over time"))


CORRECTIONS = [
    ("Focal length, left fx", "left_fx", "%", 100.0), ("Principal point, left cx", "left_cx", "px", 1.0),
    ("Mount, about y", "mount_theta_y", "deg", DEG), ("Right camera, along y", "right_p_y", "mm", 1e3)]


def corrections(sequence):
    """What single parameters of the calibration are corrected by, with 3-sigma bounds."""
    runs = runs_with(sequence, "corrections")
    for name, key, unit, factor in CORRECTIONS if runs else []:
        curves = [(index, sequence.seconds(run.corrections["stamp_ns"]), [factor * v for v in run.corrections[key]],
                   [3.0 * factor * s for s in run.corrections[key + "_sigma"]]) for index, run in runs]
        spans = [v + sign * b for _, _, values, bounds in curves for v, b in zip(values, bounds) for sign in (-1, 1)]
        chart = Chart(time_range(sequence), padded(spans), TIME, f"correction ({unit})", time=True)
        for index, seconds, values, bounds in curves:
            chart.band(seconds, [v - b for v, b in zip(values, bounds)], [v + b for v, b in zip(values, bounds)],
                       f"run{index}")
            chart.line(seconds, values, f"run{index}")
        yield Figure(name, "correction of what was given, with its 3-sigma bound", picture([chart], name))


def plane_lives(sequence):
    """When each plane was known, and when it was held in the estimate."""
    for index, run in runs_with(sequence, "planes"):
        table = run.planes
        ids = sorted(set(table["id"]))
        if not ids:
            continue
        rows = {plane: len(ids) - 1 - row for row, plane in enumerate(ids)}
        step = max(1, len(ids) // 14)
        chart = Chart(time_range(sequence), (-0.7, len(ids) - 0.3), TIME, "plane", time=True,
                      y_names=[(rows[plane], f"{plane:g}") for plane in ids[::step]])
        seconds = sequence.seconds(table["stamp_ns"])
        for plane in ids:
            own = [i for i, of in enumerate(table["id"]) if of == plane]
            begin = 0
            for k in range(1, len(own) + 1):
                if k < len(own) and table["is_held"][own[k]] == table["is_held"][own[begin]]:
                    continue
                i, end = own[begin], own[min(k, len(own) - 1)]
                held = table["is_held"][i] > 0
                size = 0.36 if held else 0.14
                chart.bar(seconds[i], rows[plane] - size, seconds[end], rows[plane] + size,
                          f"run{index}" + ("" if held else " faint"),
                          f"plane {plane:g}, {table['kind'][i]}{', held' if held else ''}")
                begin = k
        yield Figure(f"Planes, {run.label}", "thin: found; thick: landmarks are held on it",
                     picture([chart], "planes over time"), legend=False)


def all_figures(sequence):
    """Sections of figures: a heading each."""
    sections = [("Trajectory", [paths]), ("Accuracy", [error_over_time, relative_errors]),
                ("Consistency", [claims, normalised_errors]), ("Mesh and planes", [mesh_accuracy, plane_lives]),
                ("Health", [health, calibration, biases]), ("Calibration", [corrections]), ("Time", [times])]
    for heading, makers in sections:
        figures = [figure for maker in makers for figure in maker(sequence)]
        if figures:
            yield heading, figures
