#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/benchmark: its files, and whole benchmarks with a program that answers at once in place of facet."""
import contextlib
import importlib.machinery
import importlib.util
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True
from bench import figures  # noqa: E402
from bench.page import logs_of, read_list  # noqa: E402

# Appends what it is asked to CALLS. The error of a flight is GROWTH mm times the length of its scene's name, in mode
# spr half of it; with a file WAIT beside it, the third replay hangs; with NO_SPR, mode spr fails.
FAKE = """#!{python} -IS
import json, sys, time
from pathlib import Path
here = Path(__file__).parent
arguments = sys.argv[1:]
value = lambda name: arguments[arguments.index(name) + 1]
with (here / "calls").open("a") as stream:
    stream.write(" ".join(arguments) + "\\n")
said = (here / "calls").read_text().splitlines()
if arguments == ["--version"]:
    print("facet        0.1.0\\ncommit       0123456789ab")
elif arguments[0] == "sim":
    if "--broken" in arguments:
        sys.exit("sim: error: broken")
    root = Path(value("--out"))
    (root / "mav0/cam0").mkdir(parents=True)
    (root / "mav0/cam0/data.csv").write_text("#\\n")
    (root / "truth").mkdir()
    (root / "truth/scene.ply").write_text(value("--scene"))
elif arguments[0] == "calibrate":
    Path(value("--out")).mkdir()
    off = 0.25 if "--inject" in arguments else 0.0
    known = [{{"name": f"cam{{k}}.c{{axis}}", "given": 9.0, "refined": 9.0 - off}} for k in "01" for axis in "xy"]
    (Path(value("--out")) / "calibration.json").write_text(json.dumps({{"parameters": known}}))
elif arguments[0] == "replay":
    while (here / "wait").exists() and sum(line.startswith("replay") for line in said) >= 3:
        time.sleep(0.1)
    out = Path(value("--out"))
    if value("--mode") == "spr" and (here / "no_spr").exists():
        sys.exit("replay: error: spr is out of order")
    (out / "mode").write_text(value("--mode"))
    (out / "trajectory.tum").write_text("0 0 0 0 0 0 0 1\\n1 2 0 0 0 0 0 1\\n")
    (out / "summary.json").write_text(json.dumps({{"estimates": 9, "final": {{"state": "TRACKING"}}}}))
elif arguments[0] == "eval":
    error = 0.001 * len((Path(value("--groundtruth")) / "truth/scene.ply").read_text()) * {growth}
    if (Path(value("--estimate")) / "mode").read_text() == "spr":
        error *= 0.5
    found = {{"path_m": 9.0, "sim3_scale": 1.0, "rpe": [],
              "ate_se3": {{"translation_m": {{"rmse": error}}, "rotation_deg": {{"rmse": 0.1}}}}}}
    if "--scene" in arguments:
        found["planes"] = {{"strict": {{"found": 3, "right": 2, "wanted": 4, "area_recall": 0.5}}}}
    Path(value("--json")).write_text(json.dumps(found))
"""
STUDY = """# a study
title: two flights
flights: {one: {scene: room}, fourteen: {scene: building, seed: 3}}
modes: [s, spr]
conditions: [1 flight, 0]
seeds: [1, 2]
tables:
  errors:
    rows: [sequence, condition, mode, case]
    columns: [[runs, count], [ATE mm, interval ate_mm, 2], [end, each end]]
  modes:
    rows: [mode]
    only: {mode: spr, condition: [1 flight, 0]}
    columns: [[pairs, count ate_mm over mode=s], [over s, interval ate_mm over mode=s, 3]]
"""


