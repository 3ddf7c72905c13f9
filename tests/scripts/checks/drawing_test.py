#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/drawing.py on small trees."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import drawing  # noqa: E402

PAGE = "# Page\n" + drawing.BEGIN + drawing.END + "Rest.\n"


class Arrows(unittest.TestCase):
    def test_an_arrow_that_follows_from_two_others_is_left_out(self):
        arrows = {"a": {"b", "c"}, "b": {"c"}, "c": set()}
        self.assertEqual(drawing.reduced(arrows), {"a": {"b"}, "b": {"c"}, "c": set()})

    def test_a_circle_is_refused(self):
        with self.assertRaises(ValueError):
            drawing.reduced({"a": {"b"}, "b": {"a"}})


class Document(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        (self.root / "ARCHITECTURE.md").write_text(PAGE, encoding="utf-8")
        self.add("estimator/imu/a.h", '#include "estimator/values/b.h"\n#include <vector>\n')
        self.add("estimator/values/b.h", '#include "platform/base/c.h"\n')
        self.add("platform/base/c.h", "")

    def add(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def run_drawing(self, *options):
        program = [sys.executable, ROOT / "scripts/checks/drawing.py", *options, self.root]
        return subprocess.run(program, stdout=subprocess.PIPE, text=True, check=False)

    def test_written_once_it_is_that_of_the_code(self):
        self.assertEqual(self.run_drawing().returncode, 1)
        self.assertEqual(self.run_drawing("--write").returncode, 0)
        self.assertEqual(self.run_drawing().returncode, 0)
        text = (self.root / "ARCHITECTURE.md").read_text(encoding="utf-8")
        self.assertIn("  estimator_imu --> estimator_values\n  estimator_values --> platform_base\n", text)
        self.assertTrue(text.startswith("# Page\n") and text.endswith("Rest.\n"))

    def test_a_new_include_makes_it_stale(self):
        self.run_drawing("--write")
        self.add("platform/base/c.h", '#include "estimator/imu/a.h"\n')
        done = self.run_drawing()
        self.assertEqual(done.returncode, 1)
        self.assertIn("includes itself", done.stdout)

    def test_a_page_without_a_place_for_it_is_refused(self):
        (self.root / "ARCHITECTURE.md").write_text("# Page\n", encoding="utf-8")
        self.assertEqual(self.run_drawing("--write").returncode, 1)


if __name__ == "__main__":
    unittest.main()
