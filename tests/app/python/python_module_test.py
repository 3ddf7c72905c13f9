#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Flies a short simulated log by the Python module, and compares with the program; then what the module refuses.

Usage: python_module_test.py PROGRAM FOLDER_OF_THE_PACKAGE EXAMPLE
"""
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

PROGRAM, PACKAGE, EXAMPLE = sys.argv[1:4]
sys.path.insert(0, PACKAGE)
try:
    import numpy
except ImportError:
    print("no numpy: skipped")
    sys.exit(77)
import facet  # noqa: E402  after numpy, without which it cannot be

SECONDS = 6.0


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)


class FlightTest(unittest.TestCase):
    """One flight for all."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)
        cls.log = cls.path / "log"
        frames = facet.simulate(str(cls.log), seed=3, duration_s=SECONDS, samples=1)
        assert frames == int(SECONDS * 20) + 1, frames
        cls.runs = {mode: facet.replay(cls.log, mode=mode) for mode in ("s", "spr")}

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_trajectory_is_that_of_the_program(self):
        for mode, by_module in self.runs.items():
            out = self.path / f"out_{mode}"
            done = run("replay", self.log, "--mode", mode, "--out", out, "--quiet")
            self.assertEqual(done.returncode, 0, done.stderr)
            mine = self.path / f"{mode}.tum"
            by_module.trajectory.save(mine)
            self.assertEqual(mine.read_bytes(), (out / "trajectory.tum").read_bytes(), mode)
            self.assertGreater(len(by_module.trajectory.stamps_ns), 50)
            covariance = (out / "covariance.csv").read_text().splitlines()[-1].split(",")
            usable = [e for e in by_module.estimates if e.is_usable]
            upper = usable[-1].covariance[numpy.triu_indices(9)]
            self.assertEqual([f"{value:.6e}" for value in upper], covariance[1:])

    def test_evaluation_is_that_of_the_program(self):
        tum = self.path / "evaluated.tum"
        self.runs["s"].trajectory.save(tum)
        done = run("eval", "--groundtruth", self.log, "--estimate", tum, "--json", self.path / "eval.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        import json

        told = json.loads((self.path / "eval.json").read_text())
        errors = facet.evaluate(self.log, tum)
        text = json.dumps(told)
        self.assertIn(f"{errors.ate.rmse:.6f}"[:6], text)
        self.assertLess(errors.ate.rmse, 0.1)
        self.assertLess(abs(errors.ate.rmse - facet.evaluate(self.log, self.runs["s"].trajectory).ate.rmse), 1e-8)
        self.assertEqual(errors.relative[0].length, 1.0)
        itself = facet.evaluate(facet.read_truth(self.log), facet.read_truth(self.log))
        self.assertLess(itself.ate.max, 1e-9)

    def test_estimate(self):
        estimate = self.runs["spr"].estimates[-1]
        self.assertEqual(estimate.health.state, "TRACKING")
        self.assertIsInstance(estimate.health.reasons, list)
        self.assertEqual(estimate.status, "ok")
        self.assertEqual(estimate.pose.shape, (4, 4))
        numpy.testing.assert_array_equal(estimate.pose[:3, 3], estimate.position)
        self.assertAlmostEqual(numpy.linalg.norm(estimate.quaternion), 1.0, places=12)
        self.assertEqual(estimate.covariance.shape, (9, 9))
        self.assertTrue((numpy.linalg.eigvalsh(estimate.covariance) > 0).all())
        for vector in (estimate.velocity, estimate.gyro_bias, estimate.accel_bias):
            self.assertEqual(vector.shape, (3,))
        self.assertGreater(estimate.time_ms, 0.0)

    def test_mesh_and_planes(self):
        flight = self.runs["spr"].flight
        mesh = flight.mesh()
        self.assertEqual((mesh.vertices.dtype, mesh.faces.dtype), (numpy.float64, numpy.int32))
        self.assertGreater(len(mesh.faces), 20)
        self.assertEqual((mesh.faces.min(), mesh.faces.max()), (0, len(mesh.vertices) - 1))
        # Normals are those of the corners.
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        normals = numpy.cross(b - a, c - a)
        normals /= numpy.linalg.norm(normals, axis=1)[:, None]
        self.assertGreater((normals * mesh.normals).sum(axis=1).min(), 0.99)
        self.assertEqual(mesh.planes.shape, (len(mesh.faces),))
        planes = flight.planes()
        self.assertGreater(len(planes), 0)
        for plane in planes:
            self.assertAlmostEqual(numpy.linalg.norm(plane.normal), 1.0, places=9)
            self.assertIn(plane.kind, ("horizontal", "vertical", "slanted"))
        self.assertEqual(flight.departed_faces().shape[1:], (3, 3))
        self.assertIsNone(flight.grid())

    def test_grid(self):
        grid = facet.replay(self.log, mode="s", duration_s=4.0, grid=True).flight.grid()
        self.assertEqual(grid.states.ndim, 3)
        self.assertTrue(set(numpy.unique(grid.states)) <= {0, 1, 2})
        self.assertGreater((grid.states == 1).sum(), 100)
        self.assertGreater((grid.states == 2).sum(), 10)
        self.assertGreater(grid.cell, 0.0)

    def test_samples_one_by_one_or_many(self):
        flight = facet.Flight(str(self.log))
        samples = [s for s in facet.Log(str(self.log), duration_s=3.0) if isinstance(s, facet.ImuSample)]
        stamps = numpy.array([s.stamp_ns for s in samples])
        flight.add_imu(stamps[0], samples[0].rate, samples[0].force)
        flight.add_imu(stamps[1:], [s.rate for s in samples[1:]], [s.force for s in samples[1:]])
        # Without frames the estimator says so.
        self.assertEqual(flight.add_imu(int(stamps[-1]) + 5_000_000, [0, 0, 0], [0, 0, 9.81]), [])

    def test_readings_of_a_range_finder_count_as_in_the_program(self):
        log, out = self.path / "ranges", self.path / "out_ranges"
        for arguments in (("sim", "--seed", 3, "--duration", 4, "--samples", 1, "--range-finder", 0.02, "--out", log),
                          ("replay", log, "--mode", "s", "--set", "range.enabled=true", "--out", out, "--quiet")):
            done = run(*arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
        readings = [sample for sample in facet.Log(str(log)) if isinstance(sample, facet.RangeSample)]
        table = (log / "mav0" / "range0" / "data.csv").read_text(encoding="utf-8").splitlines()
        rows = [line.split(",") for line in table if not line.startswith("#")]
        frames = [sample.stamp_ns for sample in facet.Log(str(log)) if isinstance(sample, facet.StereoFrame)]
        due = [(int(row[0]), *map(float, row[1:4])) for row in rows if int(row[0]) <= frames[-1]]
        self.assertEqual([(reading.stamp_ns, *reading.point) for reading in readings], due)
        self.assertGreater(len(due), 100)

        given = facet.replay(log, settings={"range.enabled": True}).trajectory
        given.save(self.path / "ranges.tum")
        self.assertEqual((self.path / "ranges.tum").read_bytes(), (out / "trajectory.tum").read_bytes())
        ignored = facet.replay(log).trajectory
        self.assertFalse(numpy.array_equal(given.positions, ignored.positions))

        # As a user's own loop gives them, many at once.
        flight = facet.Flight(str(log), settings={"range.enabled": True})
        flight.add_range([stamp for stamp, *_ in due], [point for _, *point in due])
        flight.add_range(due[-1][0] + 1, due[-1][1:])

    def test_images_as_they_are(self):
        log = facet.Log(str(self.log), duration_s=1.0)
        frame = next(sample for sample in log if isinstance(sample, facet.StereoFrame))
        rows, columns = facet.Flight(str(self.log)).image_size
        self.assertEqual(frame.left.shape, (rows, columns))
        again = facet.Flight(str(self.log))
        wide = numpy.zeros((rows, columns + 13), numpy.uint8)
        wide[:, :columns] = frame.left
        self.assertEqual(again.add_frame(frame.stamp_ns, wide[:, :columns], frame.right).status, "not ready")

    def test_what_is_refused(self):
        flight = facet.Flight(str(self.log))
        rows, columns = flight.image_size
        image = numpy.zeros((rows, columns), numpy.uint8)
        for call, sentence in (
            (lambda: flight.add_frame(0, image.astype(float)), "left must be a grey image, rows x columns of uint8"),
            (lambda: flight.add_frame(0, image[:, :, None]), "left must be a grey image"),
            (lambda: flight.add_frame(0, image, image[1:]), "right is 479 x 752 of uint8; the calibration's camera"),
            (lambda: flight.add_frame(0, numpy.asfortranarray(image)), "numpy.ascontiguousarray"),
            (lambda: flight.add_frame(0, image[::-1]), "numpy.ascontiguousarray"),
            (lambda: flight.add_frame(0, [[1, 2], [3, 4]]), "left must be an array of numpy"),
            (lambda: flight.add_frame(0, None), "a frame has one image at least"),
            (lambda: flight.add_imu(0.5, [0, 0, 0], [0, 0, 0]), "stamps_ns must be whole nanoseconds"),
            (lambda: flight.add_imu(0, [0, 0], [0, 0, 0]), "rates must be numbers of shape (3,) or (N, 3), not 2"),
            (lambda: flight.add_imu(0, [0, 0, 0], "no"), "forces must be numbers"),
            (lambda: flight.add_imu(0, [0, 0, numpy.nan], [0, 0, 0]), "rates must be finite"),
            (lambda: flight.add_imu([0, 1], [0, 0, 0], [0, 0, 0]), "must have equal lengths, not 2, 1 and 1"),
            (lambda: flight.add_range([0, 1], [0, 0, -1]), "must have equal lengths, not 2 and 1"),
            (lambda: flight.add_range(0, [0, -1]), "points must be numbers of shape (3,) or (N, 3)"),
            (lambda: facet.Flight("/nowhere.yaml"), "/nowhere.yaml"),
            (lambda: facet.Flight(str(self.log), mode="x"), "mode 'x' is unknown; one of: s, sp, spr"),
            (lambda: facet.Flight(str(self.log), settings={"no.key": 1}), "no.key"),
            (lambda: facet.Log("/nowhere"), "/nowhere"),
            (lambda: facet.Log(str(self.log), start_s=-1), "start_s must not be negative"),
            (lambda: facet.read_trajectory("/nowhere.tum"), "/nowhere.tum"),
            (lambda: facet.read_truth("/nowhere"), "no state_groundtruth_estimate0"),
            (lambda: facet.simulate(str(self.path / "x"), scene="moon"), "moon"),
        ):
            with self.assertRaises(ValueError) as raised:
                call()
            self.assertIn(sentence, str(raised.exception))

    def test_settings_count(self):
        flight = facet.Flight(str(self.log), settings={"frontend.max_features": 100, "frontend.backend": "own"})
        frame = None
        for sample in facet.Log(str(self.log), duration_s=2.0):
            if isinstance(sample, facet.ImuSample):
                flight.add_imu(sample.stamp_ns, sample.rate, sample.force)
            else:
                frame = flight.add_frame(sample.stamp_ns, sample.left, sample.right)
        self.assertLessEqual(frame.health.tracked, 100)

    def test_the_interpreter_goes_on_meanwhile(self):
        ticks = []
        stop = threading.Event()

        def count():
            while not stop.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.0005)

        thread = threading.Thread(target=count)
        thread.start()
        begin = time.monotonic()
        facet.simulate(str(self.path / "meanwhile"), duration_s=0.5, samples=1)
        end = time.monotonic()
        stop.set()
        thread.join()
        self.assertGreater(len([t for t in ticks if begin < t < end]), 10)

    def test_everything_is_explained(self):
        stub = (Path(PACKAGE) / "facet" / "__init__.pyi").read_text(encoding="utf-8")
        self.assertTrue((Path(PACKAGE) / "facet" / "py.typed").is_file())
        for name in facet.__all__:
            self.assertTrue(getattr(facet, name).__doc__, name)
            self.assertIn(name, stub)

    def test_example(self):
        environment = {**os.environ, "PYTHONPATH": PACKAGE}
        done = subprocess.run([sys.executable, EXAMPLE, str(self.path / "example"), "--duration", "4"],
                              capture_output=True, text=True, check=False, env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("mode spr  TRACKING at the end", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
