# SPDX-License-Identifier: BSD-2-Clause
"""Times the whole pipeline, pinned to one core: frames, keyframes, their stages, and peak memory.

Times are CPU times, without decoding images. Every sequence is replayed --repeat times in every mode, interleaved;
of each figure the least counts, because whatever else runs on the machine only adds. With --against the program of
another commit is built (in out/against, kept for the next time) and replays interleaved with this one, so that their
ratio holds on a machine whose speed drifts; for commits that did not measure frames by CPU time, that of the process
is used. With --scaling the first sequence is also replayed with other numbers of features and keyframes, and the growth
of every stage is fitted: time ~ number^exponent. With --instructions callgrind counts those of every frame of the first
seconds, which no load of the machine changes."""
import json
import math

from bench.benchmark_lib import Work, first_error, fresh_folder, number
from bench.flying import run_measured
from bench.instruction_count import count_instructions
from bench.older_build import BuildFailed, program_of
from bench.plan import PlanError

SCALING = {"frontend.max_features": [50, 100, 150, 200, 300, 400, 512], "window.keyframes": [5, 8, 12, 16, 20, 25, 32]}
FIGURES_OF = ["median", "p99", "max"]
KINDS = ["all", "estimate", "tracked", "keyframe", "keyframe_stages"]
COLUMNS = ["sequence", "mode", "mean", "p99", "estimate p99", *(f"tracked {f}" for f in FIGURES_OF),
           *(f"keyframe {f}" for f in FIGURES_OF), "peak MiB"]
RATIO_COLUMNS = ["sequence", "mode", "clock of", "mean before", "now", "mean", "tracked", "keyframe", "p99",
                 "whole process"]
INSTRUCTION_COLUMNS = ["millions of instructions", "mode", "mean", "p99", "max",
                       *(f"{kind} {f}" for kind in ("tracked", "keyframe") for f in FIGURES_OF)]


def add_options(group):
    group.add_argument("--repeat", type=int, default=3, help="replays of each (default 3)")
    group.add_argument("--scaling", action="store_true", help="also time other numbers of features and keyframes")
    group.add_argument("--against", metavar="COMMIT", help="also time the program of this commit, interleaved")
    group.add_argument("--instructions", type=float, metavar="S", default=0.0,
                       help="also count the instructions of the first S seconds' frames")


def replay(bench, log, mode, out, facet=None, settings=()):
    """Times of one replay by both clocks with its peak resident memory, or what went wrong."""
    fresh_folder(out)
    options = [*bench.plan.options_in(mode), *(part for setting in settings for part in ("--set", setting))]
    code, said, seconds, rss_mib = run_measured(bench.pinned(bench.replay_command(log, out, options, facet)),
                                                out / "log.txt")
    if code != 0 or not (out / "summary.json").is_file():
        return None, f"exit {code}: {first_error(said)}"
    summary = json.loads((out / "summary.json").read_text())
    return {"wall": {key: summary["timing"][key] for key in KINDS if key in summary["timing"]},
            "processor": summary["timing"].get("processor"),  # commits before it was measured have none
            "process_ms": 1e3 * seconds / max(summary["timing"]["all"]["count"], 1), "peak_rss_mib": rss_mib}, ""


def least(timings):
    """Figure by figure the least of several replays of the same work."""
    first = timings[0]
    if isinstance(first, dict):
        return {key: least([t[key] for t in timings]) for key in first}
    return min(timings) if isinstance(first, (int, float)) else first


def rows_of(bench, logs, older):
    """One row a sequence and mode; with a program `older`, one more for it behind each."""
    rows = {}
    work = Work(bench.arguments.repeat * len(logs) * len(bench.plan.modes))
    for turn in range(bench.arguments.repeat):
        for name, log in logs.items():
            for mode in bench.plan.modes:
                work.next(f"turn {turn + 1} of {bench.arguments.repeat}: {name}, {mode}")
                for program in [bench.facet] + ([older] if older else []):
                    row = rows.setdefault((name, mode, program), {"sequence": name, "mode": mode, "runs": [],
                                                                  "is_older": program == older, "problem": ""})
                    timing, problem = replay(bench, log, mode, bench.out / f"{name}_{mode}", program)
                    row["problem"] = problem or row["problem"]
                    row["runs"] += [timing] if timing else []
    for row in rows.values():
        row["timing"] = least(row["runs"]) if row["runs"] else None
    return list(rows.values())


def by_processor(timing):
    """Least times by CPU time, or by the wall's where the program has no other."""
    return timing["processor"] or timing["wall"]


def ratio_rows(rows):
    """For each sequence and mode the times of this program over those of the older one, by CPU time.

    Of a commit that had none for its frames only the mean is reported: what the process took, less what this program's
    takes besides its frames, which is decoding for the most part and the same work in both.
    """
    table = []
    for new, old in zip(rows[0::2], rows[1::2]):
        if new["timing"] is None or old["timing"] is None:
            continue
        a, b = new["timing"]["processor"], old["timing"]["processor"]
        process = [new["timing"]["process_ms"], old["timing"]["process_ms"]]
        before = b["all"]["mean"] if b else process[1] - (process[0] - a["all"]["mean"])
        pairs = [(a["all"]["mean"], before)]
        pairs += [(a[kind][f], b[kind][f] if b else None)
                  for kind, f in [("tracked", "median"), ("keyframe", "median"), ("all", "p99")]]
        table.append([new["sequence"], new["mode"], "frames" if b else "process", number(before, 2),
                      number(a["all"]["mean"], 2)] +
                     ["-" if y is None else number(x / y, 2) for x, y in [*pairs, process]])
    return table


