#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""A flight over ROS 2's topics: another program with another implementation of DDS (fast_dds_peer, Fast DDS) plays a
simulated log as drivers of cameras and an inertial sensor would, in real time, and listens to what facet run publishes.
What facet was given must be the log, its pixels to the bit and its readings to the last digit; what it published must
be what it wrote into its files; and the flight must be the one that a replay of the log gives.

Usage: ros2_flight_test.py FACET FAST_DDS_PEER
"""
import bisect
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

LENGTH_S = 6
LATEST_STAMP_NS = 200_000  # by how much a stamp may move on its way over both clocks of this computer
MOST_LATE = 0.1            # share of the frames that a busy machine may be late for

VEHICLE = """
calibration: {{euroc: log/mav0}}
cameras: {{rate_hz: 20, ros2: {{left: /left/image_raw, right: /right/image_raw}}}}
imu: {{ros2: {{topic: /imu/data}}}}
ros2: {{domain: {domain}}}
sinks: {{rate_hz: 0, ros2: {{grid: true}}}}
"""


def read_csv(text):
    rows = [line.split(",") for line in text.splitlines() if line and not line.startswith("#")]
    return {int(row[0]): row[1:] for row in rows}


def nearest(stamps, stamp):
    at = bisect.bisect_left(stamps, stamp)
    return min(stamps[max(at - 1, 0):at + 1], key=lambda known: abs(known - stamp))


def replay(facet, log, out):
    subprocess.run([facet, "replay", str(log), "--out", str(out), "--quiet"], check=True, capture_output=True,
                   timeout=300)
    return read_csv((out / "trajectory.csv").read_text(encoding="utf-8"))


def fly(facet, peer, folder, domain):
    """What the peer printed, and what facet run cost: processor time (s)."""
    vehicle = folder / "vehicle.yaml"
    vehicle.write_text(VEHICLE.format(domain=domain), encoding="utf-8")
    subprocess.run([facet, "check-config", str(vehicle)], check=True, capture_output=True)
    command = [facet, "run", "--config", str(vehicle), "--out", str(folder / "flown"), "--record", "--quiet"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        try:
            heard = subprocess.run([peer, str(folder / "log"), str(domain)], capture_output=True, text=True,
                                   timeout=120)
            run.send_signal(signal.SIGINT)
            out, error = run.communicate(timeout=60)
        finally:
            run.kill()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert heard.returncode == 0, (heard.stderr, out, error)
    assert run.returncode == 0, (out, error)
    print(out, error, heard.stderr, sep="")
    return heard.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compare_readings(log, flown, shift_ns):
    sent = read_csv((log / "mav0/imu0/data.csv").read_text(encoding="utf-8"))
    received = read_csv((flown / "mav0/imu0/data.csv").read_text(encoding="utf-8"))
    stamps = sorted(sent)
    furthest = 0
    used = []
    for stamp in sorted(received):
        known = nearest(stamps, stamp + shift_ns)
        used.append(stamps.index(known))
        furthest = max(furthest, abs(known - stamp - shift_ns))
        for mine, theirs in zip(received[stamp], sent[known]):
            assert abs(float(mine) - float(theirs)) <= 1e-9 * (1 + abs(float(theirs))), (stamp, mine, theirs)
    lost = used[-1] - used[0] + 1 - len(used)
    print(f"{len(used)} readings, {lost} lost between them, stamps off by {furthest / 1e3:.1f} us at most")
    assert used == sorted(set(used)) and furthest < LATEST_STAMP_NS and lost <= MOST_LATE * len(used)


def compare_pixels(log, flown, shift_ns):
    """Of some images: unpacking a PNG takes a while here."""
    def images(folder, camera):
        rows = read_csv((folder / "mav0" / camera / "data.csv").read_text(encoding="utf-8"))
        return {stamp: folder / "mav0" / camera / "data" / row[0].strip() for stamp, row in rows.items()}
    for camera in ("cam0", "cam1"):
        sent, received = images(log, camera), images(flown, camera)
        stamps = sorted(sent)
        for stamp in sorted(received)[::len(received) // 2]:
            assert pixels(received[stamp]) == pixels(sent[nearest(stamps, stamp + shift_ns)]), (camera, stamp)
    print("images are the same to the bit")


def pixels(path):
    """Rows of a PNG of 8-bit grey."""
    data = path.read_bytes()
    width = int.from_bytes(data[16:20], "big")
    rows, at = b"", 8
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IDAT":
            rows += data[at + 8:at + 8 + size]
        at += size + 12
    return unfiltered(zlib.decompress(rows), width)


def unfiltered(rows, width):
    """PNG's filters taken off 8-bit grey (RFC 2083, 6)."""
    result, above = bytearray(), bytearray(width)
    for begin in range(0, len(rows), width + 1):
        kind, row = rows[begin], bytearray(rows[begin + 1:begin + 1 + width])
        for i in range(width) if kind else ():
            a, b, c = (row[i - 1] if i else 0), above[i], (above[i - 1] if i else 0)
            if kind == 4:
                p = a + b - c
                add = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            else:
                add = (0, a, b, (a + b) // 2)[kind]
            row[i] = (row[i] + add) & 255
        result += row
        above = row
    return bytes(result)


def compare_poses(heard, trajectory, what, most_apart_ns):
    """Distances between poses of the same instant (m), sorted."""
    stamps = sorted(trajectory)
    apart = []
    for stamp, pose in heard.items():
        known = nearest(stamps, stamp)
        if abs(known - stamp) <= most_apart_ns:
            apart.append(math.dist([float(x) for x in pose[:3]], [float(x) for x in trajectory[known][:3]]))
    apart.sort()
    print(f"{len(apart)} of {len(heard)} poses, {1e3 * apart[len(apart) // 2]:.3g} mm from {what} (median), "
          f"{1e3 * apart[-1]:.3g} mm at most")
    return apart


def main():
    facet, peer = sys.argv[1], sys.argv[2]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        log, flown = folder / "log", folder / "flown"
        subprocess.run([facet, "sim", "--scene", "room", "--out", str(log), "--duration", str(LENGTH_S), "--seed", "3",
                        "--samples", "1"], check=True, capture_output=True)
        expected = replay(facet, log, folder / "expected")
        printed, spent_s = fly(facet, peer, folder, 1 + os.getpid() % 200)
        heard = read_csv(printed)
        counts = json.loads(printed.splitlines()[-1][1:])
        print(counts)
        assert counts["unreadable"] == 0 and counts["wrong"] == 0
        print(f"{len(heard)} odometries of {len(expected)} frames of a replay")
        assert counts["/tf"] == counts["/facet/odometry"] == len(heard) > (1 - MOST_LATE) * len(expected) - 3
        assert counts["tracking"] >= 1 and counts["mesh_triangles"] > 50 and counts["landmarks"] > 50
        assert counts["path_poses"] > 5 and counts["planes_triangles"] % 2 == 0
        assert counts["grid_free"] > 20 and counts["grid_occupied"] > 20

        # The recorded log is in the monotonic clock's time, the peer's shift begins at the wall clock's.
        written = read_csv((flown / "trajectory.csv").read_text(encoding="utf-8"))
        shift_ns = counts["shift_ns"] + time.clock_gettime_ns(time.CLOCK_REALTIME) - time.monotonic_ns()
        compare_readings(log, flown, shift_ns)
        compare_pixels(log, flown, shift_ns)
        own = {stamp + shift_ns: row for stamp, row in written.items()}
        apart = compare_poses(heard, own, "facet's own file", LATEST_STAMP_NS)
        assert len(apart) >= len(heard) - 2 and apart[-1] < 1e-6
        apart = compare_poses(heard, expected, "a replay of the log", 2_000_000)
        assert len(apart) > 0.9 * len(heard) and apart[len(apart) // 2] < 0.005 and apart[-1] < 0.03
        ages = sorted(float(row[7]) for row in heard.values())
        print(f"from stamp to odometry {ages[len(ages) // 2]:.1f} ms (median), {ages[int(0.95 * len(ages))]:.1f} ms "
              f"(95 %); {spent_s:.2f} s of processor time for both programs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
