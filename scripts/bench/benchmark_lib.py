# SPDX-License-Identifier: BSD-2-Clause
"""What the benchmark scripts share: running the program, reading its files, tables, the chi-square band."""
import argparse
import csv
import math
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


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
    return parser


def check_arguments(parser, arguments):
    """Ends with exit code 2 and one line if what base_parser asks for, or a dataset, is not there."""
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


def replay_command(arguments, dataset, out, extra=(), mode=None, settings=()):
    """Command that replays a dataset into the folder `out`, in the mode and with the parameters of the arguments."""
    command = [arguments.facet, "replay", dataset, "--mode", mode or arguments.mode, "--out", out, "--quiet", *extra]
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
    """Evaluates a replay's folder; the figures are in its eval.json."""
    command = [arguments.facet, "eval", "--groundtruth", dataset, "--estimate", out, "--json", out / "eval.json"]
    return run(command + list(extra), out / "log.txt")


def first_error(output):
    lines = [line for line in output.splitlines() if "error" in line]
    return lines[0] if lines else (output.strip().splitlines() or ["no output"])[-1]


def fresh_folder(path):
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


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
