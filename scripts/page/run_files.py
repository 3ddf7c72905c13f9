# SPDX-License-Identifier: BSD-2-Clause
"""Reads the folder of one `facet replay` or `facet run`, and what `facet eval` left beside it. Standard library only.

Every file but summary.json and trajectory.csv may be missing: what it would have shown is then None.
"""
import csv
import functools
import json
import pathlib
import re
import struct

TEXT_COLUMNS = {"state", "reason_names", "kind"}
TRAJECTORY = ["stamp_ns", "px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "gx", "gy", "gz", "ax", "ay",
              "az"]
# The paper's experiment: its modes; weights of its authors' program; co-planarity alone, nothing of planes and gravity;
# the calibration as given.
PAPER_MODES = ("s", "sp", "spr")
AS_PUBLISHED = {"window.published_weights": "true", "regularity.use_gravity": "false",
                "calibration.estimate_cameras": "false", "calibration.estimate_time_offset": "false"}
PLY_TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f",
             "double": "d", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I",
             "float32": "f", "float64": "d"}


class InputProblem(Exception):
    """A file that cannot be used: one line that names it."""


def read_columns(path, names=None):
    """Columns of a CSV file by name, or None if there is no such file; stamps are integers, the rest floats or text."""
    if not path.is_file():
        return None
    with path.open(newline="") as stream:
        rows = csv.reader(stream)
        header = names or []
        lines = []
        for row in rows:
            if row and row[0].startswith("#"):
                continue
            if not header:
                header = row
            else:
                lines.append(row)
    table = {}
    for index, name in enumerate(header):
        convert = str if name in TEXT_COLUMNS else int if name == "stamp_ns" else float
        try:
            table[name] = [convert(line[index]) for line in lines]
        except (ValueError, IndexError) as error:
            raise InputProblem(f"{path}: column {name}: {error}") from error
    return table


def ply_elements(stream, path):
    """Name, count and properties (name, format; a list is one of three indices) of each element of the header."""
    elements = []
    if stream.readline().strip() != b"ply":
        raise InputProblem(f"{path}: no PLY file")
    for raw in iter(stream.readline, b""):
        words = raw.decode("ascii", "replace").split()
        if words[:1] == ["end_header"]:
            return elements
        if words[:1] == ["format"] and words[1] != "binary_little_endian":
            raise InputProblem(f"{path}: only binary_little_endian is read")
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            elements[-1][2].append(("indices", PLY_TYPES[words[2]] + 3 * PLY_TYPES[words[3]]))
        elif words[:1] == ["property"]:
            elements[-1][2].append((words[2], PLY_TYPES[words[1]]))
    raise InputProblem(f"{path}: header without end")


def read_mesh(path):
    """Vertices [(x, y, z)], triangles [(a, b, c)], plane ids and sigmas (or None) of a mesh, or None without a file."""
    if not path.is_file():
        return None
    found = {}
    with path.open("rb") as stream:
        for name, count, properties in ply_elements(stream, path):
            layout = struct.Struct("<" + "".join(code for _, code in properties))
            data = stream.read(layout.size * count)
            if len(data) != layout.size * count:
                raise InputProblem(f"{path}: truncated")
            found[name] = ([key for key, _ in properties], list(layout.iter_unpack(data)))
    keys, vertices = found["vertex"]
    x = keys.index("x")
    keys, faces = found["face"]
    # The indices are one property of four numbers: what stands behind it comes three later.
    after = {key: keys.index(key) + 3 for key in keys[1:]}
    return {"vertices": [row[x:x + 3] for row in vertices],
            "triangles": [row[1:4] for row in faces],
            "planes": [row[after["plane_id"]] for row in faces] if "plane_id" in after else [-1] * len(faces),
            "sigmas": [row[after["sigma"]] for row in faces] if "sigma" in after else None}


def read_json(path):
    """The object in a file, or None if there is none."""
    if not path.is_file():
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise InputProblem(f"{path}: {error}") from error


