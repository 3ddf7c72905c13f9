#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Exchanges MCAP files with @mcap/core, an implementation by the format's authors. Skipped (77) where node or the
packages are not installed: scripts/setup --npm installs them.

Usage: mcap_peer_test.py NODE_MODULES FACET...
FACET is our program, after the emulator that runs it if there is one.

Files of facet convert are read by @mcap/core with all checksums, and hold what the log's folder holds; our schemas ask
for what Foxglove's ask for. Files that @mcap/core has written of them, with other chunks, compressions and without
indices, give the folder back to the byte.
"""
import filecmp
import hashlib
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
SKIPPED = 77
PACKAGES = ("@mcap/core", "@mcap/support", "@foxglove/schemas")
BEGIN = 1_400_000_000_000_000_000
CAMERAS = ("cam0", "cam1")
FRAMES = 25


def run_node(modules, *arguments):
    environment = {**os.environ, "NODE_PATH": str(modules)}
    return subprocess.run(["node", str(HERE / "mcap_peer.cjs"), *map(str, arguments)], env=environment, check=True,
                          capture_output=True, text=True, timeout=120).stdout


def png(width, height, seed):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + hashlib.shake_128(f"{seed} {v}".encode()).digest(width) for v in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_log(folder):
    """A log of noise images, enough for several chunks."""
    root = folder / "mav0"
    for camera in CAMERAS:
        (root / camera / "data").mkdir(parents=True)
        rows = ["#timestamp [ns],filename"]
        for k in range(FRAMES):
            stamp = BEGIN + k * 50_000_000
            (root / camera / "data" / f"{stamp}.png").write_bytes(png(400, 300, f"{camera} {k}"))
            rows.append(f"{stamp},{stamp}.png")
        (root / camera / "data.csv").write_text("\r\n".join(rows) + "\r\n", encoding="utf-8")
        (root / camera / "sensor.yaml").write_text(f"# of {camera}\nintrinsics: [1, 2, 3, 4]\n", encoding="utf-8")
    imu = [f"{BEGIN + i * 5_000_000},{i / 100:.2f},-1e-05,{i}.0,0.1,0.20,9.81000" for i in range(10 * FRAMES)]
    truth = [f"{BEGIN + i * 5_000_000},{i},0.5,-1,1,0,0,0,7.5,0,0,0,0,0,1e-3,0,0" for i in range(FRAMES)]
    for name, rows in (("imu0", imu), ("state_groundtruth_estimate0", truth)):
        (root / name).mkdir()
        (root / name / "data.csv").write_text("#head\n" + "\n".join(rows) + "\n", encoding="utf-8")


def files_of(folder):
    return sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())


def check_same(a, b, what):
    assert files_of(a) == files_of(b), (what, files_of(a), files_of(b))
    for name in files_of(a):
        assert filecmp.cmp(a / name, b / name, shallow=False), (what, name)


def check_read(log, heard, what):
    """What @mcap/core has found in a file of ours."""
    counts = {f"/{camera}": FRAMES for camera in CAMERAS} | {"/imu0": 10 * FRAMES, "/groundtruth": FRAMES}
    assert heard["done"] and heard["profile"] == "facet", what
    assert {topic: len(found["messages"]) for topic, found in heard["topics"].items()} == counts, what
    statistics, total = heard["statistics"], sum(counts.values())
    assert int(statistics["messageCount"]) == total == heard["records"]["Message"], (what, statistics)
    assert statistics["chunkCount"] == heard["records"]["ChunkIndex"] > 1, (what, statistics)
    assert int(statistics["messageStartTime"]) == BEGIN, what
    assert heard["attachments"] == {
        f"mav0/{camera}/sensor.yaml": hashlib.sha256((log / "mav0" / camera / "sensor.yaml").read_bytes()).hexdigest()
        for camera in CAMERAS}, (what, heard["attachments"])
    for topic, found in heard["topics"].items():
        assert (found["encoding"], found["schemaEncoding"]) == ("json", "jsonschema"), what
        properties = json.loads(found["schemaText"])["properties"]
        for message in found["messages"]:
            stamp = message["content"]["timestamp"]
            assert stamp["sec"] * 10**9 + stamp["nsec"] == int(message["time"]), (what, message)
            assert set(message["content"]) <= set(properties), (what, message)
    for camera in CAMERAS:
        for message in heard["topics"][f"/{camera}"]["messages"]:
            file = log / "mav0" / camera / "data" / f"{message['time']}.png"
            assert message["content"]["data"] == hashlib.sha256(file.read_bytes()).hexdigest(), (what, file)
            assert message["content"]["format"] == "png"
    sample = heard["topics"]["/imu0"]["messages"][7]["content"]
    assert sample["angular_velocity"] == {"x": 0.07, "y": -1e-05, "z": 7}, sample
    assert sample["linear_acceleration"] == {"x": 0.1, "y": 0.2, "z": 9.81}, sample
    pose = heard["topics"]["/groundtruth"]["messages"][3]["content"]
    assert pose["pose"] == {"position": {"x": 3, "y": 0.5, "z": -1},
                            "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}, pose
    assert (pose["velocity"]["x"], pose["accelerometer_bias"]["x"]) == (7.5, 1e-3), pose


def check_schema(ours, theirs, name):
    """Everything that theirs demands is demanded by ours, with the same type."""
    assert ours["type"] == theirs["type"], name
    assert set(theirs.get("required", ())) <= set(ours.get("required", ours["properties"])), name
    for key, value in theirs.get("properties", {}).items():
        mine = ours["properties"][key]
        assert mine["type"] == value["type"], (name, key)
        assert mine.get("contentEncoding") == value.get("contentEncoding"), (name, key)
        assert {k: mine.get(k) for k in ("minimum", "maximum")} == {k: value.get(k) for k in ("minimum", "maximum")}
        if value["type"] == "object":
            check_schema(mine, value, f"{name}.{key}")


def main():
    modules, *program = sys.argv[1:]
    modules = Path(modules)
    if shutil.which("node") is None:
        print("SKIPPED: node is not installed")
        return SKIPPED
    for package in PACKAGES:
        if not (modules / package).is_dir():
            print(f"SKIPPED: {modules}/{package} is missing: scripts/setup --npm installs it")
            return SKIPPED

    def convert(*arguments):
        subprocess.run([*program, "convert", *map(str, arguments), "--quiet"], check=True, capture_output=True)

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        log, ours = folder / "log", folder / "ours.mcap"
        write_log(log)
        for compression in ("none", "lz4", "zstd"):
            convert(log, ours, "--compression", compression)
            heard = json.loads(run_node(modules, "read", ours))
            check_read(log, heard, compression)
        print(f"{int(heard['statistics']['messageCount'])} messages of ours are read by @mcap/core as they were meant")
        for name, schema in json.loads(run_node(modules, "schemas")).items():
            texts = {found["schemaText"] for found in heard["topics"].values() if found["schema"] == name}
            assert len(texts) == 1, (name, texts)
            check_schema(json.loads(texts.pop()), schema, name)
        print("our schemas ask for what Foxglove's ask for")
        for kind in ("zstd", "plain", "bare", "loose"):
            theirs, back = folder / f"{kind}.mcap", folder / kind
            run_node(modules, "write", ours, theirs, kind)
            convert(theirs, back)
            check_same(log, back, kind)
        print("files of @mcap/core, in four kinds, give the folder back to the byte")
    return 0


if __name__ == "__main__":
    sys.exit(main())
