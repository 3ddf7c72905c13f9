# SPDX-License-Identifier: BSD-2-Clause
"""The matrix of faults: its file, checked, and the verdict on one flight with one fault."""
import bisect
import dataclasses
import math

from bench.plan import PlanError, as_list, known

WHEN = ("always", "on", "while")
STATES = ("INIT", "TRACKING", "DEGRADED", "LOST", "none")
CELL_KEYS = {"sensor", "fault", "inject", "at", "when", "states", "reasons", "warnings", "recovery_s", "ate_mm", "end",
             "estimates", "exit", "known"}
FILE_KEYS = {"at", "length", "flights", "limits", "known", "cells", "guest"}
LIMIT_KEYS = {"seconds_per_second", "rss_mib", "files_mib", "silent_sigmas", "silent_mm", "silent_deg",
              "silent_quality", "silent_s", "ate_mm", "recovery_s", "estimates"}


@dataclasses.dataclass(frozen=True)
class Cell:
    """One fault of one sensor, and what a flight with it has to show."""
    sensor: str
    fault: str
    inject: tuple           # as --inject takes it, without times
    when: str = "while"     # always: in the whole flight; on: from a time to the end; while: for some time
    states: tuple = ("TRACKING",)  # that may be seen while the fault lasts; none: no estimate is given
    reasons: tuple = ()     # of health.csv, or a kind of warning: one of them has to be seen while the fault lasts
    recovery_s: float = None   # from the end of the fault to TRACKING that stays
    ate_mm: float = None       # bound on the error over the whole flight; infinite: none, the state says it all
    end: tuple = ("TRACKING",)  # states that the flight may end in
    estimates: float = None    # least share with an estimate of the frames that can have one
    exit: tuple = (0,)         # of facet replay, one of these
    at: float = None           # seconds after the first frame, where it matters; else the file's
    known: str = ""            # why the error is not detected here; stands in the table

    @property
    def name(self):
        """Names the cell's case, and with other signs its folder."""
        return f"{self.sensor}, {self.fault}"

    def specs(self, at_s, length_s):
        """Arguments of --inject."""
        at_s = at_s if self.at is None else self.at
        window = {"always": "", "on": f"@{at_s:g}", "while": f"@{at_s:g}+{length_s:g}"}[self.when]
        return [spec if spec.startswith("calibration") else spec + window for spec in self.inject]

    def window(self, at_s, length_s):
        """When the fault lasts, seconds after the first frame."""
        at_s = at_s if self.at is None else self.at
        return (0.0 if self.when == "always" else at_s, at_s + length_s if self.when == "while" else math.inf)


def read_cell(entry, limits, number):
    where = f"cell {number}"
    known(entry, CELL_KEYS, where)
    for key in ("sensor", "fault", "inject"):
        if key not in entry:
            raise PlanError(f"{where}: has no {key}")
    where = f"{entry['sensor']}, {entry['fault']}"
    fields = dict(entry)
    for key in ("inject", "states", "reasons", "end", "exit"):
        if key in fields:
            fields[key] = tuple(as_list(fields[key]))
    for key in ("recovery_s", "ate_mm", "estimates"):
        fields[key] = float(fields.get(key, limits[key]))
    cell = Cell(**fields)
    if cell.when not in WHEN:
        raise PlanError(f"{where}: when: must be one of {', '.join(WHEN)}")
    for state in cell.states + cell.end:
        if state not in STATES:
            raise PlanError(f"{where}: unknown state '{state}'; one of: {', '.join(STATES)}")
    return cell


def read_cells(matrix):
    """The cells of a file's content; PlanError if something is wrong with it."""
    known(matrix, FILE_KEYS, "the file")
    known(matrix["limits"], LIMIT_KEYS, "limits")
    for key in LIMIT_KEYS:
        if not isinstance(matrix["limits"].get(key), (int, float)):
            raise PlanError(f"limits: {key} must be a number")
    cells = [read_cell(entry, matrix["limits"], i + 1) for i, entry in enumerate(matrix["cells"])]
    names = [cell.name for cell in cells]
    for name in names:
        if names.count(name) > 1:
            raise PlanError(f"the cell {name} stands there twice")
    return cells


@dataclasses.dataclass
class Flight:
    """What a replay with a fault left: rows of health.csv and of errors.csv, and figures of the process."""
    health: list
    errors: list
    warnings: dict
    frames: int           # of the log
    estimates: int        # with an estimate
    ate_mm: float = None  # none: it could not be compared
    exit: int = 0
    seconds: float = 0.0     # of CPU time
    duration_s: float = 1.0  # of the log
    rss_mib: float = 0.0
    files_mib: float = 0.0
    trouble: str = ""     # a crash, a hang, or an evaluation that failed


def seconds_of(rows):
    """Rows with the time since the log's first frame."""
    return [(1e-9 * row["t_ns"], row) for row in rows]


