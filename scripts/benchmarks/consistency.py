# SPDX-License-Identifier: BSD-2-Clause
"""The average over all flights of the NEES at each instant, and the share of instants within its band."""
from bench.benchmark_lib import number
from bench.stats import average_band

PARTS = [("pose", 6), ("orientation", 3), ("position", 3), ("velocity", 3)]
STANDS_S = 2.0  # of every flight: a vehicle that stands has no error to speak of
HEADS = ["K", "part", "NEES", "95 % band", "inside %", "above %"]


def averages(tables, part):
    """(average NEES, flights) at each instant in flight. All flights share their stamps, and seconds count from the
    first estimate of any."""
    begin = min((int(table[0]["stamp_ns"]) for table in tables if table), default=0)
    series = {}
    for line in (line for table in tables for line in table):
        seconds = round(1e-9 * (int(line["stamp_ns"]) - begin), 2)  # stamps hold the time offset of their flight
        value = float(line[f"nees_{part}"])
        if value == value and seconds >= STANDS_S:
            series.setdefault(seconds, []).append(value)
    return [(sum(values) / len(values), len(values)) for values in series.values()]


def tables(bench, runs):
    rows = []
    for condition in bench.plan.conditions:
        errors = [run.errors for flight, run in runs.items() if run and flight.condition == condition]
        for part, size in PARTS:
            points = averages(errors, part)
            if not points:
                continue
            bands = [average_band(size, n) for _, n in points]
            inside = sum(low <= value <= high for (value, _), (low, high) in zip(points, bands)) / len(points)
            above = sum(value > high for (value, _), (_, high) in zip(points, bands)) / len(points)
            low, high = average_band(size, max(n for _, n in points))
            rows.append([str(condition), part, f"{number(sum(v for v, _ in points) / len(points), 2)} / {size}",
                         f"{low:.2f} to {high:.2f}", number(100 * inside, 1), number(100 * above, 1)])
    return {"average": (HEADS, rows, 2)}, []
