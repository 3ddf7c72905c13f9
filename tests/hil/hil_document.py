# SPDX-License-Identifier: BSD-2-Clause
"""The tables of docs/hil.md, from the results of hil_run.py."""
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from bench.marked_document import put_between_marks  # noqa: E402

import hil_faults  # noqa: E402

NAMES = {"icm42688": "ICM-42688-P", "adis16475": "ADIS16475-2", "bmi088": "BMI088", "dronecan": "DroneCAN",
         "openimu300": "OpenIMU300"}  # fmt: skip


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
    head = ("sensor", "fault", "for", "states meanwhile", "reasons", "recovery", "longest gap", "ATE", "at the end",
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


def update(document, results):
    """Puts every table that has rows between its marks."""
    parts = {
        "virtual": (virtual_table, [row for row in results["agreement"] if row["time"] == "virtual"]),
        "faults": (faults_table, results["faults"]),
        "records": (records_table, results["records"]),
    }
    for name, (make, rows) in parts.items():
        if rows and not put_between_marks(document, f"scripts/hil: {name}", make(rows)):
            print(f"hil: {document} has no marks for the table '{name}'", file=sys.stderr)
