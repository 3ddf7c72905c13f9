# SPDX-License-Identifier: BSD-2-Clause
"""Recordings that are broken off in flight: the program is killed, or the computer loses its power."""
from concurrent.futures import ThreadPoolExecutor

import hil_compare

BREAK_S = 6.0
# What may be missing before the break.
MAX_LOST_S = 1.0
CASES = (("killed", "folder"), ("killed", "mcap"), ("power_cut", "folder"), ("power_cut", "mcap"))
WORDS = {"killed": "the program is killed (SIGKILL)", "power_cut": "the computer loses its power"}


def rows(hil):
    print("  recording broken off     form     replayed up to        frames  differs from the whole flight's replay")
    hil.replay("icm42688")
    with ThreadPoolExecutor(hil.args.jobs) as guests:
        return list(guests.map(lambda case: row_of(hil, *case), CASES))


def row_of(hil, kind, form):
    name = f"broken_{kind}_{form}"
    job, report = hil.play("icm42688", name, record=form, faults=[f"{kind}@{BREAK_S}+0"])
    log = job.folder / "out"
    log = log / "flight.mcap" if form == "mcap" else log
    again = job.folder / "again"
    hil.replay_to(log, again)
    poses = hil_compare.read_poses(again, report["shift_ns"])
    whole, _ = hil.replay("icm42688")
    break_ns = report["first_frame_ns"] + round(BREAK_S * hil_compare.NANO)
    row = {
        "kind": kind, "form": form, "words": WORDS[kind], "frames": len(poses),
        "lost_s": (break_ns - max(poses)) / hil_compare.NANO,
        "max_mm": hil_compare.differences(whole, poses)["max_mm"],
    }  # fmt: skip
    row["good"] = row["lost_s"] <= MAX_LOST_S and row["max_mm"] < 1.0
    print(
        f"  {kind:<24} {form:<8} {row['lost_s']:.2f} s before it {row['frames']:>8}  {row['max_mm']:.4f} mm"
        f"{'' if row['good'] else '   NOT AS PROMISED'}",
        flush=True,
    )
    return row
