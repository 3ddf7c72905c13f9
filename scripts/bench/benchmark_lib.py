# SPDX-License-Identifier: BSD-2-Clause
"""What scripts share: running the program, reading its files, progress, tables as text."""
import csv
import functools
import hashlib
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(command, log):
    """Exit code and output of a command; everything it says also goes to the log file."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    with log.open("a") as stream:
        stream.write(f"$ {' '.join(str(part) for part in command)}\n{done.stdout}\n")
    return done.returncode, done.stdout


class Work:
    """Says on standard error what has been done of several pieces of work, and about how long the rest will take."""

    def __init__(self, pieces):
        """A number of pieces that take about as long as each other, or how long each takes, in any unit."""
        self.weights = [1.0] * pieces if isinstance(pieces, int) else list(pieces)
        self.begin = time.monotonic()
        self.done = 0

    def left(self):
        """", about N min left", or "" if there is nothing to tell it from."""
        worked, total = sum(self.weights[:self.done]), sum(self.weights)
        if worked <= 0 or worked >= total:
            return ""
        seconds = (time.monotonic() - self.begin) * (total - worked) / worked
        return f", about {seconds / 60:.0f} min left" if seconds > 90 else f", about {seconds:.0f} s left"

    def next(self, what):
        """Says that a piece begins: for pieces that take long."""
        print(f"[{self.done + 1}/{len(self.weights)}{self.left()}] {what}", file=sys.stderr, flush=True)
        self.done += 1

    def finished(self, what):
        """Says that a piece is done."""
        self.done += 1
        print(f"[{self.done}/{len(self.weights)}{self.left()}] {what}", file=sys.stderr, flush=True)


def first_error(output):
    lines = [line for line in output.splitlines() if "error" in line]
    return lines[0] if lines else (output.strip().splitlines() or ["no output"])[-1]


def fresh_folder(path):
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


def sum_of(files):
    """Changes when the files do."""
    return hashlib.sha256(b"".join(pathlib.Path(file).read_bytes() for file in files)).hexdigest()[:16]


@functools.cache
def simulator_sum():
    """Changes when the simulator does: its flights are then rendered again."""
    return sum_of(sorted(file for folder in ("app/lab/sim", "estimator/geometry")
                         for file in (ROOT / folder).rglob("*.*")))


def read_table(path):
    """Rows of a CSV file as dictionaries."""
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def state_durations(rows):
    """Seconds in each state of health.csv, in order of first appearance; a state lasts until the next row."""
    durations = {}
    for row, following in zip(rows, rows[1:] + [None]):
        seconds = 0.0 if following is None else 1e-9 * (int(following["stamp_ns"]) - int(row["stamp_ns"]))
        durations[row["state"]] = durations.get(row["state"], 0.0) + seconds
    return durations


def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def text_table(columns, rows, left=1):
    """Aligned columns, the first `left` ones to the left."""
    table = [columns] + rows
    widths = [max(len(line[i]) for line in table) for i in range(len(columns))]
    return "\n".join("  ".join(cell.ljust(w) if i < left else cell.rjust(w)
                               for i, (cell, w) in enumerate(zip(line, widths))).rstrip() for line in table)


def markdown_table(columns, rows):
    lines = ["| " + " | ".join(columns) + " |", "|---" * len(columns) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def load_pyplot(parser_error):
    """matplotlib for writing files, or one line on how to get it."""
    try:
        import matplotlib
    except ImportError:
        parser_error(f"plots need matplotlib, which {sys.executable} does not have: apt-get install python3-matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot
    return pyplot
