# SPDX-License-Identifier: BSD-2-Clause
"""The steps of docs/bring_up.md that virtual hardware can take: dry run, also of devices that fail, and recording."""
from dataclasses import dataclass

import hil_guest

VEHICLE = ("--config", "/run/share/vehicle.yaml")
FOR_EVER = "@0+1000"


@dataclass
class Step:
    name: str
    command: tuple
    says: tuple  # what its output has to hold
    exit_code: int = 0
    faults: tuple = ()


STEPS = (
    Step("check_config", ("check-config", "/run/share/vehicle.yaml"), ("can be used",)),
    Step("dry_run", ("run", *VEHICLE, "--dry-run"),
         ("ok        left camera:", "ok        right camera:", "ok        trigger:", "ok        imu:",
          "mean specific force")),
    # The left camera has sent the frames ahead of the log.
    Step("dry_run_cameras_silent", ("run", *VEHICLE, "--dry-run"),
         ("WRONG     left camera:  /dev/video40: no data for 500 ms",
          "WRONG     right camera: opens, but delivers nothing", "ok        imu:"), 2, (f"both_dropped{FOR_EVER}",)),
    Step("dry_run_trigger_dead", ("run", *VEHICLE, "--dry-run"),
         ("ok        left camera:", "WRONG     trigger:      opens, but delivers nothing"), 2,
         (f"edges_lost{FOR_EVER}",)),
    Step("dry_run_imu_silent", ("run", *VEHICLE, "--dry-run"),
         ("WRONG     imu:          opens, but delivers nothing",), 2, (f"imu_silent{FOR_EVER}",)),
    Step("record", ("record", *VEHICLE, "--out", "/run/share/motion", "--duration", "8"), ()),
)  # fmt: skip


def rows(hil):
    results = [row_of(hil, step) for step in STEPS]
    results.append(checked_calibration(hil))
    return results


def row_of(hil, step):
    job = hil_guest.Job(log=hil.log, folder=hil.out / f"bring_up_{step.name}", command=step.command,
                        faults=list(step.faults), timeout_s=hil.args.timeout)  # fmt: skip
    report = hil_guest.fly(hil.programs, job)
    said = (job.folder / "run.log").read_text(encoding="utf-8", errors="replace")
    missing = [words for words in step.says if words not in said]
    row = {"name": step.name, "exit_code": report["exit_code"], "said": said, "missing": missing}
    row["good"] = not missing and report["exit_code"] == step.exit_code
    show(row)
    return row


def checked_calibration(hil):
    """What was recorded in the guest, judged outside."""
    row = {"name": "check_calibration", "missing": [], "exit_code": 0, "said": "", "good": True}
    try:
        hil.call(hil.programs.facet, "check-calibration", hil.out / "bring_up_record/motion")
    except hil_guest.GuestError as error:
        row.update(said=str(error), exit_code=1, good=False)
    show(row)
    return row


def show(row):
    print(f"  {row['name']}: exit code {row['exit_code']}{'' if row['good'] else '   NOT AS docs/bring_up.md SAYS'}")
    for words in row["missing"]:
        print(f"    not said: {words}")
    if not row["good"]:
        print("    " + row["said"].replace("\n", "\n    "), flush=True)
