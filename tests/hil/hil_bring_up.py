# SPDX-License-Identifier: BSD-2-Clause
"""The steps of docs/bring_up.md that virtual hardware can take: dry run, also of devices that fail, and recording."""
import re
from concurrent.futures import ThreadPoolExecutor
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
    sensor: str = "icm42688"


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


# By default vivid stamps the end of a frame that is not over yet.
START_OF_EXPOSURE = "timestamp_source: 1"
# Of vivid, the kernel's test driver, through the whole of videobuf2; it makes five images a second.
HEAP = Step("dry_run_heap", ("run", "--config", "/run/share/heap.yaml", "--dry-run"),
            ("ok        left camera:  /dev/video50 640x480, 5.0 frames/s, 0 lost, 0 bad",
             "ok        right camera: /dev/video51 640x480, 5.0 frames/s, 0 lost, 0 bad"))  # fmt: skip


# The same driver with its own faults, which are controls of it.
def vivid_step(name, left, *says, exit_code=0):
    return Step(f"dry_run_{name}", ("run", "--config", "/run/share/other.yaml", "--dry-run"), (left, *says), exit_code)


VIVID = (
    (vivid_step("streamon_refused", "WRONG     left camera:  /dev/video50: streaming does not start: Invalid argument",
                "ok        right camera:", exit_code=2), "inject_vidioc_streamon_error: 0"),
    (vivid_step("unplugged", "WRONG     left camera:  /dev/video50:", "No such device", exit_code=2), "disconnect: 0"),
    (vivid_step("bad_buffer", "left camera:  /dev/video50 640x480, ", "0 lost, 1 bad"),
     "inject_v4l2_buf_flag_error: 0"),
)  # fmt: skip
# Sensors behind a media controller: vimc, whose first nodes have a sensor each.
MEDIA = Step("dry_run_media_graph", ("run", "--config", "/run/share/other.yaml", "--dry-run"),
             ("ok        left camera:  /dev/video0 640x480,", "ok        right camera: /dev/video1 640x480,",
              "0 lost, 0 bad"))  # fmt: skip
NO_SIZE = Step("dry_run_media_size", ("run", "--config", "/run/share/other.yaml", "--dry-run"),
               ("WRONG     left camera:  /dev/video0: /dev/media", "gives 640x480 in bus format",
                "instead of 641x481"), 2)  # fmt: skip


# Inertial sensors that the kernel drives: at half its rate, by a timer instead of its own trigger, the kernel's dummy,
# and one that is not there.
def iio_step(name, *says, exit_code=0):
    command = ("run", "--config", "/run/share/iio.yaml", "--dry-run")
    return Step(f"dry_run_iio_{name}", command, says, exit_code, sensor="iio")


IIO = (
    (iio_step("slow", "imu:          100 samples/s, 0 lost, 0 bad", "mean specific force"),
     "device: facet-imu, rate_hz: 100"),
    (iio_step("timer", "imu:          250 samples/s, 0 lost, 0 bad", "mean specific force"),
     "device: facet-imu, rate_hz: 250, trigger: facet-timer"),
    (iio_step("dummy", "WRONG     imu:", "facet-dummy: has no angular rates (in_anglvel_x to z) in its scans",
              exit_code=2), "device: facet-dummy"),
    (iio_step("none", "WRONG     imu:", "facet-dummy", "facet-imu", exit_code=2), "device: icm42600-gyro"),
)  # fmt: skip


def iio_vehicle(log, keys):
    return {"iio.yaml": hil_guest.VEHICLE.format(calibration=log / "mav0", mode="s", rate=20.0, backend="libgpiod",
                                                 imu=f"iio: {{{keys}}}", sinks="", realtime="",
                                                 pixels="")}  # fmt: skip


def other_cameras(log, left, right, size, keys="", right_controls="", rate=5.0):
    """A vehicle with these nodes, and a calibration of their size."""
    files = heap_files(log, size)
    del files["heap.yaml"]
    text = hil_guest.VEHICLE.format(
        calibration="/run/share/mav0", mode="s", rate=rate, backend="libgpiod",
        imu=hil_guest.SENSOR_CONFIG["icm42688"].replace("READY", hil_guest.READY % "libgpiod"), sinks="", realtime="",
        pixels="")  # fmt: skip
    text = text.replace("{device: /dev/video40}", f"{{device: {left}{', ' + keys if keys else ''}}}")
    right += f", controls: {{{right_controls}}}" if right_controls else ""
    files["other.yaml"] = text.replace("/dev/video41", right)
    return files


def heap_files(log, size="[640, 480]"):
    """A vehicle whose cameras fill buffers of a DMA heap, and a calibration of their size."""
    files = {}
    for sensor in ("cam0", "cam1", "imu0"):
        text = (log / f"mav0/{sensor}/sensor.yaml").read_text(encoding="utf-8")
        files[f"mav0/{sensor}/sensor.yaml"] = re.sub(r"^resolution:.*$", f"resolution: {size}", text,
                                                     flags=re.MULTILINE)  # fmt: skip
    files["heap.yaml"] = hil_guest.VEHICLE.format(
        calibration="/run/share/mav0", mode="s", rate=5.0, backend="libgpiod",
        imu=hil_guest.SENSOR_CONFIG["icm42688"].replace("READY", hil_guest.READY % "libgpiod"), sinks="", realtime="",
        pixels=f"  heap: /dev/dma_heap/system\n  controls: {{{START_OF_EXPOSURE}}}\n"
    ).replace("video4", "video5")  # fmt: skip
    return files


def rows(hil):
    steps = [(step, {}) for step in STEPS] + [(HEAP, heap_files(hil.log))]
    for step, control in VIVID:
        controls = f"controls: {{{START_OF_EXPOSURE}, {control}}}"
        steps.append((step, other_cameras(hil.log, "/dev/video50", "/dev/video51", "[640, 480]", controls,
                                          START_OF_EXPOSURE)))  # fmt: skip
    steps.append((MEDIA, other_cameras(hil.log, "/dev/video0", "/dev/video1", "[640, 480]", rate=50.0)))
    steps.append((NO_SIZE, other_cameras(hil.log, "/dev/video0", "/dev/video1", "[641, 481]")))
    steps += [(step, iio_vehicle(hil.log, keys)) for step, keys in IIO]
    with ThreadPoolExecutor(hil.args.jobs) as guests:
        results = list(guests.map(lambda step: row_of(hil, *step), steps))
    results.append(checked_calibration(hil))
    return results


def row_of(hil, step, files):
    job = hil_guest.Job(log=hil.log, folder=hil.out / f"bring_up_{step.name}", command=step.command,
                        sensor=step.sensor, faults=list(step.faults), files=files,
                        timeout_s=hil.args.timeout)  # fmt: skip
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
