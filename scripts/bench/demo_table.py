#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Prints the figures of one run as a short table.

Usage: demo_table.py MODE EVAL.json SUMMARY.json      (written by `facet eval --json` and `facet replay`)
"""
import json
import sys
from pathlib import Path


def field(tree, *keys):
    for key in keys:
        if not isinstance(tree, dict) or tree.get(key) is None:
            return None
        tree = tree[key]
    return tree


def row(name, text, *values):
    shown = "not available" if any(value is None for value in values) else text.format(*values)
    print(f"  {name:<34}{shown}")


def main():
    if len(sys.argv) != 4 or sys.argv[1].startswith("-"):
        print(__doc__)
        return 0 if "--help" in sys.argv or "-h" in sys.argv else 2
    evaluation, summary = (json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[2:])
    print(f"Result in mode {sys.argv[1]}")
    row("path", "{:.2f} m in {:.1f} s", field(evaluation, "path_m"), field(evaluation, "duration_s"))
    coverage = field(evaluation, "coverage", "time")
    row("time covered", "{:.1f} %", None if coverage is None else 100.0 * coverage)
    row("frames, keyframes", "{}, {}", field(summary, "frames"), field(summary, "keyframes"))
    for key, name in (("ate_se3", "SE(3)"), ("ate_yaw4", "yaw + translation")):
        translation = field(evaluation, key, "translation_m")
        row(
            f"ATE, aligned by {name}",
            "RMSE {:.4f} m, median {:.4f} m, max {:.4f} m",
            field(translation, "rmse"),
            field(translation, "median"),
            field(translation, "max"),
        )
    row("drift at the end", "{:.3f} % of the path", field(evaluation, "end_drift_percent"))
    accuracy = field(evaluation, "mesh", "by_trajectory", "accuracy_m")
    row("mesh to the true surface", "median {:.4f} m, 90 % within {:.3f} m", field(accuracy, "median"),
        field(accuracy, "p90"))
    planes = field(evaluation, "planes")
    row("planes", "{} found, {} of them correct; {} of {} true ones found", field(planes, "found"),
        field(planes, "right"), field(planes, "wanted_found"), field(planes, "wanted"))
    timing = field(summary, "timing", "processor", "all")
    row("CPU time per frame", "mean {:.1f} ms, p99 {:.1f} ms", field(timing, "mean"), field(timing, "p99"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