class Run:
    """One folder of results. Tables are read when they are first asked for."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.summary = read_json(self.folder / "summary.json")
        if self.summary is None:
            raise InputProblem(f"{folder}: no summary.json in it; facet replay or facet run writes it at its end")
        self.trajectory = read_columns(self.folder / "trajectory.csv", TRAJECTORY)
        if not self.trajectory or not self.trajectory["stamp_ns"]:
            raise InputProblem(f"{folder}: no pose in its trajectory.csv")
        self.evaluation = read_json(self.folder / "eval.json")
        self.mode = self.summary["mode"]
        self.label = self.mode

    @property
    def form(self):
        """The mode and what was set differently; the noise of the log's own IMU is no setting, and the map acts on no
        estimate."""
        changed = {key: value for key, value in self.summary.get("parameters", {}).items()
                   if not key.startswith(("imu_noise.", "map."))}
        if changed == AS_PUBLISHED:
            return f"{self.mode} as published"
        return ", ".join([self.mode, *(f"{key}={value}" for key, value in changed.items())])

    @property
    def dataset(self):
        """The log as it was given."""
        return self.summary["dataset"]

    @property
    def sequence(self):
        """The log's name."""
        path = pathlib.PurePath(self.dataset)
        return path.parent.name if path.name == "mav0" else path.name or self.dataset

    @functools.cached_property
    def program(self):
        """Version and commit of the program; the latter from program.txt, what `facet --version` said."""
        file = self.folder / "program.txt"
        commit = re.search(r"^commit +(\S+)", file.read_text(), re.MULTILINE) if file.is_file() else None
        return f"facet {self.summary.get('version', '?')}, commit {commit.group(1) if commit else 'not recorded'}"

    @functools.cached_property
    def euroc(self):
        """The whole sequence of EuRoC that this is by euroc.txt, for example MH_01, or None."""
        file = self.folder / "euroc.txt"
        return file.read_text().strip() if file.is_file() else None

    def table(self, name):
        """Columns of a file of the run, or None."""
        return read_columns(self.folder / name)

    ate = functools.cached_property(lambda self: self.table("ate.csv"))
    rpe = functools.cached_property(lambda self: self.table("rpe.csv"))
    errors = functools.cached_property(lambda self: self.table("errors.csv"))
    health = functools.cached_property(lambda self: self.table("health.csv"))
    timing = functools.cached_property(lambda self: self.table("timing.csv"))
    planes = functools.cached_property(lambda self: self.table("planes.csv"))
    rays = functools.cached_property(lambda self: self.table("rays.csv"))
    corrections = functools.cached_property(lambda self: self.table("calibration.csv"))
    mesh_log = functools.cached_property(lambda self: self.table("mesh.csv"))
    mesh_distance = functools.cached_property(lambda self: self.table("mesh_distance.csv"))
    mesh = functools.cached_property(lambda self: read_mesh(self.folder / "mesh.ply"))

    def figure(self, *keys):
        """A figure of eval.json, or None."""
        tree = self.evaluation
        for key in keys:
            tree = tree.get(key) if isinstance(tree, dict) else None
        return tree


class Sequence:
    """The runs on one log."""

    def __init__(self, name, runs):
        self.name = name
        self.runs = runs
        self.begin_ns = min(run.trajectory["stamp_ns"][0] for run in runs)
        seen = {}
        for run in runs:
            faults = " ".join(run.summary.get("faults", []))
            run.label = run.form + (f", {faults}" if faults else "")
            seen.setdefault(run.label, []).append(run)
        for same in seen.values():
            for run in same if len(same) > 1 else []:
                run.label += f" ({run.folder.name})"

    def seconds(self, stamps):
        """Stamps (ns) in seconds since the first estimate of any run."""
        return [1e-9 * (stamp - self.begin_ns) for stamp in stamps]


def load_sequences(folders):
    """The folders' runs by log, both in the order given. Raises InputProblem."""
    logs = {}
    for folder in folders:
        run = Run(folder)
        logs.setdefault(run.dataset, []).append(run)
    return [Sequence(runs[0].sequence, runs) for runs in logs.values()]
