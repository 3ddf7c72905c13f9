# SPDX-License-Identifier: BSD-2-Clause
"""What a benchmark flies: its file, checked, and the flights that it stands for. scripts/benchmarks/README.md explains
every key."""
import dataclasses
import itertools
import pathlib
import re

import yaml

from bench.benchmark_lib import simulator_sum

KEYS = {"title", "document", "flights", "conditions", "seeds", "modes", "cases", "parameters", "set", "inject",
        "replay", "scene", "config", "duration", "start_step", "draw_stride", "may_fail", "tables", "notes", "baseline"}
VARIANT_KEYS = {"mode", "set", "inject", "replay", "eval", "sim", "without", "duration", "scene", "optional", "means"}
DEFAULT_FLIGHTS = {f"sim_{scene}": {"scene": scene, "seed": 1, "duration": 30, "samples": 5}
                   for scene in ("room", "hall")}
CONDITION_LEGEND = ("K: calibration perturbed by K sigma; idle, flight: rotor vibration added to the inertial samples;"
                    " +images: images rotate with it")
MODES = ("s", "sp", "spr")
VIBRATIONS = ("none", "idle", "flight", "idle+images", "flight+images")
NAME = re.compile(r"[\w+-][^/\n]*$")


class PlanError(Exception):
    """One line that says what is wrong with a benchmark's file, or with what was asked of it."""


@dataclasses.dataclass(frozen=True)
class Condition:
    """The calibration is perturbed by `factor` sigma of a good one; `vibration` is added to the inertial samples."""
    factor: float
    vibration: str = "none"  # idle, flight; idle+images, flight+images: images turn as well

    def __str__(self):
        return f"{self.factor:g}" + ("" if self.vibration == "none" else f", {self.vibration}")

    @property
    def is_drawn(self):
        """Whether it depends on a seed."""
        return self.factor > 0 or self.vibration != "none"

    def name(self, seed=None):
        """Names folders, and flights in a baseline."""
        shaken = "" if self.vibration == "none" else f"_{self.vibration}"
        return f"k{self.factor:g}{shaken}" + ("" if seed is None else f"_seed{seed}")

    def options(self, seed):
        """Options of `facet replay` for one draw."""
        kind, _, images = self.vibration.partition("+")
        shown = f",1,{images}" if images else ""
        shaken = [] if kind == "none" else ["--inject", f"vibration={kind},{seed}{shown}"]
        return (["--inject", f"calibration={self.factor:g},{seed}"] if self.factor > 0 else []) + shaken

    @staticmethod
    def of(text):
        """The condition of a text: K, and a kind of vibration behind a space."""
        factor, _, vibration = str(text).replace(",", " ").partition(" ")
        vibration = vibration.strip() or "none"
        if not re.fullmatch(r"\d+(\.\d+)?", factor) or vibration not in VIBRATIONS:
            raise PlanError(f"condition '{text}': K, which is not negative, and perhaps one of {', '.join(VIBRATIONS)}")
        return Condition(float(factor), vibration)


@dataclasses.dataclass(frozen=True)
class Log:
    """A sequence to replay: a folder, or a flight to simulate."""
    name: str
    folder: pathlib.Path = None
    simulate: tuple = ()  # options of facet sim but --out, as (name, value)
    seed: int = 0         # of a simulated flight
    optional: bool = False  # flown only if it is asked for by name

    def options(self, changed=()):
        """Options of facet sim, some of them changed by a case."""
        told = {**dict(self.simulate), **dict(changed)}
        return [part for key, value in told.items() if value is not False
                for part in ([f"--{key}"] if value is True else [f"--{key}", text_of(value)])]


@dataclasses.dataclass(frozen=True)
class Variant:
    """A mode or a case: what of a replay it sets."""
    name: str
    mode: str = None
    settings: tuple = ()   # KEY=VALUE
    inject: tuple = ()     # as --inject takes it
    replay: tuple = ()     # further options of facet replay
    eval: tuple = ()       # and of facet eval
    sim: tuple = ()        # and of facet sim, as (name, value): a flight of its own
    without: tuple = ()    # folders of the log that are left out
    duration: float = None
    scene: object = None   # true: evaluated against the true surface
    optional: bool = False  # flown only if it is asked for by name
    means: str = ""        # for a legend below the table

    @property
    def depends_on_seed(self):
        return any("{seed}" in text or "{draw}" in text for text in (*self.settings, *self.inject, *self.replay))


@dataclasses.dataclass(frozen=True)
class Flight:
    """One replay of one log."""
    sequence: str
    condition: Condition
    case: str
    mode: str
    seed: int
    is_drawn: bool = True  # otherwise all seeds give the same

    @property
    def name(self):
        """Names the flight's folder, and the flight in a baseline."""
        parts = (self.sequence, self.mode, self.case, self.condition.name(self.seed if self.is_drawn else None))
        return "/".join(re.sub(r"[^A-Za-z0-9.,+=_-]+", "_", part) for part in parts)

    def __str__(self):
        case = "" if self.case == "default" else f", {self.case}"
        return f"{self.sequence}, K = {self.condition}, {self.mode}{case}, seed {self.seed}"


