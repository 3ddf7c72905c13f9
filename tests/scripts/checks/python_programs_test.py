#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/python_programs.py on small programs, each with one thing wrong."""
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import python_programs  # noqa: E402

FIRST_LINE = "#!/usr/bin/env python3\n"


class PythonPrograms(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        (self.root / "scripts").mkdir()

    def tearDown(self):
        self.folder.cleanup()

    def problems(self, text, name="scripts/program"):
        (self.root / name).write_text(FIRST_LINE + text)
        return python_programs.check_tree(self.root)[0]

    def test_a_program_without_an_ending_is_compiled(self):
        found = self.problems("x = 1\nif x\n")
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith("scripts/program:3: "), found[0])

    def test_an_invalid_escape_is_an_error(self):
        found = self.problems("print('\\d')\n")
        self.assertEqual(len(found), 1, found)
        self.assertIn("invalid escape", found[0])

    def test_a_comparison_that_python_warns_of_is_an_error(self):
        self.assertEqual(len(self.problems("print(1 is 1)\n")), 1)

    def test_nothing_is_left_behind(self):
        self.problems("print(1)\n", "scripts/program.py")
        self.assertEqual([file.name for file in (self.root / "scripts").iterdir()], ["program.py"])

    @unittest.skipUnless(shutil.which("pyflakes3"), "pyflakes3 is not installed (scripts/setup --check)")
    def test_unused_imports_and_undefined_names(self):
        self.assertEqual(self.problems("print(1)\n"), [])
        found = self.problems("import os\nprint(one)\n")
        self.assertEqual(len(found), 2, found)
        self.assertTrue(any("'os' imported but unused" in line for line in found), found)
        self.assertTrue(any("undefined name 'one'" in line for line in found), found)


if __name__ == "__main__":
    unittest.main()
