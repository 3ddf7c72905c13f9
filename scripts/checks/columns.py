#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""No line of a source, comments included, is wider than 120 columns: clang-format leaves comments as they are.

Usage: columns.py [ROOT]      prints a line `file:line: rule` for every violation; exit code 1 if there is any

Checked are C++, CMake, Python, shell and YAML files. Two kinds of lines may be wider, because they cannot be broken:
one whose URL alone makes it so (without the URL it would fit), and one that begins inside a raw string literal of C++.
"""
import argparse
import re
import sys
from pathlib import Path

from tree import ROOT, project_files

MAX_COLUMNS = 120
LANGUAGES = {"c++", "cmake", "python", "shell", "yaml"}
URL = re.compile(r"https?://\S+")
RAW_STRING = re.compile(r'\bR"([^()\\\s]{0,16})\(')


def raw_string_left_open(line, delimiter):
    """What will end the raw string literal that is open after this line, or None.

    `delimiter` is the same for the line before.
    """
    position = 0
    while True:
        if delimiter is None:
            opened = RAW_STRING.search(line, position)
            if opened is None:
                return None
            delimiter, position = f'){opened.group(1)}"', opened.end()
        closed = line.find(delimiter, position)
        if closed < 0:
            return delimiter
        delimiter, position = None, closed + len(delimiter)


def too_wide(lines, is_cpp):
    """(number, width) of each line that is too wide."""
    delimiter = None
    for number, line in enumerate(lines, start=1):
        begins_in_raw_string = delimiter is not None
        if is_cpp:
            delimiter = raw_string_left_open(line, delimiter)
        if len(line) > MAX_COLUMNS and not begins_in_raw_string and len(URL.sub("", line)) > MAX_COLUMNS:
            yield number, len(line)


def check_tree(root):
    """All violations below root as `file:line: text`, and the number of files seen."""
    files = project_files(root, LANGUAGES)
    violations = []
    for path in files:
        lines = (root / path).read_text(encoding="utf-8").splitlines()
        is_cpp = path.endswith((".h", ".cpp", ".in"))
        violations += [f"{path}:{number}: {width} columns; break the line ({MAX_COLUMNS} at most)"
                       for number, width in too_wide(lines, is_cpp)]
    return violations, len(files)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=ROOT)
    violations, files = check_tree(parser.parse_args().root)
    for violation in violations:
        print(violation)
    print(f"columns: {files} files, {len(violations)} violations")
    return 1 if violations or not files else 0


if __name__ == "__main__":
    sys.exit(main())
