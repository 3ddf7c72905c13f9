#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""The files of the project that are written in a language the checks know, whether or not their names have an ending.

Usage: tree.py LANGUAGE [ROOT]      prints the paths of all files in that language: c++, cmake, python, shell or yaml
"""
import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Whatever else lies at the root (build, out, a private checkout of something) is not looked into.
FOLDERS = ("platform", "drivers", "estimator", "mesh", "app", "tests", "scripts", "toolchains", ".ci")
ENDINGS = {
    ".h": "c++",
    ".cpp": "c++",
    ".c": "c++",
    ".in": "c++",
    ".cmake": "cmake",
    ".py": "python",
    ".sh": "shell",
    ".yaml": "yaml",
}
# The first line of programs whose names have no ending.
FIRST_LINES = (
    (re.compile(rb"^#!.*\bpython"), "python"),
    (re.compile(rb"^#!.*\b(ba|da)?sh\b"), "shell"),
)


def language(file):
    """The language of a file, or None if it is none of those that are checked."""
    if file.name == "CMakeLists.txt":
        return "cmake"
    if file.suffix:
        return ENDINGS.get(file.suffix)
    with file.open("rb") as stream:
        first_line = stream.readline(200)
    return next((name for pattern, name in FIRST_LINES if pattern.match(first_line)), None)


def project_files(root, languages):
    """Paths, relative to root and sorted, of all files in one of the languages."""
    candidates = [file for folder in FOLDERS for file in (root / folder).rglob("*")] + list(root.glob("*"))
    chosen = [file for file in candidates if file.is_file() and language(file) in languages]
    return sorted(file.relative_to(root).as_posix() for file in chosen)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("language", choices=sorted(set(ENDINGS.values())))
    parser.add_argument("root", nargs="?", type=Path, default=ROOT)
    arguments = parser.parse_args()
    for path in project_files(arguments.root, {arguments.language}):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
