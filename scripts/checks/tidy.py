#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Runs clang-tidy on the sources of the build, skipping those that passed before and have not changed since.

Sources that the build itself writes, into BUILD_FOLDER, are not checked: they may not be there yet.

Usage: tidy.py [--jobs N] [--tests] BUILD_FOLDER      (BUILD_FOLDER holds compile_commands.json)
"""
import argparse
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cache import ROOT, Cache


def check(entry, build_folder, cache):
    """None if the file has passed before, otherwise clang-tidy's exit code and output."""
    context = entry["command"].encode() + (ROOT / ".clang-tidy").read_bytes()
    stamp = cache.stamp(Path(entry["file"]), context)
    if stamp.exists():
        return None
    command = ["clang-tidy", "--quiet", "--extra-arg=-Wno-unknown-warning-option", "-p", str(build_folder)]
    command.append(entry["file"])
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if run.returncode == 0:
        stamp.touch()
    return run.returncode, run.stdout or run.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build_folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tests", action="store_true", help="the tests too")
    arguments = parser.parse_args()
    cache = Cache("tidy")
    unchecked = {"build"} if arguments.tests else {"build", "tests"}
    entries = {}
    for entry in json.loads((arguments.build_folder / "compile_commands.json").read_text(encoding="utf-8")):
        if Path(entry["file"]).relative_to(ROOT).parts[0] not in unchecked:
            entries.setdefault(entry["file"], entry)

    bad = known = 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        results = pool.map(lambda entry: check(entry, arguments.build_folder, cache), entries.values())
        for file, result in zip(entries, results):
            if result is None:
                known += 1
            elif result[0] != 0:
                bad += 1
                print(f"{Path(file).relative_to(ROOT)}:\n{result[1]}", flush=True)
    print(f"tidy: {len(entries)} files, {known} of them unchanged since they passed, {bad} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
