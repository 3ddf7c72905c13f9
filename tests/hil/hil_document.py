# SPDX-License-Identifier: BSD-2-Clause
"""The tables of docs/hil.md, from the results of hil_run.py."""
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from bench.marked_document import LOCAL_OPTIONS, measured_by, put_between_marks  # noqa: E402

import hil_faults  # noqa: E402

NAMES = {"icm42688": "ICM-42688-P", "adis16475": "ADIS16475-2", "bmi088": "BMI088", "dronecan": "DroneCAN",
         "openimu300": "OpenIMU300", "iio": "the kernel's (IIO)"}  # fmt: skip
SIMULATED_LOG = "log_room"  # of scripts/target/hil


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def virtual_table(rows):
    head = ("sensor", "lines by", "pixels", "recorded as", "frames", "samples as sent", "stamps off by at most",
            "replay of the recording", "ATE, replay of the log", "ATE, in the loop")  # fmt: skip
    return table(head, [(
        NAMES[row["sensor"]], row["backend"], row["format"], row["record"], f"{row['frames']} of {row['of']}",
        f"{row['inertial']['samples']} of {row['inertial']['of']}"
        + (f", to {row['inertial']['max_value']:.0e}" if row["inertial"]["max_value"] else ""),
        f"{row['inertial']['max_stamp_ns']:.0f} ns",
        "differs: " + ", ".join(row["differ"]) if row["differ"] else "the same bytes",
        f"{row['ate_replay_mm']:.2f} mm", f"{row['ate_mm']:.2f} mm") for row in rows])  # fmt: skip


def faults_table(rows):
    head = ("sensor", "fault", "for", "states during it", "reasons", "recovery", "longest gap", "ATE", "at the end",
            "found")  # fmt: skip
    return table(head, [(
        NAMES[row["sensor"]], row["words"], hil_faults.length_words(row), " ".join(row["states"]) or "-",
        ", ".join(row["reasons"]) or "-", "-" if math.isnan(row["recovery_s"]) else f"{row['recovery_s']:.2f} s",
        f"{row['longest_gap_s']:.2f} s", f"{row['ate_mm']:.2f} mm", row["ends"],
        hil_faults.found_words(row) or "nothing") for row in rows])  # fmt: skip


def records_table(rows):
    head = ("6 s after the first frame", "recorded as", "readable up to", "frames",
            "difference to a replay of the whole flight")  # fmt: skip
    return table(head, [(row["words"], row["form"], f"{row['lost_s']:.2f} s before", str(row["frames"]),
                         f"{row['max_mm']:.3f} mm") for row in rows])  # fmt: skip


def real_table(rows):
    head = ("sensor", "frames used", "latency, median / p99", "injector late by up to", "ATE, replay",
            "ATE, in the loop")  # fmt: skip
    return table(head, [(
        NAMES[row["sensor"]], f"{row['frames']} of {row['of']}",
        f"{row['latency_ms']['median']:.0f} / {row['latency_ms']['p99']:.0f} ms", f"{row['late_ms']:.0f} ms",
        f"{row['ate_replay_mm']:.2f} mm", f"{row['ate_mm']:.2f} mm") for row in rows])  # fmt: skip


def soak_table(rows):
    head = ("part", "frames used", "not TRACKING", "late", "latency, median / p99", "memory", "ATE")
    names = {"first": "first 10 min", "last": "last 10 min", "all": "all"}
    lines = []
    for row in rows:
        for part, name in names.items():
            p = row[part]
            of = f" of {row['of']}" if part == "all" else ""
            lines.append((name, f"{p['frames']}{of}", str(p["not_tracking"]), str(p["late"]),
                          f"{p['median_ms']:.1f} / {p['p99_ms']:.1f} ms", f"{p['mib']:.1f} MiB",
                          f"{p['ate_mm']:.2f} mm"))  # fmt: skip
    return table(head, lines)


def one_camera_table(rows):
    head = ("part", "frames used", "LOST", "resets", "median of the images", "well lit", "memory", "ATE")
    names = {"first": "first 10 min", "last": "last 10 min", "all": "all"}
    lines = []
    for row in rows:
        for part, name in names.items():
            p, is_all = row[part], part == "all"
            grey = row["grey"]
            lines.append((name, f"{p['frames']} of {row['of']}" if is_all else str(p["frames"]), str(p["lost"]),
                          str(row["resets"]) if is_all else "", f"{grey['low']} to {grey['high']}" if is_all else "",
                          f"{100.0 * grey['lit']:.1f} %" if is_all else "", f"{p['mib']:.1f} MiB",
                          f"{p['ate_mm']:.2f} mm"))  # fmt: skip
    return table(head, lines)


def made_by(args):
    """The command that a reader can repeat: scripts/target/hil finds the programs, and by default simulates the log."""
    local = LOCAL_OPTIONS | {"--kernel", "--inject"} | ({"--log"} if Path(args.log).name == SIMULATED_LOG else set())
    return measured_by(args.facet, "scripts/target/hil", local)


def update(args, results):
    """Puts every table that has rows between its marks in args.document."""
    agreement = {time: [row for row in results["agreement"] if row["time"] == time] for time in ("virtual", "real")}
    parts = {
        "virtual": (virtual_table, agreement["virtual"]),
        "real": (real_table, agreement["real"]),
        "faults": (faults_table, results["faults"]),
        "records": (records_table, results["records"]),
        "soak": (soak_table, [row for row in results["soak"] if "grey" not in row]),
        "one camera": (one_camera_table, [row for row in results["soak"] if "grey" in row]),
    }
    for name, (make, rows) in parts.items():
        text = f"{make(rows)}\n\n{made_by(args)}" if rows else ""
        if rows and not put_between_marks(args.document, f"scripts/target/hil: {name}", text):
            print(f"hil: {args.document} has no marks for the table '{name}'", file=sys.stderr)
