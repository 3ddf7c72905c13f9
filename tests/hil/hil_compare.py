# SPDX-License-Identifier: BSD-2-Clause
"""What a flight in the guest did, against a replay of the same log: poses, errors, health."""
import csv
import json
import math
import os
import subprocess
from pathlib import Path

NANO = 1_000_000_000


def written(folder, name):
    """A file of a flight; under the name it had while it grew if the program was killed."""
    path = Path(folder) / name
    return path if path.exists() else Path(folder) / f"{name}.part"


def read_poses(folder, shift_ns=0):
    """{stamp in the log's time: (x, y, z, qw, qx, qy, qz)} of trajectory.csv."""
    poses = {}
    with open(written(folder, "trajectory.csv"), encoding="utf-8") as file:
        for row in csv.reader(file):
            if len(row) >= 8 and not row[0].startswith("#"):
                poses[int(row[0]) - shift_ns] = tuple(float(value) for value in row[1:8])
    return poses


def pair_up(reference, other, tolerance_ns=200_000):
    """Poses of the same frame: stamps that came through a kernel are rounded, or not quite on time."""
    stamps = sorted(other)
    pairs = []
    at = 0
    for stamp in sorted(reference):
        while at < len(stamps) and stamps[at] < stamp - tolerance_ns:
            at += 1
        if at < len(stamps) and stamps[at] <= stamp + tolerance_ns:
            pairs.append((stamp, stamps[at]))
    return pairs


def angle_deg(a, b):
    aw, ax, ay, az = a[3:]
    bw, bx, by, bz = b[3:]
    w = aw * bw + ax * bx + ay * by + az * bz
    x = aw * bx - ax * bw - ay * bz + az * by
    y = aw * by - ay * bw - az * bx + ax * bz
    z = aw * bz - az * bw - ax * by + ay * bx
    return math.degrees(2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w)))


def differences(reference, other):
    """Without alignment: both begin at the origin."""
    pairs = pair_up(reference, other)
    if not pairs:
        return {"common": 0, "rms_mm": math.nan, "max_mm": math.nan, "max_deg": math.nan, "max_stamp_us": math.nan}
    distances = [1000.0 * math.dist(reference[a][:3], other[b][:3]) for a, b in pairs]
    return {
        "common": len(pairs),
        "rms_mm": math.sqrt(sum(d * d for d in distances) / len(distances)),
        "max_mm": max(distances),
        "max_deg": max(angle_deg(reference[a], other[b]) for a, b in pairs),
        "max_stamp_us": max(abs(a - b) for a, b in pairs) / 1000.0,
    }


def ate_mm(facet, log, poses, work):
    """By `facet eval`: translation, aligned by yaw and position."""
    Path(work).mkdir(parents=True, exist_ok=True)
    tum = Path(work) / "trajectory.tum"
    lines = [
        f"{stamp // NANO}.{stamp % NANO:09d} {p[0]} {p[1]} {p[2]} {p[4]} {p[5]} {p[6]} {p[3]}\n"
        for stamp, p in sorted(poses.items())
    ]
    tum.write_text("".join(lines), encoding="utf-8")
    result = Path(work) / "eval.json"
    command = [facet, "eval", "--groundtruth", log, "--estimate", tum, "--json", result]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return math.nan
    return 1000.0 * json.loads(result.read_text(encoding="utf-8"))["ate_yaw4"]["translation_m"]["rmse"]


def read_health(folder, shift_ns=0):
    """[(stamp in the log's time, state, reasons)]"""
    rows = []
    with open(written(folder, "health.csv"), encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["reset_counter"] is None:
                continue  # the last line, cut off
            reasons = row["reason_names"].split("|") if row["reason_names"] else []
            rows.append((int(row["stamp_ns"]) - shift_ns, row["state"], reasons, int(row["reset_counter"])))
    return rows


def recovery(health, plain, begin_ns, end_ns):
    """How a fault between two instants showed. `plain` is the health of the same flight without it."""
    usual = {stamp: state for stamp, state, _, _ in plain}
    usual_stamps = sorted(usual)

    def usual_state(stamp):
        near = min(usual_stamps, key=lambda known: abs(known - stamp))
        return usual[near]

    states, reasons = [], []
    recovered_ns = None
    gap_ns = 0
    last = None
    for stamp, state, why, _ in health:
        if last is not None and stamp > begin_ns - 2 * NANO:
            gap_ns = max(gap_ns, stamp - last)
        last = stamp
        if stamp < begin_ns:
            continue
        if state != usual_state(stamp):
            states += [state] if state not in states else []
            recovered_ns = None
        elif recovered_ns is None:
            recovered_ns = stamp
        if stamp < end_ns + NANO:
            reasons += [reason for reason in why if reason not in reasons]
    return {
        "states": states,
        "reasons": reasons,
        "longest_gap_s": gap_ns / NANO,
        "recovery_s": max(0.0, (recovered_ns - end_ns) / NANO) if recovered_ns is not None else math.nan,
        "resets": health[-1][3] - health[0][3] if health else 0,
    }


def read_inertial(folder):
    """[(stamp, (rates and forces))] of a log's inertial sensor."""
    with open(Path(folder) / "mav0/imu0/data.csv", encoding="utf-8") as file:
        return [(int(row[0]), tuple(float(value) for value in row[1:7])) for row in csv.reader(file)
                if row and not row[0].startswith("#")]


def inertial_differences(encoded, recorded, shift_ns):
    """Between the samples that were sent and those that the program recorded, one to one."""
    if len(encoded) != len(recorded):
        return {"samples": len(recorded), "of": len(encoded), "max_value": math.nan, "max_stamp_ns": math.nan}
    return {
        "samples": len(recorded),
        "of": len(encoded),
        "max_value": max(abs(a - b) for (_, x), (_, y) in zip(encoded, recorded) for a, b in zip(x, y)),
        "max_stamp_ns": max(abs(y - shift_ns - x) for (x, _), (y, _) in zip(encoded, recorded)),
    }


def files_that_differ(folder, other, names):
    """Those of the names whose files are not the same to the byte, or are missing."""
    def content(where, name):
        path = Path(where) / name
        return path.read_bytes() if path.is_file() else None

    return [name for name in names if content(folder, name) is None or content(folder, name) != content(other, name)]


def link_log(log, folder, imu_csv):
    """The log with other inertial samples; everything else is linked."""
    root = Path(folder) / "mav0"
    (root / "imu0").mkdir(parents=True, exist_ok=True)
    for entry in os.scandir(Path(log) / "mav0"):
        target = root / entry.name
        if entry.name != "imu0" and not target.exists():
            target.symlink_to(Path(entry.path).resolve())
    sensor = root / "imu0/sensor.yaml"
    if not sensor.exists():
        sensor.symlink_to((Path(log) / "mav0/imu0/sensor.yaml").resolve())
    return imu_csv(root / "imu0/data.csv")
