# SPDX-License-Identifier: BSD-2-Clause
"""Still pictures of the meshes of a sequence for the report, by numpy and PIL if they are there."""
import pathlib
import re

from page.scene import MAX_DISTANCE

try:
    import numpy as np
    from page import mesh_picture
except ImportError:
    mesh_picture = None

NO_PICTURES = "Still pictures of the meshes are left out: numpy and PIL are missing (scripts/setup --plots)."


def ramp():
    """The page's scale of colours, of its light theme, (8, 3) in [0, 1]."""
    style = (pathlib.Path(__file__).parent / "page.css").read_text()
    found = {int(step): code for step, code in reversed(re.findall(r"--m(\d): #([0-9a-f]{6})", style))}
    return np.array([[int(found[step][i:i + 2], 16) / 255 for i in (0, 2, 4)] for step in range(8)])


def stills(sequence):
    """Title, note and PNG of each picture, or None without numpy and PIL."""
    if mesh_picture is None:
        return None
    by_distance, by_plane = [], []
    side = None  # the same for all
    for run in sequence.runs:
        if not run.mesh or not run.mesh["triangles"]:
            continue
        vertices = np.array(run.mesh["vertices"])
        triangles = np.array(run.mesh["triangles"])
        side = mesh_picture.better_side(vertices, triangles) if side is None else side
        distances = run.mesh_distance
        if distances and len(distances["corner_0"]) == len(triangles):
            at = np.stack(list(distances.values()), axis=1) / MAX_DISTANCE
            points, parts, shades = mesh_picture.quarters(vertices, triangles, at)
            picture = mesh_picture.draw(points, parts, mesh_picture.by_shade(shades, ramp()), side)
            by_distance.append((f"Mesh by error, {run.label}",
                                f"blue: on the surface, red: {100 * MAX_DISTANCE:g} cm and more; from above, without "
                                "what faces away", mesh_picture.as_png(picture)))
        picture = mesh_picture.draw(vertices, triangles, mesh_picture.by_plane(np.array(run.mesh["planes"])), side)
        by_plane.append((f"Mesh by plane, {run.label}", "a colour each; grey: on none", mesh_picture.as_png(picture)))
    return by_distance + by_plane