def cells(row):
    name = row["sequence"] + (" (before)" if row["is_older"] else "")
    if row["timing"] is None:
        return [name, row["mode"], row["problem"]] + ["-"] * (len(COLUMNS) - 3)
    timing = by_processor(row["timing"])
    # Programs of commits before it was measured give out the estimate with the frame.
    estimate = timing.get("estimate", timing["all"])
    return ([name, row["mode"], number(timing["all"]["mean"], 2), number(timing["all"]["p99"], 2),
             number(estimate["p99"], 2)] +
            [number(timing[kind][f], 2) for kind in ("tracked", "keyframe") for f in FIGURES_OF] +
            [number(row["timing"]["peak_rss_mib"], 1)])


def instruction_rows(bench, logs):
    """A row a sequence and mode, and what went wrong."""
    rows, problems = [], []
    work = Work(len(logs) * len(bench.plan.modes))
    for name, log in logs.items():
        for mode in bench.plan.modes:
            work.next(f"instructions: {name}, {mode}")
            out = fresh_folder(bench.out / f"instructions_{name}_{mode}")
            options = [*bench.plan.options_in(mode), "--duration", str(bench.arguments.instructions)]
            counts, problem = count_instructions(bench.replay_command(log, out, options), out)
            if counts is None:
                problems.append(f"{name}, {mode}: {problem}")
                continue
            values = [counts["mean"], counts["all"]["p99"], counts["all"]["max"]]
            values += [counts.get(kind, {}).get(f) for kind in ("tracked", "keyframe") for f in FIGURES_OF]
            rows.append([name, mode] + ["-" if f is None else number(1e-6 * f, 1) for f in values])
    return rows, problems


def exponent(points):
    """Slope of log(time) over log(number): least squares over points with times above the clock's grain (0.01 ms)."""
    logs = [(math.log(n), math.log(t)) for n, t in points if t > 0.01]
    if len(logs) < 3:
        return None
    mean_x, mean_y = (sum(column) / len(logs) for column in zip(*logs))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)


def scaling_table(bench, log, key, values):
    """Medians of a tracked frame, a keyframe and its stages over the values of a parameter."""
    mode = list(bench.plan.modes)[-1]
    runs = {value: [] for value in values}
    work = Work(bench.arguments.repeat * len(values))
    for _ in range(bench.arguments.repeat):
        for value in values:
            work.next(f"scaling: {key}={value}")
            timing, problem = replay(bench, log, mode, bench.out / "scaling", settings=[f"{key}={value}"])
            if timing is None:
                raise PlanError(f"{key}={value}: {problem}")
            runs[value].append(timing)
    times = {}
    for value in values:
        timing = by_processor(least(runs[value]))
        parts = {"tracked frame": timing["tracked"], "keyframe": timing["keyframe"], **timing["keyframe_stages"]}
        for name, figures in parts.items():
            times.setdefault(name, []).append(figures["median"])
    rows = [[name, *(number(t, 2) for t in row), number(exponent(list(zip(values, row))), 2)]
            for name, row in times.items()]
    return [key, *map(str, values), "exponent"], rows


def measure(bench):
    try:
        older = program_of(bench.arguments.against) if bench.arguments.against else None
    except BuildFailed as error:
        raise PlanError(f"--against {bench.arguments.against}: {error}") from None
    logs = {name: bench.rendered(log) for name, log in bench.plan.logs.items()}
    bench.results = rows = rows_of(bench, logs, older)
    good = [row for row in rows if row["timing"] and not row["is_older"]]
    stages = list(by_processor(good[0]["timing"])["keyframe_stages"]) if good else []
    made = {"frames": (COLUMNS, [cells(row) for row in rows], 2),
            "stages": (["keyframe stages, median", "mode", *stages],
                       [[row["sequence"], row["mode"], *(number(by_processor(row["timing"])["keyframe_stages"][s][
                           "median"], 2) for s in stages)] for row in good], 2)}
    broken = [f"{row['sequence']}, {row['mode']}: {row['problem']}" for row in rows if row["problem"]]
    if older:
        made["against"] = ([f"now over {bench.arguments.against}", *RATIO_COLUMNS[1:]], ratio_rows(rows), 3)
    if bench.arguments.instructions > 0:
        counted, problems = instruction_rows(bench, logs)
        made["instructions"], broken = (INSTRUCTION_COLUMNS, counted, 2), broken + problems
    if bench.arguments.scaling:
        for key, values in SCALING.items():
            made[key] = (*scaling_table(bench, next(iter(logs.values())), key, values), 1)
    return made, broken
