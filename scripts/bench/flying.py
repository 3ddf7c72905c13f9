# SPDX-License-Identifier: BSD-2-Clause
"""Flies what a plan asks for: renders logs, replays, evaluates. What is done stays done until it would be another."""
import concurrent.futures
import contextlib
import fcntl
import functools
import json
import os
import re
import shutil
import subprocess
import threading

from bench.benchmark_lib import Work, first_error, fresh_folder, read_table, run, simulator_sum, sum_of
from bench.plan import PlanError

HANG_S = 1800
LARGE = ("*.ply", "mesh.csv")  # not kept; a benchmark that judges them does so in its flight


class Run:
    """What a flight has left in its folder. `problem` is a line if something went wrong; without a `has_result`
    columns are empty."""

    def __init__(self, flight, folder, log, options):
        self.flight, self.folder, self.log, self.options = flight, folder, log, options  # options of facet replay
        told = json.loads((folder / "run.json").read_text())
        self.exit, self.seconds, self.rss_mib, self.files_mib = (
            told[key] for key in ("exit", "seconds", "rss_mib", "files_mib"))
        self.problem, self.has_result = told["problem"], told["has_result"]

    @functools.cached_property
    def eval(self):
        return json.loads((self.folder / "eval.json").read_text()) if (self.folder / "eval.json").is_file() else {}

    @functools.cached_property
    def summary(self):
        path = self.folder / "summary.json"
        return json.loads(path.read_text()) if path.is_file() else {}

    @functools.cached_property
    def health(self):
        return self.table("health.csv")

    @functools.cached_property
    def errors(self):
        return self.table("errors.csv")

    def table(self, name):
        return read_table(self.folder / name) if (self.folder / name).is_file() else []


def run_measured(command, log, hang_s=HANG_S):
    """Exit code (negative: a signal), output, CPU time (s) and memory (MiB) of a command that may hang."""
    with log.open("w+") as stream:
        stream.write(f"$ {' '.join(map(str, command))}\n")
        stream.flush()
        process = subprocess.Popen([str(part) for part in command], stdout=stream, stderr=subprocess.STDOUT)
        timer = threading.Timer(hang_s, process.kill)
        timer.start()
        _, status, usage = os.wait4(process.pid, 0)
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        stream.seek(0)
        output = stream.read()
    return process.returncode, output, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


@contextlib.contextmanager
def locked(path, waits):
    """Keeps others, and other threads, from what a file stands for; the lock goes with the process, however it ends."""
    with path.open("w") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | (0 if waits else fcntl.LOCK_NB))
        except BlockingIOError:
            raise PlanError(f"another benchmark is at work in {path.parent}") from None
        yield


