#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Compares our reading of a CAN database with that of cantools, signal by signal. Skipped (77) without cantools.

Usage: dbc_against_cantools_test.py DBC_VALUES_PROGRAM DBC_FILE
"""
import math
import subprocess
import sys


def main():
    try:
        import cantools
    except ImportError:
        print("SKIPPED: the Python package cantools is not installed (Debian 12 does not have it)")
        return 77
    *program, path = sys.argv[1:]  # the program, after the emulator that runs it if there is one
    database = cantools.database.load_file(path, strict=False)
    output = subprocess.run([*program, path], check=True, capture_output=True, text=True).stdout
    compared = 0
    for line in output.splitlines():
        message, data, signal, value = line.split()
        try:
            decoded = database.get_message_by_name(message).decode(bytes.fromhex(data), decode_choices=False)
        except cantools.database.errors.DecodeError:  # a page of the multiplexer that no signal has
            assert value == "-" or signal in ("Page", "Both"), line
            continue
        if value == "-":
            assert signal not in decoded, line
        else:
            assert math.isclose(decoded[signal], float(value), rel_tol=1e-14, abs_tol=1e-14), (line, decoded[signal])
        compared += 1
    print(f"{compared} values agree with cantools {cantools.__version__}")
    assert compared > 1000
    return 0


if __name__ == "__main__":
    sys.exit(main())
