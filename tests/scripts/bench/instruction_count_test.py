#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/bench/instruction_count.py and marked_document.py."""
import pathlib
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[3] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True
from bench import instruction_count, marked_document  # noqa: E402


class Figures(unittest.TestCase):
    def test_percentiles_are_values_of_the_list(self):
        self.assertEqual(instruction_count.figures([5, 1, 4, 2, 3]), {"median": 3, "p99": 5, "max": 5})
        self.assertEqual(instruction_count.percentile(range(1, 201), 0.99), 198)
        self.assertEqual(instruction_count.percentile([7], 0.5), 7)


class Counts(unittest.TestCase):
    def test_only_what_ends_when_a_frame_is_written_counts_in_order(self):
        frame, after = instruction_count.FRAME, instruction_count.AFTER
        files = [(1, frame, 90_000_000), (2, after, 3_000_000), (3, frame, 900), (4, frame, 2_000_000),
                 (5, after, 4_000_000), (10, after, 5_000_000)]
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for number, trigger, count in files:
                (folder / f"callgrind.out.{number}").write_text(
                    f"desc: Trigger: --dump-before={trigger}facet::Something const&)\nfn=main\n1 2\ntotals: {count}\n")
            (folder / "callgrind.out").write_text("desc: Trigger: Program termination\ntotals: 7000000\n")
            self.assertEqual(instruction_count.counts_of(folder), [3_000_000, 4_000_000, 5_000_000])


class Marks(unittest.TestCase):
    def test_only_the_part_of_that_name_is_replaced(self):
        with tempfile.TemporaryDirectory() as name:
            document = pathlib.Path(name) / "page.md"
            document.write_text("a\n<!-- one -->\nold\n<!-- end -->\nb\n<!-- two -->\nkept\n<!-- end -->\n")
            self.assertTrue(marked_document.put_between_marks(document, "one", "new"))
            expected = "a\n<!-- one -->\nnew\n<!-- end -->\nb\n<!-- two -->\nkept\n<!-- end -->\n"
            self.assertEqual(document.read_text(), expected)

    def test_a_document_without_the_part_is_untouched(self):
        with tempfile.TemporaryDirectory() as name:
            document = pathlib.Path(name) / "page.md"
            for text in ("nothing\n", "<!-- one -->\nwithout an end\n"):
                document.write_text(text)
                self.assertFalse(marked_document.put_between_marks(document, "one", "new"))
                self.assertEqual(document.read_text(), text)


if __name__ == "__main__":
    unittest.main()
