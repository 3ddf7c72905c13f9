#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Ceres' functions of Eigen have names of their own, so that the program solves with those of its own compiler flags.

Usage: keep_eigen_apart_test.py NM ARCHIVE PROGRAM
"""
import subprocess
import sys
import unittest

NM, ARCHIVE, PROGRAM = sys.argv[1:4]
SHARED = set("WVu")  # types of symbols of which the linker keeps one


def symbols(path):
    """Names and types of what a file defines."""
    lines = subprocess.run([NM, "--defined-only", "--format=posix", path], capture_output=True, text=True,
                           check=True).stdout.splitlines()
    return [fields[:2] for fields in map(str.split, lines) if len(fields) >= 2]


class KeepEigenApart(unittest.TestCase):
    def test_the_archive_shares_no_function_of_eigen(self):
        shared = [name for name, kind in symbols(ARCHIVE)
                  if kind in SHARED and name.startswith(("_ZN5Eigen", "_ZNK5Eigen"))]
        self.assertEqual(shared, [])

    def test_the_program_has_both(self):
        names = [name for name, _ in symbols(PROGRAM)]
        self.assertTrue(any(name.startswith("apart_ZN5Eigen") for name in names))
        self.assertTrue(any(name.startswith("_ZN5Eigen") for name in names))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
