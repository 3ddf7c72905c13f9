#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tables of docs/hil.md: each between its marks, with the command and the commit that made it."""
import argparse
import contextlib
import io
import math
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

sys.dont_write_bytecode = True
import hil_document  # noqa: E402
import hil_soak  # noqa: E402

FAULT = {"sensor": "icm42688", "words": "silent", "length_s": 0.3, "states": ["DEGRADED"], "reasons": ["imu_gap"],
         "recovery_s": math.nan, "longest_gap_s": 0.3, "ate_mm": 1.03, "ends": "TRACKING", "found": {"gap": 1}}
FLIGHT = {"sensor": "dronecan", "time": "real", "frames": 240, "of": 241, "late_ms": 5.2, "ate_replay_mm": 1.1,
          "ate_mm": 1.2, "latency_ms": {"median": 28.4, "p99": 55.6}}
PART = {"frames": 11998, "not_tracking": 1, "late": 2, "median_ms": 18.3, "p99_ms": 23.3, "mib": 98.04, "ate_mm": 0.512,
        "lost": 0}
ONE_CAMERA = {"of": 12000, "frames": 11998, "growth_mib": 0.5, "resets": 1, "first": PART, "last": PART, "all": PART,
              "grey": {"low": 36, "high": 106, "lit": 1.0}}
NOTHING = {"agreement": [], "faults": [], "records": [], "soak": []}


class Document(unittest.TestCase):
    def update(self, text, **results):
        with tempfile.TemporaryDirectory() as folder:
            document, facet = Path(folder, "hil.md"), Path(folder, "facet")
            document.write_text(text, encoding="utf-8")
            facet.write_text("#!/bin/sh\necho 'commit  0123abc'\n", encoding="utf-8")
            facet.chmod(0o755)
            words = ["hil_run.py", "--kernel", "linux", "--facet", str(facet), "--inject", "hil_inject", "--log",
                     f"{folder}/log_room", "--out", folder, "--jobs", "2", "--time", "none", "--faults",
                     "--document", str(document)]  # fmt: skip
            args = argparse.Namespace(document=document, facet=facet, log=f"{folder}/log_room")
            with mock.patch.object(sys, "argv", words), contextlib.redirect_stderr(io.StringIO()) as said:
                hil_document.update(args, {**NOTHING, **results})
            return document.read_text(encoding="utf-8"), said.getvalue()

    def test_a_table_says_what_made_it_and_leaves_the_others_alone(self):
        before = ("<!-- scripts/target/hil: faults -->\nold\n<!-- end -->\n"
                  "<!-- scripts/target/hil: real -->\nkept\n<!-- end -->\n")
        after, _ = self.update(before, faults=[FAULT])
        self.assertNotIn("old", after)
        self.assertIn("kept", after)
        row = "| ICM-42688-P | silent | 0.30 s | DEGRADED | imu_gap | - | 0.30 s | 1.03 mm | TRACKING | gap 1 |"
        self.assertIn(row, after)
        self.assertIn("`scripts/target/hil --time none --faults`, commit 0123abc.", after)

    def test_latencies_of_flights_in_real_time(self):
        after, _ = self.update("<!-- scripts/target/hil: real -->\n<!-- end -->\n", agreement=[FLIGHT])
        self.assertIn("| DroneCAN | 240 of 241 | 28 / 56 ms | 5 ms | 1.10 mm | 1.20 mm |", after)

    def test_the_parts_of_a_long_flight(self):
        after, _ = self.update("<!-- scripts/target/hil: soak -->\n<!-- end -->\n",
                               soak=[{"of": 72000, "first": PART, "last": PART, "all": PART}])
        self.assertIn("| first 10 min | 11998 | 1 | 2 | 18.3 / 23.3 ms | 98.0 MiB | 0.51 mm |", after)
        self.assertIn("| all | 11998 of 72000 |", after)

    def test_a_long_flight_with_one_camera_has_a_table_of_its_own(self):
        before = ("<!-- scripts/target/hil: soak -->\nkept\n<!-- end -->\n"
                  "<!-- scripts/target/hil: one camera -->\n<!-- end -->\n")
        after, _ = self.update(before, soak=[ONE_CAMERA])
        self.assertIn("kept", after)
        self.assertIn("| first 10 min | 11998 | 0 |  |  |  | 98.0 MiB | 0.51 mm |", after)
        self.assertIn("| all | 11998 of 12000 | 0 | 1 | 36 to 106 | 100.0 % | 98.0 MiB | 0.51 mm |", after)

    def test_what_a_flight_with_one_camera_must_not_do(self):
        self.assertTrue(hil_soak.one_camera_is_good(ONE_CAMERA))
        for wrong in ({"frames": 11000}, {"growth_mib": 1.1}, {"grey": {**ONE_CAMERA["grey"], "lit": 0.98}},
                      {"all": {**PART, "lost": 1}}, {"resets": 2}):  # fmt: skip
            self.assertFalse(hil_soak.one_camera_is_good({**ONE_CAMERA, **wrong}), wrong)

    def test_what_a_long_flight_must_not_do(self):
        row = {"of": 12000, "frames": 12000, "growth_mib": 0.5, "first": PART, "last": PART}
        self.assertTrue(hil_soak.is_good(row))
        for wrong in ({"frames": 11000}, {"growth_mib": 1.1}, {"last": {**PART, "median_ms": 21.0}},
                      {"last": {**PART, "ate_mm": 1.1}}, {"last": {**PART, "ate_mm": math.nan}}):  # fmt: skip
            self.assertFalse(hil_soak.is_good({**row, **wrong}), wrong)

    def test_virtual_time_may_be_slower_than_the_hosts(self):
        self.assertEqual(hil_soak.limit_s(30, "real"), 2400)
        self.assertEqual(hil_soak.limit_s(30, "virtual"), 7800)
        self.assertEqual(hil_soak.limit_s(0, "virtual"), 600)

    def test_what_the_program_says_each_second(self):
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "states.csv")
            table.write_text('seconds,resident_mib,"words"\n'
                             '9.66,106.2,"starting"\n'
                             '19.66,106.3,"TRACKING quality 95, 20.0 frames/s, latency 18.3/23.3 ms, 300 features, '
                             '6 planes, 2 late, 1 overruns, 0 source errors"\n', encoding="utf-8")  # fmt: skip
            self.assertEqual(hil_soak.read_states(table), [(19.66, 106.3, "TRACKING", 18.3, 23.3, 2, 1)])

    def test_counters_rise_from_before_a_part_to_its_end(self):
        states = [(seconds, 90.0, "TRACKING", 20.0, 30.0, late, 0) for seconds, late in ((5, 1), (61, 1), (115, 4))]
        self.assertEqual([hil_soak.counted(states, 5, begin_s, begin_s + 60) for begin_s in (0, 60, 120)], [1, 3, 0])

    def test_what_each_minute_was_like(self):
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "minutes.csv")
            hil_soak.write_minutes(table, [{"frames": 1199, "ate_mm": 0.5}, {"frames": 0, "ate_mm": math.nan}])
            self.assertEqual(table.read_text(encoding="utf-8").split(),
                             ["seconds,frames,ate_mm", "0.0,1199,0.5", "60.0,0,nan"])  # fmt: skip

    def test_a_table_without_a_place_is_told(self):
        after, said = self.update("nothing\n", faults=[FAULT])
        self.assertEqual(after, "nothing\n")
        self.assertIn("no marks for the table 'faults'", said)


if __name__ == "__main__":
    unittest.main()
