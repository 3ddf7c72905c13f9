#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/columns.py on lines around the limit."""
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import columns  # noqa: E402

FITS = "x" * columns.MAX_COLUMNS
TOO_WIDE = FITS + "x"


class Columns(unittest.TestCase):
    def numbers(self, *lines, is_cpp=True):
        return [number for number, _ in columns.too_wide(lines, is_cpp)]

    def test_120_columns_fit(self):
        self.assertEqual(self.numbers(FITS, TOO_WIDE, FITS, TOO_WIDE), [2, 4])

    def test_comments_count(self):
        self.assertEqual(self.numbers("// " + FITS, "# " + FITS, "/// a"), [1, 2])

    def test_characters_count_not_bytes(self):
        self.assertEqual(self.numbers("\u00e9" * columns.MAX_COLUMNS), [])

    def test_a_long_url_may_be_wider(self):
        url = "https://example.org/" + FITS
        self.assertEqual(self.numbers(f"// see {url}", f"# {url}."), [])

    def test_a_url_in_a_line_that_is_too_wide_without_it_may_not(self):
        self.assertEqual(self.numbers(f"// https://example.org {FITS}"), [1])

    def test_lines_that_begin_in_a_raw_string_may_be_wider(self):
        self.assertEqual(self.numbers('const char* text = R"(', TOO_WIDE, TOO_WIDE + ')";', TOO_WIDE), [4])
        self.assertEqual(self.numbers('f(R"json({', TOO_WIDE, ')"', TOO_WIDE, ')json");', TOO_WIDE), [6])

    def test_a_raw_string_in_one_line_is_over_at_its_end(self):
        self.assertEqual(self.numbers('f(R"(a)", R"(b)");', TOO_WIDE), [2])
        self.assertEqual(self.numbers('f(R"(a)", R"(b', TOO_WIDE, ')");', TOO_WIDE), [4])

    def test_only_cpp_has_raw_strings(self):
        self.assertEqual(self.numbers('x = R"(', TOO_WIDE, is_cpp=False), [2])

    def test_files_of_every_language(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "scripts").mkdir()
            for name in ("CMakeLists.txt", "scripts/a.cpp", "scripts/a.py", "scripts/a.sh", "scripts/a.yaml"):
                (root / name).write_text(TOO_WIDE + "\n")
            (root / "scripts/program").write_text("#!/bin/sh\n" + TOO_WIDE + "\n")
            (root / "README.md").write_text(TOO_WIDE + "\n")
            violations, files = columns.check_tree(root)
            self.assertEqual(files, 6)
            self.assertEqual(len(violations), 6, violations)
            self.assertIn("scripts/program:2: 121 columns; break the line (120 at most)", violations)


if __name__ == "__main__":
    unittest.main()
