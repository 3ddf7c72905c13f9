# SPDX-License-Identifier: BSD-2-Clause
"""Figures of what comes back when images do."""
import bisect
import csv
import math
import re


def seconds(row):
    return int(row["stamp_ns"]) * 1e-9


def outage(run):
    """When the images go and come back (s)."""
    at, length = map(float, re.search(r"drop_frames=1@([\d.]+)\+([\d.]+)", " ".join(run.options)).groups())
    begin = seconds(run.health[0])
    return begin + at, begin + at + length


def poses(path):
    """Rows of a EuRoC table as (stamp in s, place, attitude w x y z)."""
    with path.open() as stream:
        numbers = [[float(value) for value in row[1:8]] + [int(row[0]) * 1e-9] for row in csv.reader(stream)
                   if not row[0].startswith("#")]
    return [(row[7], row[:3], row[3:7]) for row in numbers]


def yaw_between(own, true):
    """Turn about the vertical from an attitude to another one, however the body is mounted."""
    w, x, y, z = own
    a, b, c, d = true
    return 2 * math.atan2(d * w - a * z - b * y + c * x, a * w + b * x + c * y + d * z)


class Alignment:
    """Yaw and place that bring estimates onto the truth, from pairs of (estimate, truth)."""

    def __init__(self, pairs):
        turns = [yaw_between(own[2], true[2]) for own, true in pairs]
        self.angle = math.atan2(sum(map(math.sin, turns)), sum(map(math.cos, turns)))
        moved = [(self.turned(own[1]), true[1]) for own, true in pairs]
        self.shift = [sum(t[k] - o[k] for o, t in moved) / len(moved) for k in range(3)]

    def turned(self, p):
        c, s = math.cos(self.angle), math.sin(self.angle)
        return [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]

    def place_error(self, own, true):
        return math.dist([a + b for a, b in zip(self.turned(own[1]), self.shift)], true[1])

    def yaw_error_deg(self, own, true):
        off = self.angle - yaw_between(own[2], true[2])
        return math.degrees(abs((off + math.pi) % (2 * math.pi) - math.pi))


def tracking_again(run):
    """Stamps (s) of the first frame that is used behind the outage, and of the first one that is TRACKING."""
    after = [row for row in run.health if seconds(row) >= outage(run)[1] - 0.01 and int(row["tracked"]) > 0]
    return seconds(after[0]), next(seconds(row) for row in after if row["state"] == "TRACKING")


def pairs_of(run):
    """(estimate, truth) before the outage, and from TRACKING on."""
    truth = poses(run.log / "mav0/state_groundtruth_estimate0/data.csv")
    stamps = [pose[0] for pose in truth]

    def nearest(t):
        i = min(max(bisect.bisect_left(stamps, t), 1), len(stamps) - 1)
        return truth[i if abs(stamps[i] - t) < abs(stamps[i - 1] - t) else i - 1]
    pairs = [(pose, nearest(pose[0])) for pose in poses(run.folder / "trajectory.csv")]
    tracking = tracking_again(run)[1]
    return ([pair for pair in pairs if pair[0][0] < outage(run)[0]],
            [pair for pair in pairs if pair[0][0] >= tracking - 1e-3])


def states_meanwhile(run):
    gone, back = outage(run)
    states = [row["state"] for row in run.health if gone + 0.2 < seconds(row) < back - 0.01]
    return " ".join(dict.fromkeys(states)) or "silence"


def place_off_m(run):
    before, later = pairs_of(run)
    return Alignment(before).place_error(*later[0])


def yaw_off_deg(run):
    before, later = pairs_of(run)
    return Alignment(before).yaw_error_deg(*later[0])


def sigma(axes):
    """Norm of the sigmas reported with the first estimate behind the outage."""
    def of(run):
        stamp = pairs_of(run)[1][0][0][0]
        row = next(row for row in run.table("covariance.csv") if abs(seconds(row) - stamp) < 1e-6)
        return math.sqrt(sum(float(row[f"c{k}{k}"]) for k in axes))
    return of


def ate_after_mm(run):
    later = pairs_of(run)[1]
    after = Alignment(later)
    return 1e3 * math.sqrt(sum(after.place_error(*pair) ** 2 for pair in later) / len(later))


FIGURES = {"states_meanwhile": states_meanwhile, "place_off_m": place_off_m, "yaw_off_deg": yaw_off_deg,
           "tracking_after_s": lambda run: tracking_again(run)[1] - tracking_again(run)[0],
           "sigma_m": sigma((3, 4, 5)), "sigma_deg": lambda run: math.degrees(sigma((0, 1, 2))(run)),
           "ate_after_mm": ate_after_mm}
