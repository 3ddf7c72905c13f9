#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""What .ci/run does when a part that it needs cannot be had: scripts that note how they are called stand for ours.

Usage: ci_run_test.py
"""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(folder, failing="", without=""):
    """Exit code, calls in order, and what was printed."""
    calls = folder / "calls"
    calls.write_text("", encoding="utf-8")
    for name in ("check", "setup", "test", "target/hil_kernel"):
        script = folder / "scripts" / name
        script.parent.mkdir(parents=True, exist_ok=True)
        script.write_text(f'#!/bin/sh\necho "{name} $*" >> {calls}\n[ "{name} $*" != "{failing}" ]\n', encoding="utf-8")
        script.chmod(0o755)
    done = subprocess.run([folder / ".ci/run"], capture_output=True, text=True, check=False,
                          env={**os.environ, "FACET_CI_WITHOUT": without})
    return done.returncode, calls.read_text(encoding="utf-8").split("\n")[:-1], done.stdout + done.stderr


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / ".ci").mkdir()
        shutil.copy(ROOT / ".ci/run", folder / ".ci/run")
        parts = ["setup --npm", "setup --browser", "setup --opencv"]
        code, calls, _ = run(folder)
        assert code == 0 and calls == ["check ", *parts, "target/hil_kernel --cached", "test "], calls
        for part in parts:  # a part that cannot be had ends the run before the tests
            code, calls, _ = run(folder, failing=part)
            assert code != 0 and calls[-1] == part, (part, calls)
        code, calls, text = run(folder, failing="setup --npm", without="npm browser")
        assert code == 0 and "setup --npm" not in calls and "setup --opencv" in calls, calls
        assert "without npm" in text and "without browser" in text, text
        code, calls, text = run(folder, without="chromium")
        assert code == 2 and calls == [] and "names 'chromium'; there are npm browser opencv" in text, text
        code, calls, text = run(folder, failing="target/hil_kernel --cached")
        assert code == 0 and "hil_test skips" in text, text
    return 0


if __name__ == "__main__":
    sys.exit(main())
