#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compares our MAVLink with node-mavlink, an implementation made from the protocol's own definitions. Skipped (77)
where node or the package is not installed: scripts/setup --npm installs it.

Usage: node_mavlink_test.py NODE_MODULES messages MAVLINK_PEER...
       node_mavlink_test.py NODE_MODULES replay FACET...
What follows the mode is our program, after the emulator that runs it if there is one.

messages   every message that we send is read by node-mavlink, and those that it sends are read by us, signed and not
replay     a simulated flight is replayed in real time; what node-mavlink receives by UDP is the trajectory that the
           replay has written, in MAVLink's frames
"""
import csv
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
SKIPPED = 77


def rounded(value):
    """As a float of 32 bits holds it."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def run_node(modules, arguments, **options):
    environment = {**os.environ, "NODE_PATH": str(modules)}
    return subprocess.run(["node", str(HERE / "node_mavlink.cjs"), *arguments], env=environment, check=True,
                          capture_output=True, text=True, timeout=60, **options).stdout


def compare_fields(ours, theirs, what):
    for name, value in ours.items():
        other = theirs[name]
        if isinstance(value, list):
            assert len(value) == len(other), (what, name)
            pairs = list(zip(value, other))
        else:
            pairs = [(value, other)]
        for a, b in pairs:
            same = a == b if isinstance(a, str) else math.isclose(rounded(a), rounded(b), rel_tol=0, abs_tol=0)
            assert same, (what, name, value, other)


def check_messages(modules, program):
    lines = subprocess.run([*program, "emit"], check=True, capture_output=True, text=True).stdout
    ours = [json.loads(line) for line in lines.splitlines()]
    theirs = [json.loads(line) for line in run_node(modules, ["read"], input=lines).splitlines()]
    assert len(ours) == len(theirs) > 8
    for mine, read in zip(ours, theirs):
        what = f"message {mine['id']}"
        assert read["id"] == mine["id"], what
        assert (read["magic"], read["payloadLength"]) == (mine["crc_extra"], mine["size"]), (what, read)
        assert (read["system"], read["component"]) == (42, 197), what
        assert read["signature"] == ("right" if mine["signed"] else "none"), (what, read)
        compare_fields(mine["fields"], read["fields"], what)
    print(f"{len(ours)} frames of ours are read by node-mavlink as they were meant")

    sent = [json.loads(line) for line in run_node(modules, ["write"]).splitlines()]
    text = "".join(frame["hex"] + "\n" for frame in sent)
    lines = subprocess.run([*program, "absorb"], input=text, check=True, capture_output=True, text=True).stdout
    *read, counters = [json.loads(line) for line in lines.splitlines()]
    known = [frame for frame in sent if frame["fields"]]
    assert len(read) == len(known) > 4, (read, sent)
    for theirs, mine in zip(known, read):
        what = f"message {theirs['id']} of theirs"
        assert mine["id"] == theirs["id"] and mine["sequence"] == theirs["sequence"], what
        assert (mine["system"], mine["component"]) == (1, 1), what
        assert mine["signature"] == theirs["signature"], (what, mine)
        compare_fields(theirs["fields"], mine["fields"], what)
    assert counters == {"packets": len(known), "unknown": len(sent) - len(known), "lost": 2, "corrupt": 0}, counters
    print(f"{len(sent)} frames of node-mavlink are read by us as they were meant")


