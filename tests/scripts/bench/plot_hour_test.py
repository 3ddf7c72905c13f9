#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of what scripts/tools/plot_hour draws."""
import importlib.machinery
import importlib.util
import math
import pathlib
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[3] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True


def load_script(name):
    loader = importlib.machinery.SourceFileLoader(name, str(SCRIPTS / "tools" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


def stamped(name, values):
    """A table with a row each 30 s."""
    return f"stamp_ns,{name}\n" + "".join(f"{k * 30_000_000_000},{value}\n" for k, value in enumerate(values))


class Panels(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.mode = pathlib.Path(self.folder.name) / "s"
        self.mode.mkdir()

    def panels(self):
        return dict(load_script("plot_hour").panels(self.mode))

    def test_figures_are_those_of_a_minute(self):
        (self.mode / "memory.csv").write_text("seconds,resident_mib\n1.0,90\n59.0,80\n61.0,100\n")
        (self.mode / "timing.csv").write_text(stamped("total_cpu_ms", [1, 3, 4, 6]))
        (self.mode / "errors.csv").write_text(stamped("nees_pose", [5, 7, 6]))
        (self.mode.parent / "hour_s.csv").write_text("seconds,ate_mm\n0.0,1.5\n120.0,2.5\n")
        self.assertEqual(self.panels(), {
            "memory (MiB)": {"most in a minute": [(0.5, 90.0), (1.5, 100.0)]},
            "processor time a frame (ms)": {"median": [(0.5, 2.0), (1.5, 5.0)],
                                            "99th percentile": [(0.5, 1.0), (1.5, 4.0)]},
            "ATE of 100 m (mm)": {"each stretch aligned by itself": [(0.0, 1.5), (2.0, 2.5)]},
            "pose NEES": {"mean of a minute": [(0.5, 6.0), (1.5, 6.0)]}})

    def test_a_flight_in_the_guest_has_its_tables_below_and_no_time_in_virtual_time(self):
        (self.mode / "out").mkdir()
        (self.mode / "out/timing.csv").write_text(stamped("total_ms", [0, 0]))
        (self.mode / "states.csv").write_text('seconds,resident_mib,words\n-1.0,60,"INIT, 0"\n5.0,70,"TRACKING, 3"\n')
        self.assertEqual(self.panels(), {"memory (MiB)": {"most in a minute": [(0.5, 70.0)]}})

    def test_a_flight_in_the_guest_has_frames_states_latency_and_error_of_each_minute(self):
        (self.mode / "minutes.csv").write_text(
            "seconds,frames,not_tracking,late,overruns,median_ms,p99_ms,worst_p99_ms,mib,ate_mm\n"
            "0.0,1199,3,0,0,28.5,55.0,60.0,90.0,1.25\n60.0,1200,0,0,0,29.5,54.0,60.0,90.0,1.5\n")
        self.assertEqual(self.panels(), {
            "frames a minute": {"used": [(0.5, 1199.0), (1.5, 1200.0)]},
            "bad frames a minute": {"not TRACKING": [(0.5, 3.0), (1.5, 0.0)], "late": [(0.5, 0.0), (1.5, 0.0)]},
            "latency (ms)": {"median": [(0.5, 28.5), (1.5, 29.5)], "99th percentile": [(0.5, 55.0), (1.5, 54.0)]},
            "ATE of a minute (mm)": {"each minute aligned by itself": [(0.5, 1.25), (1.5, 1.5)]}})

    def test_a_flight_in_real_time_in_the_guest_has_the_time_a_frame_takes(self):
        (self.mode / "out").mkdir()
        (self.mode / "out/timing.csv").write_text(stamped("total_ms", [4, 6]))
        lines = {"median": [(0.5, 5.0)], "99th percentile": [(0.5, 4.0)]}
        self.assertEqual(self.panels(), {"time a frame (ms)": lines})

    def test_spikes_call_for_a_logarithm_zeros_forbid_it(self):
        has_spikes = load_script("plot_hour").has_spikes
        quiet = [(0.5, 0.3), (1.5, 0.4), (2.5, 0.5), (3.5, math.nan)]
        self.assertFalse(has_spikes({"a": quiet}))
        self.assertTrue(has_spikes({"a": quiet + [(4.5, 900.0)]}))
        self.assertFalse(has_spikes({"a": quiet + [(4.5, 900.0), (5.5, 0.0)]}))

    def test_an_empty_folder_has_none(self):
        self.assertEqual(self.panels(), {})


if __name__ == "__main__":
    unittest.main()
