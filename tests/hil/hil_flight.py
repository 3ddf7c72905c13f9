# SPDX-License-Identifier: BSD-2-Clause
"""A log, flights of it in the guest, and what a replay makes of it."""
import json
import subprocess
from pathlib import Path

import hil_compare
import hil_guest


class Hil:
    """The programs, a log, and what a replay makes of it."""

    def __init__(self, args):
        self.args = args
        self.programs = hil_guest.Programs(*(Path(p).resolve() for p in (args.kernel, args.facet, args.inject)))
        self.log = Path(args.log).resolve()
        self.out = Path(args.out).resolve()
        self.part = ["--start", str(args.start), "--duration", str(args.duration)]
        self.replays = {}

    def call(self, *command):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            said = done.stderr.strip() or done.stdout.strip()
            raise hil_guest.GuestError(f"{Path(str(command[0])).name} {command[1]}: {said}")

    def encoded_log(self, sensor):
        """The log with inertial samples as the sensor rounds them."""
        folder = self.out / f"log_{sensor}"
        hil_compare.link_log(
            self.log,
            folder,
            lambda csv: self.call(
                self.programs.inject, "encode", "--log", self.log, *self.part, "--imu", sensor, "--out", csv
            ),
        )
        return folder

    def replay(self, sensor=None):
        """Poses of a replay, and their error; of the samples as a sensor rounds them if one is named."""
        if sensor not in self.replays:
            log = self.log if sensor is None else self.encoded_log(sensor)
            name = f"replay_{sensor or 'log'}"
            options = ["--start", self.args.start]
            if self.args.duration > 0.0:
                options += ["--duration", self.args.duration]
            self.replay_to(log, self.out / name, options)
            poses = hil_compare.read_poses(self.out / name)
            self.replays[sensor] = (poses, self.ate(poses, name))
        return self.replays[sensor]

    def replay_to(self, log, out, options=()):
        self.call(self.programs.facet, "replay", log, "--mode", self.args.mode, "--out", out, "--quiet", *options)

    def ate(self, poses, name):
        return hil_compare.ate_mm(self.programs.facet, self.log, poses, self.out / "eval" / name)

    def play(self, sensor, name, **options):
        """@return the job, and the injector's report"""
        job = hil_guest.Job(
            log=self.log, folder=self.out / name, sensor=sensor, mode=self.args.mode, start_s=self.args.start,
            duration_s=self.args.duration, timeout_s=self.args.timeout, **options,
        )  # fmt: skip
        report = hil_guest.fly(self.programs, job)
        if report["exit_code"] != 0:
            words = (job.folder / "run.log").read_text(encoding="utf-8", errors="replace").strip()
            print(f"  {name}: facet run ended with code {report['exit_code']}: {words}", flush=True)
        return job, report

    def fly(self, sensor, name, **options):
        job, report = self.play(sensor, name, **options)
        return self.flight_in(job.folder / "out", name, report)

    @staticmethod
    def flight_in(folder, name, report):
        """What a flight has left in its folder."""
        flight = {"report": report, "folder": folder, "name": name}
        flight["poses"] = hil_compare.read_poses(folder, report["shift_ns"])
        flight["health"] = hil_compare.read_health(folder, report["shift_ns"])
        summary = folder / "summary.json"
        flight["summary"] = json.loads(summary.read_text(encoding="utf-8")) if summary.exists() else None
        return flight
