# SPDX-License-Identifier: BSD-2-Clause
"""What is flown for the golden files, and how: simulated flights, each rendered once, and replays of them."""
import hashlib
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

# A few seconds each, one ray a pixel: to render them is nearly all that the test takes.
FLIGHTS = {
    "room_tour": ("--scene", "room", "--seed", "1", "--duration", "6", "--stand", "1", "--samples", "1"),
    "room_hover": ("--scene", "room", "--seed", "2", "--duration", "3", "--stand", "0.5", "--samples", "1",
                   "--flight", "hover"),
    "hall_tour": ("--scene", "hall", "--seed", "2", "--duration", "4", "--stand", "0.5", "--samples", "1"),
}  # fmt: skip

# With half the window, keyframes leave it within these few seconds: marginalization and the residuals of finished
# landmarks are in the files too.
SHORT_WINDOW = ("--set", "window.keyframes=10")


@dataclass(frozen=True)
class Run:
    """A replay of a flight; its golden file is called NAME.txt."""

    name: str
    flight: str
    arguments: tuple


RUNS = (
    Run("room_tour_spr", "room_tour", ("--mode", "spr")),
    Run("room_tour_faults", "room_tour", ("--mode", "s", *SHORT_WINDOW, "--inject", "blackout@2+0.4",
                                          "--inject", "imu_gap@3+0.3", "--inject", "no_right@4.5+0.5")),
    Run("room_hover_sp", "room_hover", ("--mode", "sp")),
    Run("hall_tour_s", "hall_tour", ("--mode", "s", *SHORT_WINDOW)),
)  # fmt: skip


class Failed(Exception):
    """A command that did not do what it should."""


def call(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise Failed(f"exit code {done.returncode} of {' '.join(command)}\n{done.stdout}")


def digest(facet):
    """Hash of the program. Of an emulated one, the program is the last word of its command."""
    return hashlib.sha256(Path(facet[-1]).read_bytes()).hexdigest()[:16]


def render(facet, work, flight):
    """Folder of the rendered flight: the one that is there, if this program made it with these arguments."""
    folder = work / "flights" / flight
    marker = folder / "complete.txt"  # written last
    wanted = f"{digest(facet)} {' '.join(FLIGHTS[flight])}\n"
    if marker.is_file() and marker.read_text(encoding="utf-8") == wanted:
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    call([*facet, "sim", *FLIGHTS[flight], "--out", str(folder)])
    marker.write_text(wanted, encoding="utf-8")
    return folder


def replay(facet, work, run):
    """Folder with the results of the run."""
    out = work / "runs" / run.name
    shutil.rmtree(out, ignore_errors=True)
    call([*facet, "replay", str(render(facet, work, run.flight)), *run.arguments, "--out", str(out), "--quiet"])
    return out
