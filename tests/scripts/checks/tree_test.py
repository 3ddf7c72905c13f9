#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/tree.py: which language a file is in."""
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import tree  # noqa: E402


class Tree(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, path, text=""):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def test_the_ending_gives_the_language(self):
        for path in ("mesh/a.h", "mesh/a.cpp", "app/a.h.in", "tests/hil/a.c"):
            self.write(path)
        for path in ("CMakeLists.txt", "mesh/CMakeLists.txt", "toolchains/a.cmake", "tests/a_test.py", "docs/a.md"):
            self.write(path)
        self.assertEqual(tree.project_files(self.root, {"c++"}),
                         ["app/a.h.in", "mesh/a.cpp", "mesh/a.h", "tests/hil/a.c"])
        self.assertEqual(tree.project_files(self.root, {"cmake"}),
                         ["CMakeLists.txt", "mesh/CMakeLists.txt", "toolchains/a.cmake"])

    def test_programs_without_an_ending_are_known_by_their_first_line(self):
        self.write("scripts/a", "#!/usr/bin/env python3\n")
        self.write("scripts/b", "#!/usr/bin/env bash\n")
        self.write("app/packaging/postinst", "#!/bin/sh\n")
        self.write("LICENSE", "python\n")
        self.assertEqual(tree.project_files(self.root, {"python"}), ["scripts/a"])
        self.assertEqual(tree.project_files(self.root, {"shell"}), ["app/packaging/postinst", "scripts/b"])

    def test_what_is_built_is_not_looked_at(self):
        for path in ("build/release/a.py", "out/a.py", ".ci/a.py"):
            self.write(path)
        self.assertEqual(tree.project_files(self.root, {"python"}), [".ci/a.py"])

    def test_the_project_itself(self):
        programs = tree.project_files(ROOT, {"python"})
        self.assertIn("scripts/benchmark", programs)
        self.assertIn("tests/scripts/checks/tree_test.py", programs)


if __name__ == "__main__":
    unittest.main()
