#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/evaluate with a program that writes small results in place of facet; the published figures."""
import json
import statistics
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
# Says what it was asked to do in CALLS; a log named "broken" fails.
FAKE = """#!/usr/bin/env python3
import sys
sys.path.insert(0, {here!r})
sys.dont_write_bytecode = True
from pathlib import Path
from small_run import FRAMES, write_run, write_truth
arguments = sys.argv[1:]
with open({calls!r}, "a") as stream:
    stream.write(" ".join(arguments[:2]) + "\\n")
value = lambda name: arguments[arguments.index(name) + 1]
if arguments == ["--version"]:
    print("facet        0.1.0\\ncommit       0123456789ab")
elif arguments[0] == "sim":
    folder = Path(value("--out"))
    for part, text in (("cam0", "1000000000,a.png\\n2000000000,b.png\\n"), ("state_groundtruth_estimate0", "")):
        (folder / "mav0" / part).mkdir(parents=True)
        (folder / "mav0" / part / "data.csv").write_text(text)
elif arguments[0] == "replay":
    if "broken" in arguments[1]:
        sys.exit("replay: error: no such thing")
    changed = [arguments[i + 1].split("=") for i, word in enumerate(arguments) if word == "--set"]
    write_run(Path(value("--out")), value("--mode"), arguments[1], parameters=dict(changed))
    sys.exit(1 if "lost" in arguments[1] else 0)
elif arguments[0] == "eval":
    write_truth(Path(value("--estimate")), [0.02] * FRAMES)
"""


