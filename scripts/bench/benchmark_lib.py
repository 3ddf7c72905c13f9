# SPDX-License-Identifier: BSD-2-Clause
"""What the benchmark scripts share: running the program, reading its files, tables, the chi-square band."""
import argparse
import csv
import dataclasses
import hashlib
import json
import math
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

from bench.marked_document import (add_document_option, check_document, measured_by, put_between_marks,
                                   script_name)

ROOT = pathlib.Path(__file__).resolve().parents[2]
QUICK_FACTORS = [1.0, 0.0]
QUICK_DURATION_S = 10.0


def base_parser(description, out):
    """A parser with the options that every benchmark has."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--facet", type=pathlib.Path, default=ROOT / "build/release/bin/facet", help="program to run")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / out, help="output folder")
    parser.add_argument("--mode", default="s")
    parser.add_argument("--config", type=pathlib.Path, help="parameters for every run")
    parser.add_argument("--core", type=int, default=0, help="core to pin to; -1 for none")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings",
                        help="parameter on top of --config, e.g. --set window.keyframes=10; may be repeated")
    add_document_option(parser)
    return parser


@dataclasses.dataclass(frozen=True)
class Condition:
    """What a row of a table was measured under: errors of the calibration, and what rotors add to the IMU."""
    factor: float
    vibration: str = "none"  # idle, flight; idle+images, flight+images: images turn as well

    def __str__(self):
        return f"{self.factor:g}" + ("" if self.vibration == "none" else f", {self.vibration}")

    @property
    def is_drawn(self):
        """Whether it depends on a seed."""
        return self.factor > 0 or self.vibration != "none"

    def name(self, seed=None):
        """Names folders and files."""
        shaken = "" if self.vibration == "none" else f"_{self.vibration}"
        return f"k{self.factor:g}{shaken}" + ("" if seed is None else f"_seed{seed}")

    def options(self, seed):
        """Options of `facet replay` for one draw."""
        kind, _, images = self.vibration.partition("+")
        shown = f",1,{images}" if images else ""
        shaken = [] if kind == "none" else ["--inject", f"vibration={kind},{seed}{shown}"]
        return (["--inject", f"calibration={self.factor:g},{seed}"] if self.factor > 0 else []) + shaken

    def fields(self):
        """What results.json says of it."""
        return dataclasses.asdict(self)

    @staticmethod
    def of(row):
        """The condition that a row with fields() is of."""
        return Condition(row["factor"], row["vibration"])


CONDITION_LEGEND = ("K: errors of the calibration in units of what a good one leaves unknown; idle, flight: with what "
                    "a real drone's rotors add to the inertial samples, +images: by which images turn as well")


def add_condition_options(parser, seeds=(1, 2, 3)):
    """Options of the benchmarks whose rows have calibrations that are wrong by K times what a good one leaves unknown.

    The rows of real calibrations come first, those of a perfect one last; before all of them one as on a real vehicle:
    the first K with the vibration of rotors. Without `seeds` there is no such option.
    """
    parser.add_argument("--vibration", choices=["idle", "flight", "none"], default="flight",
                        help="what rotors add to the IMU in the first row (default flight); none: no such row")
    parser.add_argument("--images", action="store_true",
                        help="after that row one whose images turn with the vibration, too, as on a real vehicle")
    parser.add_argument("--factors", type=float, nargs="+", default=[1.0, 2.0, 0.0], metavar="K",
                        help="errors of the calibration, in the order of the rows (default: 1 2 0)")
    if seeds:
        parser.add_argument("--seeds", type=int, nargs="+", default=list(seeds),
                            help=f"draws of the errors (default: {' '.join(map(str, seeds))})")
    parser.add_argument("--duration", type=float, help="only this much of each log, or of each flight (s)")
    parser.add_argument("--quick", action="store_true",
                        help=f"to try it out: K of 1 and 0, one seed, {QUICK_DURATION_S:g} s of each log")


def conditions(arguments):
    """What the rows are measured under, in their order."""
    kinds = [] if arguments.vibration == "none" else ["", "+images"] if arguments.images else [""]
    shaken = [Condition(arguments.factors[0], arguments.vibration + kind) for kind in kinds]
    return [*shaken, *(Condition(factor) for factor in arguments.factors)]


def shorten_if_quick(arguments):
    """Cuts the arguments of add_condition_options down to what --quick asks for."""
    if arguments.quick:
        arguments.factors = QUICK_FACTORS
        arguments.seeds = getattr(arguments, "seeds", [])[:1]
        arguments.duration = arguments.duration or QUICK_DURATION_S


def seeds_of(arguments, condition):
    """The seeds that a row is made of: without errors all draws are the same."""
    return arguments.seeds if condition.is_drawn else arguments.seeds[:1]


def count_draws(arguments):
    """How many runs a table of conditions() x datasets x seeds has."""
    return len(arguments.datasets) * sum(len(seeds_of(arguments, condition)) for condition in conditions(arguments))


def log_options(arguments):
    """Options of `facet replay` for as much of a log as is wanted."""
    return ["--duration", f"{arguments.duration:g}"] if arguments.duration else []


def medians(runs):
    """Column by column over the runs; what a run does not have (None) does not count."""
    columns = [[value for value in column if value is not None] for column in zip(*runs)]
    return [statistics.median(column) if column else None for column in columns]


def worst(values):
    """The largest of those that are there; None if none is."""
    return max((value for value in values if value is not None), default=None)


def check_arguments(parser, arguments):
    """Ends with exit code 2 and one line if what base_parser asks for, or a dataset, is not there."""
    check_document(parser, arguments)
    if any(factor < 0 for factor in getattr(arguments, "factors", [])):
        parser.error("--factors: must not be negative")
    if getattr(arguments, "duration", None) is not None and arguments.duration <= 0:
        parser.error("--duration: must be positive")
    if not arguments.facet.is_file():
        parser.error(f"{arguments.facet}: no such program; build it or give --facet")
    for dataset in getattr(arguments, "datasets", []):
        if not dataset.is_dir():
            parser.error(f"{dataset}: no such folder")
    for setting in arguments.settings:
        if "=" not in setting:
            parser.error(f"--set {setting}: must be KEY=VALUE")
    if arguments.config and not arguments.config.is_file():
        parser.error(f"{arguments.config}: no such file")


def run(command, log):
    """Exit code and output of a command; everything it says also goes to the log file."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    with log.open("a") as stream:
        stream.write(f"$ {' '.join(str(part) for part in command)}\n{done.stdout}\n")
    return done.returncode, done.stdout