def settled(flight):
    """Rows without the last two: a log may end before the inertial samples that its last frames need."""
    return flight.health[:-2] if len(flight.health) > 2 else flight.health


def recovery_s(flight, end_s):
    """From the end of the fault to TRACKING that stays to the flight's end; none if it never does."""
    start = None
    for t, row in seconds_of(settled(flight)):
        if t < end_s:
            continue
        if row["state"] != "TRACKING":
            start = None
        elif start is None:
            start = t
    return None if start is None else max(0.0, start - end_s)


def final_state(flight):
    rows = settled(flight)
    return rows[-1]["state"] if rows else "none"


def silent_s(flight, limits):
    """Seconds of undetected error: TRACKING with high quality, but wrong far beyond the reported covariance."""
    period_s = flight.duration_s / max(1, flight.frames - 1)
    stamps = [row["t_ns"] for row in flight.health]
    wrong = 0
    for error in flight.errors:
        # The estimate's stamp is the frame's with the time offset that was found: the row before, or the one after.
        at = bisect.bisect_left(stamps, error["t_ns"] - int(5e8 * period_s))
        if at == len(stamps) or stamps[at] > error["t_ns"] + 5e8 * period_s:
            continue
        row = flight.health[at]
        if row["state"] != "TRACKING" or row["quality"] <= limits["silent_quality"]:
            continue
        place = max(abs(e) / s for e, s in zip(error["p"], error["p_sigma"]))
        turn = max(abs(e) / s for e, s in zip(error["theta"], error["theta_sigma"]))
        far = 1e3 * math.hypot(*error["p"]) > limits["silent_mm"]
        turned = math.degrees(math.hypot(*error["theta"])) > limits["silent_deg"]
        if (place > limits["silent_sigmas"] and far) or (turn > limits["silent_sigmas"] and turned):
            wrong += 1
    return wrong * period_s


@dataclasses.dataclass
class Verdict:
    """What a cell showed, and where it is not what it had to show."""
    states: list
    reasons: list
    recovery_s: float
    silent_s: float
    broken: list

    @property
    def is_kept(self):
        return not self.broken


def during(flight, begin_s, end_s):
    """States and reasons of a fault's time, reasons up to a second later."""
    states = sorted({row["state"] for t, row in seconds_of(settled(flight)) if begin_s <= t < end_s})
    reasons = {reason for t, row in seconds_of(flight.health) if begin_s <= t < end_s + 1.0
               for reason in row["reasons"]}
    return states or ["none"], sorted(reasons | set(flight.warnings))


def possible_share(cell, flight, begin_s):
    """Share of a log's frames that can have an estimate: those before a fault that leaves nothing to estimate from."""
    is_for_good = cell.when == "on" and "LOST" in cell.end
    return min(1.0, begin_s / flight.duration_s) if is_for_good else 1.0


def judge(cell, flight, limits, window):
    """The verdict on a cell."""
    begin_s, end_s = window
    states, reasons = during(flight, begin_s, end_s)
    recovery = recovery_s(flight, end_s) if math.isfinite(end_s) else None
    silent = silent_s(flight, limits)
    final = final_state(flight)
    share = flight.estimates / max(1, flight.frames)
    broken = [flight.trouble] if flight.trouble else []

    def demand(condition, text):
        if not condition:
            broken.append(text)
    demand(flight.exit in cell.exit, f"exit {flight.exit} instead of {' or '.join(map(str, cell.exit))}")
    demand(set(states) <= set(cell.states), f"states {' '.join(states)}")
    demand(not cell.reasons or set(cell.reasons) & set(reasons), f"none of {', '.join(cell.reasons)}")
    demand(final in cell.end, f"ends {final}")
    if math.isfinite(end_s) and math.isfinite(cell.recovery_s):
        demand(recovery is not None and recovery <= cell.recovery_s, "recovers " + (
            "never" if recovery is None else f"in {recovery:.2f} s"))
    demand(share >= cell.estimates * possible_share(cell, flight, begin_s), f"{100 * share:.0f} % estimated")
    demand(math.isinf(cell.ate_mm) or (flight.ate_mm is not None and flight.ate_mm <= cell.ate_mm),
           "no error known" if flight.ate_mm is None else f"ATE {flight.ate_mm:.1f} mm")
    demand(silent <= limits["silent_s"] or cell.known, f"undetected error for {silent:.1f} s")
    demand(flight.seconds <= 20.0 + limits["seconds_per_second"] * flight.duration_s, f"took {flight.seconds:.0f} s")
    demand(flight.rss_mib <= limits["rss_mib"], f"{flight.rss_mib:.0f} MiB of memory")
    demand(flight.files_mib <= limits["files_mib"], f"{flight.files_mib:.0f} MiB of files")
    return Verdict(states, reasons, recovery, silent, broken)
