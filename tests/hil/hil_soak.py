# SPDX-License-Identifier: BSD-2-Clause
"""A long flight in the guest: whether its last ten minutes are as good as its first."""
import csv
import math
import re
import statistics
from pathlib import Path

import hil_agreement
import hil_compare
import hil_faults

PART_S = 600.0
MINUTE_S = 60.0
SENSOR = "icm42688"
GROWTH_MIB = 1.0  # of memory from the second sixth of the flight, when the mesh is there, to the last one
TRUTH_STEP = 2  # of its rows at 200 Hz every second one
LIGHT = 8.0  # times as much and as little as usual
SETTLED_S = 15  # by then the exposure is found, and the camera gone
MOST_RESETS = 1  # the change of cameras
# Virtual time is as fast as the machine computes: on a busy one a flight took 1.5 times its length. A guest that hangs
# is to end all the same.
VIRTUAL_SLOWNESS = 4.0
LEAST_LIT = 0.99  # share of the seconds in which the living camera's images are as bright as they should be
STATE = re.compile(r"(\w+) quality .* latency ([\d.]+)/([\d.]+) ms, .* (\d+) late, (\d+) overruns")


def limit_s(minutes, time):
    """Seconds of the host in which the flight has to end; the guest boots and decodes the log in the first ones."""
    return 60.0 * minutes * (VIRTUAL_SLOWNESS if time == "virtual" else 1.0) + 600.0


def turn_of(log):
    """Frames of the log, and the time from its first one to that of the next turn."""
    with open(log / "mav0/cam0/data.csv", encoding="utf-8") as file:
        stamps = [int(row[0]) for row in csv.reader(file) if row and not row[0].startswith("#")]
    return len(stamps), (stamps[-1] - stamps[0]) // (len(stamps) - 1) * len(stamps)


def write_truth(log, turns, period_ns, path):
    """The ground truth of all turns as a table; the log itself has that of one."""
    lines = (log / "mav0/state_groundtruth_estimate0/data.csv").read_text(encoding="utf-8").splitlines()
    rows = [line.split(",", 1) for line in lines if not line.startswith("#")][::TRUTH_STEP]
    begin_ns = int(rows[0][0])
    with open(path, "w", encoding="utf-8") as file:
        for turn in range(turns):
            file.writelines(f"{int(stamp) + turn * period_ns},{rest}\n" for stamp, rest in rows
                            if turn == turns - 1 or int(stamp) - begin_ns < period_ns)  # fmt: skip


def read_states(path):
    """[(seconds since the first frame, MiB, state, median and 99th percentile of the latest latencies in ms, late
    frames, overruns)], what the program said each second."""
    states = []
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            said = STATE.match(row["words"])
            if said:
                states.append((float(row["seconds"]), float(row["resident_mib"]), said[1], float(said[2]),
                               float(said[3]), int(said[4]), int(said[5])))  # fmt: skip
    return states


def counted(states, column, begin_s, end_s):
    """By how much one of the program's counters rose."""
    def until(second):
        return max((state[column] for state in states if state[0] < second), default=0)

    return until(end_s) - until(begin_s)


def part_of(hil, flight, states, truth, begin_s, end_s):
    """What a part of the flight was like; NaN is what the program did not say."""
    first_ns = flight["report"]["first_frame_ns"]
    span = [first_ns + round(second * hil_compare.NANO) for second in (begin_s, end_s)]
    poses = {stamp: pose for stamp, pose in flight["poses"].items() if span[0] <= stamp < span[1]}
    said = [state for state in states if begin_s <= state[0] < end_s]
    name = f"{flight['name']}_{begin_s:.0f}"
    return {
        "frames": len(poses),
        "not_tracking": sum(state != "TRACKING" for stamp, state, _, _ in flight["health"]
                            if span[0] <= stamp < span[1]),
        "lost": sum(state == "LOST" for stamp, state, _, _ in flight["health"] if span[0] <= stamp < span[1]),
        "late": counted(states, 5, begin_s, end_s), "overruns": counted(states, 6, begin_s, end_s),
        "median_ms": statistics.median([state[3] for state in said] or [math.nan]),
        "p99_ms": statistics.median([state[4] for state in said] or [math.nan]),
        "worst_p99_ms": max((state[4] for state in said), default=math.nan),
        "mib": max((state[1] for state in said), default=math.nan),
        "ate_mm": hil_compare.ate_mm(hil.programs.facet, truth, poses, hil.out / "eval" / name),
    }  # fmt: skip