def replay_command(arguments, dataset, out, extra=(), mode=None, settings=(), quiet=True):
    """Command that replays a dataset into the folder `out`, in the mode and with the parameters of the arguments."""
    command = [arguments.facet, "replay", dataset, "--mode", mode or arguments.mode, "--out", out, *extra]
    command += ["--quiet"] if quiet else []
    if arguments.config:
        command += ["--config", arguments.config]
    for setting in [*arguments.settings, *settings]:
        command += ["--set", setting]
    return [str(part) for part in command]


def pinned(arguments, command):
    """The command on the core of the arguments."""
    on_core = arguments.core >= 0 and shutil.which("taskset")
    return ["taskset", "-c", str(arguments.core), *command] if on_core else command


def replay(arguments, dataset, out, extra=()):
    """Replays a dataset into the folder `out`; its log.txt keeps what is said."""
    return run(pinned(arguments, replay_command(arguments, dataset, out, extra)), out / "log.txt")


def evaluate(arguments, dataset, out, extra=()):
    """Evaluates a replay's folder; the figures are in its eval.json. Images that were turned have a truth of their own,
    which does not go with a scene."""
    turned = out / "groundtruth.csv"
    truth = turned if turned.is_file() and "--scene" not in extra else dataset
    command = [arguments.facet, "eval", "--groundtruth", truth, "--estimate", out, "--json", out / "eval.json"]
    return run(command + list(extra), out / "log.txt")


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


def simulator_sum():
    """Changes when the simulator does: its flights are then rendered anew."""
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


def write_tables(arguments, heading, tables, notes, results, left=1, part=None):
    """Writes table.txt, table.md and results.json into the output folder, prints table.txt and puts table.md into the
    document, if one was given.

    `tables` are pairs of columns and rows, of which the first `left` columns hold text. table.md says what made it.
    A `part` has a mark of its own in the document: the script's name, a colon and the part.
    """
    texts = [text_table(columns, rows, left) for columns, rows in tables]
    (arguments.out / "table.txt").write_text("\n".join([heading, "\n\n".join(texts)] + notes) + "\n")
    marked = "\n\n".join([heading[:1].upper() + heading[1:] + ".",
                          *(markdown_table(columns, rows) for columns, rows in tables), *notes,
                          measured_by(arguments.facet)])
    (arguments.out / "table.md").write_text(marked + "\n")
    (arguments.out / "results.json").write_text(json.dumps(results, indent=2) + "\n")
    print((arguments.out / "table.txt").read_text(), end="")
    if arguments.document:
        put_between_marks(arguments.document, script_name() + (f": {part}" if part else ""), marked)
    print(f"written: {arguments.out}/table.txt, table.md, results.json", file=sys.stderr)


def chi_square_point(dof, sigmas):
    """Point of the chi-square distribution as far out as `sigmas` of the normal one [Wilson, Hilferty 1931].

    Within 0.3 % for dof >= 30.
    """
    part = 2.0 / (9.0 * dof)
    return dof * (1.0 - part + sigmas * math.sqrt(part)) ** 3


def average_band(dof, runs):
    """Band that holds 95 % of the average NEES of `runs` independent runs of a consistent estimator at one instant."""
    return tuple(chi_square_point(dof * runs, s) / runs for s in (-1.959964, 1.959964))


def load_pyplot(parser_error):
    """matplotlib for writing files, or one line on how to get it."""
    try:
        import matplotlib
    except ImportError:
        parser_error(f"plots need matplotlib, which {sys.executable} does not have: apt-get install python3-matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot
    return pyplot
