#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""scripts/evaluate with the program itself, over a folder of short flights that have the traps of EuRoC's sequences.

MH_04 and V2_03 have unequal numbers of left and right images, V2_03 lacks many of both, the machine hall's true states
begin after the images, and its vehicle is lifted by hand: there is no standing at the start.

Usage: euroc_traps_test.py FACET [TEST...]
"""
import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
FACET = Path(sys.argv.pop(1)).resolve() if len(sys.argv) > 1 else ROOT / "build/release/bin/facet"
SECONDS, RATE = 8, 20


def thin_out(table, wanted):
    """Keeps the rows of a table whose number `wanted` accepts; returns how many have gone."""
    lines = table.read_text().splitlines()
    header = [line for line in lines if line.startswith("#")]
    rows = [line for line in lines if not line.startswith("#")]
    kept = [row for i, row in enumerate(rows) if wanted(i)]
    table.write_text("\n".join(header + kept) + "\n")
    return len(rows) - len(kept)


class EurocTraps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        root = Path(cls.folder.name)
        cls.logs, cls.out = root / "euroc", root / "out"
        cls.logs.mkdir()
        subprocess.run([FACET, "sim", "--scene", "hall", "--out", root / "flight", "--duration", str(SECONDS),
                        "--stand", "0", "--samples", "1", "--seed", "4"], check=True, capture_output=True)
        cls.left_gone = cls.imitate(root / "flight", "MH_04_difficult", left=lambda i: i % 23 != 11,
                                    right=lambda i: i % 17 != 5, truth=lambda i: i >= 2 * 200)
        cls.both_gone = cls.imitate(root / "flight", "V2_03_difficult", left=lambda i: not (i > 60 and i % 3 == 0),
                                    right=lambda i: not (i > 60 and i % 3 == 0) and i % 29 != 7)
        done = subprocess.run([ROOT / "scripts/evaluate", cls.logs, "--modes", "s", "--facet", FACET, "--out", cls.out],
                              capture_output=True, text=True, check=False)
        cls.said, cls.code = done.stderr, done.returncode

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def imitate(cls, flight, name, left, right, truth=lambda _: True):
        """A copy of the flight without some rows; the number of left images that it lacks."""
        mav0 = cls.logs / name / "mav0"
        shutil.copytree(flight / "mav0", mav0)
        gone = thin_out(mav0 / "cam0/data.csv", left)
        assert gone != thin_out(mav0 / "cam1/data.csv", right)
        thin_out(mav0 / "state_groundtruth_estimate0/data.csv", truth)
        return gone

    def result(self, name):
        folder = self.out / f"{name}_s"
        return (json.loads((folder / "summary.json").read_text()), json.loads((folder / "eval.json").read_text()),
                (folder / "trajectory.tum").read_text().splitlines())

    def test_the_folder_is_evaluated_without_a_failure(self):
        self.assertEqual(self.code, 0, self.said)
        self.assertIn("<h2>MH_04_difficult</h2>", (self.out / "report.html").read_text(encoding="utf-8"))

    def test_images_of_one_side_are_used_and_a_moving_start_with_a_late_truth_counts_no_more_than_it_is(self):
        summary, evaluation, poses = self.result("MH_04_difficult")
        # Where the left image is missing the right one makes the frame.
        self.assertGreater(summary["frames"], SECONDS * RATE - 5)
        self.assertGreater(len(poses), 0.8 * summary["frames"])
        self.assertLess(evaluation["matched"], len(poses), "poses from before the truth are not compared")
        self.assertGreater(evaluation["matched"], (SECONDS - 3) * RATE)
        self.assertLess(evaluation["ate_se3"]["translation_m"]["rmse"], 0.02)

    def test_a_third_of_the_images_missing_costs_frames_but_not_the_flight(self):
        summary, evaluation, _ = self.result("V2_03_difficult")
        self.assertEqual(summary["frames"], SECONDS * RATE + 1 - self.both_gone)
        self.assertEqual(summary["final"]["state"], "TRACKING")
        self.assertLess(evaluation["ate_se3"]["translation_m"]["rmse"], 0.03)


if __name__ == "__main__":
    unittest.main()
