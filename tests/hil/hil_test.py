#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""The short hardware-in-the-loop test: a simulated flight through the kernel's drivers in virtual time, by SPI, by CAN
and by a driver in the kernel (IIO), recorded and replayed, faults of camera, line, sensor, clock and program, and the
steps of the bring-up, with the kernel's own cameras, vivid and vimc. Skipped (77) where the guest kernel has not been
built.

Usage: hil_test.py FACET HIL_INJECT WORK_FOLDER
"""
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DURATION = "9"
FLIGHT = ["--scene", "room", "--duration", DURATION, "--stand", "1.5", "--samples", "1", "--seed", "3"]


def skip(why):
    print(f"SKIPPED: {why}")
    return 77


def main(facet, inject, work):
    find_kernel = [ROOT / "scripts/target/hil_kernel", "--cached"]
    found = subprocess.run(find_kernel, capture_output=True, text=True, check=False)
    if found.returncode != 0:
        return skip(found.stderr.strip())
    if subprocess.run(["sh", "-c", "command -v ip"], capture_output=True, check=False).returncode != 0:
        return skip("iproute2 is not installed: run scripts/setup --hil")
    work = Path(work) / f"flight_of_{DURATION}_s"
    log = work / "log"
    if not (log / "mav0").is_dir():
        fresh = work / "log.new"
        shutil.rmtree(fresh, ignore_errors=True)
        subprocess.run([facet, "sim", *FLIGHT, "--out", fresh], check=True, stdout=subprocess.DEVNULL)
        fresh.rename(log)
    command = [
        sys.executable, ROOT / "tests/hil/hil_run.py", "--kernel", found.stdout.strip(), "--facet", facet,
        "--inject", inject,
        "--log", log, "--out", work / "out", "--sensors", "icm42688,dronecan,iio", "--time", "virtual",
        "--faults", "unplugged,unplugged+dim,flagged_frames_2.0,left_ahead,edges_lost_0.15,imu_brown_out,clock_30s,"
        "imu_unplugged_0.5,stopped,sinks_hang",
        "--bring-up", "--timeout", "240",
    ]  # fmt: skip
    return subprocess.run(command, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:4]))