class Evaluate(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        self.calls = self.root / "calls"
        self.program = self.root / "facet"
        self.program.write_text(FAKE.format(here=str(HERE), calls=str(self.calls)))
        self.program.chmod(0o755)

    def tearDown(self):
        self.folder.cleanup()

    def log(self, name, begin_ns=1_403_636_580_000_000_000, seconds=100, truth=True):
        """A log cut down to its stamps."""
        folder = self.root / "logs" / name
        (folder / "mav0/cam0").mkdir(parents=True)
        stamps = [begin_ns, begin_ns + int(seconds * 1e9)]
        (folder / "mav0/cam0/data.csv").write_text("#t\n" + "".join(f"{t},{t}.png\n" for t in stamps))
        if truth:
            (folder / "mav0/state_groundtruth_estimate0").mkdir()
            (folder / "mav0/state_groundtruth_estimate0/data.csv").write_text("#t\n")
        return folder

    def run_it(self, *arguments, code=0):
        command = [sys.executable, ROOT / "scripts/evaluate", *arguments, "--facet", self.program, "--out",
                   self.root / "out"]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def page(self):
        return (self.root / "out/report.html").read_text(encoding="utf-8")

    def test_simulated_flights_are_rendered_once_and_flown_in_every_form(self):
        done = self.run_it("--scenes", "room")
        self.assertIn("] the report", done.stderr)
        self.assertRegex(done.stderr, r"\[4/6, about .* left\] ")
        self.assertIn("| sim_room | 6.4 m | `s` | 20.0 mm | 20.0 mm | 12.3 mm |", done.stdout)
        self.assertRegex(done.stdout, r"\| sim_room \| 6.4 m \| `spr` \| 20.0 mm \|.* \| 4.0 ms \|")
        self.assertIn("commit 0123456789ab", (self.root / "out/table.md").read_text())
        self.assertIn("commit 0123456789ab", self.page())
        self.run_it("--scenes", "room")
        calls = self.calls.read_text().splitlines()
        self.assertEqual(calls.count("sim --scene"), 1)
        self.assertEqual(sum(call.startswith("replay") for call in calls), 4)
        self.run_it("--scenes", "room", "--duration", "5")
        self.assertEqual(self.calls.read_text().splitlines().count("sim --scene"), 2)

    def test_the_papers_experiment_has_its_modes_as_published_and_exact_calibrations(self):
        done = self.run_it("--scenes", "room", "--paper")
        for mode in ("s", "sp", "spr"):
            self.assertIn(f"| sim_room | 6.4 m | `{mode}` as published |", done.stdout)
            self.assertIn(f"{mode} as published</th>", self.page())
        self.assertIn("K = 0", (self.root / "out/table.md").read_text())
        self.assertIn("calibration_error=0 ", (self.root / "out/sim_room/.complete").read_text())

    def test_the_table_goes_into_a_document(self):
        document = self.root / "README.md"
        document.write_text("before\n<!-- scripts/evaluate -->\nold\n<!-- end -->\nafter\n")
        self.run_it(self.log("one"), "--modes", "s", "--document", document)
        text = document.read_text()
        self.assertRegex(text, r"(?s)^before\n<!-- scripts/evaluate -->\n\| sequence.*\| one \|")
        self.assertTrue(text.endswith("<!-- end -->\nafter\n"))
        self.assertNotIn("old", text)
        document.write_text("nothing")
        self.assertIn("no line", self.run_it(self.log("two"), "--document", document, code=2).stderr)
        document.write_text("<!-- scripts/evaluate -->\n<!-- end -->\n")
        self.assertIn("no line '<!-- scripts/evaluate: paper -->'",
                      self.run_it(self.log("three"), "--paper", "--document", document, code=2).stderr)

    def test_whole_sequences_of_euroc_stand_beside_what_others_have_published(self):
        for name in ("MH_01_easy", "V2_03_difficult"):
            self.log(name)
        self.run_it(self.root / "logs")
        self.assertNotIn("its true orientation is known to be inaccurate", self.page())
        self.assertIn("EuRoC, beside what others have published", self.page())
        self.assertIn("<td class=\"left\">facet, spr</td><td>0.020</td><td>0.020</td>", self.page())
        self.assertIn("Kimera-VIO [4]</td><td>0.080</td><td>0.190</td>", self.page())
        self.assertIn("SVO+GTSAM, one camera [5]</td><td>0.050</td><td>\u2013</td>", self.page())

    def test_an_inaccurate_truth_is_named(self):
        self.log("V1_01_easy")
        self.run_it(self.root / "logs", "--modes", "s")
        self.assertIn("V1_01: its true orientation is known to be inaccurate", self.page())

    def test_what_is_not_such_a_sequence_does_not(self):
        self.log("MH_01_easy", seconds=15)
        self.log("MH_02_easy", begin_ns=1_600_000_000_000_000_000)
        (self.log("V1_01_easy") / "truth").mkdir()
        self.log("MH_03_medium_rendered")
        self.run_it(self.root / "logs", "--modes", "s")
        self.assertIn("MH_03_medium_rendered", self.page())
        self.assertNotIn("what others have published", self.page())

    def test_a_part_of_such_a_sequence_does_not(self):
        self.run_it(self.log("MH_01_easy"), "--duration", "20", "--modes", "s")
        self.assertNotIn("what others have published", self.page())

    def test_logs_without_ground_truth_are_flown_and_shown(self):
        self.run_it(self.log("own", truth=False) / "mav0", "--modes", "s")
        self.assertNotIn("eval", self.calls.read_text())
        self.assertIn("no ground truth", self.page())

    def test_a_failed_run_leaves_the_others(self):
        self.log("broken")
        self.log("lost")
        self.log("good")
        done = self.run_it(self.root / "logs", "--modes", "s", code=1)
        self.assertIn("broken in mode s failed: replay: error: no such thing", done.stderr)
        self.assertIn("lost in mode s failed", done.stderr)
        self.assertIn("<h2>good</h2>", self.page())
        self.assertIn("<h2>lost</h2>", self.page())
        self.assertNotIn("<h2>broken</h2>", self.page())

    def test_the_matrix_of_faults_is_flown_and_shown_if_asked(self):
        log = self.log("own")
        self.run_it(log, "--modes", "s")
        self.assertNotIn("When sensors fail", self.page())
        self.run_it(log, "--modes", "s", "--faults", "left camera: dies")
        self.assertRegex(self.page(), r"When sensors fail.*of 2 cells as expected")
        done = self.run_it(log, "--modes", "s", "--faults", "no such cell", code=2)
        self.assertIn("no such cell", done.stderr)

    def test_wrong_usage_is_refused(self):
        (self.root / "empty").mkdir()
        self.assertIn("no log", self.run_it(self.root / "empty", code=2).stderr)
        self.assertIn("must be positive", self.run_it("--duration", "0", code=2).stderr)
        self.log("a/one")
        self.log("b/one")
        self.assertIn("two logs are named one",
                      self.run_it(self.root / "logs/a", self.root / "logs/b", code=2).stderr)


class Published(unittest.TestCase):
    def test_figures_are_whole_and_have_a_source(self):
        published = json.loads((ROOT / "scripts/page/published.json").read_text())
        for system in published["systems"]:
            figures = [figure for figure in system["rmse_m"] if figure is not None]
            self.assertEqual(len(system["rmse_m"]), len(published["sequences"]), system["name"])
            self.assertAlmostEqual(statistics.fmean(figures), system["mean_m"], delta=6e-4, msg=system["name"])
            self.assertLessEqual(1, system["source"])
            self.assertLessEqual(system["source"], len(published["sources"]))


if __name__ == "__main__":
    unittest.main()
