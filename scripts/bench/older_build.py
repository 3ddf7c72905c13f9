# SPDX-License-Identifier: BSD-2-Clause
"""Programs of earlier commits, each built in a work tree of its own below out/against and kept for the next time."""
import shutil
import subprocess
import sys

from bench.benchmark_lib import ROOT


class BuildFailed(Exception):
    pass


def git(*arguments):
    """What git prints; BuildFailed with its last line if it fails."""
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BuildFailed((done.stderr.strip().splitlines() or [f"git {arguments[0]} failed"])[-1])
    return done.stdout.strip()


def program_of(commit):
    """The release program of a commit (any name that git knows), built if it is not there yet.

    Raises BuildFailed with one line that names the commit or the log.
    """
    if not (ROOT / ".git").exists():
        raise BuildFailed("this folder is no git checkout, so there are no earlier commits to build")
    known = git("rev-parse", "--verify", f"{commit}^{{commit}}")
    short = known[:12]
    folder = ROOT / "out/against" / short
    program = folder / "build/release/bin/facet"
    if program.is_file():
        return program
    if not (folder / "CMakeLists.txt").is_file():
        shutil.rmtree(folder, ignore_errors=True)
        git("worktree", "prune")
        git("worktree", "add", "--detach", "--force", str(folder), known)
    log = folder.with_suffix(".log")
    print(f"building {short} (log: {log})", file=sys.stderr, flush=True)
    with log.open("w") as stream:
        done = subprocess.run([str(folder / "scripts/build")], stdout=stream, stderr=subprocess.STDOUT, cwd=folder,
                              check=False)
    if done.returncode != 0 or not program.is_file():
        raise BuildFailed(f"{short} does not build here: {log}")
    return program