def read_trajectory(path):
    """Rows of trajectory.csv by time in microseconds: position, quaternion w x y z, velocity."""
    rows = {}
    with open(path, encoding="utf-8") as file:
        for row in csv.reader(file):
            if row and not row[0].startswith("#"):
                values = [float(x) for x in row[1:11]]
                rows[int(row[0]) // 1000] = (values[0:3], values[3:7], values[7:10])
    return rows


def turn_back(q, v):
    """R(q)^T v for a unit quaternion w x y z."""
    w, x, y, z = q
    u = (-x, -y, -z)
    t = [2 * (u[1] * v[2] - u[2] * v[1]), 2 * (u[2] * v[0] - u[0] * v[2]), 2 * (u[0] * v[1] - u[1] * v[0])]
    return [v[0] + w * t[0] + u[1] * t[2] - u[2] * t[1], v[1] + w * t[1] + u[2] * t[0] - u[0] * t[2],
            v[2] + w * t[2] + u[0] * t[1] - u[1] * t[0]]


def worst(a, b):
    return max(abs(x - y) for x, y in zip(a, b))


def check_replay(modules, program):
    with tempfile.TemporaryDirectory() as folder:
        flight, out = Path(folder, "flight"), Path(folder, "out")
        subprocess.run([*program, "sim", "--scene", "room", "--out", str(flight), "--duration", "5", "--seed", "3",
                        "--samples", "1"],
                       check=True, capture_output=True)
        environment = {**os.environ, "NODE_PATH": str(modules)}
        with subprocess.Popen(["node", str(HERE / "node_mavlink.cjs"), "listen"], env=environment, text=True,
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE) as listener:
            port = int(listener.stdout.readline())
            replay = subprocess.run([*program, "replay", str(flight), "--out", str(out), "--realtime", "--quiet",
                                     "--mavlink", f"udp:127.0.0.1:{port}"], capture_output=True, text=True)
            print(replay.stdout, replay.stderr)
            assert replay.returncode == 0
            heard, _ = listener.communicate("stop\n", timeout=60)
        messages = [json.loads(line) for line in heard.splitlines()]
        compare_flight(messages, read_trajectory(out / "trajectory.csv"))


def compare_flight(messages, trajectory):
    poses = [message["fields"] for message in messages if message["id"] == 331]
    heartbeats = [message for message in messages if message["id"] == 0]
    texts = [message["fields"]["text"] for message in messages if message["id"] == 253]
    assert len(poses) == len(trajectory) > 60, (len(poses), len(trajectory))
    assert len(heartbeats) >= 4, "a heartbeat a second"
    assert any("TRACKING" in text for text in texts), texts
    sequences = [message["sequence"] for message in messages]
    assert all((b - a) % 256 == 1 for a, b in zip(sequences, sequences[1:])), "frames were lost"
    for pose in poses:
        position, q, velocity = trajectory[int(pose["timeUsec"])]
        v_body = turn_back(q, velocity)
        sign = -1 if q[0] < 0 else 1
        assert worst((pose["x"], pose["y"], pose["z"]), (position[0], -position[1], -position[2])) < 2e-6, pose
        assert worst(pose["q"], (sign * q[0], sign * q[1], -sign * q[2], -sign * q[3])) < 2e-6, pose
        assert worst((pose["vx"], pose["vy"], pose["vz"]), (v_body[0], -v_body[1], -v_body[2])) < 2e-6, pose
        assert (pose["frameId"], pose["childFrameId"], pose["estimatorType"]) == (20, 12, 3)
        assert 1 <= pose["quality"] <= 100
        diagonals = [pose[name][i] for name in ("poseCovariance", "velocityCovariance") for i in (0, 6, 11, 15, 18, 20)]
        assert all(0 < variance < 10 for variance in diagonals), diagonals
    print(f"{len(poses)} poses received over UDP are the trajectory, to the rounding of their 32 bits")


def main():
    modules, mode, *program = sys.argv[1:]
    modules = Path(modules)
    if shutil.which("node") is None:
        print("SKIPPED: node is not installed")
        return SKIPPED
    if not (modules / "node-mavlink").is_dir():
        print(f"SKIPPED: {modules}/node-mavlink is missing: scripts/setup --npm installs it")
        return SKIPPED
    {"messages": check_messages, "replay": check_replay}[mode](modules, program)
    return 0


if __name__ == "__main__":
    sys.exit(main())
