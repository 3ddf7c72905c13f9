# SPDX-License-Identifier: BSD-2-Clause
"""Runs `facet run` in a guest kernel whose sensors play a log."""
import json
import os
import shlex
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
CAN_SENSORS = ("dronecan", "openimu300")
SENSORS = ("icm42688", "adis16475", "bmi088") + CAN_SENSORS + ("iio",)
BACKENDS = ("libgpiod", "chardev")

VEHICLE = """calibration: {{euroc: {calibration}}}
estimator: {{mode: {mode}}}
cameras:
  rate_hz: {rate}
  exposure_s: 0.004
  readout_s: 0.008
  left: {{device: /dev/video40}}
  right: {{device: /dev/video41}}
{pixels}trigger: {{chip: /run/gpiochip, line: camera-trigger, backend: {backend}}}
imu:
  {imu}
{sinks}{realtime}"""
SENSOR_CONFIG = {
    "icm42688": "spi: {chip: icm42688, device: /dev/spidev0.0, rate_hz: 200, READY}",
    "adis16475": "spi: {chip: adis16475-2, device: /dev/spidev0.0, decimation: 9, READY}",
    "bmi088": "spi: {chip: bmi088, device: /dev/spidev0.0, accel_device: /dev/spidev0.1, rate_hz: 200, READY}",
    "dronecan": "can: {interface: vcan0, decoder: dronecan, use_integrals: true}",
    "openimu300": "can: {interface: vcan0, decoder: openimu300}",
    "iio": "iio: {device: facet-imu, rate_hz: 200, attributes: {in_accel_scale: 0.004788403}}",
}
# Exposure and gain are the program's; the sensor's have steps of 0.1 ms (tests/hil/inject/sensor_light.h).
AUTO_EXPOSURE = "  auto_exposure: {exposure_step_s: 0.0001, most_exposure: 80, most_gain: 16}\n"
READY = "data_ready: {chip: /run/gpiochip, line: imu-ready, backend: %s}"
# Where a restarted program begins a folder of its own and announces the jump: on the bus, which nobody else uses then.
RESTARTING_SINKS = "sinks: {log: {folder: /run/share/flights}, can: {interface: vcan0}}\n"
# As on a vehicle: sensors before the estimator.
REALTIME = """realtime:
  threads:
    estimator: {priority: 10}
    imu: {priority: 45}
    cameras: {priority: 35}
    trigger: {priority: 40}
    output: {priority: 20}
"""


class GuestError(Exception):
    pass


@dataclass
class Job:
    """One flight in the guest."""

    log: Path
    folder: Path
    sensor: str = "icm42688"
    backend: str = "libgpiod"  # of the lines
    pixels: tuple = ("GREY", 0, False)  # format, significant bits, in the high bits
    record: str = ""  # "folder" or "mcap"
    watchdog_s: float = 0.0  # 0: not watched
    light: float = 0.0  # exposure and gain are the program's, and light swings by this factor either way in a minute
    command: tuple = ()  # of facet, instead of run; it does not say when it is ready
    files: dict = field(default_factory=dict)  # name: text, below /run/share
    mode: str = "spr"
    start_s: float = 0.0
    duration_s: float = 0.0
    turns: int = 1  # more: what the program says of its state each second is kept
    virtual_time: bool = True
    rate_hz: float = 20.0
    faults: list = field(default_factory=list)
    timeout_s: float = 600.0

    def part(self):
        return ["--start", str(self.start_s), "--duration", str(self.duration_s)]


@dataclass
class Programs:
    kernel: Path
    facet: Path
    inject: Path


def pixel_keys(pixels):
    name, bits, high = pixels
    keys = f"  format: {name}\n" if name != "GREY" else ""
    keys += f"  significant_bits: {bits}\n" if bits else ""
    return keys + ("  msb_aligned: true\n" if high else "")


def pixel_options(pixels):
    name, bits, high = pixels
    return ["--format", name, "--significant-bits", str(bits)] + (["--msb-aligned"] if high else [])


