# SPDX-License-Identifier: BSD-2-Clause
"""Figures of what a memory of places recognises, and of the flight in its map."""
import bisect
import math
import re
import statistics

from bench.looped_log import period_of, stamps_of
from bench.quaternion import rotated

FALSE_M = 0.2            # a recognised pose further off than that is of another place
NEAR_M, NEAR_DEG = 1.0, 20.0
FORGOTTEN_S = 8.0        # the window has no keyframe that old


class Truth:
    """The true poses of body and left camera; after its end the flight is repeated (replay --loops)."""

    def __init__(self, log):
        rows = (log / "mav0/state_groundtruth_estimate0/data.csv").read_text().splitlines()[1:]
        self.rows = [[float(cell) for cell in row.split(",")[:8]] for row in rows]
        self.stamps = [row[0] for row in self.rows]
        self.period = period_of(stamps_of(log))
        yaml = (log / "mav0/cam0/sensor.yaml").read_text()
        matrix = [float(cell) for cell in re.search(r"data:\s*\[([^\]]*)\]", yaml).group(1).split(",")]
        self.lever, self.axis = matrix[3:12:4], matrix[2:12:4]

    def body(self, stamp_ns):
        """Position and attitude, between two samples; None before the first one."""
        while stamp_ns >= self.stamps[-1] and stamp_ns - self.period >= self.stamps[0]:
            stamp_ns -= self.period
        i = bisect.bisect_left(self.stamps, stamp_ns)
        if not 0 < i < len(self.stamps):
            return None
        a, b = self.rows[i - 1], self.rows[i]
        share = (stamp_ns - a[0]) / (b[0] - a[0])
        mixed = [p + share * (q - p) for p, q in zip(a[1:8], b[1:8])]
        norm = math.hypot(*mixed[3:])
        return mixed[:3], [value / norm for value in mixed[3:]]

    def camera(self, stamp_ns):
        """Position, and where it looks."""
        pose = self.body(stamp_ns)
        if pose is None:
            return None
        place, attitude = pose
        return [p + d for p, d in zip(place, rotated(attitude, self.lever))], rotated(attitude, self.axis)


def truth_of(run):
    if not hasattr(run, "truth"):
        run.truth = Truth(run.log)
    return run.truth


def aligned(run, name):
    """Pairs (estimated, true) of positions, and the yaw that aligns them."""
    pairs = []
    for line in (run.folder / name).read_text().splitlines():
        cells = line.split()
        seconds, fraction = cells[0].split(".")
        pose = truth_of(run).body(int(seconds) * 10**9 + int(fraction))
        if pose is not None:
            pairs.append(([float(cell) for cell in cells[1:4]], pose[0]))
    mean = [[statistics.fmean(pair[k][i] for pair in pairs) for i in range(3)] for k in range(2)]
    pairs = [tuple([p[i] - mean[k][i] for i in range(3)] for k, p in enumerate(pair)) for pair in pairs]
    yaw = math.atan2(sum(e[0] * t[1] - e[1] * t[0] for e, t in pairs), sum(e[0] * t[0] + e[1] * t[1] for e, t in pairs))
    return pairs, yaw


def turned(yaw, v):
    c, s = math.cos(yaw), math.sin(yaw)
    return [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]]


def ate_mm(name):
    def figure(run):
        pairs, yaw = aligned(run, name)
        return 1e3 * math.sqrt(statistics.fmean(math.dist(turned(yaw, e), t) ** 2 for e, t in pairs))
    return figure


def views(run):
    """The rows of places.csv, by the view's stamp."""
    found = {}
    for row in run.table("places.csv"):
        found.setdefault(int(row["stamp_ns"]), []).append(row)
    return found


def yaw_errors(run):
    """By how much the odometry's axes are turned against the true ones, by stamp (rad)."""
    yaws = {}
    for line in (run.folder / "trajectory.tum").read_text().splitlines():
        stamp, _, _, _, *quaternion = line.split()
        x, y, z, w = map(float, quaternion)
        stamp_ns = int(stamp.replace(".", ""))
        pose = truth_of(run).body(stamp_ns)
        if pose is not None:
            heading, true = (rotated(q, truth_of(run).axis) for q in ([w, x, y, z], pose[1]))
            yaws[stamp_ns] = math.atan2(true[1], true[0]) - math.atan2(heading[1], heading[0])
    return yaws


def loop_errors_m(run):
    """Of the accepted recognitions: where the place is, seen from the view, against the truth."""
    if not hasattr(run, "loop_errors_m"):
        run.loop_errors_m = measured_loop_errors_m(run)
    return run.loop_errors_m


def measured_loop_errors_m(run):
    yaws = yaw_errors(run)
    errors = []
    for row in run.table("places.csv"):
        if row["accepted"] == "1" and int(row["stamp_ns"]) in yaws:
            here, there = (truth_of(run).camera(int(row[key])) for key in ("stamp_ns", "place_stamp_ns"))
            way = turned(yaws[int(row["stamp_ns"])] - float(row["yaw"]), [float(row[key]) for key in "xyz"])
            errors.append(math.dist(way, [a - b for a, b in zip(here[0], there[0])]))
    return errors


def revisits(run):
    """Stamps of views taken close to an earlier one that the window has forgotten."""
    known = [(stamp, truth_of(run).camera(stamp)) for stamp in views(run)]
    known = [(stamp, pose) for stamp, pose in known if pose is not None]
    least = math.cos(math.radians(NEAR_DEG))
    return [stamp for stamp, (place, axis) in known
            if any(stamp - earlier > 1e9 * FORGOTTEN_S and math.dist(place, other[0]) < NEAR_M
                   and sum(a * b for a, b in zip(axis, other[1])) > least for earlier, other in known)]


def recognised_percent(run):
    again = revisits(run)
    found = views(run)
    known = sum(any(row["accepted"] == "1" for row in found[stamp]) for stamp in again)
    return 100 * known / len(again) if again else None


def map_over_odometry(run):
    return ate_mm("trajectory_map.tum")(run) / ate_mm("trajectory.tum")(run)


def located_percent(run):
    """Frames with a pose in the map, of those with one in the odometry's world."""
    lines = [len((run.folder / name).read_text().splitlines()) for name in ("trajectory_map.tum", "trajectory.tum")]
    return 100 * lines[0] / lines[1]


FIGURES = {
    "odometry_mm": ate_mm("trajectory.tum"), "map_mm": ate_mm("trajectory_map.tum"),
    "map_over_odometry": map_over_odometry, "located_percent": located_percent, "views": lambda run: len(views(run)),
    "revisits": lambda run: len(revisits(run)), "recognised_percent": recognised_percent,
    "false_recognitions": lambda run: sum(error > FALSE_M for error in loop_errors_m(run)),
    "loop_mm": lambda run: 1e3 * statistics.median(loop_errors_m(run)) if loop_errors_m(run) else None,
    "places_ms": lambda run: statistics.fmean(float(row["places_cpu_ms"]) for row in run.table("timing.csv"))}
