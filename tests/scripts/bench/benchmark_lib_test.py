#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/bench/benchmark_lib.py and of how the benchmark scripts refuse wrong usage."""
import contextlib
import io
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

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

    def test_nothing_to_do_says_nothing(self):
        self.assertEqual(self.said(0, 1, []), [])


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


class Draws(unittest.TestCase):
    def arguments(self, *given):
        parser = lib.base_parser("", "test")
        lib.add_condition_options(parser)
        arguments = parser.parse_args(given)
        lib.shorten_if_quick(arguments)
        return arguments

    def test_real_calibrations_come_first(self):
        arguments = self.arguments()
        self.assertEqual(arguments.factors, [1.0, 2.0, 0.0])
        rows = lib.conditions(arguments)
        self.assertEqual([str(row) for row in rows], ["1, flight", "1", "2", "0"])
        self.assertEqual([lib.seeds_of(arguments, row) for row in rows], [[1, 2, 3], [1, 2, 3], [1, 2, 3], [1]])
        self.assertEqual(len({row.name(1) for row in rows}), 4)
        self.assertEqual(rows[0].options(3), ["--inject", "calibration=1,3", "--inject", "vibration=flight,3"])
        self.assertEqual(lib.Condition.of({"ate": 1, **rows[0].fields()}), rows[0])
        self.assertEqual([str(row) for row in lib.conditions(self.arguments("--vibration", "none"))], ["1", "2", "0"])
        self.assertEqual(lib.log_options(arguments), [])

    def test_images_show_the_vibration_in_a_row_of_their_own(self):
        rows = lib.conditions(self.arguments("--images", "--factors", "1"))
        self.assertEqual([str(row) for row in rows], ["1, flight", "1, flight+images", "1"])
        self.assertEqual(rows[1].options(3), ["--inject", "calibration=1,3", "--inject", "vibration=flight,3,1,images"])
        self.assertEqual(len({row.name(1) for row in rows}), 3)
        none = self.arguments("--images", "--vibration", "none", "--factors", "1")
        self.assertEqual([str(row) for row in lib.conditions(none)], ["1"])

    def test_quick_is_one_draw_of_a_short_log(self):
        arguments = self.arguments("--quick", "--seeds", "7", "8")
        self.assertEqual((arguments.factors, arguments.seeds), ([1.0, 0.0], [7]))
        self.assertEqual(lib.log_options(arguments), ["--duration", "10"])
        self.assertEqual(lib.log_options(self.arguments("--quick", "--duration", "4")), ["--duration", "4"])

    def test_a_perfect_calibration_is_replayed_as_it_is(self):
        self.assertEqual(lib.Condition(0.0).options(3), [])
        self.assertEqual(lib.Condition(0.5).options(3), ["--inject", "calibration=0.5,3"])
        self.assertEqual(lib.Condition(2.0).name(3), "k2_seed3")

    def test_medians_leave_out_what_is_not_there(self):
        self.assertEqual(lib.medians([[1.0, None, None], [3.0, 5.0, None], [2.0, 7.0, None]]), [2.0, 6.0, None])
        self.assertEqual(lib.worst([1.0, None, 3.0]), 3.0)
        self.assertIsNone(lib.worst([None]))

    def test_tables_are_written_printed_and_put_into_a_document(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            program = folder / "facet"
            program.write_text("#!/bin/sh\necho 'facet 1'\necho 'commit   0123abc'\n")
            program.chmod(0o755)
            log = folder / "flight 7"
            log.mkdir()
            document = folder / "accuracy.md"
            document.write_text("before\n<!-- scripts/benchmark_x -->\nold\n<!-- end -->\nafter\n")
            given = ["benchmark_x", str(log), "--seeds", "2", "--core=1", "--out", str(folder), "--facet", str(program),
                     "--document", str(document)]
            out = io.StringIO()
            with unittest.mock.patch.object(sys, "argv", given), contextlib.redirect_stdout(out), \
                    contextlib.redirect_stderr(io.StringIO()):
                arguments = self.arguments(*given[2:])
                lib.write_tables(arguments, "what", [(["a", "K"], [["x", "1"]])], ["a note"], {"x": 1})
            self.assertEqual((folder / "table.txt").read_text(), "what\na  K\nx  1\na note\n")
            self.assertEqual(out.getvalue(), (folder / "table.txt").read_text())
            expected = ("What.\n\n| a | K |\n|---|---|\n| x | 1 |\n\na note\n\n"
                        "`scripts/benchmark_x 'flight 7' --seeds 2`, commit 0123abc.\n")
            self.assertEqual((folder / "table.md").read_text(), expected)
            self.assertEqual(document.read_text(),
                             f"before\n<!-- scripts/benchmark_x -->\n{expected}<!-- end -->\nafter\n")
            self.assertEqual(json.loads((folder / "results.json").read_text()), {"x": 1})

    def test_a_document_without_a_place_is_refused_before_anything_runs(self):
        with tempfile.TemporaryDirectory() as name:
            document = pathlib.Path(name) / "accuracy.md"
            parser = lib.base_parser("", "test")
            for text, problem in ((None, "no such file"), ("<!-- scripts/other -->\n", "no line")):
                if text is not None:
                    document.write_text(text)
                error = io.StringIO()
                with self.assertRaises(SystemExit) as end, contextlib.redirect_stderr(error):
                    lib.check_arguments(parser, parser.parse_args(["--document", str(document)]))
                self.assertEqual(end.exception.code, 2)
                self.assertIn(problem, error.getvalue())


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
            for script in ("benchmark_accuracy", "benchmark_robustness", "benchmark_one_camera"):
                self.assertIn(f"{nowhere}: no such program", self.complaint(script, "--facet", nowhere, folder))
                self.assertIn(f"{nowhere}: no such folder", self.complaint(script, "--facet", program, nowhere))
                self.assertIn("must be KEY=VALUE", self.complaint(script, "--facet", program, "--set", "x", folder))
            self.assertIn("unknown 'fog'", self.complaint("benchmark_robustness", "--facet", program, "--faults", "fog",
                                                          folder))
            self.assertIn("--runs", self.complaint("benchmark_consistency", "--facet", program, "--runs", "0"))
            self.assertIn("--minutes", self.complaint("benchmark_hour", "--facet", program, "--minutes", "0.5"))
            for script in ("benchmark_accuracy", "benchmark_mesh", "benchmark_calibration", "benchmark_obstacles"):
                self.assertIn("--factors", self.complaint(script, folder, "--facet", program, "--factors", "-1"))
                self.assertIn("--duration", self.complaint(script, folder, "--facet", program, "--duration", "0"))
            self.assertIn("no covariance.csv", self.complaint("plot_consistency", folder, folder, "--facet", program))
            self.assertIn("no table of a long run", self.complaint("tools/plot_hour", folder))

    def test_help(self):
        for script in ("benchmark_accuracy", "benchmark_calibration", "benchmark_consistency", "benchmark_hour",
                       "benchmark_mesh", "benchmark_obstacles", "benchmark_one_camera", "benchmark_outages",
                       "benchmark_planes", "benchmark_robustness", "plot_consistency", "tools/plot_hour"):
            done = subprocess.run([sys.executable, SCRIPTS / script, "--help"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
