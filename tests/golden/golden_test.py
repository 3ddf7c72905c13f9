#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Simulates and replays a few short flights and compares what comes out with the files in tests/golden.

Usage: golden_test.py [--near] [--update] WORK_FOLDER FACET...
FACET is the program, with its emulator before it if it needs one.
Exit codes: 0 the same, 1 something differs or failed, 2 bad usage.
"""
import argparse
import difflib
import sys
from pathlib import Path

GOLDEN = Path(__file__).resolve().parent
sys.path.insert(0, str(GOLDEN))
sys.dont_write_bytecode = True
import describe  # noqa: E402
import flights  # noqa: E402


def text_of(facet, work, run):
    """What the golden file of a run should say."""
    arguments = " ".join(run.arguments)
    head = f"facet sim {' '.join(flights.FLIGHTS[run.flight])}\nfacet replay {arguments}\n\n"
    text = head + describe.describe(flights.replay(facet, work, run))
    (work / f"{run.name}.txt").write_text(text, encoding="utf-8")
    return text


def check(name, golden, text, is_near):
    """Whether the texts agree; prints where they do not."""
    settled = describe.settle(golden, text, is_near)
    if settled == golden:
        print(f"{name}: {'as in the golden file' if text == golden else 'as in the golden file, but for rounding'}")
        return True
    sys.stdout.writelines(
        difflib.unified_diff(
            golden.splitlines(keepends=True),
            settled.splitlines(keepends=True),
            f"tests/golden/{name}.txt",
            "this program",
        )
    )
    return False


def update(name, golden, text):
    """Rewrites the file, unless only its rounding would change."""
    if golden and describe.settle(golden, text, False) == golden:
        print(f"{name}: unchanged")
        return
    (GOLDEN / f"{name}.txt").write_text(text, encoding="utf-8")
    print(f"{name}: rewritten")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--near", action="store_true", help="tolerate what another processor or compiler may change")
    parser.add_argument("--update", action="store_true", help="rewrite the golden files")
    parser.add_argument("work", type=Path)
    parser.add_argument("facet", nargs=argparse.REMAINDER)  # an emulator brings options of its own
    arguments = parser.parse_args()
    if not arguments.facet:
        parser.error("FACET is missing")
    all_same = True
    for run in flights.RUNS:
        path = GOLDEN / f"{run.name}.txt"
        golden = path.read_text(encoding="utf-8") if path.is_file() else ""
        try:
            text = text_of(arguments.facet, arguments.work, run)
        except flights.Failed as failure:
            print(f"{run.name}: {failure}")
            all_same = False
            continue
        if arguments.update:
            update(run.name, golden, text)
        else:
            all_same = check(run.name, golden, text, arguments.near) and all_same
    if not all_same and not arguments.update:
        print("If the change is wanted: scripts/tools/update_golden rewrites the files; commit them with the change.")
    return 0 if all_same else 1


if __name__ == "__main__":
    sys.exit(main())
