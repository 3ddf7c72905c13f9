#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Checks who includes whom, and a few rules on single files. ARCHITECTURE.md ("Who may include whom") has the reasons.

Usage: layers.py [ROOT]      prints a line `file:line: rule` for every violation; exit code 1 if there is any
"""
import argparse
import re
import sys
from pathlib import Path

SOURCE_FOLDERS = ("platform", "drivers", "estimator", "mesh", "app", "tests", "docs")
FLIGHT_FOLDERS = ("platform", "drivers", "estimator", "mesh", "app")
LAB = "app/lab"
MAX_LINES_IN_FLIGHT = 400
MAX_LINES = 500
SPDX = "// SPDX-License-Identifier: BSD-2-Clause"
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')

# For every area the prefixes of project headers it may include, itself aside: a prefix names a folder and all below it.
# The longest area that fits a file counts.
BASE = ("platform/base/",)
VALUES = BASE + ("estimator/geometry/", "estimator/values/")
APP_BASE = ("platform/", "estimator/", "mesh/", "app/support/")
APP_CONFIG = APP_BASE + ("drivers/", "app/calibration/", "app/config/")
APP_PIPELINE = APP_CONFIG + ("app/foxglove/", "app/mcap/", "app/output/", "app/pipeline/", "app/view/")
ALLOWED = {
    "platform/base": (),
    "platform/port": BASE,
    "platform/linux": BASE + ("platform/port/",),
    "drivers/common": BASE + ("platform/port/",),
    "drivers": BASE + ("platform/port/", "drivers/common/"),
    "estimator/geometry": BASE,
    "estimator/values": BASE + ("estimator/geometry/",),
    "estimator/frontend": VALUES,
    "estimator/imu": VALUES,
    "estimator/factors": VALUES + ("estimator/imu/",),
    "estimator/solver": VALUES + ("estimator/imu/", "estimator/factors/"),
    "estimator/window": VALUES + ("estimator/imu/", "estimator/factors/", "estimator/solver/"),
    "estimator/api": VALUES + ("estimator/imu/", "estimator/frontend/", "estimator/window/"),
    "estimator/flight": BASE + ("estimator/",),
    "mesh": VALUES,
    "mesh/depth": VALUES + ("mesh/", "estimator/frontend/"),
    "mesh/planes": VALUES + ("mesh/",),
    "mesh/places": VALUES + ("estimator/frontend/",),
    "mesh/volume": VALUES + ("mesh/", "estimator/frontend/"),
    "mesh/mapping": VALUES + ("mesh/", "estimator/api/"),
    # The flight program: nothing of it sees app/lab.
    "app/support": BASE,
    "app/calibration": APP_BASE,
    "app/config": APP_CONFIG,
    "app/foxglove": APP_BASE + ("app/calibration/",),
    "app/mcap": APP_BASE,
    "app/output": APP_BASE + ("app/foxglove/", "app/mcap/"),
    "app/pipeline": APP_PIPELINE,
    "app/run": APP_PIPELINE,
    "app/view": APP_BASE + ("app/foxglove/", "app/output/"),
    "app/lab": APP_PIPELINE + ("app/lab/",),
    "app/commands": ("platform/", "drivers/", "estimator/", "mesh/", "app/"),
    # Not part of the program: what Python loads instead of it.
    "app/python": APP_PIPELINE + ("app/lab/",),
    "app": ("app/commands/",),
    "tests": ("platform/", "drivers/", "estimator/", "mesh/", "app/"),
    # Sees what is installed: toolchains/install_library.cmake.
    "docs/example": BASE + ("estimator/", "mesh/", "drivers/world_stream/"),
}

# Headers of the standard library and the operating system that make code impure: clocks, threads, files, output.
IMPURE = re.compile(
    r"^(thread|mutex|shared_mutex|condition_variable|future|stop_token|semaphore|latch|barrier|atomic"
    r"|chrono|ctime|time\.h"
    r"|iostream|ostream|istream|fstream|sstream|syncstream|cstdio|stdio\.h|filesystem|csignal|signal\.h"
    r"|unistd\.h|fcntl\.h|poll\.h|pthread\.h|sched\.h|dlfcn\.h|(sys|linux|arpa|netinet)/.*)$"
)
PURE_AREAS = ("estimator", "mesh")

# Third-party headers and the areas that may use them. Tests may use all.
THIRD_PARTY = (
    (re.compile(r"^yaml-cpp/"), ("app",)),
    (re.compile(r"^CLI/"), ("app",)),
    (re.compile(r"^pybind11/"), ("app/python",)),
    (re.compile(r"^nlohmann/"), ("app",)),
    (re.compile(r"^spdlog/"), ("app",)),
    (re.compile(r"^fmt/"), ("app", "drivers")),
    (re.compile(r"^png\.h$"), ("app", "drivers/replay_asl")),
    (re.compile(r"^opencv2/"), ("estimator/frontend",)),
    (re.compile(r"^ceres/"), ("app/lab/calibrate",)),
    (re.compile(r"^boost/(asio|beast)"), ("app/view",)),
    (re.compile(r"^lib(avcodec|avformat|avutil)/"), ("app/lab/convert",)),
    (re.compile(r"^sqlite3\.h$"), ("app/lab/convert",)),
    (re.compile(r"^jpeglib\.h$"), ("drivers/common", "drivers/replay_asl")),
    (re.compile(r"^tiffio\.h$"), ("drivers/replay_asl",)),
    (re.compile(r"^(zlib|bzlib|zstd|lz4frame)\.h$"), ("app/mcap",)),
    (re.compile(r"^gpiod\.h$"), ("drivers/trigger_gpio",)),
    (re.compile(r"^(dds/|[a-z0-9]+_msgs\.h$)"), ("drivers/ros2",)),
)


def in_area(path, area):
    return path == area or path.startswith(area + "/")


def area_of(path):
    """The longest area of ALLOWED that holds the file, or None."""
    fitting = [area for area in ALLOWED if in_area(path, area)]
    return max(fitting, key=len) if fitting else None


def unit_of(path):
    """The folder inside which a file may include freely: a single driver, or its area."""
    if path.startswith("drivers/"):
        return "/".join(path.split("/")[:2])
    return area_of(path)


def is_private_frontend_header(path):
    return path.startswith("estimator/frontend/") and (
        path.endswith("_impl.h") or path.startswith("estimator/frontend/internal/")
    )


def is_private_flight_header(path):
    """What is behind Estimator: not installed, seen by its own tests only."""
    return path.startswith("estimator/flight/")


def max_lines(path):
    """What flies is read more often, and more carefully, than what works on logs and tests."""
    flies = any(in_area(path, folder) for folder in FLIGHT_FOLDERS) and not in_area(path, LAB)
    return MAX_LINES_IN_FLIGHT if flies else MAX_LINES


def check_project_include(path, included, root):
    if in_area(path, "docs") and (root / path).parent.joinpath(included).is_file():
        return None  # an example is somebody else's program: it sees what lies beside it
    if not included.startswith(tuple(folder + "/" for folder in SOURCE_FOLDERS)):
        return f'"{included}" does not start at the project root'
    if not (root / included).is_file() and not (root / f"{included}.in").is_file():
        return f'"{included}" does not exist'
    area = area_of(path)
    if is_private_frontend_header(included) and area not in ("estimator/frontend", "tests"):
        return f'"{included}" is private to estimator/frontend'
    if is_private_flight_header(included) and area not in ("estimator/flight", "tests"):
        return f'"{included}" is private to estimator/flight'
    if in_area(included, unit_of(path)):
        return None
    for prefix in ALLOWED[area]:
        if included.startswith(prefix):
            return None
    return f'{area} must not include "{included}"'


def check_system_include(path, included):
    if in_area(path, "tests"):
        return None
    for pattern, areas in THIRD_PARTY:
        if pattern.search(included) and not any(in_area(path, area) for area in areas):
            return f"<{included}> is only for {', '.join(areas)}"
    if included.startswith("opencv2/") and path.endswith(".h") and not is_private_frontend_header(path):
        return f"<{included}> in a header: only .cpp files, *_impl.h and internal/ of estimator/frontend"
    if any(in_area(path, area) for area in PURE_AREAS) and IMPURE.match(included):
        return f"<{included}> in {path.split('/')[0]}/, which has no clock, thread, file or log"
    return None


def check_file(root, path):
    """Violations of one file as (line, text)."""
    lines = (root / path).read_text(encoding="utf-8").splitlines()
    if not lines or lines[0] != SPDX:
        yield 1, f"first line must be: {SPDX}"
    if len(lines) > max_lines(path):
        yield len(lines), f"{len(lines)} lines; split the file ({max_lines(path)} at most)"
    if path.endswith(".h"):
        if len(lines) < 2 or not lines[1].startswith("// "):
            yield 2, "second line must be a comment with the header's purpose"
        if "#pragma once" not in lines:
            yield 1, "#pragma once is missing"
    if area_of(path) is None:
        yield 1, f"no include rule for this folder: add it to {Path(__file__).name}"
        return
    for number, line in enumerate(lines, start=1):
        match = INCLUDE.match(line)
        if match:
            quoted = match.group(1) == '"'
            included = match.group(2)
            text = check_project_include(path, included, root) if quoted else check_system_include(path, included)
            if text:
                yield number, text


def check_tree(root):
    """All violations below root as `file:line: text`, and the number of files seen."""
    violations = []
    files = 0
    for folder in SOURCE_FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix in (".h", ".cpp") and file.is_file():
                files += 1
                path = file.relative_to(root).as_posix()
                violations += [f"{path}:{line}: {text}" for line, text in check_file(root, path)]
    return violations, files


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parents[2])
    root = parser.parse_args().root
    violations, files = check_tree(root)
    for violation in violations:
        print(violation)
    if files == 0:
        print(f"{root}: no sources found")
        return 2
    print(f"layers: {files} files, {len(violations)} violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
