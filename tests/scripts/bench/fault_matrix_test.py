#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/bench/fault_matrix.py, and that scripts/benchmarks/faults.yaml is one."""
import math
import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
from bench import fault_matrix as matrix  # noqa: E402
from bench.plan import PlanError  # noqa: E402

LIMITS = {"seconds_per_second": 8, "rss_mib": 600, "files_mib": 40, "silent_sigmas": 5, "silent_mm": 20,
          "silent_deg": 1, "silent_quality": 50, "silent_s": 0.3, "ate_mm": 5, "recovery_s": 1, "estimates": 0.9}
FRAMES = 201  # 10 s at 20 Hz


def row(i, state="TRACKING", quality=100, reasons=()):
    return {"t_ns": i * 50_000_000, "state": state, "quality": quality, "resets": 0, "reasons": list(reasons)}


def error(i, p_m=0.0, sigma_m=0.001, theta_rad=0.0):
    return {"t_ns": i * 50_000_000, "theta": [0.0, 0.0, theta_rad], "p": [p_m, 0.0, 0.0],
            "theta_sigma": [0.001] * 3, "p_sigma": [sigma_m] * 3}


def flight(**changes):
    fields = {"health": [row(i) for i in range(FRAMES)], "errors": [error(i) for i in range(FRAMES)], "warnings": {},
              "frames": FRAMES, "estimates": FRAMES, "ate_mm": 1.0, "duration_s": 10.0, **changes}
    return matrix.Flight(**fields)


def cell(**changes):
    fields = {"sensor": "IMU", "fault": "dies", "inject": ("imu_gap",), "recovery_s": 1.0, "ate_mm": 5.0,
              "estimates": 0.9, **changes}
    return matrix.Cell(**fields)


def broken(cell_, flight_):
    return matrix.judge(cell_, flight_, LIMITS, cell_.window(5, 2)).broken


def with_rows(begin, end, *state):
    return [row(i, *state) if begin <= i < end else row(i) for i in range(FRAMES)]


class Verdicts(unittest.TestCase):
    def test_a_flight_as_expected_keeps_all(self):
        self.assertEqual(broken(cell(), flight()), [])

    def test_states_meanwhile(self):
        degraded = flight(health=with_rows(110, 120, "DEGRADED", 60, ["imu_gap"]))
        self.assertEqual(broken(cell(), degraded), ["states DEGRADED TRACKING"])
        self.assertEqual(broken(cell(states=("TRACKING", "DEGRADED"), reasons=("imu_gap",)), degraded), [])
        self.assertEqual(broken(cell(states=("TRACKING", "DEGRADED"), reasons=("few_stereo",)), degraded),
                         ["none of few_stereo"])
        silent = flight(health=[row(i) for i in range(FRAMES) if not 100 <= i < 140])
        self.assertEqual(broken(cell(), silent), ["states none"])

    def test_a_kind_of_warning_is_a_reason(self):
        told = flight(warnings={"calibration_check": 1})
        self.assertEqual(broken(cell(reasons=("calibration_check", "calibration")), told), [])

    def test_recovery_is_to_tracking_that_stays(self):
        late = with_rows(140, 170, "DEGRADED")
        self.assertEqual(broken(cell(), flight(health=late)), ["recovers in 1.50 s"])
        late[150] = row(150)  # for one frame only
        self.assertEqual(broken(cell(), flight(health=late)), ["recovers in 1.50 s"])
        never = with_rows(140, FRAMES, "LOST", 0)
        self.assertEqual(broken(cell(), flight(health=never)), ["ends LOST", "recovers never"])
        self.assertEqual(broken(cell(when="on", states=("TRACKING", "LOST"), end=("LOST",)), flight(health=never)), [])

    def test_the_last_frames_of_a_log_say_nothing(self):
        cut = with_rows(FRAMES - 1, FRAMES, "DEGRADED", 60, ["imu_gap"])
        self.assertEqual(broken(cell(), flight(health=cut)), [])
        self.assertEqual(broken(cell(when="on"), flight(health=cut)), [])

    def test_error_coverage_and_exit(self):
        self.assertEqual(broken(cell(), flight(ate_mm=5.1)), ["ATE 5.1 mm"])
        self.assertEqual(broken(cell(), flight(ate_mm=None)), ["no error known"])
        self.assertEqual(broken(cell(ate_mm=math.inf), flight(ate_mm=None)), [])
        self.assertEqual(broken(cell(), flight(estimates=100)), ["50 % estimated"])
        self.assertEqual(broken(cell(), flight(exit=1)), ["exit 1 instead of 0"])
        lost = {"when": "on", "states": ("TRACKING", "LOST"), "end": ("LOST",)}  # from the middle of the flight on
        health = with_rows(110, FRAMES, "LOST", 0)
        self.assertEqual(broken(cell(**lost), flight(health=health, estimates=95)), [])
        self.assertEqual(broken(cell(**lost), flight(health=health, estimates=80)), ["40 % estimated"])

    def test_crash_hang_memory_and_output(self):
        self.assertEqual(broken(cell(), flight(trouble="replay ended by signal 11")), ["replay ended by signal 11"])
        self.assertEqual(broken(cell(), flight(seconds=101)), ["took 101 s"])
        self.assertEqual(broken(cell(), flight(rss_mib=601)), ["601 MiB of memory"])
        self.assertEqual(broken(cell(), flight(files_mib=41)), ["41 MiB of files"])

    def test_wrong_in_silence(self):
        off = [error(i, 0.03 if i > 150 else 0.0) for i in range(FRAMES)]
        self.assertEqual(broken(cell(), flight(errors=off)), ["undetected error for 2.5 s"])
        self.assertEqual(broken(cell(known="nothing can tell"), flight(errors=off)), [])
        turned = [error(i, theta_rad=0.02) for i in range(1, FRAMES)]
        self.assertEqual(broken(cell(), flight(errors=turned)), ["undetected error for 10.0 s"])

    def test_what_is_claimed_small_or_said_is_no_silence(self):
        self.assertEqual(broken(cell(), flight(errors=[error(i, 0.03, 0.01) for i in range(FRAMES)])), [])
        self.assertEqual(broken(cell(), flight(errors=[error(i, 0.01) for i in range(FRAMES)])), [])
        off = [error(i, 0.03) for i in range(FRAMES)]
        self.assertEqual(broken(cell(), flight(errors=off, health=[row(i, quality=50) for i in range(FRAMES)])), [])


