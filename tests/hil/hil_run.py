#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Plays a log through kernel devices into `facet run` in a guest, and compares with `facet replay`; see docs/hil.md.

Exit codes: 0 within the limits, 1 not, 2 bad usage or a guest that did not come to its end, 77 skipped.
"""
import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import hil_compare  # noqa: E402
import hil_guest  # noqa: E402

# Virtual time: against a replay of the samples as the sensor rounds them, position.
MAX_DIFFERENCE_MM = 0.01
# Real time: against the replay's error, as a share; differences below this much are rounding.
MAX_ATE_SHARE = 0.10
LEAST_ATE_MM = 0.5
LEAST_FRAMES = 0.95

FAULT_BEGIN_S = 4.0
FAULTS = (
    ("icm42688", "both_dropped", 0.5),
    ("icm42688", "left_dropped", 0.5),
    ("icm42688", "right_dropped", 0.5),
    ("icm42688", "torn", 0.25),
    ("icm42688", "short_frames", 0.25),
    ("icm42688", "flagged_frames", 0.25),
    ("icm42688", "edges_lost", 0.15),
    ("icm42688", "edges_extra", 0.15),
    ("icm42688", "unplugged", 1.0),
    ("icm42688", "imu_silent", 0.3),
    ("icm42688", "imu_damaged", 0.5),
    ("icm42688", "imu_dead", 0.5),
    ("adis16475", "imu_damaged", 0.5),
    ("dronecan", "imu_silent", 0.3),
    ("dronecan", "can_loss", 0.5),
    ("dronecan", "bus_off", 0.5),
    ("dronecan", "can_down", 0.5),
)


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

    def replay(self, sensor=None):
        """Poses of a replay; of the samples as a sensor rounds them if one is named."""
        if sensor not in self.replays:
            log, name = self.log, f"replay_{sensor or 'log'}"
            if sensor is not None:
                log = self.out / f"log_{sensor}"
                hil_compare.link_log(
                    self.log,
                    log,
                    lambda csv: self.call(
                        self.programs.inject, "encode", "--log", self.log, *self.part, "--imu", sensor, "--out", csv
                    ),
                )
            options = ["--start", self.args.start, "--mode", self.args.mode, "--out", self.out / name, "--quiet"]
            if self.args.duration > 0.0:
                options += ["--duration", self.args.duration]
            self.call(self.programs.facet, "replay", log, *options)
            poses = hil_compare.read_poses(self.out / name)
            self.replays[sensor] = (poses, self.ate(poses, name))
        return self.replays[sensor]

    def ate(self, poses, name):
        return hil_compare.ate_mm(self.programs.facet, self.log, poses, self.out / "eval" / name)

    def fly(self, sensor, virtual_time=True, faults=(), name=None):
        name = name or f"{sensor}_{'virtual' if virtual_time else 'real'}"
        job = hil_guest.Job(
            log=self.log, folder=self.out / name, sensor=sensor, mode=self.args.mode, start_s=self.args.start,
            duration_s=self.args.duration, virtual_time=virtual_time, faults=list(faults), timeout_s=self.args.timeout,
        )  # fmt: skip
        report = hil_guest.fly(self.programs, job)
        if report["exit_code"] != 0:
            words = (job.folder / "run.log").read_text(encoding="utf-8", errors="replace").strip()
            print(f"  {name}: facet run ended with code {report['exit_code']}: {words}", flush=True)
        flight = {"report": report, "folder": job.folder / "out", "name": name}
        flight["poses"] = hil_compare.read_poses(flight["folder"], report["shift_ns"])
        flight["summary"] = json.loads((flight["folder"] / "summary.json").read_text(encoding="utf-8"))
        return flight

    def agreement(self, sensor, virtual_time):
        """One row of the table, and whether it is within the limits."""
        flight = self.fly(sensor, virtual_time)
        replay, replay_ate = self.replay()
        encoded, _ = self.replay(sensor)
        live = flight["summary"]["live"]
        row = {
            "sensor": sensor,
            "time": "virtual" if virtual_time else "real",
            "frames": len(flight["poses"]),
            "of": len(encoded),
            "log": hil_compare.differences(replay, flight["poses"]),
            "encoded": hil_compare.differences(encoded, flight["poses"]),
            "ate_replay_mm": replay_ate,
            "ate_mm": self.ate(flight["poses"], flight["name"]),
            "latency_ms": live["latency_ms"],
            "drops": live["drops"],
            "overruns": live["overruns"],
            "late_ms": flight["report"]["latest_ms"],
        }
        row["good"] = self.is_good(row)
        return row

    @staticmethod
    def is_good(row):
        if row["time"] == "virtual":
            return row["frames"] == row["of"] and row["encoded"]["max_mm"] <= MAX_DIFFERENCE_MM
        worse_mm = abs(row["ate_mm"] - row["ate_replay_mm"])
        most_mm = max(MAX_ATE_SHARE * row["ate_replay_mm"], LEAST_ATE_MM)
        return row["frames"] >= LEAST_FRAMES * row["of"] and worse_mm <= most_mm


def print_row(row):
    log, encoded = row["log"], row["encoded"]
    print(
        f"  {row['sensor']:<11} {row['time']:<8} {row['frames']:>4} of {row['of']:<4}"
        f" {log['rms_mm']:>8.3f} {log['max_mm']:>8.3f} {log['max_deg']:>7.4f}"
        f"   {encoded['max_mm']:>8.4f} {encoded['max_stamp_us']:>7.3f}"
        f"   {row['ate_replay_mm']:>7.2f} {row['ate_mm']:>7.2f}"
        f"   {row['latency_ms']['median']:>6.1f} {row['latency_ms']['p99']:>6.1f} {row['late_ms']:>7.2f}"
        f"  {'' if row['good'] else 'OUTSIDE THE LIMITS'}",
        flush=True,
    )


def agreement_table(hil, sensors, times):
    print("                                  against replay            as encoded          ATE            latency "
          "   late")
    print("  sensor      time       frames     rms mm   max mm     deg     max mm      us    replay     hil     med "
          "   p99    max ms")
    rows = []
    for sensor in sensors:
        for virtual_time in times:
            rows.append(hil.agreement(sensor, virtual_time))
            print_row(rows[-1])
    return rows


def count_findings(summary):
    live = summary["live"]
    found = {name: count for name, count in live["synchroniser"].items() if count > 0}
    for source, counters in live["sources"].items():
        found.update({f"{source} {name}": count for name, count in counters.items()
                      if name != "delivered" and count > 0})
    return found


def fault_table(hil, faults):
    print("  fault                              states         recovery  gap s  ATE mm (without)  found")
    plain = {}
    rows = []
    for sensor, kind, length_s in faults:
        if sensor not in plain:
            flight = hil.fly(sensor, name=f"{sensor}_plain")
            plain[sensor] = (
                hil_compare.read_health(flight["folder"], flight["report"]["shift_ns"]),
                hil.ate(flight["poses"], flight["name"]),
                count_findings(flight["summary"]),
            )
        health, ate, usual = plain[sensor]
        name = f"{sensor}_{kind}"
        flight = hil.fly(sensor, faults=[f"{kind}@{FAULT_BEGIN_S}+{length_s}"], name=name)
        begin_ns = flight["report"]["first_frame_ns"] + round(FAULT_BEGIN_S * hil_compare.NANO)
        end_ns = begin_ns + round(length_s * hil_compare.NANO)
        own = hil_compare.read_health(flight["folder"], flight["report"]["shift_ns"])
        recovery = hil_compare.recovery(own, health, begin_ns, end_ns)
        row = {"sensor": sensor, "fault": kind, "length_s": length_s, **recovery}
        row["ate_mm"], row["ate_plain_mm"] = hil.ate(flight["poses"], name), ate
        found = count_findings(flight["summary"])
        row["found"] = {key: count for key, count in found.items() if count != usual.get(key)}
        row["exit_code"] = flight["report"]["exit_code"]
        row["good"] = row["exit_code"] == 0 and not math.isnan(row["recovery_s"])
        rows.append(row)
        words = ", ".join(f"{key} {count}" for key, count in row["found"].items())
        print(
            f"  {sensor + ' ' + kind:<25} {length_s:>4.2f} s  {'|'.join(row['states']) or '-':<16}"
            f" {row['recovery_s']:>6.2f} s {row['longest_gap_s']:>6.2f}  {row['ate_mm']:>7.2f} ({ate:.2f})   {words}"
            f"{'' if row['good'] else '   NOT RECOVERED'}",
            flush=True,
        )
    return rows


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    paths = {
        "kernel": "the guest's",
        "facet": "the program under test",
        "inject": "hil_inject",
        "log": "EuRoC/ASL folder",
        "out": "folder for results",
    }
    for name, what in paths.items():
        parser.add_argument(f"--{name}", required=True, help=what)
    parser.add_argument("--sensors", default="icm42688,dronecan",
                        help=f"comma-separated, of {', '.join(hil_guest.SENSORS)}")
    parser.add_argument("--time", choices=("virtual", "real", "both", "none"), default="virtual")
    parser.add_argument("--faults", nargs="?", const="all",
                        help="also the fault table; or only these kinds, comma-separated")
    parser.add_argument("--mode", default="spr")
    parser.add_argument("--start", type=float, default=0.0)
    parser.add_argument("--duration", type=float, default=0.0)
    parser.add_argument("--timeout", type=float, default=900.0, help="of one flight, in the host's seconds")
    return parser.parse_args(arguments)


def main(arguments):
    args = parse(arguments)
    sensors = args.sensors.split(",")
    if not set(sensors) <= set(hil_guest.SENSORS):
        print(f"hil: --sensors: one or more of {', '.join(hil_guest.SENSORS)}", file=sys.stderr)
        return 2
    try:
        hil = Hil(args)
        hil.out.mkdir(parents=True, exist_ok=True)
        times = {"virtual": [True], "real": [False], "both": [True, False], "none": []}[args.time]
        results = {"agreement": agreement_table(hil, sensors, times) if times else [], "faults": []}
        if args.faults:
            kinds = None if args.faults == "all" else args.faults.split(",")
            results["faults"] = fault_table(hil, [fault for fault in FAULTS if kinds is None or fault[1] in kinds])
        (hil.out / "hil.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
        return 0 if all(row["good"] for rows in results.values() for row in rows) else 1
    except (hil_guest.GuestError, OSError) as error:
        print(f"hil: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
