# SPDX-License-Identifier: BSD-2-Clause
"""Calibrates on one log with `facet calibrate` and replays the others with the result.

The logs must share one true rig, which their sensor.yaml files state. For every log and draw the calibration is made
wrong by K and refined from that log; every other log is replayed with the result."""
import json
import statistics

from bench.benchmark_lib import Work, first_error, fresh_folder, number, run
from bench.plan import PlanError

HEADS = ["calibrated on", "replayed", "K", "seeds", "ATE mm", "worst", "x true", "worst principal px"]


def calibrated(bench, log, folder, options=()):
    """Parameters by name, as given and as refined, of a calibration whose files are put into the folder."""
    code, output = run([bench.facet, "calibrate", log, "--out", folder / "refined", "--quiet", *options],
                       folder / "log.txt")
    if code != 0:
        raise PlanError(f"{log.name}: calibrate exit {code}: {first_error(output)}")
    return {row["name"]: row for row in json.loads((folder / "refined/calibration.json").read_text())["parameters"]}


def ate_mm(bench, log, folder, options=()):
    """Error of one replay."""
    fresh_folder(folder)
    own = bench.plan.options_in(next(iter(bench.plan.modes)))
    run(bench.replay_command(log, folder, [*own, *options]), folder / "log.txt")
    problem = bench.evaluate(log, folder)
    if problem:
        raise PlanError(f"{log.name}: {problem}")
    for large in folder.glob("*.ply"):
        large.unlink()
    return 1e3 * json.loads((folder / "eval.json").read_text())["ate_se3"]["translation_m"]["rmse"]


def draws(bench, source, log, condition, logs, work):
    """[(error of a principal point (px), {log: ATE (mm)})] of every draw."""
    own = calibrated(bench, log, fresh_folder(bench.out / f"{source}_own"))
    truth = {name: row["given"] for name, row in own.items() if name[4:] in (".cx", ".cy")}
    found = []
    for seed in bench.plan.seeds:
        work.next(f"{source}, K = {condition}, seed {seed}")
        folder = fresh_folder(bench.out / f"{source}_{condition.name(seed)}")
        refined = calibrated(bench, log, folder, condition.options(seed))
        found.append((max(abs(refined[name]["refined"] - value) for name, value in truth.items()),
                      {name: ate_mm(bench, other, folder / name, ["--calibration", folder / "refined"])
                       for name, other in logs.items() if name != source}))
    return found


def measure(bench):
    logs = {name: bench.rendered(log) for name, log in bench.plan.logs.items()}
    if len(logs) < 2:
        raise PlanError("at least two logs: one to calibrate on, one to replay")
    reference = {name: ate_mm(bench, log, bench.out / f"{name}_true") for name, log in logs.items()}
    work = Work(len(logs) * len(bench.plan.conditions) * len(bench.plan.seeds))
    rows, broken, bench.results = [], [], []
    for source, log in logs.items():
        for condition in bench.plan.conditions:
            try:
                mine = draws(bench, source, log, condition, logs, work)
            except PlanError as error:
                broken.append(str(error))
                continue
            bench.results.append({"source": source, "K": str(condition), "draws": mine})
            for name in (name for name in logs if name != source):
                ate = [errors[name] for _, errors in mine]
                rows.append([source, name, str(condition), str(len(ate)), number(statistics.median(ate), 2),
                             number(max(ate), 2), number(statistics.median(ate) / reference[name], 2),
                             number(max(px for px, _ in mine), 3)])
    return {"calibrate": (HEADS, rows, 2)}, broken
