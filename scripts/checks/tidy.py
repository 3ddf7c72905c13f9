#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Runs clang-tidy on the sources of the build, skipping those that passed before and have not changed since.

Up to eight sources of a target are looked at as one, since most of the time goes to the headers that they share: a
quarter of what single sources take. Findings are reported for the sources themselves; that each of them includes what
it needs is for alone.py to see. Sources that the build itself writes are not checked: they may not be there yet.

Usage: tidy.py [--jobs N] [--tests] BUILD_FOLDER      (BUILD_FOLDER holds compile_commands.json)
"""
import argparse
import collections
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cache import ROOT, Cache
from compile_commands import sources_of

MOST = 8
FOLDER = ROOT / "build" / "tidy_groups"


class Group:
    """Sources of a target with the same flags, and the file that includes them."""

    def __init__(self, sources, number):
        self.names = [source.file.relative_to(ROOT).as_posix() for source in sources]
        self.flags = sources[0].flags
        self.file = FOLDER / (re.sub(r"\W+", "_", sources[0].target) + f"_{number}.cpp")
        text = "".join(f'#include "{name}"\n' for name in self.names)
        if not self.file.is_file() or self.file.read_text(encoding="utf-8") != text:
            self.file.write_text(text, encoding="utf-8")


def grouped(sources):
    """Groups of nearly equal size."""
    of_target = collections.defaultdict(list)
    for source in sources:
        of_target[(source.target, tuple(source.flags))].append(source)
    FOLDER.mkdir(parents=True, exist_ok=True)
    numbers = collections.Counter()
    groups = []
    for (target, _), members in of_target.items():
        count = -(-len(members) // MOST)
        for k in range(count):
            groups.append(Group(members[k::count], numbers[target]))
            numbers[target] += 1
    return groups


def look(file, flags):
    """clang-tidy's exit code and output."""
    command = ["clang-tidy", "--quiet", str(file), "--", *flags, "-Wno-unknown-warning-option"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return run.returncode, run.stdout or run.stderr


def check(group, cache):
    """None if the group has passed before, otherwise clang-tidy's exit code and output.

    Names that two sources keep to themselves may clash in a group: then its sources are looked at one by one.
    """
    context = " ".join(group.flags).encode() + (ROOT / ".clang-tidy").read_bytes()
    stamp = cache.stamp(group.file, context)
    if stamp.exists():
        return None
    code, output = look(group.file, group.flags)
    if code != 0 and len(group.names) > 1 and "[clang-diagnostic-error]" in output:
        results = [look(ROOT / name, group.flags) for name in group.names]
        output = "".join(text for single, text in results if single != 0)
        code = int(any(single != 0 for single, _ in results))
    if code == 0:
        stamp.touch()
    return code, output


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build_folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tests", action="store_true", help="the tests too")
    arguments = parser.parse_args()
    cache = Cache("tidy")
    sources = sources_of(arguments.build_folder, {"build"} if arguments.tests else {"build", "tests"})
    groups = grouped(sources)

    bad = known = 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for group, result in zip(groups, pool.map(lambda group: check(group, cache), groups)):
            if result is None:
                known += 1
            elif result[0] != 0:
                bad += 1
                print(f"{' '.join(group.names)}:\n{result[1]}", flush=True)
    print(f"tidy: {len(sources)} files in {len(groups)} groups, {known} of them unchanged since they passed, "
          f"{bad} failed")
    return 1 if bad or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
