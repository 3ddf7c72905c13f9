#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/words.py on small trees: what is prose, and what is not."""
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import words  # noqa: E402


class Words(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def found(self, path, text):
        """Line and phrase of each finding in a tree with this file alone."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        findings, _ = words.check_tree(self.root)
        file.unlink()
        return [tuple(finding.split('"')[0].rstrip(": ").rsplit(":", 1)[1:]) + (finding.split('"')[1],)
                for finding in findings]

    def test_documents_are_prose_but_for_code_and_links(self):
        self.assertEqual(self.found("guide/a.md", "# A\n\nIt is begun Anew.\n"), [("3", "Anew")])
        self.assertEqual(self.found("README.md", "`anew` [b](told.md)\n\n```\nanew\n```\n\nbegun\n"), [])
        self.assertEqual(self.found("app/packaging/facet.1", ".TH FACET\nthe disc\n"), [("2", "disc")])

    def test_a_phrase_may_run_over_the_end_of_a_line(self):
        self.assertEqual(self.found("a.md", "it takes processor\ntime\n"), [("1", "processor time")])
        self.assertEqual(self.found("mesh/a.h", "/// it takes processor\n/// time\n"), [("1", "processor /// time")])

    def test_of_sources_comments_of_headers_and_texts_of_the_program(self):
        self.assertEqual(self.found("mesh/a.h", "int told = 1;  ///< is told\n"), [("1", "told")])
        self.assertEqual(self.found("mesh/a.h", "/// @param told  `told`\n"), [])
        self.assertEqual(self.found("tests/a.cpp", '// it is told\nauto x = "it is told";\n'), [])
        text = '// it is told\n\nauto x = "it is told", y = "told";\n'
        self.assertEqual(self.found("app/a.cpp", text), [("3", "told")])

    def test_of_tests_the_names(self):
        self.assertEqual(self.found("tests/a.cpp", '// told\nTEST_CASE("a NaN is told", "[a]") { told("told x"); }\n'),
                         [("2", "told")])

    def test_of_scripts_comments_and_texts(self):
        self.assertEqual(self.found("scripts/a.py", 'told = 1  # is told\nx = "told"\ny = "is told"\n'),
                         [("1", "told"), ("3", "told")])
        self.assertEqual(self.found("scripts/a.sh", '#!/bin/sh\n# told\nsay "is told: $told"\n[ "$told" = 1 ]\n'),
                         [("2", "told"), ("3", "told")])
        self.assertEqual(self.found("scripts/a.yaml", "a: 1  # told\n"), [("1", "told")])

    def test_words_of_the_language_and_terms_stay(self):
        for text in ("there is none", "none of these is", "address claiming", "a disc of radius r", "retold"):
            self.assertEqual(self.found("a.md", text + "\n"), [], text)


if __name__ == "__main__":
    unittest.main()
