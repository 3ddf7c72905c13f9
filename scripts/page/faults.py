# SPDX-License-Identifier: BSD-2-Clause
"""The matrix of faults in the report, from what scripts/benchmark faults left in its folder."""
import html
import pathlib

from page import tables
from page.run_files import InputProblem, read_json

NEEDED = ("sensor", "fault", "log", "states", "reasons", "recovery_s", "ate_mm", "estimated", "end", "silent_s", "kept",
          "verdict", "span")
OUTCOMES = (("kept", "as expected"), ("silent", "undetected error"), ("broken", "not as expected"))


class FaultMatrix:
    """Rows of results.json, and the sentence of table.md that says what made them. Raises InputProblem."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.rows = read_json(folder / "results.json")
        if not isinstance(self.rows, list) or not self.rows:
            raise InputProblem(f"{folder}: no cell in its results.json; scripts/benchmark faults writes it")
        for number, row in enumerate(self.rows, start=1):
            missing = [key for key in NEEDED if not isinstance(row, dict) or key not in row]
            if missing:
                raise InputProblem(f"{folder}/results.json: cell {number} has no {missing[0]}")
        made = folder / "table.md"
        said = made.read_text(encoding="utf-8").strip().splitlines()[-1] if made.is_file() else ""
        self.made_by = said.replace("`", "") or "not recorded by what"
        self.has_logs = len({row["log"] for row in self.rows}) > 1


def outcome(row):
    """Key of OUTCOMES."""
    return "broken" if not row["kept"] else "silent" if row["silent_s"] else "kept"


def chip(row, with_log):
    """A cell of the matrix: its fault in the colour of its outcome, with a mark for those who see no colours."""
    kind = outcome(row)
    log = f" ({row['log']})" if with_log else ""
    said = f"{row['sensor']}, {row['fault']}{log}: {row['verdict']}; {' '.join(row['states'])}"
    mark = {"kept": "", "silent": f" \u26a0 {row['silent_s']:.1f} s", "broken": " \u2717"}[kind]
    return (f"<span class='chip {kind}' title='{html.escape(said, quote=True)}'>"
            f"{html.escape(row['fault'] + log + mark)}</span>")


def overview(matrix):
    """One line a sensor, one chip a cell."""
    sensors = [sensor for sensor in dict.fromkeys(row["sensor"] for row in matrix.rows) if sensor != "-"]
    lines = "".join(
        f"<div class='sensor'><b>{html.escape(sensor)}</b><div>"
        + "".join(chip(row, matrix.has_logs) for row in matrix.rows if row["sensor"] == sensor) + "</div></div>"
        for sensor in sensors)
    keys = "".join(f"<span><i class='key chip {kind}'></i>{name}</span>" for kind, name in OUTCOMES)
    return f"<figure class='table faults'>{lines}<div class='legend'>{keys}</div></figure>"


def full_table(matrix):
    """What docs/faults.md has, as HTML."""
    columns = ["sensor", "fault", *(["log"] if matrix.has_logs else []), "for", "verdict", "states during it",
               "reasons", "recovery (s)", "ATE (mm)", "estimated (%)", "end", "undetected error (s)"]
    rows = [[row["sensor"], row["fault"], *([row["log"]] if matrix.has_logs else []), row["span"], row["verdict"],
             " ".join(row["states"]), ", ".join(row["reasons"]) or "\u2013", tables.cell(row["recovery_s"], 2),
             tables.cell(row["ate_mm"], 1), tables.cell(row["estimated"], 0, 100.0), row["end"],
             tables.cell(row["silent_s"] or None, 1)] for row in matrix.rows]
    return tables.table(columns, rows, "<b>Every cell</b>; recovery: from the end of the fault to TRACKING that stays; "
                        "undetected error: TRACKING with high quality while wrong by more than five sigma",
                        left=6 + matrix.has_logs)


def section_html(matrix):
    """The section of the report; empty without a matrix."""
    if matrix is None:
        return ""
    kept = sum(row["kept"] for row in matrix.rows)
    silent = sum(row["silent_s"] for row in matrix.rows)
    said = (f"{kept} of {len(matrix.rows)} cells as expected, undetected errors of {silent:.1f} s in all. "
            f"Made by {matrix.made_by}")
    return (f"<section id='faults'><h2>When sensors fail</h2><p class='soft'>{html.escape(said)}</p>{overview(matrix)}"
            f"<details><summary>Every cell in figures</summary>{full_table(matrix)}</details></section>")
