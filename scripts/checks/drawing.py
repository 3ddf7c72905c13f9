#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Draws who includes whom, from the code, into ARCHITECTURE.md; or checks that the drawing is that of the code.

Folders are the areas of layers.py; tests and docs are left out. An arrow from A to B: a file of A includes one of B. An
arrow that follows from two others is left out.

Usage: drawing.py [--write] [ROOT]      exit code 1 if the drawing is another one (unless --write)
"""
import argparse
import sys
import textwrap
from pathlib import Path

from layers import FLIGHT_FOLDERS, INCLUDE, area_of

BEGIN = "<!-- Made by scripts/checks/drawing.py --write -->\n"
END = "<!-- End of the drawing -->\n"
DRIVERS = "drivers"  # drawn as one: none sees another


def room(path):
    area = area_of(path)
    return DRIVERS if area is not None and area.startswith(DRIVERS) else area


def read_arrows(root):
    """{area: set of areas that it includes}"""
    arrows = {}
    for folder in FLIGHT_FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            here = room(file.relative_to(root).as_posix())
            arrows.setdefault(here, set())
            for line in file.read_text(encoding="utf-8").splitlines():
                match = INCLUDE.match(line)
                there = room(match.group(2)) if match and match.group(1) == '"' else None
                if there not in (None, here):
                    arrows[here].add(there)
    return arrows


def reachable(arrows, begin):
    """Areas that can be reached from one, itself only over a circle."""
    seen, waiting = set(), list(arrows.get(begin, ()))
    while waiting:
        area = waiting.pop()
        if area not in seen:
            seen.add(area)
            waiting += arrows.get(area, ())
    return seen


def reduced(arrows):
    """The least arrows with the same reach. ValueError if folders include each other in a circle."""
    for area in arrows:
        if area in reachable(arrows, area):
            raise ValueError(f"{area} includes itself over other folders")
    return {area: {to for to in others if not any(to in reachable(arrows, other) for other in others - {to})}
            for area, others in arrows.items()}


def name(area):
    return area.replace("/", "_")


def draw(arrows):
    """Text in Mermaid's language: a box for each top folder, in it its areas."""
    lines = ["```mermaid", "flowchart LR"]
    for folder in FLIGHT_FOLDERS:
        areas = sorted(area for area in arrows if area.split("/")[0] == folder)
        lines.append(f"  subgraph top_{folder}[{folder}]")
        boxes = "; ".join(f"{name(area)}[{area.removeprefix(folder + '/')}]" for area in areas)
        lines += [f"    {line}" for line in textwrap.wrap(boxes, 112)]
        lines.append("  end")
    lines += [f"  {name(area)} --> {' & '.join(name(to) for to in sorted(arrows[area]))}"
              for area in sorted(arrows) if arrows[area]]
    return "\n".join([*lines, "```", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parents[2])
    parser.add_argument("--write", action="store_true", help="put the drawing into ARCHITECTURE.md")
    arguments = parser.parse_args()
    document = arguments.root / "ARCHITECTURE.md"
    text = document.read_text(encoding="utf-8")
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        print(f"{document}: no place for the drawing, between {BEGIN.strip()} and {END.strip()}")
        return 1
    before, rest = text.split(BEGIN)
    old, after = rest.split(END)
    try:
        new = draw(reduced(read_arrows(arguments.root)))
    except ValueError as error:
        print(error)
        return 1
    if arguments.write:
        document.write_text(before + BEGIN + new + END + after, encoding="utf-8")
    elif old != new:
        print(f"{document}: the drawing is not that of the code; scripts/checks/drawing.py --write makes it again")
        return 1
    print(f"drawing: {new.count('[') - len(FLIGHT_FOLDERS)} folders, {new.count('-->') + new.count('&')} arrows")
    return 0


if __name__ == "__main__":
    sys.exit(main())
