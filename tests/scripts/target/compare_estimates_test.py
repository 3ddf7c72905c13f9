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


def turned(pose, degrees):
    """The pose, turned about its own z axis."""
    x, y, z, qx, qy, qz, qw = pose
    s, c = math.sin(math.radians(degrees) / 2), math.cos(math.radians(degrees) / 2)
    return (x, y, z, qx * c + qy * s, qy * c - qx * s, qz * c + qw * s, qw * c - qz * s)


class CompareEstimates(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        half = math.sqrt(0.5)
        self.poses = {f"100.{i:02}": (0.1 * i, 1.0, -2.0, half, 0.0, 0.0, half) for i in range(20)}

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, poses):
        folder = self.root / name
        folder.mkdir(exist_ok=True)
        lines = [f"{stamp} {' '.join(repr(value) for value in pose)}\n" for stamp, pose in poses.items()]
        (folder / "trajectory.tum").write_text("# stamp x y z qx qy qz qw\n" + "".join(lines), encoding="utf-8")
        return f"{name}={folder}"

    def run_script(self, *arguments):
        command = [sys.executable, str(ROOT / "scripts/target/compare_estimates.py"), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def test_known_differences(self):
        moved = {stamp: (p[0] + 3e-4, p[1] - 4e-4, *p[2:]) for stamp, p in self.poses.items()}
        found = compare_estimates.compare(self.poses, moved)
        self.assertAlmostEqual(found["max_mm"], 0.5, places=9)
        self.assertAlmostEqual(found["rms_mm"], 0.5, places=9)
        self.assertFalse(found["same"])
        for degrees in (1e-7, 0.003, -20.0, 179.0):
            other = {stamp: turned(pose, degrees) for stamp, pose in self.poses.items()}
            found = compare_estimates.compare(self.poses, other)
            self.assertAlmostEqual(found["max_deg"], abs(degrees), delta=1e-6 * abs(degrees) + 1e-12)
            opposite = {stamp: (*p[:3], *(-v for v in p[3:])) for stamp, p in other.items()}
            self.assertAlmostEqual(compare_estimates.compare(self.poses, opposite)["max_deg"], found["max_deg"])

    def test_limits_decide_the_exit_code(self):
        reference = self.write("a", self.poses)
        same = self.write("b", self.poses)
        last = list(self.poses)[-1]
        far = self.write("c", {**self.poses, last: (*self.poses[last][:2], -1.9985, *self.poses[last][3:])})
        turn = self.write("d", {**self.poses, last: turned(self.poses[last], 0.02)})
        good = self.run_script(reference, same)
        self.assertEqual(good.returncode, 0, good.stderr)
        self.assertRegex(good.stdout, r"b +20 .* yes\n")
        for other in (far, turn):
            bad = self.run_script(reference, same, other)
            self.assertEqual(bad.returncode, 1)
            self.assertIn(f"beyond 1 mm or 0.01 deg: {other[0]}", bad.stdout)
        self.assertEqual(self.run_script("--max-mm", "2", reference, far).returncode, 0)
        self.assertEqual(self.run_script("--max-deg", "0.03", reference, turn).returncode, 0)

    def test_bad_input_is_one_line(self):
        reference = self.write("a", self.poses)
        shorter = self.write("b", dict(list(self.poses.items())[1:]))
        empty = self.write("c", {})
        broken = self.write("d", {"1.0": (0.0, math.nan, 0.0, 0.0, 0.0, 0.0, 1.0)})
        cases = {
            (reference,): "at least two",
            (reference, "b"): "at least two",
            (reference, shorter): "a and b: 1 frames",
            (reference, empty): "no pose",
            (reference, broken): "trajectory.tum:2: not a stamp and seven numbers",
            (reference, f"e={self.root}/none"): "none/trajectory.tum: No such file",
        }
        for arguments, complaint in cases.items():
            run = self.run_script(*arguments)
            self.assertEqual(run.returncode, 2, arguments)
            self.assertIn(complaint, run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
