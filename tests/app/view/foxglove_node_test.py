#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Foxglove's own client (npm's @foxglove/ws-protocol) connects to the live view of a replay: it lists the channels,
whose schemas are those that Foxglove publishes (@foxglove/schemas), and what it receives is what the replay has written
into its files. So is what @mcap/core reads in the file that the replay has written for Foxglove. Skipped (77) where
node or a package is not installed: scripts/setup --npm installs them.

Usage: foxglove_node_test.py NODE_MODULES FACET...     the program, after the emulator that runs it if there is one
"""
import base64
import csv
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
SKIPPED = 77
TOPICS = {"/pose", "/path", "/tf", "/mesh", "/planes", "/image", "/health", "/calibration", "/timing"}
PACKAGES = ("@foxglove/ws-protocol", "@foxglove/schemas", "@mcap/core", "@mcap/support", "ws")
MCAP_PEER = HERE.parent / "lab/convert/mcap_peer.cjs"


def node(modules, *arguments, **options):
    environment = {**os.environ, "NODE_PATH": str(modules)}
    return subprocess.Popen(["node", str(HERE / "foxglove_node.cjs"), *arguments], env=environment, text=True,
                            stdout=subprocess.PIPE, **options)


def without_words(schema):
    """A schema without what is for people only."""
    if isinstance(schema, list):
        return [without_words(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {name: without_words(part) for name, part in schema.items()
            if name not in ("$comment", "description") or isinstance(part, dict)}


def check_schemas(modules, channels):
    published = json.loads(node(modules, "schemas").communicate(timeout=60)[0])
    compared = set()
    for channel in channels:
        assert (channel["encoding"], channel["schemaEncoding"]) == ("json", "jsonschema"), channel
        room, name = channel["schemaName"].split(".")
        if room == "foxglove":
            ours, theirs = without_words(json.loads(channel["schema"])), without_words(published[name])
            assert ours == theirs, (name, ours, theirs)
            compared.add(name)
    assert compared == {"PoseInFrame", "PosesInFrame", "FrameTransform", "SceneUpdate", "CompressedImage"}, compared
    print(f"{len(compared)} schemas are those that Foxglove publishes")


def decode_png(file):
    """Width, height and rows of an 8-bit grey PNG; rows filtered by none, the left pixel, its mean with the upper."""
    assert file[:8] == b"\x89PNG\r\n\x1a\n"
    at, data, size = 8, b"", None
    while at < len(file):
        length, kind = struct.unpack(">I4s", file[at:at + 8])
        body = file[at + 8:at + 8 + length]
        assert struct.unpack(">I", file[at + 8 + length:at + 12 + length])[0] == zlib.crc32(kind + body)
        size = struct.unpack(">IIBB", body[:10]) if kind == b"IHDR" else size
        data += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height, depth, colour = size
    assert (depth, colour) == (8, 0), size
    pixels = zlib.decompress(data)
    assert len(pixels) == height * (width + 1)
    rows = []
    for v in range(height):
        kind, row = pixels[v * (width + 1)], bytearray(pixels[v * (width + 1) + 1:(v + 1) * (width + 1)])
        assert kind in (0, 1, 3), kind
        above = rows[-1] if rows and kind == 3 else bytes(width)
        for u in range(width if kind != 0 else 0):
            left = row[u - 1] if u > 0 else 0
            row[u] = (row[u] + (left if kind == 1 else (left + above[u]) // 2)) % 256
        rows.append(row)
    return width, height, rows


def read_trajectory(path):
    """Poses by stamp in ns: position and quaternion x y z w."""
    poses = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        seconds, *values = line.split()
        whole, rest = seconds.split(".")
        poses[int(whole) * 10**9 + int(rest.ljust(9, "0"))] = [float(value) for value in values]
    return poses


def stamp_of(data):
    return data["timestamp"]["sec"] * 10**9 + data["timestamp"]["nsec"]


def numbers_of(place, turn):
    return [place[axis] for axis in "xyz"] + [turn[axis] for axis in "xyzw"]


def check_poses(heard, trajectory):
    for topic, parts in (("/pose", lambda data: (data["pose"]["position"], data["pose"]["orientation"])),
                         ("/tf", lambda data: (data["translation"], data["rotation"]))):
        count = 0
        for time, data in heard[topic]:
            assert time == stamp_of(data), (topic, time, data)
            if topic == "/tf" and data["parent_frame_id"] != "world":
                assert (data["parent_frame_id"], data["child_frame_id"]) == ("body", "camera"), data
                continue
            expected = trajectory[time]
            assert max(abs(a - b) for a, b in zip(numbers_of(*parts(data)), expected)) < 1e-9, (data, expected)
            count += 1
        assert count > 60, (topic, count)
        print(f"{count} poses of {topic} are those of trajectory.tum, to its nine digits")


def check_scenes(heard):
    _, mesh = heard["/mesh"][-1]
    lists = mesh["entities"][0]["triangles"]
    corners = sum(len(triangles["points"]) for triangles in lists)
    assert corners % 3 == 0 and corners > 300 and len(heard["/mesh"]) > 3, corners
    planes = [update["entities"][0] for _, update in heard["/planes"]]
    assert any(len(entity["triangles"]) == len(entity["texts"]) > 0 for entity in planes)
    print(f"{len(heard['/mesh'])} meshes, the last one of {corners // 3} triangles on {len(lists)} colours")


def check_image(heard):
    _, image = heard["/image"][-1]
    assert image["format"] == "png" and image["frame_id"] == "camera"
    width, height, rows = decode_png(base64.b64decode(image["data"], validate=True))
    assert (width, height) == (376, 240), (width, height)
    levels = {value for row in rows for value in row}
    assert len(levels) > 100, "the image is blank"
    print(f"{len(heard['/image'])} images, the last one of {width} x {height} pixels with {len(levels)} levels")


def read_rows(path):
    """Rows of a table by the time of a message: within half a frame, as an estimate's stamp has the time offset."""
    with open(path, encoding="utf-8") as file:
        rows = {int(row.pop("stamp_ns")): row for row in csv.DictReader(file)}

    def row_at(time):
        nearest = min(rows, key=lambda stamp: abs(stamp - time))
        assert abs(nearest - time) < 20e6, (time, nearest)
        return rows[nearest]
    return row_at


