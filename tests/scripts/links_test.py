#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Every relative link in a document of the project leads to a file or folder, and its anchor to a heading; and every
document that a source names is there."""
import re
import unittest
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parents[2]
SKIPPED = {"build", "out"}
LINK = re.compile(r"\]\(([^()\s]+)\)")
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.MULTILINE | re.DOTALL)
FOLDERS = ("app", "docs", "drivers", "estimator", "mesh", "platform", "scripts", "tests")
ENDINGS = {"", ".1", ".cpp", ".dbc", ".h", ".js", ".py", ".txt", ".yaml"}
NAMED = re.compile(r"\b(?:app|docs|drivers|estimator|mesh|platform|scripts|tests)/[\w/]+\.md\b")
HEADING = re.compile(r"^#+ +(.+?) *$", re.MULTILINE)


def documents():
    for path in sorted(ROOT.rglob("*.md")):
        folders = path.relative_to(ROOT).parts[:-1]
        if not any(name in SKIPPED or name.startswith(".") for name in folders):
            yield path


def anchors(text):
    """Names that headings are linked by, as GitHub makes them: lower case, no punctuation, hyphens for spaces."""
    headings = HEADING.findall(re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(path):
    """The relative links of one document that lead nowhere."""
    for target in LINK.findall(CODE.sub("", path.read_text(encoding="utf-8"))):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = unquote(target).partition("#")
        place = path.parent / file if file else path
        if not place.exists():
            yield f"{target}: no such file"
        elif anchor and (place.is_dir() or anchor not in anchors(place.read_text(encoding="utf-8"))):
            yield f"{target}: no such heading"


class Links(unittest.TestCase):
    def test_anchors_are_named_as_github_names_them(self):
        self.assertEqual(anchors("# A b\n\n```\n# no heading\n```\n## `sp` is an alias, of `s`\n"),
                         {"a-b", "sp-is-an-alias-of-s"})

    def test_relative_links_of_all_documents_resolve(self):
        found = list(documents())
        self.assertIn(ROOT / "README.md", found)
        broken = [f"{path.relative_to(ROOT)}: {what}" for path in found for what in broken_links(path)]
        self.assertEqual(broken, [])

    def test_documents_that_sources_name_are_there(self):
        missing = []
        for folder in FOLDERS:
            for path in sorted((ROOT / folder).rglob("*")):
                if not path.is_file() or path.suffix not in ENDINGS:
                    continue
                text = path.read_text("utf-8", "replace")
                missing += [f"{path.relative_to(ROOT)}: {name}" for name in NAMED.findall(text)
                            if not (ROOT / name).exists()]
        self.assertEqual(missing, [])


if __name__ == "__main__":
    unittest.main()
