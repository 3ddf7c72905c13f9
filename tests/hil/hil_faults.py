# SPDX-License-Identifier: BSD-2-Clause
"""Flights with faults: how each showed, how long it took to get over it, and what it cost."""
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import hil_compare

BEGIN_S = 4.0
FOR_EVER_S = 1000.0
MAX_RECOVERY_S = 0.5
WATCHDOG_S = 0.5
UNIT_WATCHDOG_S = 10.0  # of app/packaging/facet.service
WANTED_GREY = 90.0  # the median that automatic exposure brings images to,
MOST_BRIGHT = 240.0  # unless that would take the brightest 2 % beyond this


@dataclass
class Fault:
    sensor: str
    kinds: str  # of tests/hil/inject/fault_plan.h, with + between them
    length_s: float
    words: str
    ends: str = "TRACKING"  # the state of the last frame
    reason: str = ""  # which has to be given
    # Longer where docs/hil.md says why.
    max_recovery_s: float = MAX_RECOVERY_S
    light: float = 0.0  # 1: exposure and gain are the program's
    lit_camera: int = 0  # whose images have to be bright in the end, then

    @property
    def name(self):
        return self.kinds + ("_for_ever" if self.is_for_ever else f"_{self.length_s}" if self.length_s else "")

    @property
    def is_for_ever(self):
        return self.length_s == FOR_EVER_S


FAULTS = (
    Fault("icm42688", "both_dropped", 0.5, "both cameras' frames lost"),
    Fault("icm42688", "left_dropped", 0.5, "left frames lost"),
    Fault("icm42688", "right_dropped", 0.5, "right frames lost"),
    Fault("icm42688", "torn", 0.25, "left frames torn, unflagged"),
    Fault("icm42688", "short_frames", 0.25, "left frames short"),
    Fault("icm42688", "flagged_frames", 0.25, "left frames flagged as bad"),
    Fault("icm42688", "flagged_frames", 2.0, "left frames flagged as bad, for long"),
    Fault("icm42688", "left_ahead", 0.05, "a left frame stamped an hour ahead"),
    Fault("icm42688", "left_ahead", 2.0, "left frames stamped an hour ahead"),
    Fault("icm42688", "unplugged", 1.0, "left camera unplugged"),
    Fault("icm42688", "unplugged+dim", FOR_EVER_S, "left camera unplugged, light falls to a tenth, automatic exposure",
          "DEGRADED", "one_camera", light=1.0, lit_camera=1),
    Fault("icm42688", "right_dropped+dim", FOR_EVER_S,
          "right camera silent, light falls to a tenth, automatic exposure", "DEGRADED", "one_camera", light=1.0),
    Fault("icm42688", "right_stalled", 1.0, "right camera stalls"),
    Fault("icm42688", "right_stalled", FOR_EVER_S, "right camera stalls", "DEGRADED", "one_camera"),
    Fault("icm42688", "left_dropped", FOR_EVER_S, "left camera silent", "DEGRADED", "one_camera"),
    Fault("icm42688", "both_dropped", FOR_EVER_S, "both cameras silent", "LOST", "no_images"),
    Fault("icm42688", "edges_lost", 0.15, "3 trigger edges vanish"),
    Fault("icm42688", "edges_extra", 0.15, "3 trigger edges too many"),
    Fault("icm42688", "edges_lost", 2.0, "trigger wire dead", reason="trigger_silent"),
    Fault("icm42688", "edges_lost", FOR_EVER_S, "trigger wire dead", "DEGRADED", "trigger_silent"),
    Fault("icm42688", "edges_lost+right_late", 2.0, "trigger wire dead, right camera 20 ms later",
          reason="trigger_silent"),
    Fault("icm42688", "edges_lost+right_late", FOR_EVER_S, "trigger wire dead, right camera 20 ms later", "DEGRADED",
          "trigger_silent"),
    Fault("icm42688", "imu_silent", 0.3, "silent"),
    Fault("icm42688", "imu_silent", FOR_EVER_S, "silent", "LOST", "imu_gap"),
    Fault("icm42688", "imu_damaged", 0.5, "every second packet damaged"),
    Fault("icm42688", "imu_dead", 0.5, "data line dead"),
    Fault("icm42688", "imu_brown_out", 0.2, "brown-out: back with registers as after power-on"),
    Fault("icm42688", "ready_merged", 1.0, "every second data-ready edge merged with the next"),
    Fault("adis16475", "imu_damaged", 0.5, "every second checksum wrong"),
    Fault("adis16475", "ready_merged", 0.5, "every second data-ready edge merged with the next"),
    Fault("bmi088", "imu_silent", 0.3, "silent"),
    Fault("bmi088", "imu_dead", 0.5, "data lines dead"),
    Fault("bmi088", "imu_brown_out", 0.2, "brown-out: back with registers as after power-on"),
    Fault("dronecan", "imu_silent", 0.3, "silent"),
    Fault("dronecan", "imu_silent", FOR_EVER_S, "silent", "LOST", "imu_gap"),
    Fault("dronecan", "can_loss", 0.5, "a third of the frames lost in bursts of ten"),
    Fault("dronecan", "bus_off", 0.5, "bus-off"),
    Fault("dronecan", "can_down", 0.5, "interface down and up"),
    Fault("dronecan", "clock_30s", 0.0, "wall clock set 30 s on"),
    Fault("dronecan", "clock_1h", 0.0, "wall clock set an hour on"),
    Fault("dronecan", "clock_back_10s", 0.0, "wall clock set back by 10 s"),
    Fault("iio", "imu_silent", 0.3, "silent"),
    Fault("iio", "imu_unplugged", 0.5, "unplugged, as after power-on when it comes back"),
    Fault("iio", "imu_unplugged", FOR_EVER_S, "unplugged", "LOST", "imu_gap"),
    Fault("iio", "clock_1h", 0.0, "wall clock set an hour on"),
)


