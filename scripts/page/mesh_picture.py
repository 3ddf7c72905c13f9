# SPDX-License-Identifier: BSD-2-Clause
"""Still pictures of meshes, by numpy alone: what render_mesh and the report draw. Needs numpy and PIL."""
import io
import sys

import numpy as np
from PIL import Image, ImageChops

TYPES = {"char": "i1", "uchar": "u1", "int8": "i1", "uint8": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4",
         "int32": "<i4", "uint": "<u4", "uint32": "<u4", "float": "<f4", "float32": "<f4", "double": "<f8",
         "float64": "<f8"}
SIZE = (1000, 750)
PATH_COLOUR = np.array([0.9, 0.35, 0.1])
LIGHT = np.array([0.36, -0.48, 0.8])  # where it comes from, unit


def read_elements(path):
    """Elements of a binary little-endian PLY file of triangles, as structured arrays by name."""
    with path.open("rb") as stream:
        elements = []
        while True:
            words = stream.readline().decode("ascii", "replace").split()
            if not words:
                sys.exit(f"{path}: no PLY header")
            if words[0] == "format" and words[1] != "binary_little_endian":
                sys.exit(f"{path}: only binary_little_endian is read")
            if words[0] == "element":
                elements.append((words[1], int(words[2]), []))
            elif words[0] == "property" and words[1] == "list":
                elements[-1][2].extend([("count", TYPES[words[2]]), ("index", TYPES[words[3]], (3,))])
            elif words[0] == "property":
                elements[-1][2].append((words[2], TYPES[words[1]]))
            elif words[0] == "end_header":
                break
        found = {}
        for name, count, fields in elements:
            dtype = np.dtype(fields)
            found[name] = np.frombuffer(stream.read(dtype.itemsize * count), dtype)
    return found


def read_ply(path):
    """Vertices (n, 3), triangles (m, 3) and plane ids (m; -1 none) of a PLY file as above."""
    found = read_elements(path)
    vertex = found["vertex"]
    face = found["face"]
    planes = face["plane_id"].astype(int) if "plane_id" in face.dtype.names else np.full(len(face), -1)
    return np.stack([vertex[k] for k in "xyz"], axis=1).astype(float), face["index"].astype(int), planes


def camera(vertices, side):
    """Rotation and perspective of a camera above a corner of the mesh, looking at its middle."""
    low, high = np.percentile(vertices, 2, axis=0), np.percentile(vertices, 98, axis=0)
    middle, extent = 0.5 * (low + high), np.linalg.norm(high - low)
    eye = middle + extent * np.array([0.62 * side, -0.62 * side, 0.55])
    forward = (middle - eye) / np.linalg.norm(middle - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward]), eye