def text_of(value):
    """A value as the program takes it."""
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else str(value)


def known(mapping, allowed, where):
    if not isinstance(mapping, dict):
        raise PlanError(f"{where or 'the file'}: must be a map")
    for key in mapping:
        if key not in allowed:
            raise PlanError(f"{where}{'.' if where else ''}{key}: unknown; one of: {', '.join(sorted(allowed))}")


def as_list(value):
    return value if isinstance(value, list) else [] if value is None else [value]


def words_of(entry, key):
    """Options of a key: a text, or a list of texts."""
    value = entry.get(key)
    return tuple(value.split()) if isinstance(value, str) else tuple(map(text_of, as_list(value)))


def settings_of(entry, where):
    """KEY=VALUE of a map."""
    mapping = entry.get("set") or {}
    if not isinstance(mapping, dict):
        raise PlanError(f"{where}.set: must be a map from keys to values")
    return tuple(f"{key}={text_of(value)}" for key, value in mapping.items())


def read_variant(name, entry, where):
    entry = entry or {}
    where = f"{where}.{name}"
    if not NAME.match(str(name)):
        raise PlanError(f"{where}: a name begins with a letter, a digit, + or -, and has no slash")
    known(entry, VARIANT_KEYS, where)
    mode = entry.get("mode")
    if mode is not None and mode not in MODES:
        raise PlanError(f"{where}: mode must be one of {', '.join(MODES)}")
    known(entry.get("sim") or {}, entry.get("sim") or {}, f"{where}.sim")
    return Variant(str(name), mode, settings_of(entry, where), tuple(map(str, as_list(entry.get("inject")))),
                   words_of(entry, "replay"), words_of(entry, "eval"), tuple((entry.get("sim") or {}).items()),
                   tuple(as_list(entry.get("without"))), entry.get("duration"), entry.get("scene"),
                   bool(entry.get("optional")), str(entry.get("means", "")))


def read_variants(content, key, default):
    """Modes or cases by name: a list of names, or a map from names to what they are."""
    entries = content.get(key) or default
    if isinstance(entries, list):
        entries = {name: {"mode": name} if key == "modes" else {} for name in entries}
    if not isinstance(entries, dict):
        raise PlanError(f"{key}: must be a list or a map")
    if key == "modes":
        entries = {name: {"mode": name, **(entry or {})} if name in MODES else entry for name, entry in entries.items()}
    return {str(name): read_variant(name, entry, key) for name, entry in entries.items()}


def read_parameters(grid):
    """Cases of all combinations of the values of parameters."""
    known(grid, grid, "parameters")
    choices = [[f"{key}={text_of(value)}" for value in as_list(values)] for key, values in grid.items()]
    for setting in itertools.chain.from_iterable(choices):
        if not re.fullmatch(r"[A-Za-z0-9._]+=[A-Za-z0-9.+-]+", setting):
            raise PlanError(f"parameters: '{setting}' cannot name a folder")
    return {",".join(combined): Variant(",".join(combined), settings=combined)
            for combined in itertools.product(*choices)}


def read_flights(entries, base):
    """Logs by name: folders, or flights to simulate; one with `seeds` stands for one of each seed."""
    known(entries, entries, "flights")
    logs = {}
    for name, entry in entries.items():
        if not NAME.match(str(name)):
            raise PlanError(f"flights.{name}: a name begins with a letter, a digit, + or -, and has no slash")
        if isinstance(entry, str):
            logs[str(name)] = log_at((base / entry).resolve(), str(name))
            continue
        if not isinstance(entry, dict) or "scene" not in entry:
            raise PlanError(f"flights.{name}: must be a log's folder, or options of facet sim with the scene")
        options = {key: value for key, value in entry.items() if key not in ("seeds", "optional")}
        for seed in as_list(entry.get("seeds", options.get("seed", 1))):
            if not isinstance(seed, int) or seed < 0:
                raise PlanError(f"flights.{name}: a seed must be a whole number that is not negative")
            own = f"{name} {seed}" if "seeds" in entry else str(name)
            logs[own] = Log(own, None, tuple({**options, "seed": seed}.items()), seed, bool(entry.get("optional")))
    return logs


def log_at(folder, name=None):
    """The log in a folder; PlanError if there is none."""
    if not any((folder / part / "cam0/data.csv").is_file() for part in ("", "mav0")):
        raise PlanError(f"{folder}: no log")
    return Log(name or folder.resolve().name, folder)


def chosen(variants, names, what):
    """Those of the variants that are asked for: by their names, or by texts that names contain."""
    if not names:
        return {name: variant for name, variant in variants.items() if not variant.optional}
    picked = {}
    for text in names:
        found = [text] if text in variants else [name for name in variants if text in name]
        if not found:
            raise PlanError(f"{what} '{text}': unknown; one of: {', '.join(variants)}")
        picked.update((name, variants[name]) for name in found)
    return picked


