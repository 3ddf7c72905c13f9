#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/target/compare_estimates.py on trajectories whose difference is known."""
import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/target"))
sys.dont_write_bytecode = True
import compare_estimates  # noqa: E402


HALF = math.sqrt(0.5)
SIGMA_RAD, SIGMA_M = 0.002, 0.01


def turned(pose, degrees):
    """The pose, turned about its own z axis."""
    x, y, z, qx, qy, qz, qw = pose
    s, c = math.sin(math.radians(degrees) / 2), math.cos(math.radians(degrees) / 2)
    return (x, y, z, qx * c + qy * s, qy * c - qx * s, qz * c + qw * s, qw * c - qz * s)


def moved(pose, x, y, z):
    return (pose[0] + x, pose[1] + y, pose[2] + z, *pose[3:])


def covariance():
    """Of [theta p v]; p_x and p_y have a correlation of 0.6."""
    sigma = [SIGMA_RAD] * 3 + [SIGMA_M] * 3 + [0.1] * 3
    found = [[sigma[i] ** 2 if i == j else 0.0 for j in range(9)] for i in range(9)]
    found[3][4] = found[4][3] = 0.6 * SIGMA_M**2
    return found


class CompareEstimates(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        self.poses = {10**11 + 10**7 * i: (0.1 * i, 1.0, -2.0, HALF, 0.0, 0.0, HALF) for i in range(20)}
        self.last = max(self.poses)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, poses, spread=covariance(), tracked_later=100):
        """What facet replay leaves of these poses; the last six frames track that many features."""
        folder = self.root / name
        folder.mkdir(exist_ok=True)

        def table(file, head, rows):
            lines = [",".join(map(str, row)) for row in rows]
            (folder / file).write_text("\n".join([head, *lines, ""]), encoding="utf-8")

        upper = [spread[i][j] for i in range(9) for j in range(i, 9)]
        rows = [(stamp, *p[:3], p[6], *p[3:6], *[0.0] * 9) for stamp, p in poses.items()]
        table("trajectory.csv", "#timestamp [ns], p_RS_R_x [m]", rows)
        table("covariance.csv", "stamp_ns,c00", [(stamp, *upper) for stamp in poses])
        counts = [100] * (len(poses) - 6) + [tracked_later] * 6
        head = ",".join(["stamp_ns", "frame_chi2", *compare_estimates.DECISIONS])
        health = [(s, 0.5, "TRACKING", 0, n, 0, 0, 0, 0, 300) for s, n in zip(poses, counts)]
        table("health.csv", head, health)
        return f"{name}={folder}"

    def compare(self, poses, **options):
        folders = [self.write("a", self.poses), self.write("b", poses, **options)]
        return compare_estimates.compare(*(folder.split("=")[1] for folder in folders))

    def run_script(self, *arguments):
        command = [sys.executable, str(ROOT / "scripts/target/compare_estimates.py"), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def test_known_differences(self):
        found = self.compare({stamp: moved(p, 3e-4, -4e-4, 0.0) for stamp, p in self.poses.items()})
        self.assertAlmostEqual(found["max_mm"], 0.5, places=9)
        self.assertAlmostEqual(found["rms_mm"], 0.5, places=9)
        self.assertFalse(found["same"])
        for degrees in (1e-7, 0.003, -20.0, 179.0):
            other = {stamp: turned(pose, degrees) for stamp, pose in self.poses.items()}
            found = self.compare(other)
            self.assertAlmostEqual(found["max_deg"], abs(degrees), delta=1e-6 * abs(degrees) + 1e-12)
            share = math.radians(abs(degrees)) / SIGMA_RAD / math.sqrt(6.0)
            self.assertAlmostEqual(found["max_sigma"], share, delta=1e-6 * share)
            opposite = {stamp: (*p[:3], *(-v for v in p[3:])) for stamp, p in other.items()}
            self.assertAlmostEqual(self.compare(opposite)["max_deg"], found["max_deg"])

    def test_the_covariance_counts_with_its_correlations(self):
        # The inverse of [1 r; r 1] has 1 / (1 - r^2) and -r / (1 - r^2): a step along both axes is 2 / (1 + r), one
        # along their difference 2 / (1 - r).
        for y, squared in ((1.0, 2.0 / 1.6), (-1.0, 2.0 / 0.4)):
            step = 0.1 * SIGMA_M
            found = self.compare({stamp: moved(p, step, y * step, 0.0) for stamp, p in self.poses.items()})
            self.assertAlmostEqual(found["max_sigma"], 0.1 * math.sqrt(squared / 6.0), places=9)
            self.assertAlmostEqual(found["rms_sigma"], found["max_sigma"], places=9)
        only_last = {**self.poses, self.last: moved(self.poses[self.last], 0.0, 0.0, SIGMA_M)}
        found = self.compare(only_last)
        self.assertAlmostEqual(found["max_sigma"], math.sqrt(1.0 / 6.0), places=9)
        self.assertAlmostEqual(found["rms_sigma"], math.sqrt(1.0 / 6.0 / 20.0), places=9)

    def test_when_decisions_begin_to_differ(self):
        self.assertIsNone(self.compare(self.poses)["other_decision_s"])
        self.assertAlmostEqual(self.compare(self.poses, tracked_later=99)["other_decision_s"], 0.14, places=9)

    def test_the_limits_decide_the_exit_code(self):
        reference = self.write("a", self.poses)
        same = self.write("b", self.poses)
        pose = self.poses[self.last]
        # One frame of twenty by 2.5 standard deviations along one axis of six: 1.02 there, 0.23 rms.
        far = self.write("c", {**self.poses, self.last: moved(pose, 0.0, 0.0, 2.5 * SIGMA_M)})
        turn = self.write("d", {**self.poses, self.last: turned(pose, math.degrees(2.5 * SIGMA_RAD))})
        near = self.write("e", {**self.poses, self.last: moved(pose, 0.0, 0.0, 2.4 * SIGMA_M)})
        # All frames by 0.65 standard deviations: 0.27 each; and by 0.6: 0.245.
        long = self.write("f", {stamp: moved(p, 0.0, 0.0, 0.65 * SIGMA_M) for stamp, p in self.poses.items()})
        short = self.write("g", {stamp: moved(p, 0.0, 0.0, 0.6 * SIGMA_M) for stamp, p in self.poses.items()})
        good = self.run_script(reference, same, near, short)
        self.assertEqual(good.returncode, 0, good.stderr)
        self.assertRegex(good.stdout, r"b +20 .* same +same\n")
        for other in (far, turn, long):
            bad = self.run_script(reference, same, other)
            self.assertEqual(bad.returncode, 1)
            self.assertIn(f"beyond 0.25 rms and 1 of the reported standard deviation: {other[0]}", bad.stdout)
            self.assertEqual(
                self.run_script("--max-sigma", "1.1", "--rms-sigma", "0.3", reference, other).returncode, 0
            )

    def test_bad_input_is_one_line(self):
        reference = self.write("a", self.poses)
        shorter = self.write("b", dict(list(self.poses.items())[1:]))
        empty = self.write("c", {})
        broken = self.write("d", {10**9: (0.0, math.nan, 0.0, 0.0, 0.0, 0.0, 1.0)})
        certain = self.write("f", self.poses, spread=[[0.0] * 9 for _ in range(9)])
        silent = self.write("g", self.poses)
        (self.root / "g" / "health.csv").write_text("stamp_ns,state\n1,INIT\n", encoding="utf-8")
        cases = {
            (reference,): "at least two",
            (reference, "b"): "at least two",
            (reference, shorter): "a and b: 1 frames",
            (reference, empty): "no row",
            (reference, broken): "trajectory.csv:2: not a stamp and 16 numbers",
            (reference, f"e={self.root}/none"): "none/trajectory.csv: No such file",
            (certain, reference): "f and a: a covariance is not positive definite",
            (reference, silent): "health.csv: not the table of facet replay ('is_keyframe')",
        }
        for arguments, complaint in cases.items():
            run = self.run_script(*arguments)
            self.assertEqual(run.returncode, 2, arguments)
            self.assertIn(complaint, run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
