#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/bench/benchmark_lib.py and of how the benchmark scripts refuse wrong usage."""
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[3] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True
from bench import benchmark_lib as lib  # noqa: E402


def chi_square_cdf(x, dof):
    """Regularised lower incomplete gamma function by its series."""
    a, x = dof / 2.0, x / 2.0
    term = total = 1.0 / a
    n = 0
    while term > 1e-16 * total:
        n += 1
        term *= x / (a + n)
        total += term
    return total * math.exp(-x + a * math.log(x) - math.lgamma(a))


class Bands(unittest.TestCase):
    def test_band_of_an_average_holds_95_percent(self):
        for dof, runs in ((3, 10), (3, 20), (6, 20), (6, 100)):
            low, high = lib.average_band(dof, runs)
            self.assertAlmostEqual(chi_square_cdf(low * runs, dof * runs), 0.025, places=3)
            self.assertAlmostEqual(chi_square_cdf(high * runs, dof * runs), 0.975, places=3)

    def test_band_narrows_around_the_dof(self):
        low, high = lib.average_band(6, 10000)
        self.assertLess(high - low, 0.2)
        self.assertTrue(low < 6 < high)

    def test_drawn_averages_fall_into_it(self):
        generator = random.Random(1)
        low, high = lib.average_band(3, 20)
        draws = [sum(generator.gauss(0, 1) ** 2 for _ in range(60)) / 20 for _ in range(2000)]
        self.assertAlmostEqual(sum(low <= x <= high for x in draws) / 2000, 0.95, delta=0.015)


class Tables(unittest.TestCase):
    def test_text_table_aligns(self):
        table = lib.text_table(["a", "fault", "x"], [["room", "none", "1.0"], ["b", "c", "10.0"]], left=2)
        self.assertEqual(table, "a     fault     x\nroom  none    1.0\nb     c      10.0")

    def test_markdown_table(self):
        self.assertEqual(lib.markdown_table(["a", "b"], [["1", "2"]]), "| a | b |\n|---|---|\n| 1 | 2 |")

    def test_number(self):
        self.assertEqual(lib.number(None, 2), "-")
        self.assertEqual(lib.number(1.005, 1), "1.0")


class Health(unittest.TestCase):
    def test_states_last_until_the_next_row(self):
        rows = [{"stamp_ns": str(ns), "state": state}
                for ns, state in ((0, "INIT"), (500000000, "TRACKING"), (2000000000, "LOST"), (2500000000, "TRACKING"))]
        durations = lib.state_durations(rows)
        self.assertEqual(list(durations), ["INIT", "TRACKING", "LOST"])
        self.assertAlmostEqual(durations["INIT"], 0.5)
        self.assertAlmostEqual(durations["TRACKING"], 1.5)
        self.assertAlmostEqual(durations["LOST"], 0.5)
        self.assertEqual(lib.state_durations([]), {})


class Usage(unittest.TestCase):
    def complaint(self, script, *arguments):
        done = subprocess.run([sys.executable, SCRIPTS / script, *map(str, arguments)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return done.stderr.strip().splitlines()[-1]

    def test_what_is_missing_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "facet"
            program.write_text("")
            nowhere = pathlib.Path(folder) / "none"
            for script in ("benchmark_accuracy", "benchmark_robustness"):
                self.assertIn(f"{nowhere}: no such program", self.complaint(script, "--facet", nowhere, folder))
                self.assertIn(f"{nowhere}: no such folder", self.complaint(script, "--facet", program, nowhere))
                self.assertIn("must be KEY=VALUE", self.complaint(script, "--facet", program, "--set", "x", folder))
            self.assertIn("unknown 'fog'", self.complaint("benchmark_robustness", "--facet", program, "--faults", "fog",
                                                          folder))
            self.assertIn("--runs", self.complaint("benchmark_consistency", "--facet", program, "--runs", "0"))
            self.assertIn("no covariance.csv", self.complaint("plot_consistency", folder, folder, "--facet", program))

    def test_help(self):
        for script in ("benchmark_accuracy", "benchmark_robustness", "benchmark_consistency", "plot_consistency"):
            done = subprocess.run([sys.executable, SCRIPTS / script, "--help"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
