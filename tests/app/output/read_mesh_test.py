#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Reads mesh_horizon.ply and mesh_live.ply with a public reader (assimp). Usage: read_mesh_test.py WRITE_MESH_PROGRAM

Exit codes: 0 fine, 1 a difference, 77 assimp is not installed.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile


def read(path):
    """What assimp says of a file: {'Vertices': '502', 'Minimum point': '(...)', ...}."""
    done = subprocess.run(["assimp", "info", str(path), "-r", "-v"], check=True, stdout=subprocess.PIPE, text=True)
    return dict(re.findall(r"^([A-Z][\w ]+?):? {2,}(\S.*?)\s*$", done.stdout, re.MULTILINE))


def check(path, faces, vertices):
    """Compares one file with the counts of who wrote it, and with what a mesh of a wall at x = 2.6 to 3 m must be."""
    info = read(path)
    assert info["Primitive Types"] == "triangles", info
    assert int(info["Faces"]) == faces, (info, faces)
    assert vertices is None or int(info["Vertices"]) == vertices, (info, vertices)
    for corner in ("Minimum point", "Maximum point"):
        x = float(info[corner].strip("()").split()[0])
        assert 2.5 < x < 3.1, info


def main():
    if shutil.which("assimp") is None:
        print("skipped: assimp is not installed; scripts/setup does it")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        written = subprocess.run([*sys.argv[1:], folder], check=True, stdout=subprocess.PIPE, text=True).stdout.split()
        live_vertices, live_faces, run_faces = (int(word) for word in written)
        assert live_faces > 200 and run_faces > live_faces
        check(pathlib.Path(folder) / "mesh_live.ply", live_faces, live_vertices)
        check(pathlib.Path(folder) / "mesh_horizon.ply", run_faces, None)
    print(f"mesh_live.ply with {live_faces} faces and mesh_horizon.ply with {run_faces} are read as written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
