#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/sweep: its statistics, and whole sweeps with a program that answers at once in place of facet."""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"
PYTHON = "/usr/bin/python3"  # which Snakemake's packages belong to
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True
from bench import sweep_table  # noqa: E402

# Appends what it is asked to CALLS. The error of a run is that of its flight, larger by GROWTH in mode spr; with a file
# WAIT beside it, the third replay hangs; flights with option --broken fail.
FAKE = """#!{python}
import json, sys, time
from pathlib import Path
here = Path(__file__).parent
arguments = sys.argv[1:]
value = lambda name: arguments[arguments.index(name) + 1]
with (here / "calls").open("a") as stream:
    stream.write(" ".join(arguments) + "\\n")
said = (here / "calls").read_text().splitlines()
if arguments == ["--version"]:
    print("facet        0.1.0\\ncommit       {commit}")
elif arguments[0] == "sim":
    if "--broken" in arguments:
        sys.exit("sim: error: broken")
    (Path(value("--out")) / "mav0/cam0").mkdir(parents=True)
    (Path(value("--out")) / "mav0/cam0/data.csv").write_text("#\\n")
elif arguments[0] == "replay":
    while (here / "wait").exists() and sum(line.startswith("replay") for line in said) >= 3:
        time.sleep(0.1)
    out = Path(value("--out"))
    if value("--mode") == "spr" and (here / "no_spr").exists():
        sys.exit("replay: error: spr is out of order")
    (out / "mode").write_text(value("--mode"))
    (out / "trajectory.tum").write_text("")
    (out / "summary.json").write_text(json.dumps({{"timing": {{"all": {{"mean": 5.0}}}},
                                                  "final": {{"state": "TRACKING"}}}}))
elif arguments[0] == "eval":
    folder = Path(value("--estimate"))
    error = 0.001 * len(Path(value("--groundtruth")).name)
    if (folder / "mode").read_text() == "spr":
        error *= {growth}
    Path(value("--json")).write_text(json.dumps({{
        "ate_se3": {{"translation_m": {{"rmse": error}}}}, "ate_yaw4": {{"rotation_deg": {{"rmse": 0.1}}}},
        "coverage": {{"time": 1.0}}, "mesh": None}}))
"""
SWEEP = """
flights: {one: {scene: room}, fourteen: {scene: hall, seed: 3}}
modes: [s, spr]
conditions: [{calibration_error: 1, vibration: flight}, {}]
seeds: [1, 2]
parameters: {window.keyframes: [8, 10]}
"""
HAS_SNAKEMAKE = shutil.which("snakemake") is not None


