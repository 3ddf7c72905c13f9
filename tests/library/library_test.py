#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Installs the library, moves it elsewhere, and builds and runs docs/example with it: the estimator by itself, and the
planner at the end of a replay's stream; and configures the library alone.

Usage: library_test.py --build FOLDER --facet PATH --work FOLDER --compiler PATH [--launcher PATH] --build-type TYPE
       --flags FLAGS
"""
import argparse
import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(*command):
    """What the command prints; ends the test, with that, if it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}\n{done.stdout}\nended with exit code {done.returncode}")
    return done.stdout


def check_installed(prefix):
    """Headers, libraries and the CMake package; nothing else, and nothing that names the source or the build folder."""
    assert sorted(path.name for path in prefix.iterdir()) == ["include", "lib"]
    headers = {path.relative_to(prefix / "include/facet") for path in (prefix / "include").rglob("*") if path.is_file()}
    parts = [ROOT / part for part in ("platform/base", "estimator", "mesh")]
    wanted = {path.relative_to(ROOT) for part in parts for path in part.rglob("*.h")
              if ROOT / "estimator/flight" not in path.parents}
    wanted |= {Path(f"drivers/world_stream/world_{part}.h") for part in ("message", "reader", "state")}
    assert headers == wanted, headers ^ wanted
    for path in (prefix / "lib/cmake/facet").iterdir():
        assert str(ROOT) not in path.read_text(encoding="utf-8"), path


def check_flags(build, wanted):
    """Users get the flags that their code must share with the library's, and none of its warnings."""
    entries = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    assert len(entries) == 2, entries
    for entry in entries:
        words = entry["command"].split()
        assert set(wanted.split()) <= set(words) and not any(word.startswith("-W") for word in words), words


def check_output(text):
    """It knows where it is, has a mesh, and has found its wall, two metres ahead."""
    match = re.match(r"TRACKING, position within (\S+) mm; faces: (\d+)\n", text)
    assert match, text
    assert float(match[1]) < 10.0 and int(match[2]) > 100, text
    planes = re.findall(r"plane with normal \((\S+), (\S+), (\S+)\), (\S+) m away\n", text)
    assert len(planes) == 1, text
    assert abs(float(planes[0][0])) > 0.999 and abs(float(planes[0][3]) - 2.0) < 0.02, text


def check_planner(planner, facet, work):
    """It follows a replay in real time from the socket's first moment to its end, and the replay is none the worse."""
    log, socket = work / "log", work / "world"
    run(facet, "sim", "--scene", "room", "--out", log, "--duration", "5", "--seed", "3", "--samples", "1")
    run(facet, "replay", log, "--out", work / "alone", "--quiet")
    assert subprocess.run([planner, socket], capture_output=True, check=False).returncode == 2  # nobody is there yet
    with subprocess.Popen([facet, "replay", log, "--out", work / "streamed", "--quiet", "--realtime", "--stream",
                           socket], stdout=subprocess.DEVNULL) as replay:
        while not socket.exists():
            assert replay.poll() is None, "the replay has ended before it streamed"
            time.sleep(0.01)
        lines = run(planner, socket).splitlines()
    assert replay.returncode == 0
    trajectories = [(work / out / "trajectory.csv").read_bytes() for out in ("alone", "streamed")]
    assert trajectories[0] == trajectories[1]
    found = [re.fullmatch(r"keyframe (\d+): (\S+) m from (an obstacle|unknown space), away along \(.*\)", line)
             for line in lines]
    assert len(found) > 5 and all(found), lines
    numbers = [int(match[1]) for match in found]
    assert numbers == sorted(set(numbers)), lines
    # It stands, then flies through what it has cleared, and never touches anything.
    assert all(0.0 < float(match[2]) <= 2.0 for match in found[1:]), lines
    assert not socket.exists()


def check_library_only(work, compiler):
    """Without the program, nothing that only the program needs is looked for."""
    build = work / "only"
    program_only = ("PNG", "yaml-cpp", "CLI11", "nlohmann_json", "fmt", "Gpiod", "BZip2", "JPEG", "Lz4", "SQLite3",
                    "TIFF", "ZLIB", "Zstd", "Catch2", "Ceres", "Libav", "OpenCVModules", "Python3")
    run("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={compiler}", "-DFACET_LIBRARY_ONLY=ON",
        *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in program_only))
    targets = set(re.findall(r"^(facet\w*): phony$", run("cmake", "--build", build, "--target", "help"), re.MULTILINE))
    assert {"facet_estimator", "facet_mesh", "facet_depth", "facet_planes", "facet_mapping",
            "facet_world_reader"} <= targets, targets
    assert not {"facet", "facet_commands", "facet_replay_asl"} & targets, targets


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--facet", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--launcher", default="")
    parser.add_argument("--build-type", required=True)
    parser.add_argument("--flags", required=True, help="of the library's code, that its users must have too")
    arguments = parser.parse_args()
    shutil.rmtree(arguments.work, ignore_errors=True)

    installed, prefix = arguments.work / "installed", arguments.work / "moved"
    run("cmake", "--install", arguments.build, "--component", "development", "--prefix", installed)
    installed.rename(prefix)
    check_installed(prefix)

    build = arguments.work / "build"
    run("cmake", "-S", ROOT / "docs/example", "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
        f"-DCMAKE_CXX_COMPILER={arguments.compiler}", f"-DCMAKE_CXX_COMPILER_LAUNCHER={arguments.launcher}",
        f"-DCMAKE_BUILD_TYPE={arguments.build_type}", "-DCMAKE_CXX_FLAGS=", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
    check_flags(build, arguments.flags)
    run("cmake", "--build", build)
    check_output(run(build / "facet_example"))
    check_planner(build / "facet_planner", arguments.facet, arguments.work)
    check_library_only(arguments.work, arguments.compiler)
    return 0


if __name__ == "__main__":
    sys.exit(main())
