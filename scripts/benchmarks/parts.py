# SPDX-License-Identifier: BSD-2-Clause
"""Times single parts with the programs of tests/bench, which scripts/build --all puts beside facet."""
import json
import subprocess

from bench.plan import PlanError

PROGRAMS = ["frontend_bench", "window_bench", "mesh_bench"]
REPEAT = 3
US = {"ns": 1e-3, "us": 1.0, "ms": 1e3, "s": 1e6}
HEADS = ["program", "part", "us, of each variant"]


def times_us(bench, program):
    """Least CPU time of each part of a program (us)."""
    path = bench.facet.parent / program
    if not path.is_file():
        raise PlanError(f"{path} is missing: scripts/build release --all")
    command = bench.pinned([str(path), "--benchmark_format=json", f"--benchmark_repetitions={REPEAT}",
                            "--benchmark_min_time=0.1"])
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    if done.returncode != 0:
        raise PlanError(f"{program} ended with exit code {done.returncode}")
    found = {}
    for run in json.loads(done.stdout)["benchmarks"]:
        if run["run_type"] == "iteration":
            us = run["cpu_time"] * US[run["time_unit"]]
            found[run["run_name"]] = min(us, found.get(run["run_name"], us))
    return found


def measure(bench):
    bench.results = {program: times_us(bench, program) for program in PROGRAMS}
    rows = {}
    for program, parts in bench.results.items():
        for part, us in parts.items():
            name, *variant = part.split("/")
            text = f"{us:.3g}" if us < 100 else f"{us:.0f}"
            rows.setdefault((program, name), []).append(f"{' '.join(variant)} ({text})" if variant else text)
    return {"parts": (HEADS, [[*part, ", ".join(texts)] for part, texts in rows.items()], 3)}, []
