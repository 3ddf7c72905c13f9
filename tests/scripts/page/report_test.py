#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/report: what is in the file for results with and without ground truth, and how it refuses others."""
import html.parser
import json
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
from pathlib import Path

from small_run import FACES, FRAMES, write_run

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
from page import chart, document, figures, scene, stills, tables  # noqa: E402
from page.run_files import AS_PUBLISHED, load_sequences  # noqa: E402


class Elements(html.parser.HTMLParser):
    """Tags, addresses that the page refers to, and the text outside of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.said, self.inside = [], [], "", ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.inside = tag
        self.addresses += [value for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data):
        if self.inside not in ("script", "style"):
            self.said += data + " "


class Report(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def make(self, *folders, code=0, options=("--no-pictures", "--no-view")):
        out = self.root / "report.html"
        command = [sys.executable, ROOT / "scripts/report", *folders, "--out", out, *options]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(done.returncode, code, done.stderr)
        return out.read_text(encoding="utf-8") if code == 0 else done.stderr

    def test_with_ground_truth_modes_are_compared_in_the_papers_table(self):
        one = write_run(self.root / "a", "s", errors=[0.02] * FRAMES)
        other = write_run(self.root / "b", "spr", errors=[0.01] * (FRAMES - 1) + [0.05])
        (one / "program.txt").write_text("facet        0.1.0\ncommit       0123456789ab\n")
        page = Elements(self.make(one, other))
        self.assertIn("commit 0123456789ab", page.said)
        self.assertIn("commit not recorded", page.said)
        self.assertRegex(page.said, r"ring\s+6\.4\s+2\.00\s+2\.00\s+1\.00\s+1\.07\s")
        for title in ("Trajectory from above, s", "Position error over time", "Relative error by length: yaw",
                      "Velocity error within its 3-sigma bound", "Mesh within a tolerance", "Planes, spr", "Health",
                      "Gyroscope bias", "Time offset of the cameras", "Focal length, left fx",
                      "Time by stage, keyframes"):
            self.assertIn(title, page.said)

    def test_without_ground_truth_the_rest_is_there(self):
        page = Elements(self.make(write_run(self.root / "a")))
        self.assertIn("no ground truth", page.said)
        self.assertIn("Trajectory from the side, s", page.said)
        self.assertIn("Time of each frame", page.said)
        for title in ("Position error", "Relative error", "Absolute translation error", "3-sigma bound; pos"):
            self.assertNotIn(title, page.said)

    def test_a_truth_without_velocities_has_no_chart_of_them(self):
        folder = write_run(self.root / "a", errors=[0.01] * FRAMES)
        lines = (folder / "errors.csv").read_text().splitlines()
        for i, line in enumerate(lines[1:], start=1):
            fields = line.split(",")
            lines[i] = ",".join(fields[:7] + ["nan"] * 3 + fields[10:])
        (folder / "errors.csv").write_text("\n".join(lines))
        page = Elements(self.make(folder))
        self.assertIn("Position error within its 3-sigma bound", page.said)
        self.assertNotIn("Velocity error within its 3-sigma bound", page.said)

    def test_a_folder_with_nothing_but_a_trajectory_is_reported(self):
        folder = write_run(self.root / "a")
        for file in folder.iterdir():
            if file.name not in ("summary.json", "trajectory.csv"):
                file.unlink()
        page = Elements(self.make(folder))
        self.assertIn("Trajectory from above, s", page.said)
        self.assertNotIn("Time offset", page.said)
        self.assertNotIn("Focal length", page.said)

    def test_it_needs_no_network(self):
        page = Elements(self.make(write_run(self.root / "a", errors=[0.01] * FRAMES)))
        self.assertGreater(page.tags.count("svg"), 10)
        for address in page.addresses:
            self.assertRegex(address, r"^(#|data:)")

    def test_without_three_js_one_sentence_says_so(self):
        with unittest.mock.patch.object(document, "DEBIAN_THREE", self.root / "none"):
            script, why = document.bundled_view(self.root / "none")
        self.assertIsNone(script)
        self.assertIn("three.js and esbuild are not installed", why)
        text = self.make(write_run(self.root / "a"), options=("--no-pictures", "--no-view"))
        self.assertNotIn("facet-view'", text)

    def test_debians_three_js_is_laid_out_as_npms(self):
        for part in ("debian/build/three.module.js", "debian/examples/jsm/lines/Line2.js"):
            (self.root / part).parent.mkdir(parents=True)
            (self.root / part).write_text("")
        esbuild = self.root / "esbuild"
        esbuild.write_text('#!/bin/sh\nfor last; do :; done\n'
                           'ls "$NODE_PATH"/three/build "$NODE_PATH"/three/addons/lines > "${last#--outfile=}"\n')
        esbuild.chmod(0o755)
        with unittest.mock.patch.multiple(document, DEBIAN_THREE=self.root / "debian", DEBIAN_ESBUILD=esbuild):
            script, why = document.bundled_view(self.root / "none")
        self.assertEqual(why, "")
        self.assertIn("three.module.js", script)
        self.assertIn("Line2.js", script)

    def test_still_pictures_are_there_if_they_can_be_drawn(self):
        text = self.make(write_run(self.root / "a", errors=[0.01] * FRAMES),
                         options=("--no-view", "--stills", self.root / "stills"))
        if stills.mesh_picture is None:
            self.assertIn("numpy and PIL are missing", text)
        else:
            self.assertIn("Mesh by error, s", text)
            written = sorted(file.name for file in (self.root / "stills").iterdir())
            self.assertEqual(written, ["ring_mesh_by_error_s.png", "ring_mesh_by_plane_s.png"])
            self.assertEqual((self.root / "stills" / written[0]).read_bytes()[:4], b"\x89PNG")

    def test_names_cannot_break_the_page(self):
        text = self.make(write_run(self.root / "a", dataset='/logs/<script>alert("x")<b'))
        self.assertNotIn("<script>alert", text)
        self.assertIn("&lt;script&gt;alert", text)

    def test_what_cannot_be_used_is_refused_with_one_line(self):
        folder = write_run(self.root / "a")
        (self.root / "empty").mkdir()
        broken = [("health.csv", b"stamp_ns,state\n12x,INIT\n"), ("summary.json", b"{")]
        if stills.mesh_picture is not None:  # else nothing may read it
            broken.append(("mesh.ply", b"ply\nen"))
        for name, content in broken:
            whole = (folder / name).read_bytes()
            (folder / name).write_bytes(content)
            options = ("--no-view",) if name == "mesh.ply" else ("--no-pictures", "--no-view")
            lines = self.make(folder, code=2, options=options).splitlines()
            self.assertEqual([line for line in lines if "error" in line], lines[-1:])  # progress comes before
            self.assertIn(name, lines[-1])
            (folder / name).write_bytes(whole)
        self.assertIn("no summary.json", self.make(self.root / "empty", code=2))

    def test_the_matrix_of_faults_is_shown_with_what_is_wrong_in_it(self):
        folder = self.root / "faults"
        folder.mkdir()
        row = {"sensor": "left camera", "fault": "dies", "log": "room", "states": ["DEGRADED", "TRACKING"],
               "reasons": ["no_images"], "recovery_s": None, "ate_mm": 2.75, "estimated": 0.98, "end": "DEGRADED",
               "silent_s": 0.0, "kept": True, "verdict": "as expected", "span": "to the end"}
        rows = [row, {**row, "sensor": "IMU", "fault": "wrong <axes>", "silent_s": 1.25},
                {**row, "sensor": "IMU", "fault": "freezes", "kept": False, "verdict": "ATE 90 mm > 50 mm"}]
        (folder / "results.json").write_text(json.dumps(rows))
        (folder / "table.md").write_text("| a |\n\n`scripts/benchmark faults`, commit 0123456789ab.\n")
        run = write_run(self.root / "a")
        options = ("--no-pictures", "--no-view", "--faults", folder)
        text = self.make(run, options=options)
        page = Elements(text)
        self.assertIn("2 of 3 cells as expected, undetected errors of 1.2 s in all", page.said)
        self.assertIn("Made by scripts/benchmark faults, commit 0123456789ab.", page.said)
        self.assertIn("wrong &lt;axes&gt; \u26a0 1.2 s", text)
        self.assertIn("ATE 90 mm &gt; 50 mm", text)
        self.assertRegex(text, r"class='chip broken'[^>]*>freezes")
        self.assertIn("#faults", page.addresses)
        del rows[1]["ate_mm"]
        for content in ("[]", "{", json.dumps(rows)):
            (folder / "results.json").write_text(content)
            self.assertIn("results.json", self.make(run, code=2, options=options))

    def test_what_was_set_differently_is_part_of_a_runs_name(self):
        runs = [write_run(self.root / str(number), "spr", parameters=changed) for number, changed in enumerate((
            {"imu_noise.gyro_noise_density": "0.001"}, AS_PUBLISHED, {"frontend.max_features": "50"}))]
        self.assertEqual([run.label for run in load_sequences(runs)[0].runs],
                         ["spr", "spr as published", "spr, frontend.max_features=50"])

    def test_times_of_optimizations_stand_by_the_planes_in_them(self):
        run = load_sequences([write_run(self.root / "a", "spr")])[0].runs[0]
        times = tables.optimization_times(run)
        self.assertEqual([planes for planes, _ in times], [0] * 17 + [1] * 15)
        for planes, ms in times:
            self.assertAlmostEqual(ms, 4 * (0.4 if planes else 0.3))
        text = self.make(self.root / "a", options=("--no-pictures", "--no-view"))
        self.assertIn("<td>17</td><td>1.2</td><td>15</td><td>1.6</td><td>0</td><td>\u2013</td>", text)

    def test_runs_of_one_mode_are_told_apart_by_their_folders(self):
        sequences = load_sequences([write_run(self.root / "a"), write_run(self.root / "b"),
                                    write_run(self.root / "c", dataset="/logs/hall")])
        self.assertEqual([(s.name, [r.label for r in s.runs]) for s in sequences],
                         [("ring", ["s (a)", "s (b)"]), ("hall", ["s"])])


class Scene(unittest.TestCase):
    def test_faces_appear_when_they_left_the_horizon(self):
        with tempfile.TemporaryDirectory() as folder:
            sequences = load_sequences([write_run(Path(folder) / "a", errors=[0.01] * FRAMES)])
            run = scene.pack(sequences)["sequences"][0]["runs"][0]
        unpack = scene.array.array("H")
        unpack.frombytes(scene.base64.b64decode(run["mesh"]["reveal"]))
        keyframes = len(run["keyframes"]["times"])
        self.assertEqual(list(unpack), list(range(keyframes)) + [keyframes - 1] * (FACES - keyframes))
        self.assertEqual(run["planes"], [{"id": 3, "first": 5, "held": 17, "kind": "horizontal", "area": 1.5,
                                          "last": keyframes - 1}])
        self.assertTrue(json.dumps(run))

    def test_the_true_path_is_brought_into_the_world_of_the_estimate(self):
        half = 2 ** -0.5  # 90 degrees about z
        self.assertEqual([round(x, 9) for x in scene.rotated((0, 0, half, half), (1, 0, 2))], [0, 1, 2])


class Charts(unittest.TestCase):
    def test_ticks_are_round_and_within_the_range(self):
        self.assertEqual(chart.nice_ticks(0.0, 1.0, 5), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0])
        self.assertEqual(chart.nice_ticks(-3.1, 3.1, 3), [-2.5, 0.0, 2.5])

    def test_peaks_survive_thinning(self):
        values = [0.0] * 20000
        values[12345] = 7.0
        points = chart.thinned(range(20000), values)
        self.assertLess(len(points), 1000)
        self.assertIn((12345, 7.0), points)

    def test_nothing_leaves_its_axes(self):
        axes = chart.Chart((0, 1), (0, 1))
        axes.line([0, 1], [-1e9, 1e9], "run0")
        places = [float(y) for y in re.findall(r",(-?[\d.]+)", re.search(r'points="(.*?)"', axes.parts[-1])[1])]
        self.assertTrue(all(0 <= y <= chart.HEIGHT for y in places), places)

    def test_quantiles(self):
        self.assertEqual([figures.quantile([1.0, 2.0, 3.0, 4.0, 5.0], q) for q in (0.0, 0.25, 0.5, 0.9)],
                         [1.0, 2.0, 3.0, 4.6])


if __name__ == "__main__":
    unittest.main()
