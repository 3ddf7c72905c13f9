#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/coverage.py."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "scripts/checks/coverage.py"


def record(file, counts):
    return f"TN:\nSF:{file}\n" + "".join(f"DA:{line},{count}\n" for line, count in counts.items()) + "end_of_record\n"


class Coverage(unittest.TestCase):
    def run_on(self, text, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            info = pathlib.Path(folder) / "lines.info"
            info.write_text(text)
            files = pathlib.Path(folder) / "files.txt"
            done = subprocess.run([sys.executable, SCRIPT, "--root", "/project", "--files", files, info, *arguments],
                                  capture_output=True, text=True)
            return done.returncode, done.stdout, files.read_text()

    def test_shares_by_folder(self):
        text = record("/project/mesh/a.cpp", {1: 5, 2: 0, 3: 1, 4: 1}) + record("/project/drivers/b.cpp", {1: 1}) + \
            record("/usr/include/c.h", {1: 0}) + record("/project/tests/d.cpp", {1: 0})
        code, output, files = self.run_on(text, "--aim", "75", "mesh", "drivers")
        self.assertEqual(code, 0)
        self.assertEqual(output.splitlines(), ["mesh          75.0 %  3 of 4 lines",
                                               "drivers      100.0 %  1 of 1 lines",
                                               "all           80.0 %  4 of 5 lines"])
        self.assertEqual(files.splitlines()[0].split()[-1], "mesh/a.cpp")
        self.assertEqual(len(files.splitlines()), 2)

    def test_a_line_that_one_of_several_records_has_run_was_run(self):
        text = record("/project/mesh/a.h", {1: 0, 2: 0}) + record("/project/mesh/a.h", {1: 3, 2: 0})
        code, output, _ = self.run_on(text, "mesh")
        self.assertEqual(code, 1)
        self.assertIn("50.0 %  1 of 2 lines  below 85 %", output)

    def test_a_folder_without_lines_is_short(self):
        self.assertEqual(self.run_on("", "mesh")[0], 1)


if __name__ == "__main__":
    unittest.main()