class Bench:
    """A benchmark at work: its arguments, its plan, its folders. Plug-ins get it."""

    def __init__(self, name, plan, arguments):
        self.name, self.plan, self.arguments = name, plan, arguments
        self.facet, self.out = arguments.facet, arguments.out
        self.linking = threading.Lock()
        self.notes = []  # below the table
        self.results = None  # of results.json; the figures of all columns unless a plug-in sets them

    @functools.cached_property
    def program(self):
        """Changes when the program does."""
        return sum_of([self.facet])

    def rendered(self, log, changed=()):
        """Folder of a log; a simulated one is rendered unless this simulator has done so. PlanError if that fails."""
        if log.folder:
            if changed:
                raise PlanError(f"{log.name}: no SEQUENCE can take the place of the case's own simulated flight")
            return log.folder
        options = log.options(changed)
        name = re.sub(r"[^A-Za-z0-9.]+", "_", " ".join(options)).strip("_")
        folder = self.arguments.flights_folder / name
        wanted = " ".join([*options, simulator_sum()])
        self.arguments.flights_folder.mkdir(parents=True, exist_ok=True)
        with locked(folder.with_name(name + ".lock"), waits=True):
            marker = folder.with_name(name + ".done")
            if not marker.is_file() or marker.read_text() != wanted:
                marker.unlink(missing_ok=True)
                fresh_folder(folder)
                code, output = run([self.facet, "sim", *options, "--out", folder, "--force"],
                                   folder.with_name(name + ".log"))
                if code != 0:
                    raise PlanError(f"{log.name}: sim exit {code}: {first_error(output)}")
                marker.write_text(wanted)
        return folder

    def log_of(self, flight):
        """Folder of the log that a flight replays."""
        folder = self.rendered(self.plan.logs[flight.sequence], self.plan.changed_flight(flight))
        missing = [part for variant in self.plan.variants(flight.case, flight.mode) for part in variant.without]
        if not missing:
            return folder
        links = self.out / "logs" / f"{folder.resolve().name}_without_{'_'.join(missing)}"
        with self.linking:
            shutil.rmtree(links, ignore_errors=True)
            (links / "mav0").mkdir(parents=True)
            for part in (folder / "mav0").resolve().iterdir():
                if part.name not in missing:
                    (links / "mav0" / part.name).symlink_to(part)
        return links

    def replay_command(self, log, out, options, facet=None):
        """Command that replays a log into a folder."""
        config = ["--config", self.plan.config] if self.plan.config else []
        command = [facet or self.facet, "replay", log, "--out", out, *options, *config, "--quiet"]
        return [str(part) for part in command]

    def pinned(self, command):
        """A command whose time is measured, on the core of the arguments."""
        core = self.arguments.core
        return ["taskset", "-c", str(core), *command] if core >= 0 and shutil.which("taskset") else command

    def evaluate(self, log, out, options=(), use_scene=None):
        """What is wrong with the evaluation of a replay's folder, or "". Images that were turned have a truth of their
        own, which does not go with a scene."""
        turned = out / "groundtruth.csv"
        scene = log / "truth/scene.ply"
        if use_scene and scene.is_file() and not turned.is_file():
            options = ["--scene", scene, *options]
        elif use_scene == "required" and not turned.is_file():
            return f"{log}: no truth/scene.ply"
        code, output = run([self.facet, "eval", "--groundtruth", turned if turned.is_file() else log, "--estimate", out,
                            "--json", out / "eval.json", "--errors", out / "errors.csv", *options], out / "log.txt")
        return f"eval exit {code}: {first_error(output)}" if code != 0 else ""

    def identity(self, flight):
        options = [part for variant in self.plan.variants(flight.case, flight.mode) for part in variant.eval]
        return " ".join(map(str, [self.plan.log_identity(flight), self.plan.config, *self.plan.replay_options(flight),
                                  self.plan.scene_use(flight), *options, "program", self.program]))

    def is_done(self, flight):
        told = self.out / "runs" / flight.name / "run.json"
        return told.is_file() and json.loads(told.read_text())["identity"] == self.identity(flight)

    def fly(self, flight):
        """The Run of a flight; one that failed is a result, too, but is tried again the next time."""
        out = self.out / "runs" / flight.name
        log = self.log_of(flight)
        if not self.arguments.fresh and self.is_done(flight):
            return Run(flight, out, log, self.plan.replay_options(flight))
        fresh_folder(out)
        command = self.replay_command(log, out, self.plan.replay_options(flight))
        code, output, seconds, rss_mib = run_measured(command, out / "log.txt")
        # Exit code 1: it ran, but lost its way.
        problem = f"replay exit {code}: {first_error(output)}" if code != 0 else ""
        files_mib = sum(file.stat().st_size for file in out.rglob("*") if file.is_file()) / 2 ** 20
        has_result = code in (0, 1) and (out / "summary.json").is_file()
        if has_result and json.loads((out / "summary.json").read_text()).get("estimates", 3) > 2:
            options = [part for variant in self.plan.variants(flight.case, flight.mode) for part in variant.eval]
            wrong = self.evaluate(log, out, [part.replace("{out}", str(out)) for part in options],
                                  self.plan.scene_use(flight))
            has_result, problem = not wrong, problem or wrong
        for pattern in LARGE:
            for file in out.glob(pattern):
                file.unlink()
        told = {"identity": self.identity(flight) if has_result else "", "exit": code, "seconds": seconds,
                "rss_mib": rss_mib, "files_mib": files_mib, "problem": problem, "has_result": has_result}
        (out / "run.json").write_text(json.dumps(told) + "\n")
        return Run(flight, out, log, self.plan.replay_options(flight))

    def fly_all(self):
        """{flight: its Run} of the whole plan, or None in place of a Run where the log could not be rendered."""
        flights = self.plan.flights
        left = [flight for flight in flights if self.arguments.fresh or not self.is_done(flight)]
        work = Work(len(left))

        def one(flight):
            try:
                done = self.fly(flight)
            except PlanError as error:
                self.notes.append(f"{flight}: {error}")
                done = None
            if flight in left:
                ate = done and done.eval.get("ate_se3")
                error = f"ATE {1e3 * ate['translation_m']['rmse']:.1f} mm" if ate else "no error"
                work.finished(f"{flight}: {error}")
            return done

        with concurrent.futures.ThreadPoolExecutor(self.arguments.jobs) as pool:
            runs = dict(zip(flights, pool.map(one, flights)))
        self.notes += [f"{flight}: {done.problem}" for flight, done in runs.items() if done and done.problem]
        return runs
