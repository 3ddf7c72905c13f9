# SPDX-License-Identifier: BSD-2-Clause
"""Logs that end as they began, as facet replay --loops repeats them."""
import csv


def stamps_of(log):
    """Of the left camera's images (ns)."""
    root = log / "mav0" if (log / "mav0").is_dir() else log
    return [int(row[0]) for row in csv.reader((root / "cam0/data.csv").open()) if row and not row[0].startswith("#")]


def period_of(stamps):
    """From a turn to the next (ns): the last image is followed by the first one a frame later."""
    return (stamps[-1] - stamps[0]) // (len(stamps) - 1) * len(stamps)
