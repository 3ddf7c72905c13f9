# SPDX-License-Identifier: BSD-2-Clause
"""facet: stereo visual-inertial estimation with a mesh and its planes, from Python.

    import facet
    flight = facet.Flight("log", mode="spr")
    flight.add_imu(stamp_ns, rate, force)                  # rad/s, m/s^2: one sample or arrays of many
    estimate = flight.add_frame(stamp_ns, left, right)     # grey images of numpy
    estimate.position, estimate.covariance, estimate.health
    flight.mesh().vertices, flight.planes()

Frames and units are those of facet: world W with z up, body B of the inertial sensor, metres, radians, seconds but for
stamps in whole nanoseconds. replay() runs a recorded log, evaluate() compares with the truth. The estimator itself is
the program's: the same log gives the same numbers as `facet replay`.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy

from . import _facet
from ._facet import (
    ErrorStatistics,
    Estimate,
    Evaluation,
    Flight,
    Grid,
    Health,
    ImuSample,
    Log,
    Mesh,
    Plane,
    RangeSample,
    RelativeError,
    StereoFrame,
    __version__,
    simulate,
)

__all__ = [
    "ErrorStatistics",
    "Estimate",
    "Evaluation",
    "Flight",
    "Grid",
    "Health",
    "ImuSample",
    "Log",
    "Mesh",
    "Plane",
    "RangeSample",
    "RelativeError",
    "Replay",
    "StereoFrame",
    "Trajectory",
    "__version__",
    "evaluate",
    "read_trajectory",
    "read_truth",
    "replay",
    "simulate",
]


class Trajectory(NamedTuple):
    """Stamped poses: whole nanoseconds (N,), positions (N, 3) in metres, unit quaternions (N, 4) as x y z w."""

    stamps_ns: numpy.ndarray
    positions: numpy.ndarray
    quaternions: numpy.ndarray

    @classmethod
    def of(cls, estimates):
        """Of the estimates that may be used."""
        usable = [estimate for estimate in estimates if estimate.is_usable]
        return cls(
            numpy.array([estimate.stamp_ns for estimate in usable], dtype=numpy.int64),
            numpy.array([estimate.position for estimate in usable]).reshape(-1, 3),
            numpy.array([estimate.quaternion for estimate in usable]).reshape(-1, 4),
        )

    def save(self, path):
        """Writes TUM text, the same as the program's trajectory.tum."""
        with open(path, "w", encoding="utf-8") as file:
            for stamp_ns, position, quaternion in zip(*self):
                sign, stamp = ("-" if stamp_ns < 0 else ""), abs(int(stamp_ns))
                seconds, nanoseconds = divmod(stamp, 1_000_000_000)
                numbers = " ".join(f"{value:.9f}" for value in (*position, *quaternion))
                file.write(f"{sign}{seconds}.{nanoseconds:09d} {numbers}\n")


def read_trajectory(path):
    """Reads TUM text: seconds, position, quaternion. ValueError with file and line if it is none."""
    return Trajectory(*_facet.read_tum(str(path)))


def read_truth(path):
    """The ground truth of a log's folder, or of its table."""
    return Trajectory(*_facet.read_truth(str(path)))


def evaluate(truth, estimate, rpe_lengths=(1.0, 2.0, 5.0, 10.0)):
    """Errors of an estimate: both a Trajectory, or a path of one; for the truth also a log's folder."""
    if not isinstance(truth, tuple):
        truth = read_trajectory(truth) if str(truth).endswith((".tum", ".txt")) else read_truth(truth)
    if not isinstance(estimate, tuple):
        estimate = read_trajectory(estimate)
    return _facet.evaluate(tuple(truth), tuple(estimate), list(rpe_lengths))


class Replay(NamedTuple):
    """What replay() gives: the flight at its end, and the estimates of all frames."""

    flight: Flight
    estimates: list

    @property
    def trajectory(self):
        """Of the estimates that may be used."""
        return Trajectory.of(self.estimates)


def replay(path, *, start_s=0.0, duration_s=None, calibration=None, on_frame=None, **options):
    """Runs a log through the estimator, as fast as it can.

    options are those of Flight: mode, config, settings, imu_calibration, grid. on_frame(flight, estimate) is called
    after each frame. Readings of a range finder in the log count with settings={"range.enabled": True}.
    """
    named = {} if calibration is None else {"calibration": str(calibration)}
    if "imu_calibration" in options:
        named["imu_calibration"] = str(options["imu_calibration"])
    log = Log(str(path), start_s=start_s, duration_s=duration_s, **named)
    flight = Flight(str(path if calibration is None else calibration), **options)
    estimates = []
    waiting = []  # frames that inertial samples do not reach yet, each with the readings before it
    readings = []

    def offer(is_last_chance):
        while waiting:
            frame, due = waiting[0]
            for reading in due:
                flight.add_range(reading.stamp_ns, reading.point)
            due.clear()
            estimate = flight.add_frame(frame.stamp_ns, frame.left, frame.right)
            if estimate.status == "not ready" and not is_last_chance:
                return
            waiting.pop(0)
            estimates.append(estimate)
            if on_frame is not None:
                on_frame(flight, estimate)

    for sample in log:
        if isinstance(sample, ImuSample):
            flight.add_imu(sample.stamp_ns, sample.rate, sample.force)
        elif isinstance(sample, RangeSample):
            readings.append(sample)
        else:
            waiting.append((sample, readings))
            readings = []
        offer(is_last_chance=len(waiting) > 20)
    offer(is_last_chance=True)
    return Replay(flight, estimates)
