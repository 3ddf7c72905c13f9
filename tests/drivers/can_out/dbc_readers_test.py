#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Reads our frames as other people do, by canmatrix and by cantools with facet.dbc, and compares with what went in.

Usage: dbc_readers_test.py FACET_DBC CAN_OUT_FRAMES_PROGRAM...
Skipped (77) where neither is installed; scripts/setup --npm installs canmatrix.
"""
import importlib.util
import os
import subprocess
import sys
import warnings

SYSTEM_PYTHON = "/usr/bin/python3"  # the one that Debian's packages are for
READERS = ("canmatrix", "cantools")


def canmatrix_reader(path):
    """A function that gives name, is_fd and {signal: (value, step)} of a frame."""
    warnings.simplefilter("ignore")
    import canmatrix.formats

    frames = {frame.arbitration_id.id: frame for frame in canmatrix.formats.loadp_flat(path).frames}

    def read(identifier, data):
        frame = frames[identifier]
        assert frame.size == len(data), (frame.name, frame.size, len(data))
        values = {name: (float(value.phys_value), float(value.signal.factor))
                  for name, value in frame.decode(data).items()}
        return frame.name, frame.is_fd, values

    return read


def cantools_reader(path):
    import cantools

    database = cantools.database.load_file(path)

    def read(identifier, data):
        message = database.get_message_by_frame_id(identifier)
        assert message.length == len(data)
        decoded = message.decode(data, decode_choices=False)
        return message.name, message.is_fd, {signal.name: (float(decoded[signal.name]), float(signal.scale))
                                             for signal in message.signals}

    return read


def compare(read, output):
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
            name, is_fd, values = read(int(fields[0]), bytes.fromhex(fields[3]))
            assert is_fd == (fields[2] == "1"), name
            names.add(name)
            for signal, (value, step) in values.items():
                assert abs(value - expected[signal]) <= 0.5001 * step, (name, signal, value, expected[signal])
                compared += 1
        last = kind
    assert len(names) == 11, names
    return compared


def main():
    there = [name for name in READERS if importlib.util.find_spec(name)]
    if not there:
        if os.path.exists(SYSTEM_PYTHON) and not os.path.samefile(sys.executable, SYSTEM_PYTHON) \
                and "FACET_TRIED" not in os.environ:
            os.environ["FACET_TRIED"] = "1"
            os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])
        print("SKIPPED: neither canmatrix nor cantools is installed")
        return 77
    path, *program = sys.argv[1:]
    output = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    for name in there:
        read = canmatrix_reader(path) if name == "canmatrix" else cantools_reader(path)
        compared = compare(read, output)
        print(f"{compared} values agree with {name}")
        assert compared > 5000
    return 0


if __name__ == "__main__":
    sys.exit(main())