def write_job(programs, job):
    share = job.folder
    (share / "vehicle.yaml").write_text(
        VEHICLE.format(
            calibration=job.log / "mav0",
            mode=job.mode,
            rate=job.rate_hz,
            imu=SENSOR_CONFIG[job.sensor].replace("READY", READY % job.backend),
            backend=job.backend,
            pixels=pixel_keys(job.pixels) + (AUTO_EXPOSURE if job.light else ""),
            sinks=RESTARTING_SINKS if job.watchdog_s else "",
            realtime="" if job.virtual_time else REALTIME,
        ),
        encoding="utf-8",
    )
    for name, text in job.files.items():
        (share / name).parent.mkdir(parents=True, exist_ok=True)
        (share / name).write_text(text, encoding="utf-8")
    play = [str(programs.inject), "play", "--log", str(job.log), *job.part(), "--imu", job.sensor]
    play += pixel_options(job.pixels) + ["--watchdog", str(job.watchdog_s)]
    for fault in job.faults:
        play += ["--fault", fault]
    play += ["--light", str(job.light)] if job.light else []
    play += ["--turns", str(job.turns), "--states", "/run/share/states.csv"] if job.turns > 1 else []
    play += ["--report", "/run/share/inject.json"]
    lines = '--trigger "$HIL_LINES/sim_gpio0/pull" --data-ready "$HIL_LINES/sim_gpio1/pull"'
    run = [str(programs.facet), "run", "--config", "/run/share/vehicle.yaml", "--quiet"]
    run += [] if job.watchdog_s else ["--out", "/run/share/out"]
    run += ["--record", "--format", job.record] if job.record else []
    if job.command:
        play.append("--at-once")
        run = [str(programs.facet), *job.command]
    (share / "job.sh").write_text(
        f"{shlex.join(play)} {lines} -- {shlex.join(run)} > /run/share/run.log 2>&1\necho $? > /run/share/exit_code\n",
        encoding="utf-8",
    )


def memory_mb(job):
    """The whole log is decoded in the guest, and facet's mesh and window need their own."""
    frames = len(list((job.log / "mav0/cam0/data").glob("*.png")))
    if job.duration_s > 0.0:
        frames = min(frames, int(job.duration_s * job.rate_hz) + 2)
    return 512 + frames * 2 * 752 * 480 // 1_000_000


def fly(programs, job):
    """Boots, flies, powers off. Returns the injector's report; raises GuestError if the guest did not finish."""
    shutil.rmtree(job.folder, ignore_errors=True)
    job.folder.mkdir(parents=True)
    write_job(programs, job)
    command = [
        str(programs.kernel), f"mem={memory_mb(job)}M", "root=none", "rootfstype=hostfs", "ro",
        f"init={FOLDER / 'guest_init.sh'}",
        "con=null", "con0=fd:0,fd:1", "ssl=null", "quiet", f"HIL_SHARE={job.folder}", f"HIL_INJECT={programs.inject}",
        "v4l2loopback.devices=2", "v4l2loopback.video_nr=40,41", "v4l2loopback.exclusive_caps=1,1",
        "v4l2loopback.max_buffers=4", f"spi_imu.chip={job.sensor}",
        # Two capture nodes with the sizes of webcams.
        "vivid.n_devs=2", "vivid.node_types=1,1", "vivid.num_inputs=1,1", "vivid.input_types=0,0",
        "vivid.vid_cap_nr=50,51",
    ]  # fmt: skip
    if job.virtual_time:
        command.append("time-travel=inf-cpu")
    environment = dict(os.environ)
    if os.access("/dev/shm", os.W_OK):
        environment["TMPDIR"] = "/dev/shm"  # the guest's memory is a file there
    with open(job.folder / "console.log", "wb") as console:
        guest = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=console, stderr=subprocess.STDOUT, env=environment,
            start_new_session=True
        )
        try:
            guest.wait(timeout=job.timeout_s)
        except subprocess.TimeoutExpired as error:
            os.killpg(guest.pid, 9)
            guest.wait()
            problem = f"{job.folder}: the guest did not end in {job.timeout_s:.0f} s; see console.log"
            raise GuestError(problem) from error
    return read_report(job)


def read_report(job):
    try:
        report = json.loads((job.folder / "inject.json").read_text(encoding="utf-8"))
        # After a power cut there is nobody to write it.
        code = job.folder / "exit_code"
        exit_code = int(code.read_text(encoding="utf-8")) if code.exists() else report["exit_code"]
    except (OSError, ValueError) as error:
        log = job.folder / "run.log"
        words = log.read_text(encoding="utf-8", errors="replace").strip() if log.exists() else ""
        raise GuestError(f"{job.folder}: no result from the guest: {words or 'see console.log'}") from error
    report["exit_code"] = exit_code
    return report
