#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""The ATE of facet eval against one computed here from the files alone, with nothing of ours: EuRoC's ground truth,
trajectory.tum and ate.csv are read as anyone would read them.

Usage: independent_ate_test.py FACET...      the program, after the emulator that runs it if there is one
"""
import csv
import json
import math
import random
import subprocess
import sys
import tempfile
from pathlib import Path

BEGIN_NS = 1_403_636_580_000_000_000


def true_position(t):
    return [2.0 * math.cos(0.5 * t), 1.5 * math.sin(0.7 * t), 0.3 * math.sin(0.9 * t)]


def write_flight(folder):
    """Truth at 200 Hz; an estimate at 20 Hz between its stamps, in another world and with errors of centimetres."""
    draw = random.Random(1)
    truth = folder / "mav0/state_groundtruth_estimate0"
    truth.mkdir(parents=True)
    rows = ["#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z"]
    for i in range(4001):
        rows.append(",".join(map(str, [BEGIN_NS + 5_000_000 * i, *true_position(0.005 * i), 1, 0, 0, 0])))
    (truth / "data.csv").write_text("\n".join(rows) + "\n")
    run = folder / "run"
    run.mkdir()
    lines = []
    for i in range(1, 390):
        stamp = BEGIN_NS + 50_000_000 * i + 1_234_567
        x, y, z = (c + draw.gauss(0.0, 0.02) for c in true_position(1e-9 * (stamp - BEGIN_NS)))
        # Turned by 90 degrees about z, and moved.
        lines.append(f"{stamp // 10**9}.{stamp % 10**9:09d} {-y + 5:.9f} {x - 3:.9f} {z + 1:.9f} 0 0 0 1")
    (run / "trajectory.tum").write_text("\n".join(lines) + "\n")
    return run


def read_truth(path):
    with path.open() as stream:
        rows = [row for row in csv.reader(stream) if not row[0].startswith("#")]
    return [(int(row[0]), [float(value) for value in row[1:4]]) for row in rows]


def read_estimate(path):
    poses = []
    for line in path.read_text().splitlines():
        seconds, *position = line.split()[:4]
        whole, _, part = seconds.partition(".")
        poses.append((int(whole) * 10**9 + int(part.ljust(9, "0")), [float(value) for value in position]))
    return poses


def matched(truth, estimate):
    """Pairs of the true position, interpolated linearly, and the estimated one."""
    pairs, k = [], 0
    for stamp, position in estimate:
        while truth[k + 1][0] < stamp:
            k += 1
        share = (stamp - truth[k][0]) / (truth[k + 1][0] - truth[k][0])
        pairs.append(([a + share * (b - a) for a, b in zip(truth[k][1], truth[k + 1][1])], position))
    return pairs


def best_rotation(pairs):
    """The unit quaternion (w, x, y, z) that turns centred estimates onto centred truths best: the eigenvector of the
    largest eigenvalue of Horn's 4 x 4 matrix (1987), here by power iteration."""
    s = [[sum(e[i] * t[j] for t, e in pairs) for j in range(3)] for i in range(3)]
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = s
    n = [[xx + yy + zz, yz - zy, zx - xz, xy - yx], [yz - zy, xx - yy - zz, xy + yx, zx + xz],
         [zx - xz, xy + yx, yy - xx - zz, yz + zy], [xy - yx, zx + xz, yz + zy, zz - xx - yy]]
    shift = sum(abs(value) for row in n for value in row)  # makes the largest eigenvalue the one of largest size
    q = [0.5, 0.5, 0.5, 0.5]
    for _ in range(20000):
        q = [shift * q[i] + sum(n[i][j] * q[j] for j in range(4)) for i in range(4)]
        length = math.sqrt(sum(value * value for value in q))
        q = [value / length for value in q]
    return q


def turned(q, p):
    w, u = q[0], q[1:]
    t = [2 * (u[1] * p[2] - u[2] * p[1]), 2 * (u[2] * p[0] - u[0] * p[2]), 2 * (u[0] * p[1] - u[1] * p[0])]
    return [p[0] + w * t[0] + u[1] * t[2] - u[2] * t[1], p[1] + w * t[1] + u[2] * t[0] - u[0] * t[2],
            p[2] + w * t[2] + u[0] * t[1] - u[1] * t[0]]


def absolute_errors(pairs):
    """Distances after the best rigid alignment."""
    count = len(pairs)
    mean_true, mean_estimate = ([sum(pair[k][i] for pair in pairs) / count for i in range(3)] for k in (0, 1))
    centred = [([a - b for a, b in zip(t, mean_true)], [a - b for a, b in zip(e, mean_estimate)]) for t, e in pairs]
    q = best_rotation(centred)
    return [math.dist(t, turned(q, e)) for t, e in centred]


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = write_flight(folder)
        command = [*sys.argv[1:], "eval", "--groundtruth", folder, "--estimate", run, "--json", run / "eval.json",
                   "--details", run]
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
        figures = json.loads((run / "eval.json").read_text())["ate_se3"]["translation_m"]
        errors = absolute_errors(matched(read_truth(folder / "mav0/state_groundtruth_estimate0/data.csv"),
                                         read_estimate(run / "trajectory.tum")))
        with (run / "ate.csv").open() as stream:
            written = [float(row["error_m"]) for row in csv.DictReader(stream)]
    assert figures["count"] == len(errors) == len(written), (figures["count"], len(errors), len(written))
    rmse = math.sqrt(sum(error * error for error in errors) / len(errors))
    assert rmse > 0.02, rmse
    assert abs(rmse - figures["rmse"]) < 1e-8, (rmse, figures["rmse"])
    assert abs(sorted(errors)[len(errors) // 2] - figures["median"]) < 1e-8, figures
    assert all(abs(a - b) < 1e-7 for a, b in zip(errors, written)), "ate.csv differs"
    return 0


if __name__ == "__main__":
    sys.exit(main())
