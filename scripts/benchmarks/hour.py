# SPDX-License-Identifier: BSD-2-Clause
"""Watches a long replay and compares its first ten minutes with its last ones. Leaves hour_MODE.csv (errors of
stretches) and MODE/memory.csv, which scripts/tools/plot_hour draws. Exit code 1: memory has grown, or a flight without
a seam was reset."""
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time

from bench.benchmark_lib import first_error, fresh_folder, number, read_table, run
from bench.looped_log import period_of, stamps_of
from bench.plan import PlanError
from bench.stats import quantile

STRETCH_M = 100.0
PART_S = 600.0
GROWTH_MIB = 1.0  # of memory from the middle of the flight to its end
TRUTH_STEP = 2    # of its rows at 200 Hz every second one
HEADS = ["log", "mode", "part", "ATE/100 m mm", "worst", "pose NEES", "velocity NEES", "process ms", "frame ms", "p99",
         "longest", "memory MiB", "not TRACKING", "resets"]


def add_options(group):
    group.add_argument("--minutes", type=float, default=60.0, help="length of the whole flight (default 60)")
    group.add_argument("--turn", type=float, metavar="S", help="length of one turn of the simulated flight, in place "
                       "of the file's; that of the whole flight: nothing repeats itself")
    group.add_argument("--rate", type=float, metavar="HZ", help="of its cameras, in place of the file's")


def prepare(content, arguments):
    for key, value in (("duration", arguments.turn), ("rate", arguments.rate)):
        if value:
            content["flights"]["closed"][key] = value
    return content


def write_truth(log, stamps, turns, path):
    """Writes the ground truth of all turns as a table."""
    period = period_of(stamps)
    lines = (log / "mav0/state_groundtruth_estimate0/data.csv").read_text().splitlines()[1:]
    rows = [line.split(",", 1) for line in lines[::TRUTH_STEP]]
    begin = int(rows[0][0])
    with path.open("w") as stream:
        for turn in range(turns):
            stream.writelines(f"{int(stamp) + turn * period},{rest}\n" for stamp, rest in rows
                              if turn == turns - 1 or int(stamp) - begin < period)


def watch(command, timing, log):
    """Runs the command. Returns its exit code and a list of (rows of timing.csv, processor seconds, MiB)."""
    ticks = os.sysconf("SC_CLK_TCK")
    sizes = []
    with log.open("w") as stream:
        child = subprocess.Popen(command, stdout=stream, stderr=subprocess.STDOUT)
        while child.poll() is None:
            try:
                growing = timing.with_name(timing.name + ".part")
                fields = pathlib.Path(f"/proc/{child.pid}/stat").read_text().rsplit(")", 1)[1].split()
                status = pathlib.Path(f"/proc/{child.pid}/status").read_text()
                mib = int(status.split("VmRSS:")[1].split()[0]) / 1024.0
                sizes.append((growing.stat().st_size, (int(fields[11]) + int(fields[12])) / ticks, mib))
            except (OSError, IndexError):
                pass  # not begun yet, or over
            time.sleep(1.0)
    text = timing.read_bytes() if timing.is_file() else b""
    rows, place, samples = -1, 0, []  # the header is no row
    for size, cpu_s, mib in sizes:
        rows += text.count(b"\n", place, size)
        place = size
        samples.append((max(rows, 0), cpu_s, mib))
    return child.returncode, samples


def stretches(rows):
    """Row ranges of the trajectory of STRETCH_M of estimated path each."""
    ranges, begin, path_m, before = [], 0, 0.0, None
    for index, row in enumerate(rows):
        place = [float(value) for value in row[1:4]]
        if before:
            path_m += sum((a - b) ** 2 for a, b in zip(place, before)) ** 0.5
        before = place
        if path_m >= STRETCH_M:
            ranges.append((begin, index + 1))
            begin, path_m = index, 0.0
    return ranges


def stretch_errors(bench, out, truth):
    """(seconds since the begin of the flight, ATE in mm) of each stretch."""
    rows = [line.split() for line in (out / "trajectory.tum").read_text().splitlines()]
    truth_rows = [line.split(",", 8) for line in truth.read_text().splitlines()]
    truth_begin = int(truth_rows[0][0])
    truth_step = (int(truth_rows[-1][0]) - truth_begin) / (len(truth_rows) - 1)
    cut, cut_truth, errors = out / "stretch.tum", out / "stretch_truth.tum", []
    for begin, end in stretches(rows):
        cut.write_text("".join(" ".join(row) + "\n" for row in rows[begin:end]))
        span = [1e9 * float(rows[k][0]) for k in (begin, end - 1)]
        first, last = (int((stamp - truth_begin) / truth_step) for stamp in span)
        cut_truth.write_text("".join(
            f"{stamp[:-9]}.{stamp[-9:]} {x} {y} {z} {qx} {qy} {qz} {qw}\n"
            for stamp, x, y, z, qw, qx, qy, qz, _ in truth_rows[max(0, first - 50):last + 50]))
        code, _ = run([bench.facet, "eval", "--groundtruth", cut_truth, "--estimate", cut, "--json",
                       out / "stretch.json"], out / "log.txt")
        if code == 0:
            ate = json.loads((out / "stretch.json").read_text())["ate_se3"]["translation_m"]["rmse"]
            errors.append((float(rows[begin][0]) - float(rows[0][0]), 1e3 * ate))
    return errors


