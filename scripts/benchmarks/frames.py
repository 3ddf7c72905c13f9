# SPDX-License-Identifier: BSD-2-Clause
"""Figures of keyframes and of the frames between them."""
import math
import statistics

from bench.figures import frame_errors, rms_of
from bench.quaternion import cross, rotated


def vector(row, name):
    return [float(row[f"{name}_{axis}"]) for axis in "xyz"]


def plus(a, b, factor=1.0):
    return [x + factor * y for x, y in zip(a, b)]


def local_jump(before, after, state):
    """What a step of the error of the position has beyond turning and stretching the way from the origin.

    If the world turns by d about the origin, the errors change by e_theta -> e_theta + d, e_p -> e_p + d x p. The
    stretch is what fits best."""
    position, attitude = state
    angles = [rotated(attitude, vector(row, "error_theta")) for row in (before, after)]
    step = plus(vector(after, "error_p"), vector(before, "error_p"), -1.0)
    rest = plus(step, cross(plus(angles[1], angles[0], -1.0), position), -1.0)
    stretch = sum(map(math.prod, zip(rest, position))) / max(1e-12, sum(x * x for x in position))
    return math.hypot(*plus(rest, position, -stretch))


def states_of(run):
    """Position and attitude (w x y z) of each stamp."""
    with (run.folder / "trajectory.csv").open() as stream:
        table = [line.split(",") for line in stream if line[0].isdigit()]
    return {int(row[0]): ([float(x) for x in row[1:4]], [float(x) for x in row[4:8]]) for row in table}


def at_frames(is_keyframe, name, figure):
    """A figure of the values of a column, or of the lengths of a vector, at keyframes or between them."""
    def of(run):
        rows = [row for key, row in frame_errors(run) if key == is_keyframe]
        values = [math.hypot(*vector(row, name)) if f"{name}_x" in row else float(row[name]) for row in rows]
        return figure([value for value in values if value == value])
    return of


def steps(share, is_local=False):
    """A quantile (mm) of the steps of the position's error from frame to frame. What a keyframe corrects is seen in the
    frames behind it, over which its work is spread."""
    def of(run):
        frames = frame_errors(run)
        states = states_of(run) if is_local else {}
        lengths = sorted(
            local_jump(a, b, states[int(b["stamp_ns"])]) if is_local else math.dist(vector(b, "error_p"),
                                                                                    vector(a, "error_p"))
            for (_, a), (_, b) in zip(frames, frames[1:]))
        return 1e3 * lengths[min(len(lengths) - 1, int(share * len(lengths)))]
    return of


def off(name, factor):
    """The largest distance of an error from its first one."""
    def of(run):
        rows = [vector(row, name) for _, row in frame_errors(run)]
        return factor * max(math.dist(row, rows[0]) for row in rows)
    return of


FIGURES = {"off_mm": off("error_p", 1e3), "off_deg": off("error_theta", math.degrees(1.0))}
for _word, _key in (("key", True), ("tracked", False)):
    FIGURES[f"v_{_word}"] = at_frames(_key, "error_v", lambda values: 1e3 * rms_of(values))
    for _part in ("pose", "velocity"):
        FIGURES[f"nees_{_part}_{_word}"] = at_frames(_key, f"nees_{_part}", statistics.fmean)
for _share in (0.5, 0.99, 1.0):
    FIGURES[f"jump_p{100 * _share:.0f}"] = steps(_share)
    FIGURES[f"local_p{100 * _share:.0f}"] = steps(_share, is_local=True)
