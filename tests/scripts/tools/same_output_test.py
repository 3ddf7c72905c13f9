#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/tools/same_output with programs that write what they are asked to."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

# Writes its own text into the files named, as `facet replay DATASET --mode M --out DIR --quiet` would.
FAKE = """#!/bin/sh
[ "$1" = replay ] || exit 2
mode="$4"
cd "$6" || exit 2
for file in {files}; do echo "$mode {text}" > "$file"; done
echo "$@" >&2
echo "{text}" > timing.csv
exit {code}
"""


class SameOutput(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        (self.root / "log").mkdir()

    def tearDown(self):
        self.folder.cleanup()

    def program(self, name, text="x", files="trajectory.tum mesh.ply", code=0):
        file = self.root / name
        file.write_text(FAKE.format(text=text, files=files, code=code))
        file.chmod(0o755)
        return file

    def run_it(self, *arguments):
        command = [sys.executable, ROOT / "scripts/tools/same_output", *arguments, "--out", self.root / "out"]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
        self.assertNotIn("Traceback", done.stderr)
        return done.returncode, done.stdout.splitlines(), done.stderr

    def test_same_in_every_mode(self):
        code, lines, _ = self.run_it(self.program("a"), self.program("b"), self.root / "log")
        self.assertEqual(code, 0)
        self.assertEqual(lines, [f"log  {mode:<3}  same (2 files)" for mode in ("s", "sp", "spr")])

    def test_files_that_differ_are_named(self):
        one, other = self.program("a"), self.program("b", text="y")
        code, lines, _ = self.run_it(one, other, self.root / "log", "--mode", "sp", "--mode", "s")
        self.assertEqual(code, 1)
        self.assertEqual(lines, [f"log  {mode:<3}  differ: trajectory.tum, mesh.ply" for mode in ("sp", "s")])

    def test_a_file_of_one_program_alone_and_the_exit_code_differ(self):
        one = self.program("a", files="trajectory.tum planes.csv")
        other = self.program("b", files="trajectory.tum", code=1)
        code, lines, _ = self.run_it(one, other, self.root / "log", "--mode", "s")
        self.assertEqual((code, lines), (1, ["log  s    differ: exit code (0, 1), planes.csv (only in A)"]))

    def test_times_of_the_machine_are_not_compared(self):
        one = self.program("a")
        other = self.root / "b"
        other.write_text(one.read_text().replace('echo "x" > timing', 'echo "y" > timing'))
        other.chmod(0o755)
        self.assertEqual(self.run_it(one, other, self.root / "log")[0], 0)

    def test_results_of_an_earlier_run_do_not_count(self):
        one = self.program("a")
        self.assertEqual(self.run_it(one, one, self.root / "log", "--mode", "s")[0], 0)
        nothing = self.program("b", files="health.csv")
        code, lines, _ = self.run_it(one, nothing, self.root / "log", "--mode", "s")
        self.assertEqual(code, 2)
        self.assertIn("FAILED: B: exit code 0", lines[0])

    def test_a_failed_replay_fails(self):
        code, lines, _ = self.run_it(self.program("a", code=2), self.program("b"), self.root / "log", "--mode", "s")
        self.assertEqual(code, 2)
        self.assertIn("FAILED: A: exit code 2: replay", lines[0])

    def test_the_duration_is_passed_on(self):
        one = self.program("a")
        self.run_it(one, one, self.root / "log", "--mode", "s", "--duration", "2")
        self.assertIn("--duration 2.0", (self.root / "out/log_s/a/log.txt").read_text())

    def test_wrong_usage(self):
        one = self.program("a")
        for arguments in ((one, self.root / "none", self.root / "log"), (one, one, self.root / "none"),
                          (one, one, self.root / "log", self.root / "log"),
                          (one, one, self.root / "log", "--mode", "x")):
            code, _, complaint = self.run_it(*arguments)
            self.assertEqual(code, 2)
            self.assertIn("same_output: error: ", complaint.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