def cells(out, rate, samples, errors, begin_s, end_s):
    """What a part of the flight was like."""
    health, timing = read_table(out / "health.csv"), read_table(out / "timing.csv")
    first, last = int(begin_s * rate), min(int(end_s * rate), len(health)) - 1
    origin = int(health[0]["stamp_ns"])
    claims = [(float(row["nees_pose"]), float(row["nees_velocity"]))
              for row in (read_table(out / "errors.csv") if (out / "errors.csv").is_file() else [])
              if begin_s <= 1e-9 * (int(row["stamp_ns"]) - origin) < end_s]
    nees = [statistics.fmean(values) for values in zip(*claims)] or [None, None]
    frames_ms = [float(row["total_cpu_ms"]) for row in timing[first:last]]
    watched = [sample for sample in samples if first <= sample[0] <= last]
    frames = watched[-1][0] - watched[0][0] if watched else 0
    ate = [value for seconds, value in errors if begin_s <= seconds < end_s]
    return [number(statistics.median(ate) if ate else None, 2), number(max(ate, default=None), 2),
            *(number(value, 2) for value in nees),
            number(1e3 * (watched[-1][1] - watched[0][1]) / frames if frames else None, 2),
            number(statistics.median(frames_ms), 2), number(quantile(frames_ms, 0.99), 1), number(max(frames_ms), 1),
            number(max((sample[2] for sample in watched), default=None), 1),
            str(sum(row["state"] != "TRACKING" for row in health[first:last + 1])),
            str(int(health[last]["reset_counter"]) - int(health[first]["reset_counter"]))]


def judge(bench, log, stamps, turns, out):
    """Errors of the stretches, and words on the whole flight."""
    truth = out / "truth.csv"
    write_truth(log, stamps, turns, truth)
    code, output = run([bench.facet, "eval", "--groundtruth", truth, "--estimate", out, "--json", out / "eval.json",
                        "--errors", out / "errors.csv"], out / "log.txt")
    if code != 0:
        raise PlanError(f"eval exit {code}: {first_error(output)}")
    found = json.loads((out / "eval.json").read_text())
    errors = stretch_errors(bench, out, truth)
    truth.unlink()
    return errors, (f"path {found['path_m']:.0f} m, ATE over all of it "
                    f"{1e3 * found['ate_se3']['translation_m']['rmse']:.1f} mm, drift at the end "
                    f"{found['end_drift_percent']:.3f} %, ")


def replay(bench, name, mode, out):
    """(stamps of the log's frames, (rows, processor seconds, MiB) meanwhile, errors of stretches, words on them)."""
    log = bench.plan.logs[name]
    folder = bench.rendered(log)
    stamps = stamps_of(folder)
    turns = max(1, round(60e9 * bench.arguments.minutes / (stamps[-1] - stamps[0])))
    faults = ("imu_noise=1", f"imu_bias=1,{log.seed}", "calibration=1,1", "vibration=flight,1")
    seamless = ["--loops", turns, *(part for fault in faults for part in ("--inject", fault))]
    options = [*bench.plan.options_in(mode), *(seamless if log.simulate else ["--passes", turns])]
    code, samples = watch(bench.pinned(bench.replay_command(folder, out, options)), out / "timing.csv", out / "log.txt")
    said = (out / "log.txt").read_text()
    if (code != 0 and "interrupted" not in said) or not samples:
        raise PlanError(f"replay exit {code}: {first_error(said)}")
    return (stamps, samples, *(judge(bench, folder, stamps, turns, out) if log.simulate else ([], "")))


def fly(bench, name, mode):
    """Rows of one log in one mode, and what is not as it should be."""
    out = fresh_folder(bench.out / (mode if len(bench.plan.logs) == 1 else f"{name}_{mode}"))
    stamps, samples, errors, note = replay(bench, name, mode, out)
    (bench.out / f"hour_{out.name}.csv").write_text(
        "seconds,ate_mm\n" + "".join(f"{t:.1f},{mm:.3f}\n" for t, mm in errors))
    rate = 1e9 * (len(stamps) - 1) / (stamps[-1] - stamps[0])
    (out / "memory.csv").write_text("seconds,resident_mib\n" + "".join(
        f"{rows / rate:.1f},{mib:.1f}\n" for rows, _, mib in samples))
    whole_s = len(read_table(out / "health.csv")) / rate  # it may have been interrupted
    part_s, middle = min(PART_S, 0.5 * whole_s), len(samples) // 2
    growth = max(s[2] for s in samples[middle:]) - max((s[2] for s in samples[:middle]), default=0.0)
    bench.notes.append(f"{name}, {mode}: {whole_s / 60:.1f} min, {note}memory {growth:+.1f} MiB in the second half")
    rows = [[name, mode, part, *cells(out, rate, samples, errors, begin, end)] for part, begin, end in
            ((f"first {part_s / 60:.3g} min", 0.0, part_s), (f"last {part_s / 60:.3g} min", whole_s - part_s, whole_s),
             ("all", 0.0, whole_s))]
    broken = [f"{name}, {mode}: memory has grown by {growth:.1f} MiB"] if growth >= GROWTH_MIB else []
    broken += [f"{name}, {mode}: reset"] if bench.plan.logs[name].simulate and rows[-1][-1] != "0" else []
    return rows, broken


def measure(bench):
    rows, broken = [], []
    for name in bench.plan.logs:
        for mode in bench.plan.modes:
            print(f"{name}, mode {mode}: {bench.arguments.minutes:g} min", file=sys.stderr, flush=True)
            try:
                more, wrong = fly(bench, name, mode)
            except PlanError as error:
                more, wrong = [], [f"{name}, {mode}: {error}"]
            rows, broken = rows + more, broken + wrong
    bench.results = rows
    return {"hour": (HEADS, rows, 3)}, broken
