#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""systemd reads the unit and a vehicle's drop-in without complaint, and rates them as closed.

Usage: service_test.py FACET_PROGRAM...      skipped (77) without systemd-analyze
"""
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
HIGHEST_EXPOSURE = 3.0

CALIBRATION = {
    "imu.yaml": "imu0:\n  accelerometer_noise_density: 0.002\n  accelerometer_random_walk: 0.003\n"
                "  gyroscope_noise_density: 0.0002\n  gyroscope_random_walk: 2.0e-5\n  update_rate: 200.0\n",
    "camchain.yaml": "".join(
        f"cam{k}:\n  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n"
        f"  intrinsics: [400, 400, 320, 240]\n  resolution: [640, 480]\n  timeshift_cam_imu: 0.0\n"
        f"  T_cam_imu: [[0, -1, 0, {-0.1 * k}], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]]\n"
        + ("  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n" if k else "")
        for k in (0, 1)
    ),
}
VEHICLE = """calibration: {camchain: camchain.yaml, imu: imu.yaml}
cameras: {rate_hz: 20}
trigger: {chip: /dev/gpiochip0, line: 17}
trigger_output: {pwm: {chip: /sys/class/pwm/pwmchip0, channel: 1}}
imu: {spi: {chip: icm42688, device: /dev/spidev0.0}}
sinks:
  mavlink: {udp_host: 10.41.1.1}
  world: {path: /run/planner/world, group: planner}
  log: {folder: /data/flights}
"""


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def main():
    if not shutil.which("systemd-analyze"):
        print("SKIPPED: no systemd-analyze here")
        return 77
    program = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in {**CALIBRATION, "vehicle.yaml": VEHICLE}.items():
            (folder / file).write_text(text, encoding="utf-8")
        made = run(*program, "check-config", "--drop-in", folder / "vehicle.yaml")
        assert made.returncode == 0, made.stderr
        named = run(*program, "check-config", "--files", folder / "vehicle.yaml")
        assert named.stdout.split() == ["camchain.yaml", "imu.yaml"], named
        unit = folder / "facet.service"
        text = (ROOT / "app/packaging/facet.service").read_text(encoding="utf-8")
        # What is not installed here: the program and its manual page.
        text = text.replace("/usr/bin/facet", "/bin/true")
        unit.write_text(re.sub(r"(?m)^Documentation=.*\n", "", text), encoding="utf-8")
        drop_in = folder / "facet.service.d/10-vehicle.conf"
        drop_in.parent.mkdir()
        drop_in.write_text(made.stdout, encoding="utf-8")
        read = run("systemd-analyze", "verify", unit)
        assert read.returncode == 0 and "facet" not in read.stderr, read.stderr
        # The check must be able to fail.
        drop_in.write_text(made.stdout + "DeviceAlow=/dev/null\n", encoding="utf-8")
        assert "DeviceAlow" in run("systemd-analyze", "verify", unit).stderr
        drop_in.write_text(made.stdout, encoding="utf-8")
        rated = run("systemd-analyze", "security", "--offline=true", f"--threshold={HIGHEST_EXPOSURE * 10:.0f}", unit)
        found = re.search(r"exposure level for facet.service: ([0-9.]+)", rated.stdout)
        assert found, rated.stdout + rated.stderr
        print("exposure", found.group(1))
        assert float(found.group(1)) <= HIGHEST_EXPOSURE
    return 0


if __name__ == "__main__":
    sys.exit(main())
