#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of what the benchmarks stand on: statistics, progress, tables as text, the time in a state."""
import contextlib
import io
import math
import sys
import unittest
import unittest.mock
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts"))
sys.dont_write_bytecode = True
from bench import benchmark_lib as lib, stats  # noqa: E402


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


class Statistics(unittest.TestCase):
    def test_student_points_are_those_of_tables(self):
        for dof, point in ((1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (10, 2.228), (30, 2.042), (1000, 1.962)):
            self.assertAlmostEqual(stats.student_point(dof) / point, 1.0, delta=0.005, msg=dof)

    def test_mean_and_interval_are_those_of_logarithms(self):
        mean, low, high = stats.geometric_mean([1.0, 2.0, 4.0])
        self.assertAlmostEqual(mean, 2.0)
        self.assertAlmostEqual(high / mean, mean / low)
        # log 2 apart: a standard deviation of log 2, and Student's point for two degrees of freedom.
        self.assertAlmostEqual(high, 2.0 * 2.0 ** (4.3027 / 3.0 ** 0.5), places=3)
        self.assertEqual(stats.geometric_mean([3.0])[1:], (None, None))
        self.assertEqual(stats.geometric_mean([]), (None, None, None))

    def test_a_band_holds_95_percent_and_narrows_around_the_dof(self):
        for dof, runs in ((3, 10), (3, 20), (6, 20), (6, 100)):
            low, high = stats.average_band(dof, runs)
            self.assertAlmostEqual(chi_square_cdf(low * runs, dof * runs), 0.025, places=3)
            self.assertAlmostEqual(chi_square_cdf(high * runs, dof * runs), 0.975, places=3)
        low, high = stats.average_band(6, 10000)
        self.assertTrue(low < 6 < high < low + 0.2)

    def test_a_quantile_is_a_value_of_the_list(self):
        self.assertEqual([stats.quantile([3, 1, 2, 4], share) for share in (0.5, 0.95, 1.0)], [2, 4, 4])
        self.assertIsNone(stats.quantile([], 0.5))

    def test_a_regression_is_larger_than_tolerance_and_chance(self):
        names = [f"room/s/default/k1_seed{seed}" for seed in (1, 2, 3, 4)]
        before = {"commit": "abc", "ate_m": {name: 0.001 * (i + 1) for i, name in enumerate(names)}}

        def regressions(*factors):
            errors = {name: before["ate_m"][name] * factor or None for name, factor in zip(names, factors)}
            return stats.check_baseline(errors, before, 0.03)[1]

        self.assertEqual(regressions(1.0, 1.0, 1.0, 1.0), [])
        self.assertEqual(regressions(1.02, 1.021, 1.02, 1.019), [], "certain, but within the tolerance")
        self.assertEqual(regressions(1.5, 0.8, 1.4, 0.9), [], "beyond the tolerance, but by chance")
        self.assertIn("mode s, default: error 1.10", regressions(1.1, 1.11, 1.09, 1.1)[0])
        self.assertIn("k1_seed2: failed, which the baseline did not", regressions(1, 0, 1, 1)[0])


class WorkLeft(unittest.TestCase):
    def said(self, pieces, seconds, calls):
        """What is said of calls (method, text), each `seconds` after the one before."""
        clock = iter(range(0, 10**6, seconds))
        out = io.StringIO()
        with unittest.mock.patch.object(lib.time, "monotonic", lambda: next(clock)), contextlib.redirect_stderr(out):
            work = lib.Work(pieces)
            for method, text in calls:
                getattr(work, method)(text)
        return out.getvalue().splitlines()

    def test_pieces_of_equal_length(self):
        self.assertEqual(self.said(3, 30, [("finished", "a"), ("finished", "b"), ("finished", "c")]),
                         ["[1/3, about 60 s left] a", "[2/3, about 30 s left] b", "[3/3] c"])

    def test_a_piece_that_begins_counts_as_work_that_is_left(self):
        self.assertEqual(self.said([1.0, 9.0], 20, [("next", "short"), ("next", "long")]),
                         ["[1/2] short", "[2/2, about 3 min left] long"])


class Text(unittest.TestCase):
    def test_tables(self):
        table = lib.text_table(["a", "fault", "x"], [["room", "none", "1.0"], ["b", "c", "10.0"]], left=2)
        self.assertEqual(table, "a     fault     x\nroom  none    1.0\nb     c      10.0")
        self.assertEqual(lib.markdown_table(["a", "b"], [["1", "2"]]), "| a | b |\n|---|---|\n| 1 | 2 |")
        self.assertEqual([lib.number(None, 2), lib.number(1.005, 1)], ["-", "1.0"])

    def test_states_last_until_the_next_row(self):
        rows = [{"stamp_ns": str(ns), "state": state}
                for ns, state in ((0, "INIT"), (500000000, "TRACKING"), (2000000000, "LOST"), (2500000000, "TRACKING"))]
        self.assertEqual(lib.state_durations(rows), {"INIT": 0.5, "TRACKING": 1.5, "LOST": 0.5})


if __name__ == "__main__":
    unittest.main()