def load():
    loader = importlib.machinery.SourceFileLoader("benchmark", str(SCRIPTS / "benchmark"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("benchmark", loader))
    loader.exec_module(module)
    return module


script = load()


class Benchmark(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        self.program = self.root / "facet"
        self.write_program()
        self.study = self.root / "study.yaml"
        self.study.write_text(STUDY)

    def write_program(self, growth=1.0):
        self.program.write_text(FAKE.format(python=sys.executable, growth=growth))
        self.program.chmod(0o755)

    def command(self, *arguments, name=None):
        return [str(SCRIPTS / "benchmark"), str(name or self.study), "--facet", str(self.program), "--out",
                str(self.root / "out"), "--flights-folder", str(self.root / "flights"), "--jobs", "1",
                *map(str, arguments)]

    def main(self, *arguments, name=None, edited=""):
        """Exit code, output and what is said on standard error; documents are those of the test's folder."""
        out, said = io.StringIO(), io.StringIO()
        with unittest.mock.patch.object(sys, "argv", self.command(*arguments, name=name)), \
                unittest.mock.patch.object(script, "ROOT", self.root), \
                unittest.mock.patch.object(script, "edited", lambda _: edited), \
                contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
            try:
                code = script.main()
            except SystemExit as end:
                code = end.code
        return code, out.getvalue(), said.getvalue()

    def run_it(self, *arguments, code=0, name=None):
        """What is printed, behind it what is said on standard error."""
        found, out, said = self.main(*arguments, name=name)
        self.assertEqual(found, code, said + out)
        return out + said

    def calls(self, what):
        return [line for line in (self.root / "calls").read_text().splitlines() if line.startswith(what)]


PERFECT = STUDY.replace("conditions: [1 flight, 0]\n", "conditions: [0]\n")  # fewer flights


class Flights(Benchmark):
    def test_all_flights_are_flown_and_compared(self):
        self.study.write_text(STUDY + "parameters: {window.keyframes: [8, 10]}\n")
        done = self.run_it()
        self.assertEqual(len(self.calls("sim")), 2)
        self.assertEqual(len(self.calls("replay")), 2 * 2 * 2 * (2 + 1))
        self.assertIn("--mode spr --inject calibration=1,2 --inject vibration=flight,2 --set window.keyframes=10",
                      " ".join(self.calls("replay")))
        self.assertRegex(done,
                         r"fourteen +1, flight +spr +window.keyframes=10 +2 +4.00 \[4.00, 4.00\] +TRACKING")
        self.assertRegex(done, r"spr +12 +0.500 \[0.500, 0.500\]")
        page = (self.root / "out/table.md").read_text()
        self.assertRegex(page, r"^Two flights; K: calibration perturbed by K sigma; .*\n\n"
                               r"\| sequence \| K \| mode \| case \| runs ")
        self.assertIn("commit 0123456789ab", page)
        self.assertEqual(len(json.loads((self.root / "out/results.json").read_text())), 24)

    def test_a_killed_benchmark_goes_on_where_it_was(self):
        (self.root / "wait").touch()
        with subprocess.Popen([sys.executable, *self.command("--allow-dirty")], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, start_new_session=True) as process:
            deadline = time.monotonic() + 60
            while len(list((self.root / "out").rglob("run.json"))) < 2 and time.monotonic() < deadline:
                time.sleep(0.05)
            self.assertIn("another benchmark is at work", self.run_it(code=2))
            os.killpg(process.pid, signal.SIGKILL)
        (self.root / "wait").unlink()
        flown = len(self.calls("replay"))
        self.run_it()
        self.assertEqual(len(self.calls("replay")) - flown, 12 - 2)
        flown = len(self.calls("replay"))
        self.run_it()
        self.assertEqual(len(self.calls("replay")), flown, "all was done")
        self.run_it("--fresh", "--flights", "one", "--conditions", "0")
        self.assertEqual(len(self.calls("replay")), flown + 2)
        self.write_program(growth=2.5)
        self.run_it()
        self.assertEqual(len(self.calls("replay")), flown + 2 + 12, "another program")

    def test_failures_are_rows_and_are_tried_again(self):
        (self.root / "no_spr").touch()
        done = self.run_it(code=1)
        self.assertIn("one, K = 0, spr, seed 1: replay exit 1: replay: error: spr is out of order", done)
        (self.root / "no_spr").unlink()
        flown = len(self.calls("replay"))
        self.run_it()
        self.assertEqual(len(self.calls("replay")), flown + 6)
        self.study.write_text(STUDY.replace("seed: 3", "broken: true"))
        self.assertIn("sim exit 1: sim: error: broken", self.run_it(code=1))

    def test_errors_that_have_grown_are_a_regression(self):
        self.study.write_text(STUDY.replace("conditions: [1 flight, 0]\n", "conditions: [1 flight]\n"))
        baseline = self.root / "baseline.json"
        self.run_it("--write-baseline", baseline)
        errors = json.loads(baseline.read_text())["ate_m"]
        self.assertEqual(len(errors), 8)
        self.assertIn("one/s/default/k1_flight_seed2", errors)
        self.run_it("--baseline", baseline)
        self.write_program(growth=1.1)
        self.assertIn("regression: mode spr, default: error 1.100 times the baseline's",
                      self.run_it("--baseline", baseline, code=1))

    def test_a_limit_that_is_exceeded_fails(self):
        self.study.write_text(PERFECT.replace("ATE mm, interval ate_mm, 2]", "ATE mm, ate_mm, 2, {most: 4}]"))
        done = self.run_it(code=1)
        self.assertIn("limit: fourteen, 0, s, default: ATE mm 8.00, target at most 4", done)
        self.assertNotIn("limit: one", done)

    def test_wrong_files_are_refused_in_one_line(self):
        for old, new, complaint in (
                ("seed: 3", "seed: x", "a seed must be a whole number"),
                ("{scene: room}", "nowhere", "nowhere: no log"),
                ("one: {scene", "one/two: {scene", "has no slash"),
                ("modes: [s, spr]", "modes: {x: {mode: t}}", "mode must be one of s, sp, spr"),
                ("modes: [s, spr]", "modes: {s: {sat: 1}}", "modes.s.sat: unknown"),
                ("1 flight, 0]\nseeds", "-1]\nseeds", "condition '-1'"),
                ("1 flight, 0]\nseeds", "1 rain]\nseeds", "condition '1 rain'"),
                ("seeds: [1, 2]", "parameters: {x: [../..]}", "cannot name a folder"),
                ("title:", "titel:", "titel: unknown"),
                ("interval ate_mm, 2", "interval ate_mn, 2", "unknown figure 'ate_mn'"),
                ("ate_mm over mode=s, 3", "ate_mm over mood=s, 3", "AXIS=VALUE"),
                ("seeds: [1, 2]", "duration: 0", "duration: must be a positive"),
                ("tables:", "tables: [", "while parsing"), (STUDY, "- 1", "must be a map")):
            self.study.write_text(STUDY.replace(old, new))
            self.assertIn(complaint, self.run_it(code=2))
        self.assertFalse((self.root / "out").exists())

    def test_wrong_usage_is_refused(self):
        for given, complaint in ((["--cases", "x"], "case 'x': unknown"), (["--modes", "x"], "mode 'x': unknown"),
                                 (["--set", "x"], "must be KEY=VALUE"), ([self.root], "no log"),
                                 (["--facet", "/nowhere"], "no such program"), (["--duration", "0"], "positive"),
                                 (["--baseline", "/nowhere"], "no such file")):
            self.assertIn(complaint, self.run_it(*given, code=2))
        self.assertIn("no such benchmark", self.run_it(code=2, name="fog"))
        self.assertIn("--repeat", self.run_it("--help", name="speed"))

    def test_held_out_buildings_have_a_table_and_errors_of_their_own(self):
        done = self.run_it("--flights", "held-out", "--cases", "nominal", "without planes", "--seeds", "2", name="hard")
        self.assertRegex(done, r"nominal +6 x 1 +8.00 +0.500 \[0.500, 0.500\] +0.50 +0.50 ")
        self.assertRegex(done, r"without planes +6 x 1 +4.00 +0.500")
        self.assertEqual(len(self.calls("sim")), 12)
        told = " ".join(self.calls("replay"))
        for seed in (10002, 10502):
            self.assertIn(f"--inject calibration=1,{seed} ", told)
        self.assertIn("--start 0.05", told)


class Page(Benchmark):
    def test_tables_go_between_their_marks(self):
        self.study.write_text(PERFECT + "document: page.md\n")
        page = self.root / "page.md"
        page.write_text("a\n<!-- scripts/benchmark study: modes -->\nold\n<!-- end -->\nb\n")
        said = self.run_it("--publish")
        self.assertIn("no line <!-- scripts/benchmark study: errors -->", said)
        self.assertRegex(page.read_text(), r"(?s)^a\n<!-- scripts/benchmark study: modes -->\nTwo flights\.\n\n"
                         r"\| mode \|.*`scripts/benchmark \S*study.yaml`, commit 0123456789ab\.\n<!-- end -->\nb\n$")
        page.write_text("nothing\n")
        self.assertEqual(self.main("--publish")[0], 1)

    def make_page(self, lines, *options):
        """Exit code and what is said of --page, with a list of these lines; page.md is the document of their tables."""
        (self.root / "page.txt").write_text("# a list\n" + "".join(f"{line}\n" for line in lines))
        given = ["benchmark", "--page", str(self.root / "logs"), *self.command("--allow-dirty", *options)[2:]]
        said = io.StringIO()
        with unittest.mock.patch.object(sys, "argv", given), unittest.mock.patch.object(script, "ROOT", self.root), \
                unittest.mock.patch.object(script, "PAGE_LIST", self.root / "page.txt"), \
                unittest.mock.patch.object(script, "edited", lambda _: ""), contextlib.redirect_stderr(said):
            try:
                code = script.main()
            except SystemExit as end:
                code = end.code
        return code, said.getvalue()

    def test_a_whole_page_is_made_by_one_command(self):
        (self.root / "logs").mkdir()
        page = self.root / "BENCHMARKS.md"
        begin = "<!-- scripts/benchmark --page -->\n<!-- end -->\n"
        page.write_text(begin + "".join(f"<!-- scripts/benchmark study: {name} -->\n<!-- end -->\n"
                                        for name in ("errors", "modes")))
        self.study.write_text(PERFECT + f"document: {page}\n")
        code, said = self.make_page([self.study])
        self.assertEqual(code, 0, said)
        self.assertIn("Made by `scripts/benchmark --page FOLDER` at commit 0123456789ab.\n<!-- end -->",
                      page.read_text())
        self.assertIn(f"`scripts/benchmark {self.study}`, commit 0123456789ab", page.read_text())
        flown = len(self.calls("replay"))
        (self.root / "no_spr").touch()
        code, said = self.make_page([f"{self.study} room_20s", f"{self.study} --cases fog", self.study])
        self.assertEqual(len(self.calls("replay")), flown, "all was done")
        self.assertEqual(code, 1)
        for sentence in ("room_20s`: no room_20s in FOLDER", "--cases fog`: exit code 2"):
            self.assertIn(sentence, said)
            self.assertIn(sentence, page.read_text())
        self.assertEqual(self.make_page([self.study], "--fresh")[0], 1, "spr is out of order")
        self.assertIn("--page goes with", self.make_page([self.study], "--seeds", "3")[1])

    def test_what_measures_by_itself_is_measured_once(self):
        (self.root / "logs").mkdir()
        page = self.root / "BENCHMARKS.md"
        page.write_text("`scripts/benchmark recording`, commit 0123456789ab.\n")
        self.assertEqual(self.make_page(["recording"]), (0, unittest.mock.ANY))
        self.assertEqual(self.make_page(["recording --turns 2"])[0], 1, "recording_load is missing")

    def test_edited_sources_are_refused_or_named(self):
        self.study.write_text(PERFECT)
        edited = "edited files, the first of 1: x.cpp"
        code, _, said = self.main(edited=edited)
        self.assertEqual(code, 2)
        self.assertIn("x.cpp: commit that first", said)
        self.assertEqual(self.main("--allow-dirty", edited=edited)[0], 0)
        self.assertIn(f", for trial only: {edited}.", (self.root / "out/table.md").read_text())


class Files(Benchmark):
    def test_every_benchmark_lists_its_flights(self):
        names = sorted(path.stem for path in (SCRIPTS / "benchmarks").glob("*.yaml"))
        self.assertGreater(len(names), 15)
        for name in names:
            given = [name, "--facet", str(self.program), "--list"]
            _, _, bench, _ = script.parse_arguments(script.make_parser(), given)
            self.assertTrue(bench.plan.flights, name)
            if "conditions" in bench.plan.content and len(bench.plan.conditions) > 1:
                # mismatch draws its calibrations, of K = 1, by the case.
                first = "0, flight" if name == "mismatch" else "1, flight"
                self.assertEqual(str(bench.plan.conditions[0]), first, f"{name}: realistic conditions come first")
            documents = [entry.get("document") for entry in
                         (bench.plan.content, *(bench.plan.content.get("tables") or {}).values())]
            for document in filter(None, documents):
                self.assertTrue((SCRIPTS.parent / document).is_file(), document)


    def test_the_list_of_the_page_names_what_there_is(self):
        page = (SCRIPTS.parent / "BENCHMARKS.md").read_text()
        for words in read_list(script.PAGE_LIST):
            given = [words[0], *words[1 + len(logs_of(words)):], "--facet", str(self.program), "--list"]
            script.parse_arguments(script.make_parser(), given)
            self.assertTrue(f"<!-- scripts/benchmark {words[0]}: " in page, words[0])


# What scripts/build --all puts beside the program: memory grows in a log that is played twice, and samples are missing.
LOAD = """#!{python}
import json, sys
log, form, folder, turns = sys.argv[1:]
print(json.dumps({{"processor_s": {{"facet-estimator": 3.0, "facet-record": 1.0}}, "duration_s": 10.0, "pairs": 200,
                  "written_mb": 80.0, "resident_mb": {{"half": 50, "end": 50 + 6 * (int(turns) - 1)}}, "frames": 200,
                  "drops": {{"late_frames": 1, "samples_not_recorded": 2}}, "refusals": ["priorities"]}}))
sys.exit(1)
"""


class PlugIns(Benchmark):
    def test_a_calibration_of_one_log_is_judged_on_the_others(self):
        done = self.run_it("--seeds", "1", "2", name="calibrate")
        self.assertRegex(done, r"sim_room +sim_hall +1 +2 +4.00 +4.00 +1.00 +0.250")
        self.assertEqual([line.split("--inject ")[1] for line in self.calls("calibrate") if "--inject" in line],
                         ["calibration=1,1", "calibration=1,2"] * 2)
        self.assertEqual(sum("--calibration" in line for line in self.calls("replay")), 4)

    def test_recording_is_measured_by_a_program_of_its_own(self):
        self.assertIn("recording_load is missing", self.run_it(name="recording", code=2))
        load_program = self.root / "recording_load"
        load_program.write_text(LOAD.format(python=sys.executable))
        load_program.chmod(0o755)
        done = self.run_it("--turns", "2", "--forms", "mcap", "--core", "-1", name="recording", code=1)
        self.assertRegex(done, r"closed +mcap +30.0 % +10.0 % +5.0 +0.40 +50, 56 +1 of 200 +2")
        for said in ("the system refused: priorities", "memory has grown by more than 5 MB", "missing in the log"):
            self.assertIn(said, done)


    def test_single_parts_are_timed_by_programs_of_their_own(self):
        self.assertIn("frontend_bench is missing", self.run_it(name="parts", code=2))
        runs = [{"run_type": "iteration", "run_name": "sweep/8", "cpu_time": time, "time_unit": "ns"}
                for time in (2500.0, 1250.0)]
        for name in ("frontend_bench", "window_bench", "mesh_bench"):
            said = json.dumps({"benchmarks": runs})
            (self.root / name).write_text(f"#!{sys.executable}\nprint({said!r})\n")
            (self.root / name).chmod(0o755)
        self.assertRegex(self.run_it("--core", "-1", name="parts"), r"mesh_bench +sweep +8 \(1.25\)\n")


class Figures(unittest.TestCase):
    def test_errors_of_planes_are_over_their_sigmas(self):
        planes = [{"sigmas": [3.0, 0.0, 1.0]}, {"sigmas": [4.0, 0.0, 1.0]}, {"verdict": "wrong"}]
        run = unittest.mock.Mock(has_result=True, eval={"planes": {"strict": {"planes": planes}}})
        found = {name: figures.figure_of(run, figures.FIGURES[name])
                 for name in ("plane_position_rms", "plane_tilt_rms", "planes_within_percent")}
        self.assertEqual(found, {"plane_position_rms": 12.5 ** 0.5, "plane_tilt_rms": 0.5 ** 0.5,
                                 "planes_within_percent": 50.0})

    def test_what_a_flight_has_not_is_none(self):
        run = unittest.mock.Mock(has_result=True, eval={"path_m": 1.0}, summary={}, health=[], errors=[])
        run.table.return_value = []
        run.folder = Path("/nowhere")
        known = {name for name, figure in figures.FIGURES.items() if figures.figure_of(run, figure) is not None}
        self.assertEqual(known, {"path_m", "init_s", "lost_before", "states_s"})
        self.assertIsNone(figures.figure_of(None, figures.FIGURES["path_m"]))


if __name__ == "__main__":
    unittest.main()