class Files(unittest.TestCase):
    def complaint(self, *cells, **changes):
        content = {"at": 5, "length": 2, "flights": {}, "limits": {**LIMITS, **changes}, "cells": list(cells)}
        with self.assertRaises(PlanError) as caught:
            matrix.read_cells(content)
        return str(caught.exception)

    def test_mistakes_are_named(self):
        dies = {"sensor": "IMU", "fault": "dies", "inject": "imu_gap"}
        self.assertIn("cell 1.state: unknown", self.complaint({**dies, "state": "LOST"}))
        self.assertIn("has no inject", self.complaint({"sensor": "IMU", "fault": "dies"}))
        self.assertIn("unknown state 'SAD'", self.complaint({**dies, "states": ["SAD"]}))
        self.assertIn("when: must be one of", self.complaint({**dies, "when": "never"}))
        self.assertIn("stands there twice", self.complaint(dies, dies))
        self.assertIn("rss_mib must be a number", self.complaint(dies, rss_mib="x"))

    def test_times_of_faults(self):
        self.assertEqual(cell().specs(5, 2), ["imu_gap@5+2"])
        self.assertEqual(cell(at=5.1).specs(5, 2), ["imu_gap@5.1+2"])
        self.assertEqual(cell(at=5.1).window(5, 2), (5.1, 7.1))
        self.assertEqual(cell(when="on").specs(5, 2), ["imu_gap@5"])
        self.assertEqual(cell(when="always", inject=("imu_gap", "calibration=5")).specs(5, 2),
                         ["imu_gap", "calibration=5"])

    def test_the_matrix_lists_its_cells(self):
        def listed(*given):
            return subprocess.run([sys.executable, ROOT / "scripts/benchmark", "faults", "--facet", sys.executable,
                                   "--list", *given], capture_output=True, text=True, check=False)
        done = listed()
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        self.assertGreater(len(lines), 80)
        self.assertIn("room, K = 0, s, IMU, dies, seed 1: facet replay --mode s --inject imu_gap@5", lines)
        self.assertEqual(len(listed("--cases", "IMU: dies", "IMU: NaN").stdout.splitlines()), 3)
        self.assertEqual(listed("--cases", "no such thing").returncode, 2)


if __name__ == "__main__":
    unittest.main()
