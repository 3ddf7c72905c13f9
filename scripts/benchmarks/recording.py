# SPDX-License-Identifier: BSD-2-Clause
"""Plays a log at its pace to the threads of facet run, without recording, into a folder and into an MCAP file.

Threads have the priorities of a vehicle's where the system grants them; images are decoded on the same core. With
--turns the log, which must end as it began (facet sim --closed), is repeated without a seam: a soak."""
import json
import subprocess

from bench.benchmark_lib import Work, fresh_folder
from bench.plan import PlanError

FORMS = ["none", "folder", "mcap"]
GROWTH_MB = 5.0  # from the middle to the end
HEADS = ["log", "recorded", "estimator", "recorder", "ms a pair", "MB a pair", "MB resident, half and end",
         "frames late", "missing in the log"]


def add_options(group):
    group.add_argument("--forms", nargs="+", default=FORMS, choices=FORMS, help="of the recording (default: all)")
    group.add_argument("--turns", type=int, default=1, help="how often the log is played (default 1)")


def play(bench, log, form):
    """What recording_load, which is built beside the program by scripts/build --all, measured."""
    program = bench.facet.parent / "recording_load"
    if not program.is_file():
        raise PlanError(f"{program} is missing: scripts/build release --all")
    folder = fresh_folder(bench.out / form)
    command = bench.pinned([program, log, form, folder, bench.arguments.turns])
    child = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, text=True, check=False)
    if child.returncode not in (0, 1):
        raise PlanError(f"recording_load ended with exit code {child.returncode}")
    fresh_folder(folder)
    return {**json.loads(child.stdout), "is_complete": child.returncode == 0}


def cells(result):
    def share(thread):
        return f"{100 * result['processor_s'].get(thread, 0.0) / result['duration_s']:.1f} %"
    pairs, resident = result["pairs"], result["resident_mb"]
    a_pair = [f"{1e3 * result['processor_s'].get('facet-record', 0.0) / pairs:.1f}",
              f"{result['written_mb'] / pairs:.2f}"] if pairs else ["-", "-"]
    missing = sum(count for name, count in result["drops"].items() if name.endswith("_not_recorded"))
    return [share("facet-estimator"), share("facet-record"), *a_pair, f"{resident['half']:.0f}, {resident['end']:.0f}",
            f"{result['drops']['late_frames']} of {result['frames']}", str(missing)]


def measure(bench):
    forms, logs = bench.arguments.forms, bench.plan.logs
    work = Work(len(forms) * len(logs))
    rows, broken, bench.results = [], [], {}
    for name, log in logs.items():
        for form in forms:
            work.next(f"{name}, recorded: {form}")
            result = bench.results.setdefault(name, {})[form] = play(bench, bench.rendered(log), form)
            rows.append([name, form, *cells(result)])
            bench.notes += [f"the system refused: {words}" for words in result["refusals"]]
            grown = result["resident_mb"]["end"] - result["resident_mb"]["half"] > GROWTH_MB
            broken += [f"{name}, {form}: memory has grown by more than {GROWTH_MB:g} MB"] if (
                grown and bench.arguments.turns > 1) else []
            broken += [] if result["is_complete"] else [f"{name}, {form}: something is missing in the log"]
    bench.notes = list(dict.fromkeys(bench.notes))
    return {"soak" if bench.arguments.turns > 1 else "recording": (HEADS, rows, 2)}, broken