def write_minutes(path, minutes):
    """What each minute was like, for scripts/tools/plot_hour."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, ["seconds", *minutes[0]], lineterminator="\n")
        writer.writeheader()
        writer.writerows({"seconds": MINUTE_S * k, **minute} for k, minute in enumerate(minutes))


def is_good(row):
    """Nothing lost, and flat: memory, latency, error."""
    first, last = row["first"], row["last"]
    return (row["frames"] >= hil_agreement.LEAST_FRAMES * row["of"]
            and row["growth_mib"] <= GROWTH_MIB
            and last["median_ms"] <= (1.0 + hil_agreement.MAX_ATE_SHARE) * first["median_ms"]
            and last["ate_mm"] - first["ate_mm"]
            <= max(hil_agreement.MAX_ATE_SHARE * first["ate_mm"], hil_agreement.LEAST_ATE_MM))  # fmt: skip


def grey_of(greys):
    """Of the living, right camera: lowest and highest median, and the share of the seconds in which it is well lit."""
    seen = [right for _, right in greys[SETTLED_S:-1]]
    return {"low": min(median for median, _ in seen), "high": max(median for median, _ in seen),
            "lit": sum(map(hil_faults.is_well_lit, seen)) / len(seen)}  # fmt: skip


def one_camera_is_good(row):
    """Nothing lost, no jump but that to the other camera, memory flat, images bright. A scale from inertial samples
    alone drifts: the error is reported."""
    return (row["frames"] >= hil_agreement.LEAST_FRAMES * row["of"] and row["growth_mib"] <= GROWTH_MIB
            and row["grey"]["lit"] >= LEAST_LIT and row["all"]["lost"] == 0
            and row["resets"] <= MOST_RESETS)  # fmt: skip


def rows(hil, minutes, time):
    frames, period_ns = turn_of(hil.log)
    turns = max(1, round(60e9 * minutes / period_ns))
    length_s = turns * period_ns / hil_compare.NANO
    one_camera = {"faults": [f"unplugged@10+{2 * length_s}"], "light": LIGHT} if hil.args.soak_one_camera else {}
    flight = hil.fly(SENSOR, "soak", virtual_time=time == "virtual", turns=turns, **one_camera)
    truth = hil.out / "soak" / "truth.csv"
    write_truth(hil.log, turns, period_ns, truth)
    states = read_states(Path(hil.out / "soak" / "states.csv"))
    part_s = min(PART_S, length_s / 2)
    row = {"sensor": SENSOR, "minutes": length_s / 60.0, "frames": len(flight["poses"]), "of": turns * frames,
           "late_ms": flight["report"]["latest_ms"], "drops": flight["summary"]["live"]["drops"],
           "resets": flight["health"][-1][3] - flight["health"][0][3]}  # fmt: skip
    for name, begin_s, end_s in (("first", 0.0, part_s), ("last", length_s - part_s, length_s),
                                 ("all", 0.0, length_s)):  # fmt: skip
        row[name] = part_of(hil, flight, states, truth, begin_s, end_s)
    # With one camera the run's mesh takes longer until it is full.
    begin, end = (2 / 3, 5 / 6) if one_camera else (1 / 6, 1 / 3)
    early = [state[1] for state in states if begin * length_s <= state[0] < end * length_s]
    row["growth_mib"] = row["last"]["mib"] - max(early)
    if one_camera:
        row["grey"] = grey_of(flight["report"]["greys"])
    row["good"] = one_camera_is_good(row) if one_camera else is_good(row)
    write_minutes(hil.out / "soak" / "minutes.csv",
                  [part_of(hil, flight, states, truth, MINUTE_S * k, min(MINUTE_S * (k + 1), length_s))
                   for k in range(math.ceil(length_s / MINUTE_S))])  # fmt: skip
    print_row(row)
    return [row]


def print_row(row):
    print(f"  {row['minutes']:.1f} min: {row['frames']} of {row['of']} frames, injector late by up to "
          f"{row['late_ms']:.0f} ms, memory {row['growth_mib']:+.1f} MiB, {row['resets']} resets: "
          f"{'within the limits' if row['good'] else 'OUTSIDE THE LIMITS'}")  # fmt: skip
    if "grey" in row:
        grey = row["grey"]
        print(f"  median of the living camera's images {grey['low']} to {grey['high']}, well lit in "
              f"{100.0 * grey['lit']:.1f} % of the seconds")  # fmt: skip
    for name in ("first", "last", "all"):
        part = row[name]
        print(f"  {name:<6} {part['frames']:>6} frames, {part['not_tracking']} not TRACKING, {part['late']} late, "
              f"{part['median_ms']:.1f} / {part['p99_ms']:.1f} ms (at worst {part['worst_p99_ms']:.1f}), "
              f"{part['mib']:.1f} MiB, ATE {part['ate_mm']:.2f} mm", flush=True)  # fmt: skip
