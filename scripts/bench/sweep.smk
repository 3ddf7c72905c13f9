# SPDX-License-Identifier: BSD-2-Clause
# The job graph of scripts/sweep, for Snakemake: flights are rendered, then every run is flown. The runs are in the
# sweep's file; what else is needed comes as config: sweep (that file), out, facet.
import pathlib
import shlex
import sys

SCRIPTS = pathlib.Path(workflow.basedir).parent
sys.path.insert(0, str(SCRIPTS))

from bench.sweep_plan import Plan

PLAN = Plan(config["sweep"], config["out"], config["facet"])
SIMULATED = [name for name, flight in PLAN.flights.items() if flight.simulate]
JOB = (f"PYTHONPATH={shlex.quote(str(SCRIPTS))} {shlex.quote(sys.executable)} -m bench.sweep_job "
       + " ".join(shlex.quote(config[key]) for key in ("sweep", "out", "facet")))


def log_of(wildcards):
    """What must be there before a run flies."""
    name = PLAN.runs[wildcards.run].flight
    flight = PLAN.flights[name]
    if flight.simulate:
        return f"flights/{name}.complete"
    root = pathlib.Path(flight.log)
    return str((root if (root / "cam0").is_dir() else root / "mav0") / "cam0/data.csv")


rule all:
    input:
        expand("runs/{run}/row.json", run=PLAN.runs),


rule simulate:
    output:
        "flights/{flight}.complete",
    wildcard_constraints:
        flight="|".join(SIMULATED) or "none",
    threads: workflow.cores
    shell:
        JOB + " simulate {wildcards.flight:q}"


rule fly:
    input:
        log_of,
    output:
        "runs/{run}/row.json",
    shell:
        JOB + " fly {wildcards.run:q}"
