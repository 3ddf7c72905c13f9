# SPDX-License-Identifier: BSD-2-Clause
"""Flights without a fault: what drivers, threads and synchroniser do to the data, which is to be nothing."""
from concurrent.futures import ThreadPoolExecutor

import hil_compare

# Virtual time: samples against those that were sent. Every look at the clock moves it on by a nanosecond. The forces of
# a BMI088 are interpolated, by stamps that are off by as much.
MAX_VALUE = {"bmi088": 1e-4}
MAX_STAMP_NS = 200
# What a replay of the recording makes again to the byte. Its mesh.ply is of the map, which depends on the threads.
SAME_FILES = ("trajectory.csv", "covariance.csv", "mesh_horizon.ply", "planes.json", "residuals.csv")
# Real time: against the replay's error, as a share; differences below this much are rounding.
MAX_ATE_SHARE = 0.10
LEAST_ATE_MM = 0.5
LEAST_FRAMES = 0.95

FORMATS = (("Y10", 0, False), ("Y10", 0, True), ("Y10P", 0, False), ("Y12", 0, False), ("Y012", 0, False),
           ("Y16", 0, False), ("Y16", 12, False), ("YUYV", 0, False))  # fmt: skip


def format_name(pixels):
    name, bits, high = pixels
    return name + (f", {bits} bits" if bits else "") + (", high bits" if high else "")


def agreement(hil, sensor, virtual_time, **options):
    """One row of the table, and whether it is within the limits."""
    pixels = options.get("pixels", ("GREY", 0, False))
    backend = options.get("backend", "libgpiod")
    record = options.pop("record", "folder") if virtual_time else ""
    name = "_".join([sensor, "virtual" if virtual_time else "real", backend, record or "no"])
    name += "_" + format_name(pixels).replace(", ", "_").replace(" ", "_")
    flight = hil.fly(sensor, name, virtual_time=virtual_time, record=record, **options)
    replay, replay_ate = hil.replay()
    encoded, _ = hil.replay(sensor)
    live = flight["summary"]["live"]
    row = {
        "sensor": sensor,
        "backend": backend,
        "format": format_name(pixels),
        "record": record,
        "time": "virtual" if virtual_time else "real",
        "frames": len(flight["poses"]),
        "of": len(encoded),
        "log": hil_compare.differences(replay, flight["poses"]),
        "encoded": hil_compare.differences(encoded, flight["poses"]),
        "ate_replay_mm": replay_ate,
        "ate_mm": hil.ate(flight["poses"], flight["name"]),
        "latency_ms": live["latency_ms"],
        "drops": live["drops"],
        "overruns": live["overruns"],
        "late_ms": flight["report"]["latest_ms"],
    }
    if record:
        add_recording(hil, sensor, flight, record, row)
    row["good"] = is_good(row)
    return row


def add_recording(hil, sensor, flight, record, row):
    """What was recorded against what was sent, and its replay against the flight."""
    recording = log = flight["folder"]
    parameters = log / "mav0/parameters.yaml"
    if record == "mcap":
        log = flight["folder"] / "flight.mcap"
        parameters = log / "mav0/parameters.yaml"
        recording = hil.out / flight["name"] / "folder"
        hil.call(hil.programs.facet, "convert", log, recording, "--quiet")
    sent = hil_compare.read_inertial(hil.encoded_log(sensor))
    got = hil_compare.read_inertial(recording)
    row["inertial"] = hil_compare.inertial_differences(sent, got, flight["report"]["shift_ns"])
    again = hil.out / flight["name"] / "again"
    hil.replay_to(log, again, ["--config", parameters])
    row["differ"] = hil_compare.files_that_differ(flight["folder"], again, SAME_FILES)


def is_good(row):
    if row["time"] == "virtual":
        inertial = row["inertial"]
        return (row["frames"] == row["of"] and not row["differ"] and inertial["max_stamp_ns"] <= MAX_STAMP_NS
                and inertial["max_value"] <= MAX_VALUE.get(row["sensor"], 0.0))  # fmt: skip
    worse_mm = abs(row["ate_mm"] - row["ate_replay_mm"])
    most_mm = max(MAX_ATE_SHARE * row["ate_replay_mm"], LEAST_ATE_MM)
    return row["frames"] >= LEAST_FRAMES * row["of"] and worse_mm <= most_mm


HEAD = (
    "                                                  recorded against sent    replay of    "
    "against replay of the log  ATE mm            latency ms  late\n"
    "  sensor     lines    pixels         time    frames       samples  value   ns   recording   "
    "rms mm   max mm      replay    live    med   p99   max ms"
)


def print_row(row):
    log = row["log"]
    recorded = " " * 24
    same = ""
    if row["record"]:
        inertial = row["inertial"]
        recorded = f"{inertial['samples']:>4} of {inertial['of']:<4} {inertial['max_value']:.0e}"
        recorded += f" {inertial['max_stamp_ns']:>4.0f}"
        same = ", ".join(row["differ"]) or f"same ({row['record']})"
    print(
        f"  {row['sensor']:<10} {row['backend']:<8} {row['format']:<14} {row['time']:<7}"
        f" {row['frames']:>3} of {row['of']:<3}  {recorded}   {same:<13}"
        f" {log['rms_mm']:>6.3f} {log['max_mm']:>8.3f}     {row['ate_replay_mm']:>7.2f} {row['ate_mm']:>7.2f}"
        f"  {row['latency_ms']['median']:>5.1f} {row['latency_ms']['p99']:>5.1f} {row['late_ms']:>7.2f}"
        f"{'' if row['good'] else '  OUTSIDE THE LIMITS'}",
        flush=True,
    )


def agreement_rows(hil, cases):
    """@param cases  of agreement()'s arguments"""
    rows = []
    if not cases:
        return rows
    print(HEAD)
    hil.replay()
    for sensor in sorted({sensor for sensor, _, _ in cases}):
        hil.replay(sensor)
    jobs = hil.args.jobs if all(virtual_time for _, virtual_time, _ in cases) else 1
    with ThreadPoolExecutor(jobs) as guests:
        for row in guests.map(lambda case: agreement(hil, case[0], case[1], **case[2]), cases):
            rows.append(row)
            print_row(row)
    return rows


def cases_of(args, times):
    """Each sensor once; the lines' other backend, recording in one file and every format with the first one."""
    sensors = args.sensors.split(",") if args.sensors else []
    cases = [(sensor, time, {}) for sensor in sensors for time in times]
    if args.variants and sensors:
        cases.append((sensors[0], True, {"backend": "chardev"}))
        cases.append((sensors[0], True, {"record": "mcap"}))
        cases += [(sensors[0], True, {"pixels": pixels}) for pixels in FORMATS]
    return cases
