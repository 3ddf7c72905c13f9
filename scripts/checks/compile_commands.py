# SPDX-License-Identifier: BSD-2-Clause
"""What a build compiles, and with which flags, from its compile_commands.json."""
import json
import shlex
from pathlib import Path

from cache import ROOT


class Source:
    """A source of the project, its target's folder in the build, and the flags it is compiled with."""

    def __init__(self, entry):
        self.file = Path(entry["file"])
        words = shlex.split(entry["command"])
        if words[0].endswith("ccache"):
            words = words[1:]
        self.compiler = words[0]
        output = Path(words[words.index("-o") + 1])
        self.target = next((str(path) for path in output.parents if path.suffix == ".dir"), str(output.parent))
        self.flags = [word for word, before in zip(words[1:], words)
                      if word not in ("-o", "-c") and before not in ("-o", "-c")]

    def folder(self):
        """The folder at the project's root that it lies in."""
        return self.file.relative_to(ROOT).parts[0]


def sources_of(build_folder, left_out):
    """Every source once, but for those below these folders. Sources that the build itself writes are in "build"."""
    sources = {}
    for entry in json.loads((build_folder / "compile_commands.json").read_text(encoding="utf-8")):
        source = Source(entry)
        if source.folder() not in left_out:
            sources.setdefault(source.file, source)
    return list(sources.values())
