#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/benchmark_hard, with a stand-in for the program."""
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import pathlib
import sys
import tempfile
import unittest
import unittest.mock

SCRIPTS = pathlib.Path(__file__).resolve().parents[3] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True

# Says how often it replayed; mode spr has half the error of mode s.
PROGRAM = r"""#!/usr/bin/env python3
import json, pathlib, sys
words = sys.argv[1:]
after = lambda option: pathlib.Path(words[words.index(option) + 1])
if words[0] == "--version":
    print("commit   0123abc")
elif words[0] == "sim":
    truth = after("--out") / "truth"
    truth.mkdir()
    tilted = words[words.index("--seed") + 1] == "101"  # by 2.6 degrees
    floor = {"name": "floor", "normal": [0.0, 0.045, 0.999] if tilted else [0.0, 0.0, 1.0]}
    truth.joinpath("planes.json").write_text(json.dumps([floor, {"name": "wall", "normal": [1.0, 0.0, 0.0]}]))
    with pathlib.Path(__file__).with_suffix(".scenes").open("a") as scenes:
        scenes.write(words[words.index("--scene") + 1] + "\n")
elif words[0] == "replay":
    with pathlib.Path(__file__).with_suffix(".count").open("a") as count:
        count.write("1")
    after("--out").joinpath("trajectory.tum").write_text("0 0 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n")
    after("--out").joinpath("mode").write_text(str(after("--mode")))
    with pathlib.Path(__file__).with_suffix(".faults").open("a") as faults:
        faults.write(words[words.index("--inject") + 1] + "\n")
elif words[0] == "eval":
    holds_planes = after("--estimate").joinpath("mode").read_text() == "spr"
    found = {"ate_se3": {"translation_m": {"rmse": 0.001 if holds_planes else 0.002}, "rotation_deg": {"rmse": 0.1}},
             "sim3_scale": 1.0, "rpe": []}
    if holds_planes:
        found["planes"] = {"strict": {"found": 3, "right": 2, "wanted": 4, "area_recall": 0.5}}
    after("--json").write_text(json.dumps(found))
"""


def load():
    loader = importlib.machinery.SourceFileLoader("benchmark_hard", str(SCRIPTS / "benchmark_hard"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("benchmark_hard", loader))
    sys.modules["benchmark_hard"] = module  # its dataclass looks itself up
    loader.exec_module(module)
    return module


hard = load()


class Cells(unittest.TestCase):
    def test_the_interval_is_of_buildings_not_of_draws(self):
        def drawn(*ratios):
            return [({"ate_mm": 1.0}, {"ate_mm": ratio}) for ratio in ratios]
        few = hard.error_cells({1: drawn(0.9), 2: drawn(1.1)})
        self.assertEqual(few[1:], ["1.10", "1.10"])
        self.assertEqual(hard.error_cells({1: drawn(*[0.9] * 9), 2: drawn(*[1.1] * 9)}), few)
        self.assertEqual(hard.error_cells({1: drawn(0.5, 2.0)}), ["1.000", "1.00", "2.00"])

    def test_buildings_and_draws_are_counted(self):
        self.assertEqual([hard.count_cell(draws) for draws in ([3, 3], [2, 1], [])], ["2 x 3", "2 + 1", "0"])

    def test_scale_is_compared_with_the_truth_and_between_modes(self):
        pairs = {1: [({"scale": 1.003}, {"scale": 1.001}), ({"scale": 0.996}, {"scale": 0.998})]}
        self.assertEqual(hard.scale_cell(pairs), "0.354, 0.158, 0.200")

    def test_recall_counts_where_something_is_asked_for(self):
        planes = [{"found": 3, "right": 2, "wanted": 4, "area_recall": 0.5},
                  {"found": 1, "right": 0, "wanted": 0, "area_recall": 0.0}]
        self.assertEqual(hard.plane_cells({1: [({}, {"planes": entry}) for entry in planes]}), ["2 / 4", "0.50"])


class Table(unittest.TestCase):
    def command(self, folder, *more):
        program = folder / "facet.py"
        program.write_text(PROGRAM)
        program.chmod(0o755)
        given = ["benchmark_hard", "--facet", str(program), "--out", str(folder / "out"), "--core", "-1", "--buildings",
                 "100", "101", "--draws", "1", "2", "--conditions", "nominal", "dim light:1", *more]
        out = io.StringIO()
        with unittest.mock.patch.object(sys, "argv", given), contextlib.redirect_stdout(out), \
                contextlib.redirect_stderr(io.StringIO()):
            try:
                return hard.main(), len(program.with_suffix(".count").read_text())
            except SystemExit as end:
                return end.code, 0

    def test_rows_of_some_buildings_are_kept_and_have_a_place_of_their_own(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            document = folder / "page.md"
            document.write_text("<!-- scripts/benchmark_hard -->\nkept\n<!-- end -->\n"
                                "<!-- scripts/benchmark_hard: held out -->\n<!-- end -->\n")
            self.assertEqual(self.command(folder), (0, 12))  # two and one buildings, two draws, two modes
            self.assertEqual(self.command(folder, "--resume", "--jobs", "2", "--document", str(document)), (0, 12))
            self.assertEqual(self.command(folder), (0, 24))
            faults = set((folder / "facet.faults").read_text().split())
            self.assertEqual(faults, {f"calibration=1,{seed}" for seed in (10001, 10002, 10101, 10102)})
            table = document.read_text()
            self.assertIn("-->\nkept\n<!-- end -->", table)
            self.assertIn("| nominal | 2 x 2 | 2.00 | 0.500 [0.500, 0.500] | 0.50 | 0.50 |", table)
            self.assertIn("| of these, a floor tilted by 1 deg and more | 1 x 2 | 2.00 | 0.500 |", table)
            self.assertIn("| dim light | 1 x 2 | 2.00 | 0.500 | 0.50 | 0.50 |", table)
            self.assertIn("'dim light:1'`, commit 0123abc.", table)  # nothing of --resume and --jobs
            self.assertEqual(len(json.loads((folder / "out/results.json").read_text())["nominal"]["101"]), 2)

    def test_halls_are_flights_of_their_own(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            self.assertEqual(self.command(folder, "--conditions", "nominal", "without planes:1"), (0, 12))
            self.assertEqual((folder / "facet.scenes").read_text().split(), ["building", "building", "hall"])

    def test_what_is_hard_in_replay_alone_shares_the_flight(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            rows = ["long, returns", "long, returns, 50 features", "long, returns, flight vibration:1"]
            self.assertEqual(self.command(folder, "--conditions", *rows), (0, 20))
            self.assertEqual((folder / "facet.scenes").read_text().split(), ["building", "building"])

    def test_unknown_rows_are_refused(self):
        with tempfile.TemporaryDirectory() as name:
            for row in ("sunny", "nominal:0", "nominal:3", "nominal:x"):
                self.assertEqual(self.command(pathlib.Path(name), "--conditions", row), (2, 0))


if __name__ == "__main__":
    unittest.main()
