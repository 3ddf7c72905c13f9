# SPDX-License-Identifier: BSD-2-Clause
"""Instructions of every frame of a replay, counted by callgrind: the same on every machine of one instruction set."""
import re
import shutil

from bench.benchmark_lib import first_error, read_table, run

# Callgrind writes what it has counted before each call of these: the second comes right after a frame.
FRAME = "facet::FramePipeline::add_frame("
AFTER = "facet::FrameRecorder::write("


def percentile(values, share):
    """The least value that `share` of the values do not exceed."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, max(0, round(share * len(ordered) + 0.5) - 1))]


def figures(values):
    return {"median": percentile(values, 0.5), "p99": percentile(values, 0.99), "max": max(values)}


def counts_of(folder):
    """Instructions of each frame, in order."""
    counts = {}
    for path in folder.glob("callgrind.out.*"):
        match = re.fullmatch(r"callgrind\.out\.(\d+)", path.name)
        text = path.read_text()
        total = re.search(r"^totals: (\d+)", text, re.MULTILINE)
        if match and total and re.search(rf"^desc: Trigger: --dump-before={re.escape(AFTER)}", text, re.MULTILINE):
            counts[int(match[1])] = int(total[1])
    return [counts[number] for number in sorted(counts)]


def count_instructions(replay_command, out):
    """Figures of all frames, of tracked frames and of keyframes of a replay into `out`, or what went wrong."""
    if not shutil.which("valgrind"):
        return None, "counting instructions needs valgrind: apt-get install valgrind"
    command = ["valgrind", "--tool=callgrind", f"--dump-before={FRAME}*", f"--dump-before={AFTER}*",
               f"--callgrind-out-file={out / 'callgrind.out'}", *replay_command]
    # Valgrind does not know every instruction: what ends the program after its last frame does no harm.
    code, said = run(command, out / "log.txt")
    timing = out / "timing.csv"
    is_keyframe = [row["is_keyframe"] == "1" for row in read_table(timing)] if timing.is_file() else []
    counts = counts_of(out)
    if not counts or len(counts) != len(is_keyframe):
        return None, f"{len(counts)} counts of {len(is_keyframe)} frames (exit {code}: {first_error(said)})"
    kinds = {"all": counts, "tracked": [c for c, k in zip(counts, is_keyframe) if not k],
             "keyframe": [c for c, k in zip(counts, is_keyframe) if k]}
    seen = {kind: figures(values) for kind, values in kinds.items() if values}
    return {"mean": sum(counts) / len(counts), **seen}, ""
