#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/deploy: ssh and scp are programs made for the purpose, which note what they are asked to do."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Notes the command, fails if it matches FAIL_ON, and answers for a vehicle with the architecture THERE.
FAKE = """#!/bin/sh
printf '%s\\n' "$(basename "$0") $*" >> "$LOG"
if [ -n "$FAIL_ON" ] && printf '%s' "$*" | grep -q -e "$FAIL_ON"; then exit 1; fi
case "$*" in
    *print-architecture*) echo "$THERE" ;;
    *status*) echo "facet.service: state of the vehicle" ;;
esac
exit 0
"""


# What reads the configuration on this side: NAMED is what it says that the file names.
FAKE_FACET = """#!/bin/sh
[ "$1" = check-config ] || exit 9
case "$2" in
    --files) [ -z "$BAD_CONFIG" ] || { echo "vehicle.yaml:3: bad" >&2; exit 2; }; printf '%s\\n' $NAMED ;;
    --drop-in) echo "[Service]" ;;
esac
"""


class Deploy(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)
        for name in ("ssh", "scp"):
            program = self.root / "bin" / name
            program.parent.mkdir(exist_ok=True)
            program.write_text(FAKE, encoding="utf-8")
            program.chmod(0o755)
        control = self.root / "tree/DEBIAN/control"
        control.parent.mkdir(parents=True)
        control.write_text(
            "Package: facet\nVersion: 1\nArchitecture: arm64\nMaintainer: a <a@b>\nDescription: x\n", encoding="utf-8"
        )
        self.package = self.root / "facet_1_arm64.deb"
        subprocess.run(
            ["dpkg-deb", "--root-owner-group", "--build", str(control.parent.parent), str(self.package)],
            check=True,
            capture_output=True,
        )
        self.config = self.root / "my vehicle.yaml"
        self.config.write_text("window:\n  keyframes: 12\n", encoding="utf-8")
        for name in ("imu.yaml", "cal/camchain.yaml"):
            (self.root / name).parent.mkdir(exist_ok=True)
            (self.root / name).write_text("x: 1\n", encoding="utf-8")
        self.facet = self.root / "facet"
        self.facet.write_text(FAKE_FACET, encoding="utf-8")
        self.facet.chmod(0o755)
        self.with_config = ("--package", self.package, "--config", self.config, "--facet", self.facet)

    def tearDown(self):
        self.folder.cleanup()

    def deploy(self, *arguments, fail_on="", there="arm64", named="cal/camchain.yaml imu.yaml /opt/all.yaml", bad=""):
        """Runs the script; returns its outcome and the lines that ssh and scp noted."""
        log = self.root / "log"
        log.write_text("", encoding="utf-8")
        environment = {
            **os.environ,
            "PATH": f"{self.root / 'bin'}:{os.environ['PATH']}",
            "LOG": str(log),
            "FAIL_ON": fail_on,
            "THERE": there,
            "NAMED": named,
            "BAD_CONFIG": bad,
        }
        run = subprocess.run(
            [str(ROOT / "scripts/deploy"), *map(str, arguments)],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        return run, log.read_text(encoding="utf-8").splitlines()

    def test_all_steps_in_order(self):
        run, log = self.deploy(*self.with_config, "pilot@drone")
        self.assertEqual(run.returncode, 0, run.stderr)
        steps = (
            "print-architecture",
            "mkdir",
            f"scp -q -o BatchMode=yes {self.package} pilot@drone:",
            "mkdir .cache/facet-deploy/config",
            f"scp -q -o BatchMode=yes {self.config} pilot@drone:.cache/facet-deploy/config/vehicle.yaml",
            "pilot@drone:.cache/facet-deploy/config/10-vehicle.conf",
            "mkdir -p .cache/facet-deploy/config/cal",
            f"{self.root}/cal/camchain.yaml pilot@drone:.cache/facet-deploy/config/cal/camchain.yaml",
            f"{self.root}/imu.yaml pilot@drone:.cache/facet-deploy/config/imu.yaml",
            "apt-get",
            "/var/lib/facet-deploy/previous.deb",
            "cp -a /etc/facet /etc/facet.before",
            "facet --version",
            "systemctl restart facet.service",
            "is-active",
            "status",
        )
        self.assertEqual(len(log), len(steps), log)
        for step, line in zip(steps, log):
            self.assertIn(step, line)
            self.assertIn("pilot@drone", line)
        self.assertIn("state of the vehicle", run.stdout)
        self.assertIn("the service runs on pilot@drone", run.stdout)

    def test_without_configuration_the_vehicle_keeps_its_own(self):
        run, log = self.deploy("--package", self.package, "drone")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertFalse([line for line in log if "vehicle.yaml" in line or "/etc/facet" in line])

    def test_a_bad_configuration_or_a_name_that_leads_elsewhere_is_not_brought(self):
        run, log = self.deploy(*self.with_config, "drone", bad="yes")
        self.assertEqual(run.returncode, 2)
        self.assertIn("vehicle.yaml:3: bad", run.stderr)
        self.assertEqual(log, [])
        for name in ("../secret.yaml", "cal/../../x", "a;b"):
            run, log = self.deploy(*self.with_config, "drone", named=name)
            self.assertEqual(run.returncode, 2, name)
            self.assertIn("plain names", run.stderr)
            self.assertEqual(log, [])
        missing = self.root / "no_program"
        missing.write_text("", encoding="utf-8")
        run, log = self.deploy("--package", self.package, "--config", self.config, "--facet", missing, "drone")
        self.assertEqual(run.returncode, 2)
        self.assertIn("scripts/build", run.stderr)

    def test_files_that_must_be_there_already_are_named(self):
        run, log = self.deploy(*self.with_config, "drone")
        self.assertIn("/opt/all.yaml must be on drone already", run.stdout + run.stderr)
        self.assertFalse([line for line in log if "all.yaml" in line])

    def test_rollback_exchanges_what_is_with_what_was(self):
        run, log = self.deploy("--rollback", "drone")
        self.assertEqual(run.returncode, 0, run.stderr)
        for step, line in zip(("facet.before ]", "mv /etc/facet.before /etc/facet", "previous.deb", "restart"), log):
            self.assertIn(step, line)
        self.assertFalse([line for line in log if line.startswith("scp")])
        run, log = self.deploy("--rollback", "drone", fail_on="facet.before ]")
        self.assertEqual(run.returncode, 2)
        self.assertIn("nothing to go back to", run.stderr)
        run, log = self.deploy("--rollback", *self.with_config, "drone")
        self.assertEqual(run.returncode, 2)
        self.assertEqual(log, [])

    def test_the_commands_do_what_they_say_on_a_vehicle(self):
        """Deploys twice and rolls back twice in a folder that stands for the vehicle."""
        vehicle = self.root / "vehicle"
        for folder in ("etc/facet", "etc/systemd/system", "home", "var/lib"):
            (vehicle / folder).mkdir(parents=True)
        (vehicle / "etc/facet/vehicle.yaml").write_text("of the package\n", encoding="utf-8")
        # Runs the command with the vehicle's folders in place of the machine's, and notes what needs a real one.
        shell = self.root / "bin/ssh"
        shell.write_text(f"""#!/bin/bash
cd {vehicle}/home
command="$(printf '%s' "${{@: -1}}" | sed 's#/etc/#{vehicle}/etc/#g; s#/var/lib/#{vehicle}/var/lib/#g; s#sudo -n##')"
apt-get() {{ :; }}; systemctl() {{ echo "$*" >> "$LOG"; }}; facet() {{ :; }}; sleep() {{ :; }}; env() {{ :; }}
dpkg() {{ echo arm64; }}
export -f apt-get systemctl facet sleep env dpkg
exec bash -c "${{command//-o root -g facet/}}"
""", encoding="utf-8")
        copy = self.root / "bin/scp"
        copy.write_text(f"""#!/bin/bash
to="${{@: -1}}"
exec cp "${{@: -2:1}}" "{vehicle}/home/${{to#*:}}"
""", encoding="utf-8")

        def text(name):
            return (vehicle / name).read_text(encoding="utf-8")

        run, _ = self.deploy(*self.with_config, "drone")
        self.assertEqual(run.returncode, 0, run.stderr)
        first = self.config.read_text(encoding="utf-8")
        self.assertEqual(text("etc/facet/vehicle.yaml"), first)
        self.assertEqual(text("etc/facet/cal/camchain.yaml"), "x: 1\n")
        self.assertEqual(text("etc/systemd/system/facet.service.d/10-vehicle.conf"), "[Service]\n")
        self.assertEqual((vehicle / "etc/facet/imu.yaml").stat().st_mode & 0o777, 0o640)
        self.assertEqual(text("etc/facet.before/vehicle.yaml"), "of the package\n")
        self.config.write_text("second\n", encoding="utf-8")
        run, _ = self.deploy(*self.with_config, "drone")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(text("etc/facet/vehicle.yaml"), "second\n")
        self.assertTrue((vehicle / "var/lib/facet-deploy/previous.deb").exists())
        for expected, before in ((first, "second\n"), ("second\n", first)):
            run, _ = self.deploy("--rollback", "drone")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(text("etc/facet/vehicle.yaml"), expected)
            self.assertEqual(text("etc/facet.before/vehicle.yaml"), before)
        self.assertFalse((vehicle / "etc/facet.swap").exists())

    def test_dry_run_touches_nothing_and_prints_what_can_be_pasted(self):
        run, log = self.deploy("--dry-run", *self.with_config, "drone")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(log, [])
        commands = [line for line in run.stdout.splitlines() if line.startswith(("ssh ", "scp "))]
        self.assertEqual(len(commands), 15)
        self.assertIn(f"'{self.config}'", run.stdout)
        # Every printed line is a command that a shell reads back as it is meant.
        script = "\n".join(commands)
        pasted = subprocess.run(
            ["bash", "-e", "-c", script],
            env={**os.environ, "PATH": f"{self.root / 'bin'}:{os.environ['PATH']}", "LOG": str(self.root / "log"),
                 "FAIL_ON": "", "THERE": "arm64"},
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(pasted.returncode, 0, pasted.stderr)
        self.assertNotIn("runs on", run.stdout)

    def test_every_failure_stops_and_is_reported(self):
        cases = {
            "print-architecture": (2, "cannot log in"),
            "mkdir": (2, "cannot make"),
            "facet.deb": (2, "copying the package failed"),
            "drone:.*vehicle.yaml": (2, "copying the configuration failed"),
            "apt-get": (2, "the installation failed"),
            "imu.yaml": (2, "copying imu.yaml failed"),
            "facet.before": (2, "installing the configuration failed"),
            "version": (2, "the program does not run"),
            "is-active": (1, "does NOT run"),
        }
        for fail_on, (code, words) in cases.items():
            run, log = self.deploy(*self.with_config, "drone", fail_on=fail_on)
            self.assertEqual(run.returncode, code, fail_on)
            self.assertIn(words, run.stdout + run.stderr)
            if code == 2:
                self.assertRegex(log[-1], fail_on, "nothing is done after a failure")
                self.assertEqual(run.stderr.count("\n"), 1)

    def test_the_wrong_processor_is_refused_before_anything_is_copied(self):
        run, log = self.deploy("--package", self.package, "drone", there="armhf")
        self.assertEqual(run.returncode, 2)
        self.assertIn("drone is armhf, the package is for arm64", run.stderr)
        self.assertEqual(len(log), 1)

    def test_bad_usage(self):
        for arguments, words in (
            ((), "which host"),
            (("--package", self.root / "none.deb", "drone"), "no such file"),
            (("--package",), "--package needs a file"),
            (("--package", self.package, "a", "b"), "one host at a time"),
            (("--package", self.package, "drone; reboot"), "no name of a host"),
            (("--package", self.package, "--fast", "drone"), "unknown option"),
        ):
            run, log = self.deploy(*arguments)
            self.assertEqual(run.returncode, 2, arguments)
            self.assertIn(words, run.stderr)
            self.assertEqual(log, [])


if __name__ == "__main__":
    if not shutil.which("dpkg-deb"):
        print("dpkg-deb is not installed")
        sys.exit(77)
    unittest.main()
