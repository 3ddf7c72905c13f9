# SPDX-License-Identifier: BSD-2-Clause
"""A small folder of results, as `facet replay` and `facet eval --details` would leave it: 8 s along a circle."""
import json
import math
import struct

FRAMES, BEGIN_NS, STEP_NS, EVERY = 160, 1_400_000_000_000_000_000, 50_000_000, 5
FACES = 60
STAGES = ["propagation", "tracking", "frame_update", "triangulation", "linearization", "solve", "marginalization",
          "landmarks", "mesh", "planes"]


def stamp(frame):
    return BEGIN_NS + frame * STEP_NS


def write_table(path, columns, rows):
    path.write_text("\n".join([",".join(columns)] + [",".join(map(str, row)) for row in rows]) + "\n")


def write_mesh(path):
    """A strip of a floor: plane 3 up to its middle, then none."""
    vertices = [(0.1 * i, 0.5 * (i % 2), 0.0) for i in range(FACES + 2)]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
              *(f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")), f"element face {FACES}",
              "property list uchar int vertex_indices", "property int plane_id", "property int observations",
              "property float sigma", "end_header"]
    body = b"".join(struct.pack("<6f", *vertex, 0, 0, 1) for vertex in vertices)
    for i in range(FACES):
        corners = (i, i + 1, i + 2) if i % 2 else (i + 1, i, i + 2)
        body += struct.pack("<B3iiif", 3, *corners, 3 if i < FACES // 2 else -1, 5, 0.01)
    path.write_bytes(("\n".join(header) + "\n").encode() + body)


def write_truth(folder, errors):
    """What facet eval leaves: position errors (m) of every frame."""
    poses = [(math.cos(0.04 * i), math.sin(0.04 * i), 1.0) for i in range(FRAMES)]
    write_table(folder / "ate.csv", ["stamp_ns", "true_x", "true_y", "true_z", "x", "y", "z", "error_m", "error_deg"],
                [(stamp(i), *p, p[0] + errors[i], p[1], p[2], errors[i], 0.1) for i, p in enumerate(poses)])
    write_table(folder / "rpe.csv", ["length_m", "stamp_ns", "translation_m", "translation_percent", "rotation_deg",
                                     "yaw_deg"],
                [(length, stamp(i), 0.01 * length * (i % 5), 1.0, 0.2, 0.1) for length in (1, 2) for i in range(40)])
    names = [f"{kind}_{key}_{axis}" for kind in ("error", "sigma") for key in ("theta", "p", "v") for axis in "xyz"]
    write_table(folder / "errors.csv", ["stamp_ns", *names, "nees_pose"],
                [(stamp(i), *[0.001] * 9, *[0.002] * 9, 6.0) for i in range(FRAMES)])
    write_table(folder / "mesh_distance.csv", ["corner_0", "corner_1", "corner_2", "side_01", "side_12", "side_20"],
                [[0.001 * (i % 90)] * 6 for i in range(FACES)])
    rmse = math.sqrt(sum(e * e for e in errors) / len(errors))
    shares = {"median": 0.0123, "p90": 0.04, "within": [0.5, 0.7, 0.9]}
    (folder / "eval.json").write_text(json.dumps({
        "path_m": 6.4, "end_drift_percent": 0.25, "coverage": {"time": 1.0},
        "ate_se3": {"translation_m": {"median": sorted(errors)[len(errors) // 2], "rmse": rmse, "max": max(errors)},
                    "transform": {"p": [0, 0, 0], "q_xyzw": [0, 0, 0, 1]}},
        "ate_yaw4": {"rotation_deg": {"rmse": 0.1}}, "consistency": {"nees": {"pose": {"mean": 6.0}}},
        "mesh": {"tolerances_m": [0.01, 0.05, 0.1],
                 "by_trajectory": {"accuracy_m": shares, "completeness_m": shares}}}))


def write_run(folder, mode="s", dataset="/logs/ring/mav0", errors=None, parameters=None):
    """Fills a folder; with ground truth if there are errors, with `parameters` that differ from their defaults."""
    folder.mkdir(parents=True, exist_ok=True)
    keyframes = range(0, FRAMES, EVERY)
    write_table(folder / "trajectory.csv", ["#stamp"] + ["-"] * 16,
                [(stamp(i), math.cos(0.04 * i), math.sin(0.04 * i), 1.0, 1, 0, 0, 0, 0.1, 0.2, 0, *[0.01] * 6)
                 for i in range(FRAMES)])
    health = ["stamp_ns", "state", "quality", "is_keyframe", "tracked", "landmarks", "calibration_stretch",
              "calibration_scale", "time_offset_s", "time_offset_sigma_s", "reset_counter", "reason_names"]
    write_table(folder / "health.csv", health,
                [(stamp(i), "DEGRADED" if 50 < i < 70 else "TRACKING", 90, int(i % EVERY == 0), 150, 300, 0.5, 1.0,
                  1e-3, 1e-4, 0, "few_features" if 50 < i < 70 else "") for i in range(FRAMES)])
    write_table(folder / "timing.csv", ["stamp_ns", "is_keyframe", "total_ms", *(f"{name}_ms" for name in STAGES),
                                        *(f"{name}_cpu_ms" for name in STAGES)],
                [(stamp(i), int(i % EVERY == 0), 5.0, *[0.5] * len(STAGES),
                  *[(0.4 if i > 81 else 0.3) if i % EVERY == 1 else 0.0] * len(STAGES)) for i in range(FRAMES)])
    write_table(folder / "planes.csv", ["stamp_ns", "id", "kind", "is_held", "area_m2"],
                [(stamp(i), 3, "horizontal", int(i > 80), 1.5) for i in keyframes if i > 20])
    write_table(folder / "mesh.csv", ["stamp_ns", "departed"], [(stamp(i), 1) for i in keyframes])
    write_table(folder / "rays.csv", ["stamp_ns", "px", "py", "pz", "dx", "dy", "dz", "in_view", "unknown", "free_m",
                                      "obstacle_m"],
                [(stamp(i), 1, 0, 1, math.cos(k), math.sin(k), 0, 1, k % 2, 2.0, 1.5 if k % 3 else "inf")
                 for i in keyframes for k in range(8)])
    names = ["left_fx", "left_cx", "mount_theta_y", "right_p_y"]
    write_table(folder / "calibration.csv", ["stamp_ns", *(n + end for n in names for end in ("", "_sigma"))],
                [(stamp(i), *[1e-3, 1e-4] * 4) for i in keyframes])
    write_mesh(folder / "mesh.ply")
    camera = {"intrinsics_px": [450, 450, 376, 240], "p_B_C_m": [0, 0, 0], "q_B_C_xyzw": [0, 0, 0, 1]}
    (folder / "summary.json").write_text(json.dumps({
        "dataset": dataset, "mode": mode, "version": "0.1.0", "frames": FRAMES, "keyframes": len(keyframes),
        "frames_by_state": {"TRACKING": FRAMES - 19, "DEGRADED": 19}, "path_m": 6.4, "warnings": 0,
        "warnings_by_kind": {}, "faults": [], "parameters": parameters or {}, "estimates": FRAMES,
        "mesh": {"run_faces": FACES}, "cameras": {"given": {"cam0": camera}},
        "timing": {"all": {"mean": 5.0}, "processor": {"all": {"mean": 4.0}}}}))
    if errors:
        write_truth(folder, errors)
    return folder
