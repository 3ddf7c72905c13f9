# SPDX-License-Identifier: BSD-2-Clause
"""Rotations of vectors."""


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotated(q, v):
    """Vector v turned by the unit quaternion q = (w, x, y, z)."""
    t = [2 * x for x in cross(q[1:], v)]
    return [x + q[0] * y + z for x, y, z in zip(v, t, cross(q[1:], t))]