class Plan:
    """All that a benchmark flies.

    `logs`, `cases` and `modes` map names to what they are; `flights` are in the order of the tables' rows: conditions,
    sequences, cases, modes, seeds. `content` is the file, after the plug-in's `prepare`.
    """

    def __init__(self, path, content, arguments):
        self.path, self.content = path, content
        known(content, KEYS, "")
        logs = read_flights(content.get("flights") or DEFAULT_FLIGHTS, path.parent)
        asked = arguments.flights is not None or not arguments.sequences
        self.logs = chosen(logs, arguments.flights, "flight") if asked else {}
        for folder in arguments.sequences:
            log = log_at(folder)
            if log.name in self.logs:
                raise PlanError(f"two sequences are named {log.name}")
            self.logs[log.name] = log
        every = {} if "parameters" not in content else read_parameters(content["parameters"])
        self.cases = chosen(every or read_variants(content, "cases", {"default": {}}), arguments.cases, "case")
        self.modes = chosen(read_variants(content, "modes", ["s"]), arguments.modes, "mode")
        self.conditions = [Condition.of(text) for text in arguments.conditions or as_list(content.get("conditions", 0))]
        self.seeds = arguments.seeds or as_list(content.get("seeds", 1))
        if not all(isinstance(seed, int) and seed >= 0 for seed in self.seeds):
            raise PlanError("seeds: whole numbers that are not negative")
        if arguments.quick:
            self.conditions, self.seeds = self.conditions[:1], self.seeds[:1]
        self.duration = arguments.duration or (10.0 if arguments.quick else content.get("duration"))
        if self.duration is not None and not (isinstance(self.duration, (int, float)) and self.duration > 0):
            raise PlanError("duration: must be a positive number of seconds")
        self.common = Variant("common", None, (*settings_of(content, "the file"), *arguments.settings),
                              tuple(as_list(content.get("inject"))) + tuple(arguments.inject),
                              words_of(content, "replay"), scene=content.get("scene"))
        self.config = arguments.config or (content.get("config") and path.parent / content["config"])
        if self.config and not pathlib.Path(self.config).is_file():
            raise PlanError(f"config: {self.config}: no such file")
        self.flights = list(self.all_flights())

    def all_flights(self):
        for condition, sequence, case, mode in itertools.product(self.conditions, self.logs, self.cases, self.modes):
            drawn = condition.is_drawn or bool(self.content.get("start_step")) or any(
                variant.depends_on_seed for variant in self.variants(case, mode))
            for seed in self.seeds if drawn else self.seeds[:1]:
                yield Flight(sequence, condition, case, mode, seed, drawn)

    def variants(self, case, mode):
        return self.common, self.modes[mode], self.cases[case]

    def draw(self, flight):
        """The seed of a flight's errors: with draw_stride another one for each simulated flight."""
        return self.content.get("draw_stride", 0) * self.logs[flight.sequence].seed + flight.seed

    def replay_options(self, flight):
        """Options of facet replay but the log, --out and --config."""
        variants = self.variants(flight.case, flight.mode)
        options = ["--mode", next(v.mode for v in reversed((Variant("", "s"), *variants)) if v.mode)]
        options += flight.condition.options(self.draw(flight))
        options += [part for v in variants for text in v.inject for part in ("--inject", text)]
        options += [part for v in variants for text in v.settings for part in ("--set", text)]
        options += [part for v in variants for part in v.replay]
        if step := self.content.get("start_step"):
            options += ["--start", f"{step * (flight.seed - 1):g}"]
        if lengths := [v for v in (self.duration, *(variant.duration for variant in variants)) if v]:
            options += ["--duration", f"{min(lengths):g}"]
        return [part.replace("{seed}", str(flight.seed)).replace("{draw}", str(self.draw(flight))) for part in options]

    def options_in(self, mode):
        """Options of facet replay in a mode, without a condition: for plug-ins that fly by themselves."""
        flight = next(flight for flight in self.flights if flight.mode == mode)
        return self.replay_options(dataclasses.replace(flight, condition=Condition(0.0)))

    def changed_flight(self, flight):
        """Options of facet sim that the flight's mode and case change."""
        return tuple(item for variant in self.variants(flight.case, flight.mode) for item in variant.sim)

    def scene_use(self, flight):
        """None, true or "required": whether the true surface is part of the evaluation."""
        return next((v.scene for v in reversed(self.variants(flight.case, flight.mode)) if v.scene is not None), None)

    def log_identity(self, flight):
        """Identifies a log, so that one that would differ today is rendered again."""
        log = self.logs[flight.sequence]
        if log.folder:
            return str(log.folder.resolve())
        return " ".join([*log.options(self.changed_flight(flight)), "simulator", simulator_sum()])


def read_file(path):
    """What a benchmark's file holds."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise PlanError(" ".join(str(error).split())) from None
    if not isinstance(content, dict):
        raise PlanError("must be a map")
    return content
