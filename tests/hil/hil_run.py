#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Plays a log through kernel devices into `facet run` in a guest, and compares with `facet replay`; see docs/hil.md.

Exit codes: 0 within the limits, 1 not, 2 bad usage or a guest that did not come to its end, 77 skipped.
"""
import argparse
import json
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import hil_agreement  # noqa: E402
import hil_bring_up  # noqa: E402
import hil_broken_records  # noqa: E402
import hil_document  # noqa: E402
import hil_faults  # noqa: E402
import hil_guest  # noqa: E402
import hil_soak  # noqa: E402
from hil_flight import Hil  # noqa: E402


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    paths = {
        "kernel": "the guest's",
        "facet": "the program under test",
        "inject": "hil_inject",
        "log": "EuRoC/ASL folder",
        "out": "folder for results",
    }
    for name, what in paths.items():
        parser.add_argument(f"--{name}", required=True, help=what)
    parser.add_argument("--sensors", default="icm42688,dronecan",
                        help=f"comma-separated, of {', '.join(hil_guest.SENSORS)}")
    parser.add_argument("--time", choices=("virtual", "real", "both", "none"), default="virtual")
    parser.add_argument("--variants", action="store_true",
                        help="also, with the first sensor, the lines' other backend, recording as MCAP, all formats")
    parser.add_argument("--faults", nargs="?", const="all",
                        help="also the fault table; or only these kinds, with or without their length, "
                        "comma-separated; stopped: the program; sinks_hang: a thread of it")
    parser.add_argument("--records", action="store_true", help="also recordings that are broken off")
    parser.add_argument("--bring-up", action="store_true", help="also the steps of docs/bring_up.md")
    parser.add_argument("--soak", type=float, default=0.0, metavar="MINUTES",
                        help="also a flight of this length; the log must end as it began (facet sim --closed) and is "
                        "repeated without a seam")
    parser.add_argument("--soak-time", choices=("virtual", "real"), default="real")
    parser.add_argument("--soak-one-camera", action="store_true",
                        help="in the soak the left camera is unplugged after ten seconds, exposure is automatic, and "
                        "light goes up and down by a factor of 64 each minute")
    parser.add_argument("--document", type=Path, metavar="FILE", help="puts the tables between their marks there")
    parser.add_argument("--mode", default="spr")
    parser.add_argument("--start", type=float, default=0.0)
    parser.add_argument("--duration", type=float, default=0.0)
    parser.add_argument("--jobs", type=int, default=1, help="guests at a time, of flights in virtual time")
    parser.add_argument("--timeout", type=float, default=900.0, help="of one flight, in the host's seconds")
    return parser.parse_args(arguments)


def chosen_faults(text):
    """@return the faults of sensors, and those of the program"""
    if not text:
        return [], []
    kinds = None if text == "all" else text.split(",")
    faults = [fault for fault in hil_faults.FAULTS if kinds is None or {fault.name, fault.kinds} & set(kinds)]
    restarts = [one for one in hil_faults.RESTARTS if kinds is None or {one.name, one.kind} & set(kinds)]
    return faults, restarts


def main(arguments):
    args = parse(arguments)
    if not set(args.sensors.split(",")) <= set(hil_guest.SENSORS):
        print(f"hil: --sensors: one or more of {', '.join(hil_guest.SENSORS)}", file=sys.stderr)
        return 2
    times = {"virtual": [True], "real": [False], "both": [True, False], "none": []}[args.time]
    try:
        args.timeout = max(args.timeout, hil_soak.limit_s(args.soak, args.soak_time))
        hil = Hil(args)
        hil.out.mkdir(parents=True, exist_ok=True)
        faults, restarts = chosen_faults(args.faults)
        parts = {
            "agreement": lambda: hil_agreement.agreement_rows(hil, hil_agreement.cases_of(args, times)),
            "records": lambda: hil_broken_records.rows(hil) if args.records else [],
            "bring_up": lambda: hil_bring_up.rows(hil) if args.bring_up else [],
            "faults": lambda: hil_faults.fault_rows(hil, faults, restarts) if faults or restarts else [],
            "soak": lambda: hil_soak.rows(hil, args.soak, args.soak_time) if args.soak > 0.0 else [],
        }
        results = {name: [] for name in parts}
        for name, measure in parts.items():
            results[name] = measure()
            (hil.out / "hil.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
            if args.document:
                hil_document.update(args, results)
        return 0 if all(row["good"] for rows in results.values() for row in rows) else 1
    except (hil_guest.GuestError, OSError) as error:
        print(f"hil: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
