# SPDX-License-Identifier: BSD-2-Clause
"""Remembers which files have passed a check, by their contents and those of all project headers they include."""
import hashlib
import re
from functools import lru_cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


@lru_cache(maxsize=None)
def contents(file):
    return file.read_bytes()


@lru_cache(maxsize=None)
def included_by(file):
    names = INCLUDE.findall(contents(file).decode("utf-8"))
    # A header made by CMake counts by its template.
    candidates = [path for name in names for path in (ROOT / name, ROOT / f"{name}.in")]
    return tuple(path for path in candidates if path.is_file())


def closure(file):
    """The file and all project headers it includes, directly or not, in a fixed order."""
    seen = {file}
    waiting = [file]
    while waiting:
        for header in included_by(waiting.pop()):
            if header not in seen:
                seen.add(header)
                waiting.append(header)
    return sorted(seen)


class Cache:
    """Stamps in build/<name>; system headers and tools are assumed not to change."""

    def __init__(self, name):
        self.folder = ROOT / "build" / name
        self.folder.mkdir(parents=True, exist_ok=True)

    def stamp(self, file, context):
        """Where the success of this file in this context (flags, settings) is recorded."""
        state = hashlib.sha256(context)
        for part in closure(file):
            state.update(part.relative_to(ROOT).as_posix().encode() + b"\0" + contents(part))
        return self.folder / state.hexdigest()
