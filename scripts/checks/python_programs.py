#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compiles every Python program, with or without an ending, with warnings as errors; then pyflakes looks for unused
imports and undefined names.

Usage: python_programs.py [ROOT]      prints a line `file:line: problem` for every problem; exit code 1 if there is any
"""
import argparse
import subprocess
import sys
import warnings
from pathlib import Path

from tree import ROOT, project_files


def compile_problem(root, path):
    """What the compiler says against a program as `file:line: text`, or None. Nothing is run and nothing is written."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            compile((root / path).read_bytes(), path, "exec", dont_inherit=True)
        except SyntaxError as error:
            return f"{path}:{error.lineno}: {error.msg}"
        except (ValueError, Warning) as error:
            return f"{path}:1: {error}"
    return None


def pyflakes_problems(root, paths):
    """The lines that pyflakes prints about the programs."""
    run = subprocess.run(["pyflakes3", *paths], cwd=root, capture_output=True, text=True, check=False)
    return run.stdout.splitlines() + run.stderr.splitlines()


def check_tree(root):
    """All violations below root, and the number of programs seen."""
    paths = project_files(root, {"python"})
    problems = [problem for path in paths if (problem := compile_problem(root, path))]
    # A program that does not compile would only be reported twice.
    if paths and not problems:
        problems = pyflakes_problems(root, paths)
    return problems, len(paths)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=ROOT)
    try:
        problems, files = check_tree(parser.parse_args().root)
    except FileNotFoundError:
        print("python_programs: pyflakes3 is not installed: run scripts/setup --check", file=sys.stderr)
        return 2
    for problem in problems:
        print(problem)
    print(f"python: {files} programs, {len(problems)} problems")
    return 1 if problems or not files else 0


if __name__ == "__main__":
    sys.exit(main())
