#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""What the package does when it is installed and purged: the system's programs note what they are asked to do."""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

PACKAGING = Path(__file__).resolve().parents[3] / "app/packaging"
FAKE = """#!/bin/sh
printf '%s\\n' "$(basename "$0") $*" >> "$LOG"
case "$(basename "$0") $*" in
    "getent group dialout") exit 2 ;;
    "getent passwd facet") exit 2 ;;
esac
"""
DROP_IN = "etc/systemd/system/facet.service.d/10-vehicle.conf"


class PackageHooks(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        (self.root / "bin").mkdir()
        for name in ("getent", "addgroup", "adduser", "systemctl", "udevadm"):
            program = self.root / "bin" / name
            program.write_text(FAKE)
            program.chmod(0o755)
        (self.root / "run/systemd/system").mkdir(parents=True)
        (self.root / "etc/facet").mkdir(parents=True)

    def tearDown(self):
        self.folder.cleanup()

    def run_hook(self, name, *arguments):
        """What it asked of the system."""
        log = self.root / "log"
        log.write_text("")
        environment = dict(os.environ, PATH=f"{self.root}/bin:{os.environ['PATH']}", LOG=str(log),
                           DPKG_ROOT=str(self.root))
        subprocess.run(["sh", PACKAGING / name, *arguments], check=True, env=environment)
        return log.read_text().splitlines()

    def test_the_user_is_in_the_groups_of_the_devices_that_there_are(self):
        asked = self.run_hook("postinst", "configure", "")
        for group in ("video", "spi", "gpio"):
            self.assertIn(f"adduser --quiet facet {group}", asked)
        self.assertNotIn("adduser --quiet facet dialout", asked)

    def test_the_rules_hold_for_devices_that_are_there_already(self):
        triggers = [line for line in self.run_hook("postinst", "configure", "") if line.startswith("udevadm trigger")]
        self.assertEqual(len(triggers), 1)
        rules = (PACKAGING / "60-facet.rules").read_text()
        for subsystem in ("video4linux", "media", "dma_heap", "spidev", "gpio"):
            self.assertIn(f'SUBSYSTEM=="{subsystem}"', rules)
            self.assertIn(f"--subsystem-match={subsystem}", triggers[0])

    def test_a_purge_leaves_nothing_that_the_package_or_its_deployment_brought(self):
        drop_in = self.root / DROP_IN
        drop_in.parent.mkdir(parents=True)
        drop_in.write_text("[Service]\n")
        self.assertIn("systemctl daemon-reload", self.run_hook("postrm", "remove"))
        self.assertTrue(drop_in.exists())
        self.assertIn("systemctl daemon-reload", self.run_hook("postrm", "purge"))
        self.assertFalse(drop_in.parent.exists())
        self.assertFalse((self.root / "etc/facet").exists())

    def test_a_purge_leaves_what_the_user_wrote(self):
        own = self.root / "etc/systemd/system/facet.service.d/50-own.conf"
        own.parent.mkdir(parents=True)
        own.write_text("[Service]\n")
        self.run_hook("postrm", "purge")
        self.assertTrue(own.exists())

    def test_other_programs_are_ended_before_the_estimator_when_memory_runs_out(self):
        self.assertIn("OOMScoreAdjust=-900", (PACKAGING / "facet.service").read_text().splitlines())


if __name__ == "__main__":
    unittest.main()
