# SPDX-License-Identifier: BSD-2-Clause
"""Statistics of benchmarks: means with confidence intervals, the chi-square band, regressions against a baseline."""
import math
import statistics

from bench.benchmark_lib import number

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


def with_interval(values, digits):
    """`mean [low, high]` of the values."""
    mean, low, high = geometric_mean(values)
    return number(mean, digits) + ("" if low is None else f" [{number(low, digits)}, {number(high, digits)}]")


def quantile(values, share):
    """The least value that this share of all does not exceed."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)] if ordered else None


def chi_square_point(dof, sigmas):
    """Point of the chi-square distribution as far out as `sigmas` of the normal one [Wilson, Hilferty 1931].

    Within 0.3 % for dof >= 30.
    """
    part = 2.0 / (9.0 * dof)
    return dof * (1.0 - part + sigmas * math.sqrt(part)) ** 3


def average_band(dof, runs):
    """Band that holds 95 % of the average NEES of `runs` independent runs of a consistent estimator at one instant."""
    return tuple(chi_square_point(dof * runs, s) / runs for s in (-1.959964, 1.959964))


def check_baseline(errors, baseline, tolerance):
    """Table of ratios against a baseline, and a sentence for each regression.

    `errors` are ATE in m (None: no result) by the name of the flight, SEQUENCE/MODE/CASE/CONDITION. A mode and case is
    worse if its mean error has grown by more than the tolerance and the interval of the ratio excludes 1; with fewer
    than LEAST_PAIRS pairs there is no such judgement. A flight that the baseline has and that now has no result is a
    regression by itself.
    """
    before = baseline["ate_m"]
    table, regressions, groups = [], [], {}
    for name, error in errors.items():
        groups.setdefault(tuple(name.split("/")[1:3]), []).append((name, error))
    for (mode, case), group in groups.items():
        ratios = [error / before[name] for name, error in group if error and before.get(name)]
        ratio, low, _ = geometric_mean(ratios)
        if ratios:
            table.append([mode, case, f"baseline {baseline['commit']}", str(len(ratios)), with_interval(ratios, 3),
                          number(max(ratios), 3)])
        if len(ratios) >= LEAST_PAIRS and ratio > 1 + tolerance and low > 1:
            regressions.append(f"regression: mode {mode}, {case}: error {ratio:.3f} times the baseline's "
                               f"({table[-1][4]}, {len(ratios)} pairs)")
        regressions += [f"regression: {name}: failed, which the baseline did not" for name, error in group
                        if error is None and name in before]
    return table, regressions
