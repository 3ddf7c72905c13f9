#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of describe.py: rounding, rotations, and which differences of two texts count."""
import math
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
import describe  # noqa: E402

GOLDEN = "head\n0.5     1234.5   -0.123\nfaces   1000\n#3      vertical   0.9999\n"


def about(axis, degrees):
    sine = math.sin(math.radians(degrees) / 2)
    return (math.cos(math.radians(degrees) / 2), *(sine * x for x in axis))


class Describe(unittest.TestCase):
    def test_no_negative_zero(self):
        self.assertEqual(describe.fixed(-0.00001, 3), "0.000")
        self.assertEqual(describe.fixed(-0.0006, 3), "-0.001")

    def test_rotations(self):
        start = about((0.6, 0.0, 0.8), 150.0)
        for degrees in (0.0, 1e-6, 30.0, -120.0):
            w, x, y, z = about((0.0, 1.0, 0.0), degrees)
            aw, ax, ay, az = start
            turned = (
                aw * w - ax * x - ay * y - az * z,
                aw * x + ax * w + ay * z - az * y,
                aw * y - ax * z + ay * w + az * x,
                aw * z + ax * y - ay * x + az * w,
            )
            for q in (turned, tuple(-value for value in turned)):
                found = describe.relative_turn_deg(start, q)
                for value, expected in zip(found, (0.0, degrees, 0.0)):
                    self.assertAlmostEqual(value, expected, places=9)
        for value, expected in zip(describe.up_in_body(about((1.0, 0.0, 0.0), 90.0)), (0.0, 1.0, 0.0)):
            self.assertAlmostEqual(value, expected, places=12)

    def test_health_has_a_line_for_every_change(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "health.csv"
            rows = ("1000000000,TRACKING,,0", "1050000000,TRACKING,,0", "1100000000,LOST,imu_gap|few_features,0",
                    "1150000000,TRACKING,,1")  # fmt: skip
            path.write_text("stamp_ns,state,reason_names,reset_counter\n" + "\n".join(rows) + "\n", encoding="utf-8")
            lines = [line.split() for line in describe.health_lines(path)][1:]
        changes = ["0.00 TRACKING 0 -", "0.10 LOST 0 imu_gap few_features", "0.15 TRACKING 1 -"]
        self.assertEqual(lines, [change.split() for change in changes])

    def settled(self, old, new, is_near):
        self.assertIn(old, GOLDEN)
        return describe.settle(GOLDEN, GOLDEN.replace(old, new), is_near)

    def test_rounding_is_no_change(self):
        for old, new in (("1234.5", "1234.6"), ("-0.123", "-0.124"), ("0.9999", "1.0000")):
            self.assertEqual(self.settled(old, new, False), GOLDEN)
        for old, new in (("1234.5", "1235.5"), ("-0.123", "-0.133"), ("1000", "1020")):
            self.assertNotEqual(self.settled(old, new, False), GOLDEN)
            self.assertEqual(self.settled(old, new, True), GOLDEN)

    def test_anything_more_is_a_change(self):
        changes = (("1234.5", "1235.6"), ("-0.123", "-0.134"), ("1000", "1021"), ("#3", "#4"), ("0.5 ", "none "),
                   ("vertical", "horizontal"), ("head", "another head"), ("#3", "\n#3"))  # fmt: skip
        for old, new in changes:
            for is_near in (False, True):
                self.assertEqual(self.settled(old, new, is_near), GOLDEN.replace(old, new), (old, new))

    def test_lines_that_agree_stay_as_they_were(self):
        found = GOLDEN.replace("1234.5", "1234.6").replace("vertical", "horizontal")
        self.assertEqual(describe.settle(GOLDEN, found, False), GOLDEN.replace("vertical", "horizontal"))


if __name__ == "__main__":
    unittest.main()