class Statistics(unittest.TestCase):
    def test_student_points_are_those_of_tables(self):
        for dof, point in ((1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (10, 2.228), (30, 2.042), (1000, 1.962)):
            self.assertAlmostEqual(sweep_table.student_point(dof) / point, 1.0, delta=0.005, msg=dof)

    def test_mean_and_interval_are_those_of_logarithms(self):
        mean, low, high = sweep_table.geometric_mean([1.0, 2.0, 4.0])
        self.assertAlmostEqual(mean, 2.0)
        self.assertAlmostEqual(high / mean, mean / low)
        # log 2 apart: a standard deviation of log 2, and Student's point for two degrees of freedom.
        self.assertAlmostEqual(high, 2.0 * 2.0 ** (4.3027 / 3.0 ** 0.5), places=3)
        self.assertEqual(sweep_table.geometric_mean([3.0])[1:], (None, None))
        self.assertEqual(sweep_table.geometric_mean([]), (None, None, None))

    def row(self, seed, error, mode="s"):
        row = {"run": f"room/{mode}/default/k1_seed{seed}", "flight": "room", "mode": mode, "variant": "default",
               "factor": 1.0, "vibration": "none", "seed": seed, "problem": ""}
        return row | ({"ate_m": error} if error else {"problem": "replay exit 2"})

    def test_a_regression_is_larger_than_tolerance_and_chance(self):
        before = sweep_table.make_baseline([self.row(seed, 0.001 * seed) for seed in (1, 2, 3, 4)], "abc")

        def regressions(*factors):
            rows = [self.row(seed, 0.001 * seed * factor) for seed, factor in enumerate(factors, 1)]
            return sweep_table.check_baseline(rows, before, 0.03)[1]

        self.assertEqual(regressions(1.0, 1.0, 1.0, 1.0), [])
        self.assertEqual(regressions(1.02, 1.021, 1.02, 1.019), [], "certain, but within the tolerance")
        self.assertEqual(regressions(1.5, 0.8, 1.4, 0.9), [], "beyond the tolerance, but by chance")
        self.assertIn("mode s, default: error 1.10", regressions(1.1, 1.11, 1.09, 1.1)[0])
        self.assertIn("k1_seed2: failed, which the baseline did not: replay exit 2", regressions(1, 0, 1, 1)[0])


@unittest.skipUnless(HAS_SNAKEMAKE, "needs Snakemake: scripts/setup --sweep")
class Sweep(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        self.program = self.root / "facet"
        self.write_program()
        self.sweep = self.root / "sweep.yaml"
        self.sweep.write_text(SWEEP)

    def tearDown(self):
        self.folder.cleanup()

    def write_program(self, growth=2.0, commit="0123456789ab"):
        self.program.write_text(FAKE.format(python=PYTHON, growth=growth, commit=commit))
        self.program.chmod(0o755)

    def command(self, *arguments):
        return [PYTHON, str(SCRIPTS / "sweep"), str(self.sweep), "--facet", str(self.program), "--out",
                str(self.root / "out"), "--cores", "1", *map(str, arguments)]

    def run_it(self, *arguments, code=0):
        done = subprocess.run(self.command(*arguments), capture_output=True, text=True, check=False)
        self.assertNotIn("Traceback", done.stderr)
        log = self.root / "out/snakemake.log"
        self.assertEqual(done.returncode, code, done.stderr + (log.read_text() if log.is_file() else ""))
        return done

    def calls(self, what):
        return [line for line in (self.root / "calls").read_text().splitlines() if line.startswith(what)]

    def rows(self):
        return {path.parent: path.stat().st_mtime_ns for path in (self.root / "out/runs").rglob("row.json")}

    def test_all_runs_are_flown_and_compared(self):
        done = self.run_it()
        self.assertEqual(len(self.calls("sim")), 2)
        self.assertEqual(len(self.calls("replay")), 2 * 2 * 2 * (2 + 1))
        self.assertIn("--inject calibration=1,2 --inject vibration=flight,2 --set window.keyframes=10",
                      " ".join(self.calls("replay")))
        table = (self.root / "out/table.txt").read_text()
        self.assertRegex(table, r"fourteen +1, flight +spr +window.keyframes=10 +2 +0 +16.00 \[16.00, 16.00\]")
        self.assertRegex(table, r"spr +window.keyframes=8 +s, window.keyframes=8 +6 +2.000 \[2.000, 2.000\]")
        self.assertRegex(table, r"s +window.keyframes=10 +s, window.keyframes=8 +6 +1.000 \[1.000, 1.000\]")
        self.assertIn("commit 0123456789ab", table)
        self.assertRegex(done.stderr, r"sweep: \d+ of 27 jobs, about \d+ s left")

    def test_a_killed_sweep_goes_on_where_it_was(self):
        (self.root / "wait").touch()
        with subprocess.Popen(self.command(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              start_new_session=True) as process:
            deadline = time.monotonic() + 60
            while len(self.rows()) < 2 and time.monotonic() < deadline:
                time.sleep(0.05)
            busy = subprocess.run(self.command(), capture_output=True, text=True, check=False)
            os.killpg(process.pid, signal.SIGKILL)
        self.assertEqual(busy.returncode, 2)
        self.assertIn("another sweep is at work", busy.stderr)
        done = self.rows()
        self.assertEqual(len(done), 2)
        (self.root / "wait").unlink()
        flown = len(self.calls("replay"))
        self.run_it()
        self.assertEqual(len(self.calls("replay")) - flown, 24 - 2)
        self.assertEqual(done, {path: stamp for path, stamp in self.rows().items() if path in done})
        flown = len(self.calls("replay"))
        self.run_it()
        self.assertEqual(len(self.calls("replay")), flown, "all was done")
        self.write_program(growth=2.5)
        self.run_it()
        self.assertEqual(len(self.calls("replay")), flown + 24, "another program")

    def test_errors_that_have_grown_are_a_regression(self):
        baseline = self.root / "baseline.json"
        self.run_it("--write-baseline", baseline)
        self.assertEqual(len(json.loads(baseline.read_text())["ate_m"]), 24)
        self.run_it("--baseline", baseline)
        self.write_program(growth=2.2)
        done = self.run_it("--baseline", baseline, code=1)
        self.assertIn("regression: mode spr, window.keyframes=8: error 1.100 times the baseline's", done.stderr)
        self.assertNotIn("regression: mode s,", done.stderr)

    def test_failures_are_rows_and_are_tried_again(self):
        (self.root / "no_spr").touch()
        done = self.run_it(code=1)
        self.assertIn("one/spr/window.keyframes=8/k0: replay exit 1: replay: error: spr is out of order", done.stdout)
        (self.root / "no_spr").unlink()
        flown = len(self.calls("replay"))
        self.assertEqual(len(self.run_it("--dry-run").stdout.splitlines()), 12)
        self.run_it()
        self.assertEqual(len(self.calls("replay")), flown + 12)
        self.assertEqual(self.run_it("--dry-run").stdout.split(), [])
        self.sweep.write_text(SWEEP.replace("seed: 3", "options: [--broken]"))
        self.assertIn("12 runs have no result", self.run_it(code=1).stderr)

    def test_wrong_files_are_refused_in_one_line(self):
        for text, complaint in (
                ("flights: {}", "flights: must be a map"),
                ("flights: {a: nowhere}", "nowhere: no log"),
                ("flights: {'a/b': {scene: room}}", "name a flight"),
                ("flights: {a: {scene: room, sed: 1}}", "flights.a.sed: unknown"),
                ("flights: {a: {scene: room}}\nmodes: [x]", "modes: must be a list of s, sp, spr"),
                ("flights: {a: {scene: room}}\nmodes: [s, s]", "modes: an entry stands there twice"),
                ("flights: {a: {scene: room}}\nconditions: [{calibration_error: -1}]", "not negative"),
                ("flights: {a: {scene: room}}\nparameters: {x: [../..]}", "cannot name a folder"),
                ("flights: {a: {scene: room}}\nduration: 0", "duration: must be a positive"),
                ("flights: {a: [", "while parsing")):
            self.sweep.write_text(text)
            done = self.run_it(code=2)
            self.assertIn(complaint, done.stderr)
        self.assertFalse((self.root / "out").exists())


if __name__ == "__main__":
    unittest.main()
