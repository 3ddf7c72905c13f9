# SPDX-License-Identifier: BSD-2-Clause
"""One job of a sweep: rendering a flight, or flying it and comparing it with the truth.

Usage: python3 -m bench.sweep_job SWEEP OUT FACET simulate FLIGHT
       python3 -m bench.sweep_job SWEEP OUT FACET fly RUN
"""
import json
import os
import pathlib
import shutil
import sys
import tempfile

from bench.benchmark_lib import first_error, fresh_folder, run
from bench.sweep_plan import Plan

KEPT = ["eval.json", "summary.json", "trajectory.tum", "log.txt"]


def flight_marker(out, name):
    """The file that says that a flight is rendered."""
    return pathlib.Path(out) / "flights" / f"{name}.complete"


def row_file(out, name):
    """The file that says what a run gave."""
    return pathlib.Path(out) / "runs" / name / "row.json"


def write_whole(path, text):
    """A file that is there whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".new")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


def simulate(plan, name, done):
    """Renders a flight; `done` is written last, with its identity. Raises RuntimeError if the program fails."""
    flight = plan.flights[name]
    folder = fresh_folder(pathlib.Path(flight.log))
    code, output = run([plan.facet, "sim", *flight.simulate, "--out", folder], folder.with_suffix(".log"))
    if code != 0:
        raise RuntimeError(f"{name}: {first_error(output)}")
    write_whole(done, plan.flight_identity(name))


def figures(folder):
    """What the tables are made of."""
    evaluation = json.loads((folder / "eval.json").read_text())
    summary = json.loads((folder / "summary.json").read_text())
    mesh = evaluation.get("mesh") or {}
    return {"ate_m": evaluation["ate_se3"]["translation_m"]["rmse"],
            "rotation_deg": evaluation["ate_yaw4"]["rotation_deg"]["rmse"],
            "mesh_m": mesh["by_trajectory"]["accuracy_m"]["median"] if mesh else None,
            "time_share": evaluation["coverage"]["time"], "frame_ms": summary["timing"]["all"]["mean"],
            "end": summary["final"]["state"]}


def fly(plan, name, row_path):
    """Flies a run and writes its row: what it is, its identity, its figures, and the problem if there is one.

    A run that fails is a row, too: one bad run must not end a sweep. The folder keeps what KEPT names.
    """
    job = plan.runs[name]
    flight = plan.flights[job.flight]
    row = {"run": name, "flight": job.flight, "mode": job.mode, "variant": job.variant,
           **job.condition.fields(), "seed": job.seed, "problem": "", "identity": plan.run_identity(name)}
    folder = row_path.parent
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="work.", dir=folder) as work:
        out = pathlib.Path(work)
        code, output = run([plan.facet, "replay", flight.log, "--out", out, "--quiet", *plan.replay, *job.options()],
                           out / "log.txt")
        if code != 0:
            row["problem"] = f"replay exit {code}: {first_error(output)}"
        if (out / "summary.json").is_file() and (out / "trajectory.tum").is_file():
            scene = pathlib.Path(flight.log) / "truth/scene.ply"
            code, output = run([plan.facet, "eval", "--groundtruth", flight.log, "--estimate", out, "--json",
                                out / "eval.json", *(["--scene", scene] if scene.is_file() else [])], out / "log.txt")
            if code != 0:
                row["problem"] = row["problem"] or f"eval exit {code}: {first_error(output)}"
            else:
                row.update(figures(out))
        for kept in KEPT:
            if (out / kept).is_file():
                shutil.move(str(out / kept), folder / kept)
    write_whole(row_path, json.dumps(row, indent=2) + "\n")


def read_row(plan, name, path):
    """What a run has left; None if that is nothing, or of another program or with other options."""
    try:
        row = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return row if row["identity"] == plan.run_identity(name) else None


def main():
    sweep, out, facet, what, name = sys.argv[1:]
    plan = Plan(sweep, out, facet)
    if what == "simulate":
        simulate(plan, name, flight_marker(out, name))
    else:
        fly(plan, name, row_file(out, name))


if __name__ == "__main__":
    main()
