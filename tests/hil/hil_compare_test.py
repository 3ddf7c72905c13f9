#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of tests/hil/hil_compare.py on poses and states that are known."""
import math
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
import hil_compare  # noqa: E402

MS = 1_000_000


def poses(shift_ns=0, moved=0.0, late_ns=0):
    return {k * 50 * MS + shift_ns + late_ns: (0.1 * k + moved, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0) for k in range(20)}


def health(states):
    return [(k * 50 * MS, state, [], 0) for k, state in enumerate(states)]


class HilCompare(unittest.TestCase):
    def test_pairs_by_stamp(self):
        found = hil_compare.differences(poses(), poses(moved=0.003, late_ns=1500))
        self.assertEqual(found["common"], 20)
        self.assertAlmostEqual(found["max_mm"], 3.0, places=6)
        self.assertAlmostEqual(found["max_stamp_us"], 1.5)
        other = poses()
        del other[500 * MS]
        self.assertEqual(hil_compare.differences(poses(), other)["common"], 19)
        self.assertEqual(hil_compare.differences(poses(), poses(late_ns=25 * MS))["common"], 0)

    def test_angle(self):
        half = math.radians(0.5)
        turned = (0, 0, 0, -math.cos(half), 0.0, 0.0, -math.sin(half))
        self.assertAlmostEqual(hil_compare.angle_deg((0, 0, 0, 1.0, 0.0, 0.0, 0.0), turned), 1.0, places=9)

    def test_recovery(self):
        plain = health(["TRACKING"] * 40)
        states = ["TRACKING"] * 10 + ["DEGRADED"] * 8 + ["LOST"] * 2 + ["TRACKING"] * 20
        found = hil_compare.recovery(health(states), plain, 500 * MS, 700 * MS)
        self.assertEqual(found["states"], ["DEGRADED", "LOST"])
        self.assertAlmostEqual(found["recovery_s"], 0.3)
        self.assertTrue(math.isnan(hil_compare.recovery(health(states[:20]), plain, 500 * MS, 700 * MS)["recovery_s"]))
        gone = [row for row in health(["TRACKING"] * 40) if not 500 * MS <= row[0] < 900 * MS]
        found = hil_compare.recovery(gone, plain, 500 * MS, 800 * MS)
        self.assertEqual(found["states"], [])
        self.assertAlmostEqual(found["longest_gap_s"], 0.45)
        self.assertAlmostEqual(found["recovery_s"], 0.1)

    def test_compares_what_was_recorded_with_what_was_sent(self):
        sent = [(k * 5 * MS, (0.1 * k, 0.0, 0.0, 0.0, 0.0, 9.8)) for k in range(10)]
        recorded = [(stamp + 70 + (3 if k == 4 else 0), values) for k, (stamp, values) in enumerate(sent)]
        found = hil_compare.inertial_differences(sent, recorded, 70)
        self.assertEqual((found["samples"], found["max_value"], found["max_stamp_ns"]), (10, 0.0, 3))
        recorded[7] = (recorded[7][0], (0.7, 0.0, 0.25, 0.0, 0.0, 9.8))
        self.assertEqual(hil_compare.inertial_differences(sent, recorded, 70)["max_value"], 0.25)
        self.assertTrue(math.isnan(hil_compare.inertial_differences(sent, recorded[1:], 70)["max_value"]))

    def test_names_files_that_differ_or_are_missing(self):
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as other:
            for where, name, text in ((folder, "a", "1"), (other, "a", "1"), (folder, "b", "1"), (other, "b", "2"),
                                      (folder, "c", "1")):  # fmt: skip
                Path(where, name).write_text(text, encoding="utf-8")
            names = ("a", "b", "c", "d")
            self.assertEqual(hil_compare.files_that_differ(folder, other, names), ["b", "c", "d"])

    def test_reads_poses_in_the_time_of_the_log(self):
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "trajectory.csv").write_text("#stamp\n1000,1,2,3,1,0,0,0,9,9,9\n", encoding="utf-8")
            self.assertEqual(hil_compare.read_poses(folder, 400), {600: (1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0)})


if __name__ == "__main__":
    unittest.main()
