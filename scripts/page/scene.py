# SPDX-License-Identifier: BSD-2-Clause
"""What the 3D view of the report shows of each run: arrays packed for view.js, in the world of the estimate."""
import array
import base64
import bisect
import itertools
import math
import sys

MAX_DISTANCE = 0.10  # m: where the colour scale of distances ends
MAX_SIGMA = 0.05     # m: and that of the mesh's own standard deviations
MAX_POSES = 4000


def packed(code, values):
    """Numbers as base64 of a little-endian array (float32 "f", uint8 "B", uint16 "H", uint32 "I", int16 "h")."""
    numbers = array.array(code, values)
    if sys.byteorder == "big":
        numbers.byteswap()
    return base64.b64encode(numbers.tobytes()).decode("ascii")


def packed_points(points):
    """Points as 16-bit integers with the size of a step (m): 0.3 mm in a scene that reaches 10 m."""
    numbers = list(flat(points))
    step = max(map(abs, numbers), default=0.0) / 32767 or 1.0
    return {"step": step, "data": packed("h", [round(number / step) for number in numbers])}


def shades(values, limit):
    """Values as 0 to 255, where 255 is the limit and more."""
    return packed("B", [min(255, round(255 * max(value, 0.0) / limit)) for value in values])


def rotated(q, p):
    """Vector p turned by the unit quaternion q = (x, y, z, w)."""
    x, y, z, w = q
    tx, ty, tz = 2 * (y * p[2] - z * p[1]), 2 * (z * p[0] - x * p[2]), 2 * (x * p[1] - y * p[0])
    return (p[0] + w * tx + y * tz - z * ty, p[1] + w * ty + z * tx - x * tz, p[2] + w * tz + x * ty - y * tx)


def flat(rows):
    """All numbers of a list of points."""
    return itertools.chain.from_iterable(rows)


def pack_mesh(run, key_stamps):
    """Faces with the keyframe from which on each is shown.

    A map, which does not say when it saw what, is shown from the beginning. Faces of the horizon are in mesh.ply in the
    order in which they left it, and mesh.csv has how many left at each keyframe; what is left over was live at the end.
    """
    mesh = run.mesh
    if not mesh or not mesh["triangles"]:
        return None
    count = len(mesh["triangles"])
    is_map = "map" in run.summary
    reveal = [0 if is_map else len(key_stamps) - 1] * count
    if run.mesh_log and not is_map:
        done = 0
        for stamp, departed in zip(run.mesh_log["stamp_ns"], run.mesh_log["departed"]):
            index = min(bisect.bisect_left(key_stamps, stamp), len(key_stamps) - 1)
            now = min(count, done + int(departed))
            reveal[done:now] = [index] * (now - done)
            done = now
    result = {"vertices": packed_points(mesh["vertices"]), "triangles": packed("I", flat(mesh["triangles"])),
              "planes": packed("i", mesh["planes"]), "reveal": packed("H", reveal), "count": count}
    if mesh["sigmas"]:
        result["sigmas"] = shades(mesh["sigmas"], MAX_SIGMA)
    distances = run.mesh_distance
    if distances and len(distances["corner_0"]) == count:
        result["distances"] = shades(flat(zip(*distances.values())), MAX_DISTANCE)
    return result


def pack_path(run, sequence):
    """Estimated and true path, and the error of each pose."""
    path = run.trajectory
    step = math.ceil(len(path["stamp_ns"]) / MAX_POSES)
    chosen = slice(None, None, step)
    points = list(zip(path["px"], path["py"], path["pz"]))[chosen]
    result = {"points": packed("f", flat(points)),
              "times": packed("f", sequence.seconds(path["stamp_ns"][chosen]))}
    transform = run.figure("ate_se3", "transform")
    if run.ate and transform:
        # Into the world of the estimate: R' (p - t).
        x, y, z, w = transform["q_xyzw"]
        true = zip(run.ate["true_x"], run.ate["true_y"], run.ate["true_z"])
        moved = [rotated((-x, -y, -z, w), [a - b for a, b in zip(p, transform["p"])]) for p in true]
        result["truth"] = packed("f", flat(moved[chosen]))
        error_of = dict(zip(run.ate["stamp_ns"], run.ate["error_m"]))
        result["errors"] = [round(error_of.get(stamp, 0.0), 5) for stamp in path["stamp_ns"][chosen]]
    return result