def check_tables(heard, out):
    for topic, fields in (("/health", ("state", "tracked", "quality")),
                          ("/timing", ("total_cpu_ms", "tracking_cpu_ms")),
                          ("/calibration", ("time_offset", "left_fx", "left_fx_sigma", "right_d1"))):
        row_at = read_rows(out / f"{topic[1:]}.csv")
        for time, data in heard[topic]:
            row = row_at(time)
            assert set(row) == set(data) - {"timestamp"}, (topic, set(row) ^ set(data))
            for field in fields:
                same = data[field] == row[field] if isinstance(data[field], str) else (
                    abs(data[field] - float(row[field])) <= 5e-3 * abs(data[field]) + 1e-3 * (topic == "/timing"))
                assert same, (topic, field, data[field], row[field])
        assert len(heard[topic]) > (3 if topic == "/calibration" else 60), topic
        print(f"{len(heard[topic])} messages of {topic} are rows of {topic[1:]}.csv")


def listen_to_replay(modules, program, folder):
    """What the client hears of a replay in real time, line by line, and the replay's results."""
    simulate = ["sim", "--scene", "room", "--out", folder / "log", "--duration", "7", "--samples", "1", "--stand", "1"]
    subprocess.run([*program, *simulate], check=True, capture_output=True)
    replay = [*program, "replay", folder / "log", "--out", folder / "out", "--quiet", "--realtime", "--log-calibration",
              "--view", "0", "--mcap", folder / "estimates.mcap"]
    with subprocess.Popen(replay, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as flight:
        address = re.search(r"http(://127\.0\.0\.1:\d+/)", flight.stderr.readline()).group(1)
        with node(modules, f"ws{address}") as client:
            heard, _ = client.communicate(timeout=120)
        said, _ = flight.communicate(timeout=60)
        assert flight.returncode == 0, said
    print(said)
    assert "1 of Foxglove" in said
    return [json.loads(line) for line in heard.splitlines()]


def check_file(modules, folder):
    """What @mcap/core reads, with all checksums, is what the client has heard."""
    environment = {**os.environ, "NODE_PATH": str(modules)}
    read = json.loads(subprocess.run(["node", MCAP_PEER, "read", folder / "estimates.mcap"], env=environment,
                                     check=True, capture_output=True, text=True, timeout=120).stdout)
    assert read["done"] and set(read["topics"]) == TOPICS, set(read["topics"]) ^ TOPICS
    check_schemas(modules, [{"encoding": topic["encoding"], "schemaEncoding": topic["schemaEncoding"],
                             "schemaName": topic["schema"], "schema": topic["schemaText"]}
                            for topic in read["topics"].values()])
    heard = {name: [(int(message["time"]), message["content"]) for message in topic["messages"]]
             for name, topic in read["topics"].items()}
    trajectory = read_trajectory(folder / "out/trajectory.tum")
    check_poses(heard, trajectory)
    check_scenes(heard)
    check_tables(heard, folder / "out")
    assert len(heard["/pose"]) == len(trajectory) and len(heard["/image"]) > 3 and len(heard["/path"]) > 3
    assert all(len(image["data"]) == 64 for _, image in heard["/image"])  # a checksum of the picture


def check_replay(modules, program):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines = listen_to_replay(modules, program, folder)
        assert not [line for line in lines if "error" in line], [line for line in lines if "error" in line]
        assert lines[0] == {"protocol": "foxglove.websocket.v1"}, lines[0]
        info = next(line["info"] for line in lines if "info" in line)
        assert (info["name"], info["capabilities"]) == ("facet", ["time"]), info
        channels = next(line["channels"] for line in lines if "channels" in line)
        assert {channel["topic"] for channel in channels} == TOPICS
        check_schemas(modules, channels)
        heard = {topic: [] for topic in TOPICS}
        for line in lines:
            if "topic" in line:
                heard[line["topic"]].append((int(line["time"]), line["data"]))
        times = [int(line["now"]) for line in lines if "now" in line]
        assert times == sorted(times) and len(times) > 60
        check_poses(heard, read_trajectory(folder / "out/trajectory.tum"))
        check_scenes(heard)
        check_image(heard)
        check_tables(heard, folder / "out")
        assert len(heard["/path"][-1][1]["poses"]) >= len(heard["/path"]) > 3
        check_file(modules, folder)


def main():
    modules, program = Path(sys.argv[1]), sys.argv[2:]
    if shutil.which("node") is None:
        print("SKIPPED: node is not installed")
        return SKIPPED
    for package in PACKAGES:
        if not (modules / package).is_dir():
            print(f"SKIPPED: {modules}/{package} is missing: scripts/setup --npm installs it")
            return SKIPPED
    check_replay(modules, program)
    return 0


if __name__ == "__main__":
    sys.exit(main())
