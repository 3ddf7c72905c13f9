#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compiles every header of the project, and every source of the program, alone: each includes all that it needs.
Skipped are those that passed before and have not changed since, headers that begin their own source: x.h where x.cpp
begins by including it, but for the tests, whose sources are not compiled here; and parts that this build leaves out:
headers in a folder whose sources it does not compile.

Clang reads each as the beginning of a file that goes on, so that no template is instantiated at its end, which is most
of a compiler's work; Eigen, where it is included, is precompiled. Warnings are for the build to find.

Usage: alone.py [--jobs N] BUILD_FOLDER      (BUILD_FOLDER holds compile_commands.json)
"""
import argparse
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cache import ROOT, Cache, closure, contents
from compile_commands import sources_of

FIRST_INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)', re.MULTILINE)
FOLDERS = ("platform", "drivers", "estimator", "mesh", "app", "tests")
CLANG = ("clang++", "-std=c++20", "-w", "-x", "c++-header")
PATHS = ("-I", "-D")
MACHINE = ("-march=",)
EIGEN = "#include <Eigen/Cholesky>\n#include <Eigen/Core>\n#include <Eigen/Geometry>\n#include <Eigen/LU>\n"


def chosen_flags(sources, beginnings):
    """The flags of the sources that begin like this, and the system's include paths, each once."""
    flags = {}
    for source in sources:
        for word, value in zip(source.flags, source.flags[1:] + [""]):
            if word == "-isystem":
                flags[(word, value)] = None
            elif word.startswith(beginnings):
                flags[(word,)] = None
    return [word for flag in flags for word in flag]


def is_first_in_its_source(header):
    if header.relative_to(ROOT).parts[0] == "tests":
        return False
    source = header.with_suffix(".cpp")
    first = FIRST_INCLUDE.search(source.read_text(encoding="utf-8")) if source.is_file() else None
    return first is not None and first.group(1) == header.relative_to(ROOT).as_posix()


def is_left_out(header, compiled):
    sources = set(header.parent.glob("*.cpp"))
    return header.relative_to(ROOT).parts[0] != "tests" and bool(sources) and not sources & compiled


def needs_eigen(file):
    return any(b"#include <Eigen/" in contents(part) for part in closure(file))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build_folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    compiled = sources_of(arguments.build_folder, {"build"})
    of_headers = [*CLANG, *chosen_flags(compiled, PATHS + MACHINE)]
    of_source = {source.file: [*CLANG, *chosen_flags([source], PATHS + MACHINE)] for source in compiled
                 if source.folder() != "tests"}
    cache = Cache("alone")
    headers = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.h")
                     if not is_left_out(file, of_source.keys()))
    begun = [header for header in headers if not is_first_in_its_source(header)]
    eigen = cache.folder / "eigen.h"
    eigen.write_text(EIGEN, encoding="utf-8")
    subprocess.run([*CLANG, *chosen_flags(compiled, MACHINE), "-o", f"{eigen}.pch", str(eigen)], cwd=ROOT, check=True)

    def check(file):
        name = file.relative_to(ROOT).as_posix()
        command = of_source.get(file, of_headers)
        stamp = cache.stamp(file, " ".join(command).encode())
        if stamp.exists():
            return name, 0, None
        precompiled = ["-Xclang", "-include-pch", "-Xclang", f"{eigen}.pch"] if needs_eigen(file) else []
        # Headers twice: the second time tests the include guard.
        text = f'#include "{name}"\n' * (2 if file.suffix == ".h" else 1)
        run = subprocess.run([*command, *precompiled, "-o", "/dev/null", "-"], input=text, cwd=ROOT,
                             capture_output=True, text=True, check=False)
        if run.returncode == 0:
            stamp.touch()
        return name, run.returncode, run.stderr

    bad = known = 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name, code, errors in pool.map(check, begun + sorted(of_source)):
            known += errors is None
            if code != 0:
                bad += 1
                print(f"{name}: does not compile alone\n{errors}")
    print(
        f"alone: {len(headers)} headers, {len(headers) - len(begun)} of them first in their own source, "
        f"{len(of_source)} sources, {known} unchanged since they passed, {bad} failed"
    )
    return 1 if bad or not headers or not of_source else 0


if __name__ == "__main__":
    sys.exit(main())