def pack_keyframes(run, sequence, key_stamps):
    """Pose of the left camera at each keyframe and its field of view."""
    path = run.trajectory
    camera = run.summary.get("cameras", {}).get("given", {}).get("cam0")
    poses = []
    for stamp in key_stamps:
        i = min(bisect.bisect_left(path["stamp_ns"], stamp), len(path["stamp_ns"]) - 1)
        poses.append([path[name][i] for name in ("px", "py", "pz", "qx", "qy", "qz", "qw")])
    result = {"times": sequence.seconds(key_stamps), "poses": packed("f", flat(poses))}
    if camera:
        fx, fy, cx, cy = camera["intrinsics_px"]
        result["camera"] = {"p": camera["p_B_C_m"], "q": camera["q_B_C_xyzw"], "x": cx / fx, "y": cy / fy}
    return result


def pack_planes(run, key_stamps):
    """Planes: id, kind, area at last, and the first keyframe that knows and that holds each."""
    table = run.planes
    planes = {}
    for i, plane in enumerate(table["id"] if table else []):
        index = min(bisect.bisect_left(key_stamps, table["stamp_ns"][i]), len(key_stamps) - 1)
        known = planes.setdefault(int(plane), {"id": int(plane), "first": index, "held": -1})
        known.update(kind=table["kind"][i], area=round(table["area_m2"][i], 2), last=index)
        if table["is_held"][i] and known["held"] < 0:
            known["held"] = index
    return list(planes.values())


def pack_rays(run, key_stamps):
    """Free stretches of the live grid: the end of each ray, its keyframe, and what is there (1 unknown, 2 an obstacle).

    All rays of a keyframe begin at the body.
    """
    table = run.rays
    if not table:
        return None
    ends, keyframes, kinds = [], [], []
    for i, stamp in enumerate(table["stamp_ns"]):
        origin = [table[name][i] for name in ("px", "py", "pz")]
        obstacle = table["obstacle_m"][i]
        length = obstacle if math.isfinite(obstacle) else table["free_m"][i]
        ends.append([p + length * table[name][i] for p, name in zip(origin, ("dx", "dy", "dz"))])
        keyframes.append(min(bisect.bisect_left(key_stamps, stamp), len(key_stamps) - 1))
        kinds.append(2 if math.isfinite(obstacle) else 1 if table["unknown"][i] else 0)
    return {"ends": packed_points(ends), "keyframes": packed("H", keyframes), "kinds": packed("B", kinds)}


def pack_run(run, sequence):
    """Everything of one run."""
    stamps = run.trajectory["stamp_ns"]
    key_stamps = [stamp for stamp, is_keyframe in zip(run.health["stamp_ns"], run.health["is_keyframe"])
                  if is_keyframe and stamp >= stamps[0]] if run.health else []
    key_stamps = key_stamps or stamps[::max(1, len(stamps) // 100)]
    return {"label": run.label, "mesh": pack_mesh(run, key_stamps), "path": pack_path(run, sequence),
            "keyframes": pack_keyframes(run, sequence, key_stamps), "planes": pack_planes(run, key_stamps),
            "rays": pack_rays(run, key_stamps)}


def pack(sequences):
    """The data of the view, to be written as JSON."""
    return {"maxDistance": MAX_DISTANCE, "maxSigma": MAX_SIGMA,
            "sequences": [{"name": sequence.name, "runs": [pack_run(run, sequence) for run in sequence.runs]}
                          for sequence in sequences]}
