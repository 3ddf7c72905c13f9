#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Imports ROS bags whose messages Foxglove's packages have serialized. Skipped (77) where node or the packages are not
installed: scripts/setup --npm installs them.

Usage: bag_peer_test.py NODE_MODULES FACET...
FACET is our program, after the emulator that runs it if there is one.

Bags of ROS 2 (CDR in MCAP, written by @mcap/core, and in sqlite3) and of ROS 1 (each compression; @foxglove/rosbag
reads them as well) become log folders with the same images, inertial samples and true poses, whatever form they had in
the bag.
"""
import contextlib
import json
import os
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
SKIPPED = 77
PACKAGES = ("@mcap/core", "@mcap/support", "@foxglove/rosmsg", "@foxglove/rosmsg-serialization",
            "@foxglove/rosmsg2-serialization", "@foxglove/rosbag")
BEGIN = 1_400_000_000_000_000_000
FRAMES = 12
WIDTH, HEIGHT = 38, 22
STEP = 40  # bytes a row of 8-bit images: two of them are padding


def run_node(modules, *arguments):
    environment = {**os.environ, "NODE_PATH": str(modules)}
    return subprocess.run(["node", str(HERE / "bag_peer.cjs"), *map(str, arguments)], env=environment, check=True,
                          capture_output=True, text=True, timeout=120).stdout


def grey(camera, k, u, v):
    return (13 * u + 7 * v + 31 * k + 101 * camera) % 256


def plain(camera, k):
    return [[grey(camera, k, u, v) for u in range(WIDTH)] for v in range(HEIGHT)]


def header(stamp):
    return {"sec": stamp // 10**9, "nsec": stamp % 10**9}


def image(camera, k, encoding):
    """An image in a form, of which every sample is the grey value."""
    stamp = BEGIN + k * 50_000_000
    pixels = plain(camera, k)
    if encoding == "png":
        rows = b"".join(b"\0" + bytes(row) for row in pixels)
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        data = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 0, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
        return "sensor_msgs/CompressedImage", {"header": header(stamp), "format": "mono8; png compressed",
                                               "bytes": data.hex()}
    pack = {"mono8": lambda x: bytes([x]), "mono16": lambda x: struct.pack("<H", 257 * x),
            "bgr8": lambda x: bytes([x, x, x]), "rgba8": lambda x: bytes([x, x, x, 0])}[encoding]
    size = len(pack(0))
    padding = b"\xee" * (STEP - WIDTH if size == 1 else 0)
    data = b"".join(b"".join(map(pack, row)) + padding for row in pixels)
    return "sensor_msgs/Image", {"header": header(stamp), "height": HEIGHT, "width": WIDTH, "encoding": encoding,
                                 "is_bigendian": 0, "step": size * WIDTH + len(padding), "bytes": data.hex()}


def xyz(x, y, z):
    return {"x": x, "y": y, "z": z}


def inertial(i):
    stamp = BEGIN - 50_000_000 + i * 5_000_000
    zeros = [0.0] * 9
    return stamp, {"header": header(stamp), "orientation": {**xyz(9, 9, 9), "w": 9}, "orientation_covariance": zeros,
                   "angular_velocity": xyz(0.01 * i, -1e-5, 1 / 3), "angular_velocity_covariance": zeros,
                   "linear_acceleration": xyz(0.1, i, 9.81), "linear_acceleration_covariance": zeros}


def true_pose(i, kind):
    stamp = BEGIN + i * 10_000_000 + 3
    place, turn = xyz(i, 0.5, -0.25), {"x": 0.1, "y": 0.2, "z": 0.3, "w": 0.9}
    pose = {"position": place, "orientation": turn}
    return stamp, {
        "geometry_msgs/PoseStamped": {"header": header(stamp), "pose": pose},
        "geometry_msgs/TransformStamped": {"header": header(stamp), "child_frame_id": "body",
                                           "transform": {"translation": place, "rotation": turn}},
        "nav_msgs/Odometry": {"header": header(stamp), "child_frame_id": "body",
                              "pose": {"pose": pose, "covariance": [0.0] * 36},
                              "twist": {"twist": {"linear": xyz(0, 0, 0), "angular": xyz(0, 0, 0)},
                                        "covariance": [0.0] * 36}}}[kind]


def entries_of(encoding, truth):
    """What a bag holds, in the order in which it was recorded: images come late, as they do."""
    entries = [(BEGIN, "/chatter", "std_msgs/String", {"data": "hello"})]
    for k in range(FRAMES):
        for camera in (0, 1):
            kind, message = image(camera, k, encoding)
            entries.append((BEGIN + k * 50_000_000 + 70_000_000 + camera, f"/cam{camera}/image_raw", kind, message))
    for i in range(10 * (FRAMES + 2)):
        stamp, message = inertial(i)
        # Every seventh sample overtakes the one before.
        entries.append((stamp + (-6_000_000 if i % 7 == 6 else 0), "/imu0", "sensor_msgs/Imu", message))
    for i in range(20):
        stamp, message = true_pose(i, truth)
        entries.append((stamp, "/truth", truth, message))
    entries.sort(key=lambda entry: entry[0])
    return [{"time": str(time), "topic": topic, "type": kind, "message": message}
            for time, topic, kind, message in entries]


def write_sqlite(path, messages):
    """The tables of rosbag2's sqlite3 storage."""
    with contextlib.closing(sqlite3.connect(path)) as database, database:
        database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
                         "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)")
        database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
                         "timestamp INTEGER NOT NULL, data BLOB NOT NULL)")
        ids = {}
        for message in messages:
            if message["topic"] not in ids:
                ids[message["topic"]] = len(ids) + 1
                kind = message["type"].replace("/", "/msg/")
                database.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')",
                                 (ids[message["topic"]], message["topic"], kind))
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                             (ids[message["topic"]], int(message["time"]), bytes.fromhex(message["hex"])))


