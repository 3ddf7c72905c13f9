#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""The demo in Python: simulates a flight, estimates it in both modes, compares with the truth (scripts/demo: a report).

Usage: python3 example.py [FOLDER] [--duration S]   with PYTHONPATH=build/python/python if it is not installed
"""
import argparse
from pathlib import Path

import facet

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", nargs="?", type=Path, default=Path("out/demo_python"))
parser.add_argument("--duration", type=float, default=30.0, help="of the flight (s)")
args = parser.parse_args()

log = args.folder / "room"
if not (log / "mav0").is_dir():
    facet.simulate(str(log), scene="room", seed=1, duration_s=args.duration, calibration_error=1)
for mode in ("s", "spr"):
    run = facet.replay(log, mode=mode)
    run.trajectory.save(args.folder / f"{mode}.tum")
    errors = facet.evaluate(log, run.trajectory)
    mesh = run.flight.mesh()
    last = run.estimates[-1]
    print(f"mode {mode:3}  {last.health.state} at the end, {errors.path:.1f} m: "
          f"ATE {100 * errors.ate.rmse:.2f} cm, {errors.ate_rotation_deg.rmse:.2f} deg")
    print(f"          sigma of the position {100 * last.covariance.diagonal()[3:6].max() ** 0.5:.1f} cm; "
          f"mesh of {len(mesh.vertices)} vertices and {len(mesh.faces)} faces, {len(run.flight.planes())} planes")
