# SPDX-License-Identifier: BSD-2-Clause
"""The results of a replay as a small text, and the comparison of two such texts."""
import csv
import json
import math
import re

STEP_S = 0.5  # between two lines of the trajectory
NEAREST_S = 0.02  # an estimate farther from its instant does not count: less than half the time between two frames
MESH_COUNTS = ("vertices", "faces", "updates", "added", "confirmed", "superseded", "contradicted", "holes_filled")
PLANE_COUNTS = ("candidates", "confirmed", "found_again", "merged", "doubted", "forgotten")

# Another processor or compiler may differ in the last bits, and in what follows from them.
NEAR_UNITS = 10  # of the last decimal: 1 mm and 0.01 deg
NEAR_COUNT_SHARE = 0.02
NEAR_COUNT = 2


def fixed(value, decimals):
    """The number, rounded; never as -0.0."""
    text = f"{value:.{decimals}f}"
    return text[1:] if text.startswith("-") and float(text) == 0.0 else text


def columns(name, values):
    return f"{name:<12}" + "".join(f"{value:>10}" for value in values)


def relative_turn_deg(a, b):
    """Rotation vector that turns attitude a into b, both (w, x, y, z), on the right of a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    w = aw * bw + ax * bx + ay * by + az * bz
    v = (
        aw * bx - ax * bw - ay * bz + az * by,
        aw * by - ay * bw - az * bx + ax * bz,
        aw * bz - az * bw - ax * by + ay * bx,
    )
    sine = math.sqrt(sum(x * x for x in v))
    if w < 0.0:
        w, v = -w, tuple(-x for x in v)
    scale = math.degrees(2.0 * math.atan2(sine, w)) / sine if sine > 0.0 else 0.0
    return tuple(scale * x for x in v)


def up_in_body(q):
    """The world's z axis seen from a body of this attitude."""
    w, x, y, z = q
    return (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))


def read_trajectory(path):
    """Rows of trajectory.csv: stamp (ns), position (m), attitude (w, x, y, z)."""
    poses = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            words = line.split(",")
            values = [float(word) for word in words[1:8]]
            poses.append((int(words[0]), tuple(values[:3]), tuple(values[3:])))
    return poses


def trajectory_lines(poses):
    if not poses:
        yield "trajectory: none"
        return
    start_ns, _, first = poses[0]
    yield "trajectory: s; mm; turned since the first pose, deg"
    yield columns("up", [fixed(value, 5) for value in up_in_body(first)])
    for k in range(int((poses[-1][0] - start_ns) * 1e-9 / STEP_S + 0.1) + 1):
        instant_ns = start_ns + round(k * STEP_S * 1e9)
        stamp_ns, position, attitude = min(poses, key=lambda pose: abs(pose[0] - instant_ns))
        values = ["none"]
        if abs(stamp_ns - instant_ns) < NEAREST_S * 1e9:
            turn_deg = relative_turn_deg(first, attitude)
            values = [fixed(1000.0 * x, 1) for x in position] + [fixed(x, 3) for x in turn_deg]
        yield columns(fixed(k * STEP_S, 1), values)


def health_lines(path):
    """Each change of state, reasons or reset counter, with its time."""
    yield "health: s; state; resets; reasons"
    start_ns = None
    before = None
    with path.open(newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            stamp_ns = int(row["stamp_ns"])
            start_ns = stamp_ns if start_ns is None else start_ns
            now = (row["state"], row["reset_counter"], row["reason_names"].replace("|", " ") or "-")
            if now != before:
                yield f"{fixed((stamp_ns - start_ns) * 1e-9, 2):<12}" + "  ".join(now)
                before = now


def plane_lines(path):
    yield "planes: kind; normal; distance, m; landmarks"
    for plane in sorted(json.loads(path.read_text(encoding="utf-8")), key=lambda plane: plane["id"]):
        values = [fixed(x, 4) for x in plane["normal"]] + [fixed(plane["distance"], 4), str(plane["inliers"])]
        yield columns(f"#{plane['id']}", [plane["kind"], *values])


def ply_counts(path):
    """Vertices and faces that a PLY file has."""
    head = path.read_bytes()[:4096].decode("latin-1")
    return [int(re.search(rf"^element {name} (\d+)$", head, re.MULTILINE).group(1)) for name in ("vertex", "face")]


def count_lines(out, summary):
    yield "counts"
    for name in ("frames", "estimates", "keyframes", "imu_samples", "warnings"):
        yield columns(name, [str(summary[name])])
    vertices, faces = ply_counts(out / "mesh_horizon.ply")
    yield columns("mesh_horizon.ply", [str(vertices), str(faces)])
    for part, names in (("mesh", MESH_COUNTS), ("planes", PLANE_COUNTS)):
        for name in names:
            yield f"{part + '.' + name:<20}  {summary[part][name]}"


def residual_lines(summary):
    yield "residuals: mean, px; deviation, px; count"
    for name, bin_ in summary["residuals_px"].items():
        yield columns(name, [fixed(bin_["mean"], 4), fixed(bin_["deviation"], 4), str(bin_["count"])])


def describe(out):
    """The text of a golden file, from the output folder of `facet replay`."""
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    sections = (
        trajectory_lines(read_trajectory(out / "trajectory.csv")),
        health_lines(out / "health.csv"),
        plane_lines(out / "planes.json"),
        count_lines(out, summary),
        residual_lines(summary),
    )
    return "\n\n".join("\n".join(lines) for lines in sections) + "\n"


def same_word(golden, found, is_near):
    """Whether two words agree: decimals to one unit of the last place, or to ten if near; integers exactly, or to 2 %;
    all else exactly."""
    if golden == found:
        return True
    if re.fullmatch(r"-?\d+\.\d+", golden) and re.fullmatch(r"-?\d+\.\d+", found):
        unit = 10.0 ** -len(golden.split(".")[1])
        return abs(float(golden) - float(found)) < ((NEAR_UNITS if is_near else 1) + 0.5) * unit
    if is_near and golden.isdecimal() and found.isdecimal():
        return abs(int(golden) - int(found)) <= max(NEAR_COUNT, NEAR_COUNT_SHARE * int(golden))
    return False


def settle(golden, found, is_near):
    """The text that was found, with the golden line in the place of every line that agrees with it: what still differs
    from the golden text is a change."""
    golden_lines, found_lines = golden.splitlines(), found.splitlines()
    if len(golden_lines) != len(found_lines):
        return found
    settled = []
    for a, b in zip(golden_lines, found_lines):
        words = list(zip(a.split(), b.split()))
        same = len(a.split()) == len(b.split()) and all(same_word(x, y, is_near) for x, y in words)
        settled.append(a if same else b)
    return "\n".join(settled) + "\n"
