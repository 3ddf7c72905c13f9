# SPDX-License-Identifier: BSD-2-Clause
"""Every sensor with every way in which it fails: cells of faults.yaml become cases, and each flight is judged by what
its cell expects: states and reasons, recovery, a bound on the error, the exit code; in any cell no crash, hang, memory
or output beyond limits, and no silence: TRACKING with a high quality although the error is beyond five standard
deviations. results.json has a row a cell; scripts/report draws it."""
import dataclasses

from bench.benchmark_lib import number
from bench.fault_matrix import Cell, Flight, final_state, judge, read_cells

COLUMNS = ["sensor", "fault", "`--inject`, for", "log", "states during it", "reasons", "recovery (s)", "ATE (mm)",
           "estimated (%)", "resets", "end", "undetected error (s)"]
LOG_COLUMN, LEFT = 3, 6
SPANS = {"always": "always", "on": "to the end"}


def prepare(content, arguments):
    """The cells as cases, the first of them without a fault."""
    cells = read_cells(content)
    limits = content["limits"]
    none = Cell("-", "none", (), ate_mm=limits["ate_mm"], when="always", states=("INIT", "TRACKING"),
                estimates=limits["estimates"])
    arguments.matrix = {**content, "cells": {cell.name: cell for cell in [none, *cells]}}
    if arguments.cases:
        arguments.cases = [none.name, *(text.replace(": ", ", ") for text in arguments.cases)]
    specs = {cell.name: list(cell.specs(content["at"], content["length"])) for cell in [none, *cells]}
    return {"title": f"mode s; faults from {content['at']:g} s on, for {content['length']:g} s unless they last to the "
            "end; ATE RMSE after SE(3) alignment; recovery: from the end of the fault to TRACKING that stays; "
            "undetected error: TRACKING with high quality while wrong by more than five sigma",
            "document": "docs/faults.md",
            "flights": content["flights"], "may_fail": True,
            "cases": {name: {"inject": given} for name, given in specs.items()}}


def first_stamp_and_count(run):
    root = run.log / "mav0" if (run.log / "mav0").is_dir() else run.log
    stamps = [int(line.split(",")[0]) for line in (root / "cam0/data.csv").read_text().splitlines()
              if line and not line.startswith("#")]
    return stamps[0], len(stamps), 1e-9 * (stamps[-1] - stamps[0])


def flight_of(run):
    """What a Run has left for the judge."""
    first_ns, frames, duration_s = first_stamp_and_count(run)
    flight = Flight([], [], {}, frames, 0, exit=run.exit, seconds=run.seconds, rss_mib=run.rss_mib,
                    files_mib=run.files_mib, duration_s=duration_s)
    if run.exit not in (0, 1):
        flight.trouble = f"replay ended by signal {-run.exit}" if run.exit < 0 else run.problem
    elif not run.has_result:
        flight.trouble = run.problem or "no summary"
    if not run.summary:
        flight.trouble = flight.trouble or "no summary"
        return flight
    flight.warnings, flight.estimates = run.summary["warnings_by_kind"], run.summary["estimates"]
    flight.health = [{"t_ns": int(row["stamp_ns"]) - first_ns, "state": row["state"], "quality": int(row["quality"]),
                      "resets": int(row["reset_counter"]), "reasons": [r for r in row["reason_names"].split("|") if r]}
                     for row in run.health]
    if run.eval:
        flight.ate_mm = 1e3 * run.eval["ate_se3"]["translation_m"]["rmse"]
    for row in run.errors:
        numbers = [float(value) for value in list(row.values())[1:19]]
        flight.errors.append({"t_ns": int(row["stamp_ns"]) - first_ns, "theta": numbers[0:3], "p": numbers[3:6],
                              "theta_sigma": [max(s, 1e-9) for s in numbers[9:12]],
                              "p_sigma": [max(s, 1e-9) for s in numbers[12:15]]})
    return flight


def row_of(run, matrix):
    cell = matrix["cells"][run.flight.case]
    flight = flight_of(run)
    verdict = judge(cell, flight, matrix["limits"], cell.window(matrix["at"], matrix["length"]))
    told = "as expected" if verdict.is_kept else "; ".join(verdict.broken)
    if cell.known and verdict.silent_s > 0:
        told += f" ({cell.known})"
    return {"sensor": cell.sensor, "fault": cell.fault, "log": run.flight.sequence, "states": verdict.states,
            "reasons": verdict.reasons, "recovery_s": verdict.recovery_s, "ate_mm": flight.ate_mm,
            "estimated": flight.estimates / max(1, flight.frames), "silent_s": verdict.silent_s,
            "end": final_state(flight), "kept": verdict.is_kept, "verdict": told,
            "span": SPANS.get(cell.when, f"{matrix['length']:g} s"), "exit": flight.exit, "seconds": flight.seconds,
            "rss_mib": flight.rss_mib, "files_mib": flight.files_mib,
            "resets": flight.health[-1]["resets"] if flight.health else 0, "cell": dataclasses.asdict(cell)}


def cells_of(row):
    specs = [f"`{spec}`" for spec in row["cell"]["inject"]]
    injected = ", ".join([*specs, row["span"]]) if specs else "-"
    # That a frame was refused is reported by image_rejected or imu_gap.
    reasons = ", ".join(reason for reason in row["reasons"] if reason != "refused_frame")
    return [row["sensor"], row["fault"], injected, row["log"], " ".join(row["states"]), reasons or "-",
            number(row["recovery_s"], 2), number(row["ate_mm"], 1), f"{100 * row['estimated']:.0f}", str(row["resets"]),
            row["end"], f"{row['silent_s']:.1f}" if row["silent_s"] else "-"]


def tables(bench, runs):
    rows = [row_of(run, bench.arguments.matrix) for run in runs.values() if run]
    bench.results = rows
    kept = sum(row["kept"] for row in rows)
    bench.notes = [f"{kept} of {len(rows)} cells are as expected"]
    said = [f"{row['sensor']}, {row['fault']}, {row['log']}: {row['verdict']}" for row in rows
            if row["verdict"] != "as expected"]
    broken = [line for line, row in zip(said, (r for r in rows if r["verdict"] != "as expected")) if not row["kept"]]
    bench.notes += [line for line in said if line not in broken]
    made = [cells_of(row) for row in rows]
    if len({row["log"] for row in rows}) > 1:
        return {"faults": (COLUMNS, made, LEFT)}, broken
    without = [cells[:LOG_COLUMN] + cells[LOG_COLUMN + 1:] for cells in made]
    return {"faults": (COLUMNS[:LOG_COLUMN] + COLUMNS[LOG_COLUMN + 1:], without, LEFT - 1)}, broken
