#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Inputs for a fuzzer's target without Clang: files of a folder, changed at random, and bytes at random.

Usage: mutate.py INPUTS OUT COUNT [SEED]      the same arguments give the same files
"""
import pathlib
import random
import struct
import sys

LONGEST = 4096
STRANGE = [struct.pack("<d", value) for value in (float("nan"), float("inf"), -0.0, 1e308, 5e-324, 1e9)]
STRANGE += [bytes(n) for n in (1, 4, 8)] + [b"\xff" * n for n in (1, 2, 4, 8)]
STRANGE += [b"\x7f\xff\xff\xff", b"\x00\x00\x00\x80"]


def changed(data, others, dice):
    """One change of some bytes."""
    data = bytearray(data)
    begin = dice.randrange(len(data) + 1)
    end = min(len(data), begin + dice.randrange(1, 33))
    kind = dice.randrange(6)
    if kind == 0 and begin < len(data):
        data[begin] ^= 1 << dice.randrange(8)
    elif kind == 1:
        data[begin:end] = dice.randbytes(end - begin)
    elif kind == 2:
        strange = dice.choice(STRANGE)
        data[begin:begin + len(strange)] = strange
    elif kind == 3:
        del data[begin:end]
    elif kind == 4:
        data[begin:begin] = data[begin:end] * dice.randrange(1, 9)
    else:
        other = dice.choice(others)
        data[begin:] = other[dice.randrange(len(other) + 1):]
    return bytes(data[:LONGEST])


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    inputs, out, count = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), int(sys.argv[3])
    dice = random.Random(int(sys.argv[4]) if len(sys.argv) == 5 else 1)
    seeds = [file.read_bytes()[:LONGEST] for file in sorted(inputs.iterdir())]
    out.mkdir(parents=True, exist_ok=True)
    for i in range(count):
        data = dice.randbytes(dice.randrange(2048)) if i % 4 == 3 else dice.choice(seeds)
        for _ in range(dice.choice((1, 2, 4, 8, 16))):
            data = changed(data, seeds, dice)
        (out / f"{i:06}").write_bytes(data)
    return 0


if __name__ == "__main__":
    sys.exit(main())