@dataclass
class Restart:
    """The program hangs, or a thread of it, and is started again at once."""

    kind: str
    words: str
    also: str = ""  # another fault from then on
    ends: str = "TRACKING"
    watchdog_s: float = WATCHDOG_S
    max_recovery_s: float = MAX_RECOVERY_S
    sensor: str = "icm42688"

    @property
    def name(self):
        return self.kind + (f"_{self.also}" if self.also else "")


RESTARTS = (
    Restart("stopped", "the program hangs; the watchdog restarts it"),
    Restart("stopped", "the program hangs; the watchdog restarts it, the trigger is gone", "edges_lost", "DEGRADED"),
    # One camera tells its scale, and with it velocity, by motion only.
    Restart("stopped", "the program hangs; the watchdog restarts it, the left camera is gone", "unplugged", "DEGRADED",
            max_recovery_s=2.5),
    Restart("sinks_hang", "the thread of the sinks hangs; the program names it and ends, and is started again",
            watchdog_s=UNIT_WATCHDOG_S),
    # Nobody has stopped the kernel's buffer.
    Restart("stopped", "the program hangs; the watchdog restarts it", sensor="iio"),
)


def is_well_lit(grey):
    """Within a factor of two of what is wanted; or as bright as the brightest 2 % of the pixels allow."""
    median, bright = grey
    return median <= WANTED_GREY * 2 and (median >= WANTED_GREY / 2 or bright >= MOST_BRIGHT / 2)


def count_findings(summary):
    live = summary["live"]
    found = {name: count for name, count in live["synchroniser"].items() if count > 0}
    for source, counters in live["sources"].items():
        found.update({f"{source} {name}": count for name, count in counters.items()
                      if name != "delivered" and count > 0})  # fmt: skip
    return found


def fault_row(hil, fault, plain):
    flight = hil.fly(fault.sensor, f"{fault.sensor}_{fault.name}",
                     faults=[f"{kind}@{BEGIN_S}+{fault.length_s}" for kind in fault.kinds.split("+")],
                     light=fault.light)  # fmt: skip
    begin_ns = flight["report"]["first_frame_ns"] + round(BEGIN_S * hil_compare.NANO)
    end_ns = begin_ns + round(fault.length_s * hil_compare.NANO)
    found, usual = count_findings(flight["summary"]), count_findings(plain["summary"])
    row = {
        "sensor": fault.sensor, "fault": fault.name, "length_s": fault.length_s, "words": fault.words,
        **hil_compare.recovery(flight["health"], plain["health"], begin_ns, end_ns),
        # The sensors stop a moment before the program, which then knows of silent ones.
        "ends": flight["summary"]["final"]["state"] if fault.is_for_ever else flight["health"][-1][1],
        "ate_mm": hil.ate(flight["poses"], flight["name"]), "ate_plain_mm": plain["ate_mm"],
        "found": {key: count for key, count in found.items() if count != usual.get(key)},
        "exit_code": flight["report"]["exit_code"],
    }  # fmt: skip
    if fault.reason and fault.reason not in row["reasons"]:
        # Without readings no frame is complete: only the end of the flight tells.
        row["reasons"] += [why for why in flight["summary"]["final"]["reasons"].split("|")
                           if why and why not in row["reasons"]]  # fmt: skip
    is_lit = True
    if fault.light:
        grey = flight["report"]["greys"][-2][fault.lit_camera]  # the last second may have ended early
        row["found"]["median of the living camera's images"] = grey[0]
        is_lit = is_well_lit(grey)
    row["good"] = (
        is_lit and row["ends"] == fault.ends and fault.reason in row["reasons"] + [""]
        and (fault.is_for_ever or (row["exit_code"] == 0 and row["recovery_s"] <= fault.max_recovery_s))
    )  # fmt: skip
    return row


