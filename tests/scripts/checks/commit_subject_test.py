#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/commit_subject, and of the hook that scripts/setup --check makes of it."""
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SCRIPT = ROOT / "scripts/checks/commit_subject"


class CommitSubject(unittest.TestCase):
    def complaint(self, message):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            file.write(message)
            file.flush()
            done = subprocess.run([SCRIPT, file.name], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode != 0, bool(done.stderr), done.stderr)
        return done.stderr

    def test_accepts_area_and_summary_with_and_without_a_body(self):
        for message in ("window: drop the shortest tracks first\n", "app, docs: one name for a thing\n\nWhy.\n",
                        "imu: " + 55 * "x", "# a comment of git\nmesh/planes: merge duplicates\n"):
            self.assertEqual(self.complaint(message), "", message)

    def test_leaves_merges_and_fixups_alone(self):
        for message in ("Merge branch 'words'", "Revert \"window: " + 60 * "x" + "\"", "fixup! window: x"):
            self.assertEqual(self.complaint(message), "", message)

    def test_refuses_other_subjects_with_the_reason(self):
        self.assertIn("area: summary", self.complaint("Update two files\n"))
        self.assertIn("area: summary", self.complaint(""))
        self.assertIn("61 characters, 60 at most", self.complaint("imu: " + 56 * "x"))
        self.assertIn("full stop", self.complaint("imu: more noise.\n"))
        self.assertIn("empty line", self.complaint("imu: more noise\nbecause of rotors\n"))

    def test_the_hook_is_installed_once_and_leaves_another_one_alone(self):
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            for path in ("scripts/checks/commit_subject", "scripts/checks/install_hook"):
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_bytes((ROOT / path).read_bytes())
                (root / path).chmod(0o755)
            git = ["git", "-C", name, "-c", "user.name=a", "-c", "user.email=a@example.org"]
            subprocess.run(["git", "init", "-q", name], check=True)
            for _ in range(2):
                subprocess.run([root / "scripts/checks/install_hook"], check=True, capture_output=True)
            commit = [*git, "commit", "-q", "--allow-empty", "-m"]
            self.assertNotEqual(subprocess.run([*commit, "Something"], check=False, capture_output=True).returncode, 0)
            self.assertEqual(subprocess.run([*commit, "docs: something"], check=False).returncode, 0)
            hook = root / ".git/hooks/commit-msg"
            hook.write_text("#!/bin/sh\nexit 0\n")
            done = subprocess.run([root / "scripts/checks/install_hook"], check=True, capture_output=True, text=True)
            self.assertIn("another commit-msg hook", done.stderr)
            self.assertEqual(hook.read_text(), "#!/bin/sh\nexit 0\n")


if __name__ == "__main__":
    unittest.main()
