#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Shares of the lines that were run, by folder, from lcov's account.

Usage: coverage.py [--aim PERCENT] [--root ROOT] [--files FILE] LINES.info FOLDER...
Prints a line for each folder and one for all; with --files also a list of the files, the least covered first. Exit
code 1 if a folder is below the aim or has no line at all.
"""
import argparse
import collections
import pathlib
import sys


def read_lines(path):
    """{file: {line: was it ever run}}, of all records that lcov has of a file."""
    files = collections.defaultdict(dict)
    lines = None
    for row in path.read_text().splitlines():
        if row.startswith("SF:"):
            lines = files[row[3:]]
        elif row.startswith("DA:") and lines is not None:
            number, count = row[3:].split(",")[:2]
            lines[number] = lines.get(number, False) or int(count) > 0
    return files


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lines", type=pathlib.Path)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--aim", type=float, default=85.0)
    parser.add_argument("--root", default=".")
    parser.add_argument("--files", type=pathlib.Path)
    arguments = parser.parse_args()
    root = pathlib.Path(arguments.root).resolve()
    shares = []
    totals = {folder: [0, 0] for folder in arguments.folders}
    for name, lines in read_lines(arguments.lines).items():
        file = pathlib.Path(name)
        if not file.is_relative_to(root) or not lines:
            continue
        file = file.relative_to(root)
        if file.parts[0] not in totals:
            continue
        run = sum(lines.values())
        shares.append((run / len(lines), run, len(lines), str(file)))
        totals[file.parts[0]][0] += run
        totals[file.parts[0]][1] += len(lines)
    if arguments.files:
        arguments.files.write_text("".join(f"{100 * share:6.1f} %  {run:5d} of {count:5d}  {file}\n"
                                           for share, run, count, file in sorted(shares)))
    short = False
    for folder, (run, count) in totals.items():
        share = 100 * run / count if count else 0.0
        is_short = not share >= arguments.aim
        short = short or is_short
        print(f"{folder:<12} {share:5.1f} %  {run} of {count} lines" + (
            f"  below {arguments.aim:g} %" if is_short else ""))
    run, count = (sum(values) for values in zip(*totals.values()))
    print(f"{'all':<12} {100 * run / max(1, count):5.1f} %  {run} of {count} lines")
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())