def restart_row(hil, restart, plain):
    """The program, or a thread of it, hangs, and its service manager starts it again."""
    faults = [f"{restart.kind}@{BEGIN_S}+0"]
    faults += [f"{restart.also}@{BEGIN_S}+{FOR_EVER_S}"] if restart.also else []
    flight_name = f"{restart.sensor}_restart_{restart.name}"
    job, report = hil.play(restart.sensor, flight_name, faults=faults, watchdog_s=restart.watchdog_s)
    folders = sorted((job.folder / "flights").glob("flight_*"))
    flights = [hil.flight_in(folder, f"{flight_name}_{i}", report) for i, folder in enumerate(folders)]
    row = {"sensor": restart.sensor, "fault": restart.name, "exit_code": report["exit_code"],
           "words": restart.words, "ate_plain_mm": plain["ate_mm"], "length_s": math.nan,
           "recovery_s": math.nan, "longest_gap_s": math.nan, "ate_mm": math.nan, "good": False,
           "states": [], "reasons": [], "ends": "-", "found": {"flights": len(flights)}}  # fmt: skip
    if len(flights) != 2:
        return row
    again = flights[1]
    tracking = [stamp for stamp, state, _, _ in again["health"] if state in ("TRACKING", restart.ends)]
    if not tracking:
        return row
    first_ns = tracking[0] + report["shift_ns"]
    begin_ns = report["first_frame_ns"] + report["shift_ns"] + round(BEGIN_S * hil_compare.NANO)
    row["length_s"] = (report["killed_ns"] - begin_ns) / hil_compare.NANO
    row["recovery_s"] = (first_ns - report["killed_ns"]) / hil_compare.NANO
    row["longest_gap_s"] = (tracking[0] - flights[0]["health"][-1][0]) / hil_compare.NANO
    row["ends"] = again["health"][-1][1]
    row["ate_mm"] = hil.ate(again["poses"], again["name"])
    ready_s = (report["ready_again_ns"] - report["killed_ns"]) / hil_compare.NANO
    counter = (job.folder / "flights/reset_counter").read_text(encoding="utf-8").strip()
    row["found"] = {"seconds until ready": round(ready_s, 2), "reset counter sent": int(counter)}
    said = (job.folder / "run.log").read_text(encoding="utf-8", errors="replace")
    names_thread = "the thread facet-sinks hangs" in said
    row["good"] = (row["exit_code"] == 0 and row["ends"] == restart.ends and int(counter) == 1
                   and row["recovery_s"] <= restart.max_recovery_s
                   and names_thread == (restart.kind == "sinks_hang"))  # fmt: skip
    return row


def fault_rows(hil, faults, restarts):
    print("  fault                                    states         ends     recovery  gap s  ATE mm (without)  "
          "reasons; found")

    def plain_flight(sensor):
        flight = hil.fly(sensor, f"{sensor}_plain")
        flight["ate_mm"] = hil.ate(flight["poses"], flight["name"])
        return flight

    sensors = sorted({one.sensor for one in (*faults, *restarts)})
    with ThreadPoolExecutor(hil.args.jobs) as guests:
        plain = dict(zip(sensors, guests.map(plain_flight, sensors)))
        flown = [guests.submit(fault_row, hil, fault, plain[fault.sensor]) for fault in faults]
        flown += [guests.submit(restart_row, hil, restart, plain[restart.sensor]) for restart in restarts]
        rows = []
        for row in flown:
            rows.append(row.result())
            print_row(rows[-1])
    return rows


def length_words(row):
    return "permanent" if row["length_s"] == FOR_EVER_S else f"{row['length_s']:.2f} s" if row["length_s"] else "once"


def found_words(row):
    return ", ".join(f"{key} {count}" for key, count in row["found"].items())


def print_row(row):
    print(
        f"  {row['sensor'] + ' ' + row['fault']:<40} {length_words(row):<8} {'|'.join(row['states']) or '-':<14}"
        f" {row['ends']:<8} {row['recovery_s']:>6.2f} s {row['longest_gap_s']:>6.2f}"
        f"  {row['ate_mm']:>7.2f} ({row['ate_plain_mm']:.2f})   {'|'.join(row['reasons']) or '-'}; {found_words(row)}"
        f"{'' if row['good'] else '   NOT AS PROMISED'}",
        flush=True,
    )
