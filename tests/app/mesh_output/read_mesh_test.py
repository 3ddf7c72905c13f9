#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Reads mesh.ply and mesh_live.ply with a public reader (meshio). Usage: read_mesh_test.py WRITE_MESH_PROGRAM

Exit codes: 0 fine, 1 a difference, 77 meshio or numpy is not installed.
"""
import pathlib
import subprocess
import sys
import tempfile

try:
    import meshio
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; scripts/setup --plots installs it")
    sys.exit(77)


def check(path, faces, vertices):
    """Compares one file with the counts of who wrote it, and with what a mesh of a wall at x = 2.6 to 3 m must be."""
    mesh = meshio.read(path)
    triangles = mesh.cells_dict["triangle"]
    assert list(mesh.cells_dict) == ["triangle"], list(mesh.cells_dict)
    assert triangles.shape == (faces, 3), (triangles.shape, faces)
    assert vertices is None or len(mesh.points) == vertices, (len(mesh.points), vertices)
    assert triangles.min() == 0 and triangles.max() == len(mesh.points) - 1
    assert len({tuple(sorted(t)) for t in triangles.tolist()}) == faces, "a face is there twice"
    assert np.all(mesh.points[:, 0] > 2.5) and np.all(mesh.points[:, 0] < 3.1)
    normals = np.stack([mesh.point_data[name] for name in ("nx", "ny", "nz")], axis=1)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-4)
    a, b, c = (mesh.points[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(across, axis=1)
    assert np.all(across[:, 0] < 0.0), "a face is turned away from the camera that saw it"
    assert area.sum() > 5.0, area.sum()
    assert np.mean(normals[:, 0]) < -0.8
    data = {name: values[0] for name, values in mesh.cell_data.items()}
    assert np.all(data["plane_id"] == -1)
    assert np.all(data["observations"] >= 1) and data["observations"].max() > 2
    assert np.all(data["sigma"] > 0.0) and np.all(data["sigma"] < 0.01)


def main():
    with tempfile.TemporaryDirectory() as folder:
        written = subprocess.run([sys.argv[1], folder], check=True, stdout=subprocess.PIPE, text=True).stdout.split()
        live_vertices, live_faces, run_faces = (int(word) for word in written)
        assert live_faces > 200 and run_faces > live_faces
        check(pathlib.Path(folder) / "mesh_live.ply", live_faces, live_vertices)
        check(pathlib.Path(folder) / "mesh.ply", run_faces, None)
    print(f"mesh_live.ply with {live_faces} faces and mesh.ply with {run_faces} are read as written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
