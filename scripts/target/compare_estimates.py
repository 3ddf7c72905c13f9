#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compares the trajectories that programs for different processors made of the same log, frame by frame and without any
alignment, with the first one's.

Usage: compare_estimates.py [--max-mm MM] [--max-deg DEG] NAME=FOLDER NAME=FOLDER...
FOLDER is the output folder of `facet replay`. Exit codes: 0 all within the limits, 1 some are not, 2 bad input.
"""
import argparse
import math
import sys
from pathlib import Path

SAME_FRAME_S = 0.005
COLUMNS = ("program", "frames", "position: rms", "max", "orientation: rms", "max", "same bytes")


class BadInput(Exception):
    pass


def read_trajectory(folder):
    """Poses by stamp, as written: {"140.05": (x, y, z, qx, qy, qz, qw)}."""
    path = Path(folder) / "trajectory.tum"
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror}") from error
    poses = {}
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.startswith("#"):
            continue
        words = line.split()
        try:
            values = tuple(float(word) for word in words[1:])
        except ValueError:
            values = ()
        if len(values) != 7 or not all(math.isfinite(value) for value in values):
            raise BadInput(f"{path}:{number}: not a stamp and seven numbers")
        poses[words[0]] = values
    if not poses:
        raise BadInput(f"{path}: no pose")
    return poses


def distance_m(a, b):
    return math.dist(a[:3], b[:3])


def angle_deg(a, b):
    """Angle of the rotation between two quaternions. By the vector part of their quotient: the arc cosine of the scalar
    part has no digits left near zero."""
    ax, ay, az, aw = a[3:]
    bx, by, bz, bw = b[3:]
    w = aw * bw + ax * bx + ay * by + az * bz
    x = aw * bx - ax * bw - ay * bz + az * by
    y = aw * by - ay * bw - az * bx + ax * bz
    z = aw * bz - az * bw - ax * by + ay * bx
    return math.degrees(2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w)))


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def pairs(reference, other):
    """Stamps of the same frame in both: they contain the time offset of their run, which differs in its last digits."""
    found = []
    left, right = sorted(reference, key=float), sorted(other, key=float)
    while left and right:
        apart_s = float(left[-1]) - float(right[-1])
        if abs(apart_s) < SAME_FRAME_S:
            found.append((left.pop(), right.pop()))
        elif apart_s > 0.0:
            left.pop()
        else:
            right.pop()
    return found


def compare(reference, other):
    """Differences of two trajectories. Frames that only one of them has make them incomparable."""
    same_frame = pairs(reference, other)
    only = len(reference) + len(other) - 2 * len(same_frame)
    if only > 0:
        raise BadInput(f"{only} frames have an estimate in one of the two only")
    positions = [1000.0 * distance_m(reference[a], other[b]) for a, b in same_frame]
    angles = [angle_deg(reference[a], other[b]) for a, b in same_frame]
    return {
        "frames": len(reference),
        "rms_mm": rms(positions),
        "max_mm": max(positions),
        "rms_deg": rms(angles),
        "max_deg": max(angles),
        "same": reference == other,
    }


def print_table(rows):
    widths = [max(len(row[i]) for row in (COLUMNS, *rows)) for i in range(len(COLUMNS))]
    for row in (COLUMNS, tuple("-" * width for width in widths), *rows):
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("estimates", nargs="+", metavar="NAME=FOLDER")
    parser.add_argument("--max-mm", type=float, default=1.0)
    parser.add_argument("--max-deg", type=float, default=0.01)
    arguments = parser.parse_args()
    try:
        named = [estimate.split("=", 1) for estimate in arguments.estimates]
        if len(named) < 2 or any(len(pair) != 2 for pair in named):
            raise BadInput("at least two NAME=FOLDER are needed")
        trajectories = [(name, read_trajectory(folder)) for name, folder in named]
        reference_name, reference = trajectories[0]
        rows = [(reference_name, str(len(reference)), "reference", "", "", "", "")]
        bad = []
        for name, trajectory in trajectories[1:]:
            try:
                found = compare(reference, trajectory)
            except BadInput as error:
                raise BadInput(f"{reference_name} and {name}: {error}") from error
            rows.append(
                (
                    name,
                    str(found["frames"]),
                    f"{found['rms_mm']:.6f} mm",
                    f"{found['max_mm']:.6f} mm",
                    f"{found['rms_deg']:.7f} deg",
                    f"{found['max_deg']:.7f} deg",
                    "yes" if found["same"] else "no",
                )
            )
            if found["max_mm"] > arguments.max_mm or found["max_deg"] > arguments.max_deg:
                bad.append(name)
    except BadInput as error:
        print(f"compare_estimates: {error}", file=sys.stderr)
        return 2
    print_table(rows)
    if bad:
        print(f"beyond {arguments.max_mm:g} mm or {arguments.max_deg:g} deg: {', '.join(bad)}")
        return 1
    print(f"all within {arguments.max_mm:g} mm and {arguments.max_deg:g} deg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
