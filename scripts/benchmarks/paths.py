# SPDX-License-Identifier: BSD-2-Clause
"""What each way of samples into the program costs, in time and in delay, against SPI.

The drivers are the program's; what they ask is scripted (tests/drivers): no device is needed, a kernel's own work is
in no figure, the scripted device's is. A pose needs the first inertial sample at or after its image, so the path of the
inertial samples delays it: by half their period on average, by what their bytes take on the line, and by the driver."""
import json
import subprocess

from bench.plan import PlanError

IMU_HZ = 200.0
CAMERA_HZ = 20.0
BAUD = 921_600
BITS_A_BYTE = 10  # with start and stop bit
HEADS = ["samples", "path", "stand-in for the device", "us a sample", "x SPI", "load of a core, %", "on the line, ms",
         "image to pose, ms more"]


def measure_load(program):
    if not program.is_file():
        raise PlanError(f"{program} is missing: scripts/build release --all")
    done = subprocess.run([program, "what each path costs"], stdout=subprocess.PIPE, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def measure(bench):
    paths = measure_load(bench.facet.parent / "path_load")
    bench.results = {"paths": paths}
    spi_us = next(path["us"] for path in paths if path["path"].startswith("SPI"))
    rows = []
    for path in paths:
        is_imu = path["kind"] == "imu"
        rate_hz = IMU_HZ if is_imu else CAMERA_HZ
        line_ms = 1e3 * path["bytes"] * BITS_A_BYTE / BAUD
        more_ms = (0.5e3 / IMU_HZ if is_imu else 0.0) + line_ms + 1e-3 * path["us"]
        rows.append([path["kind"], path["path"], path["stand_in"], f"{path['us']:.1f}",
                     f"{path['us'] / spi_us:.1f}" if is_imu else "-", f"{1e-4 * path['us'] * rate_hz:.3f}",
                     f"{line_ms:.2f}" if path["bytes"] else "-", f"{more_ms:.2f}"])
    bench.notes += [f"inertial samples at {IMU_HZ:g} Hz, images of 752 x 480 at {CAMERA_HZ:g} Hz",
                    f"a serial line at {BAUD} baud",
                    "image to pose, more: half an inertial period, the line (by arithmetic) and the driver (measured)"]
    return {"paths": (HEADS, rows, 3)}, []