def better_side(vertices, triangles):
    """The side of camera() from which more of the mesh is seen from its front."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return max((1.0, -1.0), key=lambda side: np.maximum(normals @ np.array([0.62 * side, -0.62 * side, 0.55]), 0).sum())


def draw_path(path, project, picture, depth, radius_px=2):
    """Draws a path (n, 3) as a line of dots wherever nothing stands before it."""
    offsets = np.stack(np.meshgrid(*2 * [np.arange(-radius_px, radius_px + 1)]), axis=-1).reshape(-1, 2)
    offsets = offsets[(offsets ** 2).sum(axis=1) <= radius_px * radius_px + 1]
    steps = np.linspace(0.0, len(path) - 1.0, 8 * len(path))
    dense = np.stack([np.interp(steps, np.arange(len(path)), path[:, k]) for k in range(3)], axis=1)
    for (u, v), z in zip(*project(dense)):
        x, y = (np.round([u, v]).astype(int) + offsets).T
        seen = (x >= 0) & (x < picture.shape[1]) & (y >= 0) & (y < picture.shape[0]) & (z > 0.05)
        x, y = x[seen], y[seen]
        front = depth[y, x] > z
        picture[y[front], x[front]] = PATH_COLOUR


def draw(vertices, triangles, shade, side, path=None, size=SIZE):
    """Depth-buffered picture. shade(points, normal, index) gives colours in [0, 1] of points on one triangle."""
    world_to_camera, eye = camera(vertices, side)
    focal = 1.15 * size[0] / 1.6

    def project(points):
        p = (points - eye) @ world_to_camera.T
        return p[:, :2] / np.maximum(p[:, 2:], 1e-3) * focal + np.array(size) / 2, p[:, 2]

    uv, distance = project(vertices)
    picture = np.ones((size[1], size[0], 3))
    depth = np.full((size[1], size[0]), np.inf)
    for index, t in enumerate(triangles):
        if distance[t].min() < 0.05:
            continue
        normal = np.cross(vertices[t[1]] - vertices[t[0]], vertices[t[2]] - vertices[t[0]])
        length = np.linalg.norm(normal)
        if length == 0 or normal @ (eye - vertices[t[0]]) < 0:
            continue  # seen from behind
        a, b, c = uv[t]
        det = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        low = np.maximum(np.floor(uv[t].min(axis=0)), 0).astype(int)
        high = np.minimum(np.ceil(uv[t].max(axis=0)), np.array(size) - 1).astype(int)
        if abs(det) < 1e-9 or (high < low).any():
            continue
        x, y = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / det
        v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / det
        weight = np.stack([1 - u - v, u, v], axis=-1) / distance[t]  # perspective: linear in 1 / z
        z = 1.0 / np.maximum(weight.sum(axis=-1), 1e-9)
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (z < depth[y, x])
        if not inside.any():
            continue
        points = (weight[inside] * z[inside][:, None]) @ vertices[t]
        depth[y[inside], x[inside]] = z[inside]
        picture[y[inside], x[inside]] = shade(points, normal / length, index)
    if path is not None:
        draw_path(path, project, picture, depth)
    return Image.fromarray((255 * picture).astype(np.uint8))


def cropped(picture, margin=10):
    """The picture without its white border, but for a margin (px)."""
    box = ImageChops.invert(picture).getbbox() or (0, 0, *picture.size)
    return picture.crop((max(box[0] - margin, 0), max(box[1] - margin, 0), min(box[2] + margin, picture.width),
                         min(box[3] + margin, picture.height)))


def by_normal(points, normal, _):
    light = 0.35 + 0.65 * abs(normal @ LIGHT)
    colour = light * (0.6 + 0.4 * np.abs(normal))
    return np.broadcast_to(colour, points.shape)


def by_grey(vertices, triangles, greys):
    """As the images show it: grey values in [0, 1] of the vertices, made brighter, between them."""
    bright = np.clip(1.1 * greys / max(np.percentile(greys, 99), 1e-3), 0.0, 1.0) ** 0.8

    def shade(points, normal, index):
        t = triangles[index]
        b, c = vertices[t[1]] - vertices[t[0]], vertices[t[2]] - vertices[t[0]]
        d = points - vertices[t[0]]
        bb, bc, cc, db, dc = b @ b, b @ c, c @ c, d @ b, d @ c
        area = bb * cc - bc * bc
        v, w = ((cc * db - bc * dc) / area, (bb * dc - bc * db) / area) if area > 0 else (0 * db, 0 * dc)
        grey = bright[t[0]] + v * (bright[t[1]] - bright[t[0]]) + w * (bright[t[2]] - bright[t[0]])
        light = 0.75 + 0.25 * abs(normal @ LIGHT)
        return light * np.clip(grey, 0.0, 1.0)[:, None] * np.array([1.0, 0.98, 0.94])
    return shade


def by_certainty(sigmas):
    """Blue for faces that are known exactly, green at 2.5 cm, red at 5 cm (standard deviation) and more."""
    def shade(points, normal, index):
        share = min(float(sigmas[index]) / 0.05, 1.0)
        low, middle, high = np.array([0.1, 0.2, 0.9]), np.array([0.2, 0.8, 0.2]), np.array([0.9, 0.1, 0.1])
        colour = low + 2 * share * (middle - low) if share < 0.5 else middle + (2 * share - 1) * (high - middle)
        return np.broadcast_to((0.6 + 0.4 * abs(normal @ LIGHT)) * colour, points.shape)
    return shade


def by_plane(planes):
    # Colours that people who do not see all of them can tell apart, after Okabe and Ito; view.js has the same.
    codes = ("0072b2", "e69f00", "009e73", "cc79a7", "56b4e9", "d55e00", "e5d43c", "8c6bb1", "7f9c1e", "a65628")
    palette = np.array([[int(code[i:i + 2], 16) / 255 for i in (0, 2, 4)] for code in codes])

    def shade(points, normal, index):
        plane = planes[index]
        colour = np.array([0.8, 0.8, 0.8])
        if plane >= 0:
            lighter = 0.5 * (plane // len(palette) % 2)
            colour = (1.0 - lighter) * palette[plane % len(palette)] + lighter
        return np.broadcast_to((0.6 + 0.4 * abs(normal @ LIGHT)) * colour, points.shape)
    return shade


def by_shade(shades, stops):
    """Colours of faces by a number in [0, 1] each, between the colours `stops` (n, 3)."""
    place = np.clip(shades, 0.0, 1.0) * (len(stops) - 1)
    low = np.minimum(place.astype(int), len(stops) - 2)
    colours = stops[low] + (place - low)[:, None] * (stops[low + 1] - stops[low])

    def shade(points, normal, index):
        light = 0.7 + 0.3 * abs(normal @ LIGHT)
        return np.broadcast_to(light * colours[index], points.shape)
    return shade


def quarters(vertices, triangles, values):
    """Each triangle as four, and the mean of the values at the corners of each.

    values (m, 6): at the corners of a triangle and the middles of its sides 01, 12, 20.
    """
    corners = vertices[triangles]
    six = np.concatenate([corners, 0.5 * (corners + corners[:, [1, 2, 0]])], axis=1)
    which = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
    return six.reshape(-1, 3), (6 * np.arange(len(triangles))[:, None, None] + which).reshape(-1, 3), \
        values[:, which].mean(axis=2).reshape(-1)


def as_png(picture, colours=200):
    """PNG bytes of a picture with few colours."""
    stream = io.BytesIO()
    few = cropped(picture).quantize(colours, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(stream, "PNG", optimize=True)
    return stream.getvalue()
