#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compiles every header of the project alone: a header includes all that it needs. Skipped are headers that passed
before and have not changed since, and those that clang-tidy compiles alone with their source: x.h where x.cpp begins by
including it, but for the tests, which tidy.py leaves out unless asked.

Usage: headers.py [--jobs N] BUILD_FOLDER      (BUILD_FOLDER holds compile_commands.json)
"""
import argparse
import json
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cache import ROOT, Cache

FIRST_INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)', re.MULTILINE)
FOLDERS = ("platform", "drivers", "estimator", "mesh", "app", "tests")


def compiler_and_flags(build_folder):
    """The compiler, and all include paths and definitions of the build, each once."""
    compiler = "c++"
    flags = {}
    for entry in json.loads((build_folder / "compile_commands.json").read_text(encoding="utf-8")):
        words = shlex.split(entry["command"])
        if not words[0].endswith("ccache"):
            compiler = words[0]
        else:
            compiler = words[1]
        for i, word in enumerate(words):
            if word == "-isystem":
                flags[("-isystem", words[i + 1])] = None
            elif word.startswith(("-I", "-D", "-march=", "-std=")):
                flags[(word,)] = None
    return compiler, [word for flag in flags for word in flag]


def is_first_in_its_source(header):
    if header.relative_to(ROOT).parts[0] == "tests":
        return False
    source = header.with_suffix(".cpp")
    first = FIRST_INCLUDE.search(source.read_text(encoding="utf-8")) if source.is_file() else None
    return first is not None and first.group(1) == header.relative_to(ROOT).as_posix()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build_folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    compiler, flags = compiler_and_flags(arguments.build_folder)
    command = [compiler, *flags, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++", "-"]
    cache = Cache("headers")
    headers = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.h"))
    alone = [header for header in headers if not is_first_in_its_source(header)]

    def check(header):
        name = header.relative_to(ROOT).as_posix()
        stamp = cache.stamp(header, " ".join(command).encode())
        if stamp.exists():
            return name, 0, None
        # Twice: the second one tests the include guard.
        text = f'#include "{name}"\n#include "{name}"\n'
        run = subprocess.run(command, input=text, cwd=ROOT, capture_output=True, text=True, check=False)
        if run.returncode == 0:
            stamp.touch()
        return name, run.returncode, run.stderr

    bad = known = 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name, code, errors in pool.map(check, alone):
            known += errors is None
            if code != 0:
                bad += 1
                print(f"{name}: does not compile alone\n{errors}")
    print(
        f"headers: {len(headers)} files, {len(headers) - len(alone)} of them first in their own source, "
        f"{known} unchanged since they passed, {bad} failed"
    )
    return 1 if bad or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
