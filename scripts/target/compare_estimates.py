#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compares the estimates that programs for different processors made of the same log, frame by frame and without any
alignment, with the first one's.

Usage: compare_estimates.py [--rms-sigma F] [--max-sigma F] NAME=FOLDER NAME=FOLDER...
FOLDER is the output folder of `facet replay`. Rounding differs between processors, and where a number is next to a
threshold, so does a decision: a feature more or less. How far the estimates then differ depends on how well the flight
determines them, which their covariance says. So the difference d of two poses, [theta p] as in covariance.csv, is
judged by the covariance C that the first program reports there: sqrt(d' C^-1 d / 6), 1 for a difference of one standard
deviation in each direction. Its mean square over the frames must not exceed 1/4 squared: if it is independent of the
error, it adds 1/16 to the mean squared error. And no frame may be beyond 1.
"decisions" is the time after the first estimate at which a count or a keyframe in health.csv first differs.
Exit codes: 0 all within the limit, 1 some are not, 2 bad input.
"""
import argparse
import csv
import math
import sys
from pathlib import Path

SAME_FRAME_S = 0.005
COLUMNS = (
    "program", "frames", "position: rms", "max", "orientation: rms", "max", "of sigma: rms", "max", "decisions", "bytes"
)  # fmt: skip
DECISIONS = ("state", "is_keyframe", "tracked", "detected", "stereo", "recalled", "outliers", "landmarks")
POSE = 6  # theta and p, of the nine of covariance.csv


class BadInput(Exception):
    pass


def read_numbers(path, count):
    """Rows of finite numbers by their stamp, the first column, which is kept in nanoseconds."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from error
    rows = {}
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.startswith(("#", "stamp_ns")):
            continue
        words = line.split(",")
        try:
            stamp_ns, values = int(words[0]), tuple(float(word) for word in words[1:])
        except ValueError:
            stamp_ns, values = 0, ()
        if len(values) != count or not all(math.isfinite(value) for value in values):
            raise BadInput(f"{path}:{number}: not a stamp and {count} numbers")
        rows[stamp_ns] = values
    if not rows:
        raise BadInput(f"{path}: no row")
    return rows


def read_trajectory(folder):
    """Poses by stamp in nanoseconds: {140050000000: (x, y, z, qx, qy, qz, qw)}."""
    rows = read_numbers(Path(folder) / "trajectory.csv", 16)
    return {stamp: (*row[:3], *row[4:7], row[3]) for stamp, row in rows.items()}


def read_covariances(folder):
    """Of [theta p], by stamp: lists of six rows."""
    found = {}
    for stamp, row in read_numbers(Path(folder) / "covariance.csv", 45).items():
        upper = iter(row)
        full = [[0.0] * 9 for _ in range(9)]
        for i in range(9):
            for j in range(i, 9):
                full[i][j] = full[j][i] = next(upper)
        found[stamp] = [line[:POSE] for line in full[:POSE]]
    return found


def read_decisions(folder):
    """[(stamp, the columns of health.csv that DECISIONS names)], as text."""
    path = Path(folder) / "health.csv"
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return [(int(row["stamp_ns"]), [row[name] for name in DECISIONS]) for row in csv.DictReader(file)]
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from error
    except (KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: not the table of facet replay ({error})") from error


def distance_m(a, b):
    return math.dist(a[:3], b[:3])


def turn_rad(a, b):
    """The rotation vector from a to b, in the body of a. By the vector part of their quotient: the arc cosine of the
    scalar part has no digits left near zero."""
    ax, ay, az, aw = a[3:]
    bx, by, bz, bw = b[3:]
    w = aw * bw + ax * bx + ay * by + az * bz
    v = (
        aw * bx - ax * bw - ay * bz + az * by,
        aw * by - ay * bw - az * bx + ax * bz,
        aw * bz - az * bw - ax * by + ay * bx,
    )
    sine = math.hypot(*v)
    scale = math.copysign(2.0 * math.atan2(sine, abs(w)) / sine, w) if sine > 0.0 else 0.0
    return tuple(scale * value for value in v)


def of_sigma(covariance, difference):
    """sqrt(d' C^-1 d / n) by Cholesky's decomposition C = L L': |L^-1 d| / sqrt(n)."""
    n = len(difference)
    lower = [[0.0] * n for _ in range(n)]
    white = []
    for i in range(n):
        for j in range(i + 1):
            rest = covariance[i][j] - sum(lower[i][k] * lower[j][k] for k in range(j))
            if i == j and rest <= 0.0:
                raise BadInput("a covariance is not positive definite")
            lower[i][j] = math.sqrt(rest) if i == j else rest / lower[j][j]
        white.append((difference[i] - sum(lower[i][k] * white[k] for k in range(i))) / lower[i][i])
    return math.hypot(*white) / math.sqrt(n)


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def pairs(reference, other):
    """Stamps of the same frame in both: they contain the time offset of their run, which differs in its last digits."""
    found = []
    left, right = sorted(reference), sorted(other)
    while left and right:
        apart_s = 1e-9 * (left[-1] - right[-1])
        if abs(apart_s) < SAME_FRAME_S:
            found.append((left.pop(), right.pop()))
        elif apart_s > 0.0:
            left.pop()
        else:
            right.pop()
    return found


def first_other_decision_s(reference, other, begin_ns):
    """Seconds after begin at which decisions first differ; None if they never do."""
    for (stamp, ours), (other_stamp, theirs) in zip(reference, other):
        if stamp != other_stamp or ours != theirs:
            return 1e-9 * (stamp - begin_ns)
    return None


def compare(reference_folder, other_folder):
    """Differences of two replays. Frames that only one of them has make them incomparable."""
    reference, other = read_trajectory(reference_folder), read_trajectory(other_folder)
    covariances = read_covariances(reference_folder)
    same_frame = pairs(reference, other)
    only = len(reference) + len(other) - 2 * len(same_frame)
    if only > 0:
        raise BadInput(f"{only} frames have an estimate in one of the two only")
    if not covariances.keys() >= reference.keys():
        raise BadInput("estimates without a covariance")
    positions, angles, shares = [], [], []
    for a, b in same_frame:
        turn = turn_rad(reference[a], other[b])
        step = [q - p for p, q in zip(reference[a][:3], other[b][:3])]
        positions.append(1000.0 * math.hypot(*step))
        angles.append(math.degrees(math.hypot(*turn)))
        shares.append(of_sigma(covariances[a], [*turn, *step]))
    decisions = [read_decisions(folder) for folder in (reference_folder, other_folder)]
    return {
        "frames": len(reference),
        "rms_mm": rms(positions),
        "max_mm": max(positions),
        "rms_deg": rms(angles),
        "max_deg": max(angles),
        "rms_sigma": rms(shares),
        "max_sigma": max(shares),
        "other_decision_s": first_other_decision_s(*decisions, min(reference)),
        "same": reference == other,
    }


def print_table(rows):
    widths = [max(len(row[i]) for row in (COLUMNS, *rows)) for i in range(len(COLUMNS))]
    for row in (COLUMNS, tuple("-" * width for width in widths), *rows):
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("estimates", nargs="+", metavar="NAME=FOLDER")
    parser.add_argument("--rms-sigma", type=float, default=0.25)
    parser.add_argument("--max-sigma", type=float, default=1.0)
    arguments = parser.parse_args()
    try:
        named = [estimate.split("=", 1) for estimate in arguments.estimates]
        if len(named) < 2 or any(len(pair) != 2 for pair in named):
            raise BadInput("at least two NAME=FOLDER are needed")
        reference_name, reference = named[0]
        rows = [(reference_name, str(len(read_trajectory(reference))), "reference", *[""] * (len(COLUMNS) - 3))]
        bad = []
        for name, folder in named[1:]:
            try:
                found = compare(reference, folder)
            except BadInput as error:
                raise BadInput(f"{reference_name} and {name}: {error}") from error
            since = found["other_decision_s"]
            rows.append(
                (
                    name,
                    str(found["frames"]),
                    f"{found['rms_mm']:.6f} mm",
                    f"{found['max_mm']:.6f} mm",
                    f"{found['rms_deg']:.7f} deg",
                    f"{found['max_deg']:.7f} deg",
                    f"{found['rms_sigma']:.4f}",
                    f"{found['max_sigma']:.4f}",
                    "same" if since is None else f"same to {since:.2f} s",
                    "same" if found["same"] else "differ",
                )
            )
            if found["rms_sigma"] > arguments.rms_sigma or found["max_sigma"] > arguments.max_sigma:
                bad.append(name)
    except BadInput as error:
        print(f"compare_estimates: {error}", file=sys.stderr)
        return 2
    print_table(rows)
    limit = f"{arguments.rms_sigma:g} rms and {arguments.max_sigma:g} of the reported standard deviation"
    print(f"beyond {limit}: {', '.join(bad)}" if bad else f"all within {limit}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