def read_png(path):
    """Rows of an 8-bit grey PNG file."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
            assert (depth, colour) == (8, 0), path
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += size + 12
    raw, rows, before = zlib.decompress(packed), [], [0] * width
    for v in range(height):
        method, line = raw[v * (width + 1)], raw[v * (width + 1) + 1:(v + 1) * (width + 1)]
        row = []
        for u, x in enumerate(line):
            a, b, c = (row[-1] if u else 0), before[u], (before[u - 1] if u else 0)
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row.append((x + (0, a, b, (a + b) // 2, nearest)[method]) % 256)
        rows.append(row)
        before = row
    return rows


def read_rows(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.split(",") for line in lines if not line.startswith("#")]


def check_log(log, what):
    root = log / "mav0"
    for camera in (0, 1):
        rows = read_rows(root / f"cam{camera}" / "data.csv")
        assert rows == [[str(BEGIN + k * 50_000_000), f"{BEGIN + k * 50_000_000}.png"] for k in range(FRAMES)], what
        for k in range(FRAMES):
            assert read_png(root / f"cam{camera}" / "data" / rows[k][1]) == plain(camera, k), (what, camera, k)
    rows = [(int(row[0]), *map(float, row[1:])) for row in read_rows(root / "imu0" / "data.csv")]
    assert rows == [(BEGIN - 50_000_000 + i * 5_000_000, 0.01 * i, -1e-5, 1 / 3, 0.1, i, 9.81)
                    for i in range(10 * (FRAMES + 2))], what
    rows = [(int(row[0]), *map(float, row[1:])) for row in read_rows(root / "state_groundtruth_estimate0" / "data.csv")]
    assert rows == [(BEGIN + i * 10_000_000 + 3, i, 0.5, -0.25, 0.9, 0.1, 0.2, 0.3) for i in range(20)], what


def main():
    modules, *program = sys.argv[1:]
    modules = Path(modules)
    if shutil.which("node") is None or shutil.which("bzip2") is None:
        print("SKIPPED: node or bzip2 is not installed")
        return SKIPPED
    for package in PACKAGES:
        if not (modules / package).is_dir():
            print(f"SKIPPED: {modules}/{package} is missing: scripts/setup --npm installs it")
            return SKIPPED

    def convert(bag, out, *options):
        return subprocess.run([*program, "convert", str(bag), str(out), "--quiet", *options], capture_output=True,
                              text=True)

    cases = (("ros2", "", "mono8", "nav_msgs/Odometry"), ("ros2", "", "png", "geometry_msgs/PoseStamped"),
             ("ros1", "none", "mono16", "geometry_msgs/TransformStamped"),
             ("ros1", "lz4", "bgr8", "geometry_msgs/PoseStamped"), ("ros1", "bz2", "rgba8", "nav_msgs/Odometry"),
             ("ros1", "bz2", "png", "geometry_msgs/PoseStamped"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for i, (version, method, encoding, truth) in enumerate(cases):
            what = f"{version} {method} {encoding}"
            entries = entries_of(encoding, truth)
            (folder / "log.json").write_text(json.dumps(entries), encoding="utf-8")
            bag, log = folder / f"{i}.{'bag' if version == 'ros1' else 'mcap'}", folder / f"log{i}"
            run_node(modules, version, folder / "log.json", bag, method)
            if version == "ros1":
                counts = json.loads(run_node(modules, "read", bag))
                assert sum(counts.values()) == len(entries), (what, counts)
            done = convert(bag, log)
            assert done.returncode == 0, (what, done.stderr)
            assert "calibration  none" in done.stdout, (what, done.stdout)
            check_log(log, what)
        print(f"{len(cases)} bags have become the log that they hold")

        named = convert(bag, folder / "one", "--left", "/cam1/image_raw", "--imu", "/imu0")
        assert named.returncode == 0 and not (folder / "one/mav0/cam1").exists(), named
        assert read_png(folder / f"one/mav0/cam0/data/{BEGIN}.png") == plain(1, 0)
        wrong = convert(bag, folder / "wrong", "--imu", "/cam0/image_raw")
        assert wrong.returncode == 2 and "no topic /cam0/image_raw for imu0" in wrong.stderr, wrong
        assert "/truth" in wrong.stderr and not (folder / "wrong").exists(), wrong
        cut = folder / "cut.bag"
        cut.write_bytes(bag.read_bytes()[:-5000])
        done = convert(cut, folder / "from_cut")
        assert done.returncode == 0 and "was cut off" in done.stderr, done

        # The same messages in the form that ROS 2 had before MCAP.
        database = folder / "bag.db3"
        write_sqlite(database, json.loads(run_node(modules, "cdr", folder / "log.json")))
        done = convert(database, folder / "from_sqlite")
        assert done.returncode == 0, done.stderr
        check_log(folder / "from_sqlite", "sqlite3")
        database.write_bytes(database.read_bytes()[:-20000])
        done = convert(database, folder / "from_cut_sqlite")
        assert done.returncode in (1, 2) or "cannot be read to its end" in done.stderr, done

        ros2 = folder / "rosbag2"
        ros2.mkdir()
        (folder / "0.mcap").rename(ros2 / "rosbag2_0.mcap")
        (ros2 / "metadata.yaml").write_text(
            "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - rosbag2_0.mcap\n",
            encoding="utf-8")
        assert convert(ros2, folder / "from_folder").returncode == 0
        check_log(folder / "from_folder", "a folder of ROS 2")
    return 0


if __name__ == "__main__":
    sys.exit(main())
