# SPDX-License-Identifier: BSD-2-Clause
"""Statistics of a sweep: means with confidence intervals, comparisons in pairs, regressions against a baseline."""
import math
import statistics

from bench.benchmark_lib import Condition, number

P95 = 0.975  # one side of an interval that holds 95 %
LEAST_PAIRS = 3


def student_point(dof):
    """Point of Student's t distribution with 97.5 % below it.

    Exact for one and two degrees of freedom, otherwise the expansion in 1/dof of Abramowitz and Stegun, Handbook of
    Mathematical Functions (1964), 26.7.5; within 0.5 %.
    """
    if dof == 1:
        return math.tan(math.pi * (P95 - 0.5))
    if dof == 2:
        return (2 * P95 - 1) * math.sqrt(2.0 / (4 * P95 * (1 - P95)))
    x = statistics.NormalDist().inv_cdf(P95)
    terms = [x, (x**3 + x) / 4, (5 * x**5 + 16 * x**3 + 3 * x) / 96, (3 * x**7 + 19 * x**5 + 17 * x**3 - 15 * x) / 384,
             (79 * x**9 + 776 * x**7 + 1482 * x**5 - 1920 * x**3 - 945 * x) / 92160]
    return sum(term / dof**i for i, term in enumerate(terms))


def geometric_mean(values):
    """Geometric mean of positive values with the ends of its 95 % interval, None where there are too few.

    Student's interval of the mean of the logarithms: errors of trajectories spread by factors, not by sums.
    """
    logs = [math.log(value) for value in values if value > 0]
    if not logs:
        return None, None, None
    mean = statistics.fmean(logs)
    if len(logs) < 2:
        return math.exp(mean), None, None
    half = student_point(len(logs) - 1) * statistics.stdev(logs) / math.sqrt(len(logs))
    return math.exp(mean), math.exp(mean - half), math.exp(mean + half)


def with_interval(values, digits, scale=1.0):
    """`mean [low, high]` of the values."""
    mean, low, high = (None if value is None else scale * value for value in geometric_mean(values))
    return number(mean, digits) + ("" if low is None else f" [{number(low, digits)}, {number(high, digits)}]")


def grouped(rows, key):
    """Lists of rows with the same key, in order of first appearance."""
    groups = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups


COLUMNS = ["flight", "conditions K", "mode", "parameters", "runs", "failed", "ATE mm [95 %]", "worst mm", "rot deg",
           "mesh mm", "frame ms"]
LEFT = 4


def table_rows(rows):
    """A row for each flight, condition, mode and set of parameters, over its seeds."""
    table = []
    for (flight, condition, mode, variant), runs in grouped(
            rows, lambda row: (row["flight"], Condition.of(row), row["mode"], row["variant"])).items():
        flown = [run for run in runs if "ate_m" in run]
        middle = {key: statistics.median(values) if values else None for key in ("rotation_deg", "mesh_m", "frame_ms")
                  for values in [[run[key] for run in flown if run[key] is not None]]}
        table.append([flight, str(condition), mode, variant, str(len(runs)),
                      str(sum(bool(run["problem"]) for run in runs)),
                      with_interval([run["ate_m"] for run in flown], 2, 1000.0) if flown else "-",
                      number(max((1000 * run["ate_m"] for run in flown), default=None), 2),
                      number(middle["rotation_deg"], 3),
                      number(None if middle["mesh_m"] is None else 1000 * middle["mesh_m"], 1),
                      number(middle["frame_ms"], 2)])
    return table


RATIO_COLUMNS = ["mode", "parameters", "against", "pairs", "ATE ratio [95 %]", "worst pair"]


def ratio_row(mode, variant, against, pairs):
    """A row of ratios: pairs are errors of the same flight under the same condition and draw, before and after."""
    ratios = [after / before for before, after in pairs if before > 0]
    return [mode, variant, against, str(len(ratios)), with_interval(ratios, 3), number(max(ratios, default=None), 3)]


def comparison_rows(rows):
    """Every mode and set of parameters against the first of the sweep, pair by pair."""
    groups = grouped(rows, lambda row: (row["mode"], row["variant"]))
    drawn = [{(row["flight"], Condition.of(row), row["seed"]): row["ate_m"] for row in group if "ate_m" in row}
             for group in groups.values()]
    names = list(groups)
    return [ratio_row(*names[i], f"{names[0][0]}, {names[0][1]}",
                      [(drawn[0][key], error) for key, error in drawn[i].items() if key in drawn[0]])
            for i in range(1, len(names))]


def make_baseline(rows, commit):
    """What later sweeps are compared with."""
    return {"commit": commit, "ate_m": {row["run"]: row["ate_m"] for row in rows if "ate_m" in row}}


def check_baseline(rows, baseline, tolerance):
    """Table of ratios against a baseline, and a sentence for each regression.

    A mode with its parameters is worse if its mean error has grown by more than the tolerance and the interval of the
    ratio excludes 1; with fewer than LEAST_PAIRS pairs there is no such judgement. A run that the baseline has and that
    now has no result is a regression by itself.
    """
    before = baseline["ate_m"]
    table, regressions = [], []
    for (mode, variant), group in grouped(rows, lambda row: (row["mode"], row["variant"])).items():
        pairs = [(before[row["run"]], row["ate_m"]) for row in group if "ate_m" in row and row["run"] in before]
        if pairs:
            table.append(ratio_row(mode, variant, f"baseline {baseline['commit']}", pairs))
        ratio, low, _ = geometric_mean([after / error for error, after in pairs if error > 0])
        if len(pairs) >= LEAST_PAIRS and ratio > 1 + tolerance and low > 1:
            regressions.append(f"regression: mode {mode}, {variant}: error {ratio:.3f} times the baseline's "
                               f"({table[-1][4]}, {len(pairs)} pairs)")
        regressions += [f"regression: {row['run']}: failed, which the baseline did not: {row['problem']}"
                        for row in group if "ate_m" not in row and row["run"] in before]
    return table, regressions
