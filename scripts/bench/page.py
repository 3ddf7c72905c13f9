# SPDX-License-Identifier: BSD-2-Clause
"""The page of results: every line of a list is a benchmark, flown one after the other and published."""
import itertools
import pathlib
import shlex
import subprocess
import sys

from bench.benchmark_lib import Work
from bench.marked_document import commit_of, put_between_marks

MARK = "scripts/benchmark --page"
PASSED_ON = ("facet", "jobs", "core", "flights_folder")  # to every benchmark
FLAGS = ("fresh", "allow_dirty")


def read_list(path):
    """The words behind scripts/benchmark of every line: a NAME, logs, options."""
    return [shlex.split(line) for line in path.read_text(encoding="utf-8").splitlines()
            if line.strip() and not line.startswith("#")]


def logs_of(words):
    return list(itertools.takewhile(lambda word: not word.startswith("-"), words[1:]))


def options_of(arguments, name):
    """Options that a benchmark gets besides those of its line."""
    options = [text for key in PASSED_ON for text in (f"--{key.replace('_', '-')}", getattr(arguments, key))]
    options += ["--out", arguments.out / pathlib.Path(name).stem] if arguments.out else []
    return [*options, *(f"--{key.replace('_', '-')}" for key in FLAGS if getattr(arguments, key))]


def make_page(arguments, script, lines, document, measures):
    """Flies and publishes what the list says. @return exit code: 1 if the page is not complete or a benchmark's is 1

    A benchmark that measures by itself is not repeated if the page has its table of this program; of all others only
    the flights that are left are flown.
    """
    commit, wrong = commit_of(arguments.facet), []
    work = Work(len(lines))
    for words in lines:
        line = shlex.join(words)
        work.next(line)
        missing = [log for log in logs_of(words) if not (arguments.page / log).is_dir()]
        if missing:
            wrong.append(f"`{line}`: no {', '.join(missing)} in FOLDER")
            continue
        made_by = f"`{shlex.join(['scripts/benchmark', *words])}`, commit {commit}."
        if measures(words[0]) and made_by in document.read_text(encoding="utf-8") and not arguments.fresh:
            continue
        logs = logs_of(words)
        command = [sys.executable, script, words[0], *(arguments.page / log for log in logs), *words[1 + len(logs):],
                   "--publish", *options_of(arguments, words[0])]
        code = subprocess.run([str(word) for word in command], check=False).returncode
        if code != 0:
            wrong.append(f"`{line}`: exit code {code}")
        if code < 0:
            break
    text = f"Made by `scripts/benchmark --page FOLDER` at commit {commit}."
    put_between_marks(document, MARK, "\n".join([text, *(["", "Incomplete:", ""] if wrong else []),
                                                 *(f"* {sentence}" for sentence in wrong)]))
    for sentence in wrong:
        print(f"benchmark: {sentence}", file=sys.stderr)
    return 1 if wrong else 0
