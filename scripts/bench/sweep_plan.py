# SPDX-License-Identifier: BSD-2-Clause
"""What a sweep runs: its file, checked, and the runs that it stands for."""
import dataclasses
import itertools
import pathlib
import re

import yaml

from bench.benchmark_lib import Condition, simulator_sum, sum_of

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*$")
SETTING = re.compile(r"[A-Za-z0-9._]+=[A-Za-z0-9.+-]+$")
MODES = ["s", "sp", "spr"]
VIBRATIONS = ["none", "idle", "flight", "idle+images", "flight+images"]
KEYS = {"flights", "modes", "conditions", "seeds", "parameters", "config", "duration"}
FLIGHT_KEYS = {"scene", "seed", "duration", "options"}


class SweepError(Exception):
    """One line that says what is wrong with a sweep's file."""


@dataclasses.dataclass(frozen=True)
class Flight:
    """A log, or a flight to simulate."""
    log: str             # folder; of a simulated flight below the sweep's output
    simulate: tuple = ()  # options of facet sim but --out; none for a log that is there


@dataclasses.dataclass(frozen=True)
class Run:
    """One replay of one flight."""
    flight: str
    mode: str
    parameters: tuple    # KEY=VALUE, in the order of the file
    condition: Condition
    seed: int            # of the condition, where it depends on one

    @property
    def variant(self):
        """Names the parameters."""
        return ",".join(self.parameters) or "default"

    @property
    def name(self):
        """Names the run's folder, and the run in a baseline."""
        seed = self.seed if self.condition.is_drawn else None
        return f"{self.flight}/{self.mode}/{self.variant}/{self.condition.name(seed)}"

    def options(self):
        """Options of facet replay that are this run's alone."""
        settings = [part for setting in self.parameters for part in ("--set", setting)]
        return ["--mode", self.mode, *self.condition.options(self.seed), *settings]


def known(keys, allowed, where):
    for key in keys:
        if key not in allowed:
            raise SweepError(f"{where}{key}: unknown; one of: {', '.join(sorted(allowed))}")


def as_list(value, where, is_good, what):
    """The list, not empty, all of it good and no entry twice."""
    if not isinstance(value, list) or not value or not all(is_good(entry) for entry in value):
        raise SweepError(f"{where}: must be a list of {what}")
    if any(value.count(entry) > 1 for entry in value):
        raise SweepError(f"{where}: an entry stands there twice")
    return value


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value < 1e9


def is_count(value):
    return is_number(value) and isinstance(value, int)


def text_of(value):
    """A parameter's value as --set takes it."""
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else str(value)


def read_flight(name, entry, base, out):
    where = f"flights.{name}"
    if not NAME.match(str(name)):
        raise SweepError(f"{where}: only letters, digits, '.', '_' and '-' name a flight")
    if isinstance(entry, str):
        log = (base / entry).resolve()
        if not any((log / part / "cam0/data.csv").is_file() for part in ("", "mav0")):
            raise SweepError(f"{where}: {log}: no log")
        return Flight(str(log))
    if not isinstance(entry, dict) or "scene" not in entry:
        raise SweepError(f"{where}: must be a log's folder, or a map with the scene of a flight to simulate")
    known(entry, FLIGHT_KEYS, f"{where}.")
    for key in ("seed", "duration"):
        if key in entry and not is_number(entry[key]):
            raise SweepError(f"{where}.{key}: must be a number that is not negative")
    options = entry.get("options", [])
    if not isinstance(options, list):
        raise SweepError(f"{where}.options: must be a list of options of facet sim")
    return Flight(str(out / "flights" / name), ("--scene", str(entry["scene"]), "--seed", str(entry.get("seed", 1)),
                                                "--duration", f"{entry.get('duration', 20):g}", *map(text_of, options)))


def read_condition(entry):
    if not isinstance(entry, dict):
        raise SweepError("conditions: must be a list of maps")
    known(entry, {"calibration_error", "vibration"}, "conditions.")
    factor, vibration = entry.get("calibration_error", 0), entry.get("vibration", "none")
    if not is_number(factor):
        raise SweepError("conditions.calibration_error: must be a number that is not negative")
    if vibration not in VIBRATIONS:
        raise SweepError(f"conditions.vibration: '{vibration}' is unknown; one of: {', '.join(VIBRATIONS)}")
    return Condition(float(factor), vibration)


def read_parameters(grid):
    """All combinations of the values of all parameters."""
    if not isinstance(grid, dict):
        raise SweepError("parameters: must be a map from keys to lists of values")
    for key, values in grid.items():
        as_list(values, f"parameters.{key}", lambda value: isinstance(value, (int, float, str)), "values")
    choices = [[f"{key}={text_of(value)}" for value in values] for key, values in grid.items()]
    for setting in itertools.chain.from_iterable(choices):
        if not SETTING.match(setting):
            raise SweepError(f"parameters: '{setting}' cannot name a folder")
    return list(itertools.product(*choices))


class Plan:
    """All that a sweep does.

    `flights` maps names to Flight, `runs` names to Run, in the order of the file: flights, parameters, modes,
    conditions, seeds. `replay` are the options that all runs share.

    What was rendered or flown is kept with its identity, and done again when that has changed: the options and the
    program, for a flight the simulator's sources in place of the program.
    """

    def __init__(self, path, out, facet):
        path = pathlib.Path(path)
        try:
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise SweepError(" ".join(str(error).split())) from None
        if not isinstance(content, dict) or not isinstance(content.get("flights"), dict) or not content["flights"]:
            raise SweepError("flights: must be a map from names to flights")
        known(content, KEYS, "")
        self.facet = str(facet)
        self.program = sum_of([facet])
        self.flights = {str(name): read_flight(name, entry, path.parent, pathlib.Path(out))
                        for name, entry in content["flights"].items()}
        modes = as_list(content.get("modes", ["s", "spr"]), "modes", lambda mode: mode in MODES, ", ".join(MODES))
        listed = as_list(content.get("conditions", [{}]), "conditions", lambda _: True, "maps")
        seeds = as_list(content.get("seeds", [1]), "seeds", is_count, "whole numbers")
        self.runs = {}
        for flight, parameters, mode, condition in itertools.product(
                self.flights, read_parameters(content.get("parameters", {})), modes, map(read_condition, listed)):
            for seed in seeds if condition.is_drawn else seeds[:1]:
                run = Run(flight, mode, parameters, condition, seed)
                self.runs[run.name] = run
        self.replay = self.shared_options(content, path.parent)

    def flight_identity(self, name):
        """Tells a rendered flight from one that would be another today."""
        return " ".join([*self.flights[name].simulate, "simulator", simulator_sum()])

    def run_identity(self, name):
        """Tells a run's result from one that would be another today."""
        run = self.runs[name]
        flight = self.flights[run.flight]
        return " ".join([*(flight.simulate or [flight.log]), *self.replay, *run.options(), "program", self.program])

    @staticmethod
    def shared_options(content, base):
        options = []
        if "duration" in content:
            if not is_number(content["duration"]) or content["duration"] == 0:
                raise SweepError("duration: must be a positive number of seconds")
            options += ["--duration", f"{content['duration']:g}"]
        if "config" in content:
            config = (base / str(content["config"])).resolve()
            if not config.is_file():
                raise SweepError(f"config: {config}: no such file")
            options += ["--config", str(config)]
        return options
