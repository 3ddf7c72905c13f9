#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compares our reading of a CAN database with that of canmatrix and cantools, signal by signal.

Usage: dbc_against_readers_test.py DBC_FILE DBC_VALUES_PROGRAM...
Skipped (77) where neither is installed; scripts/setup --npm installs canmatrix.
"""
import math
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from dbc_readers import readers  # noqa: E402


def compare(reader, lines):
    """@return the number of values, and of signals that are not in a frame, that both see alike"""
    values, absent = 0, 0
    for line in lines:
        message, data, signal, ours = line.split()
        theirs = reader.read(message, bytes.fromhex(data))
        if theirs is None:
            continue
        if ours == "-":
            assert signal not in theirs.values, line
            absent += 1
        else:
            value = theirs.values[signal]
            assert math.isclose(value, float(ours), rel_tol=1e-14, abs_tol=1e-14), (line, value)
            values += 1
    return values, absent


def main(path, *program):  # the program comes after the emulator that runs it, if there is one
    there = readers(path)
    if not there:
        print("SKIPPED: neither canmatrix nor cantools is installed")
        return 77
    output = subprocess.run([*program, path], check=True, capture_output=True, text=True).stdout
    for reader in there:
        values, absent = compare(reader, output.splitlines())
        print(f"{values} values and {absent} absences agree with {reader.name}")
        assert values > 1500 and absent > 100
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
