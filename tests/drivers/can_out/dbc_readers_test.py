#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Reads our frames as other people do, by canmatrix and by cantools with facet.dbc, and compares with what went in.

Usage: dbc_readers_test.py FACET_DBC CAN_OUT_FRAMES_PROGRAM...
Skipped (77) where neither is installed; scripts/setup --npm installs canmatrix.
"""
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from dbc_readers import readers  # noqa: E402


def compare(reader, output):
    """How many values agree to half a step of their signal."""
    compared = 0
    names = set()
    expected = {}
    last = ""
    for line in output.splitlines():
        kind, *fields = line.split()
        if kind == "expect":
            expected = {} if last == "frame" else expected
            expected[fields[0]] = float(fields[1])
        else:
            frame = reader.read(int(fields[0]), bytes.fromhex(fields[3]))
            assert frame.is_fd == (fields[2] == "1"), frame.name
            names.add(frame.name)
            for signal, value in frame.values.items():
                assert abs(value - expected[signal]) <= 0.5001 * frame.steps[signal], (frame.name, signal, value)
                compared += 1
        last = kind
    assert len(names) == 11, names
    return compared


def main(path, *program):
    there = readers(path)
    if not there:
        print("SKIPPED: neither canmatrix nor cantools is installed")
        return 77
    output = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    for reader in there:
        compared = compare(reader, output)
        print(f"{compared} values agree with {reader.name}")
        assert compared > 5000
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
