# SPDX-License-Identifier: BSD-2-Clause
"""Parts of documents that scripts make: what stands between a line with the part's mark and the next end mark."""
import pathlib
import re
import shlex
import subprocess
import sys

END = "<!-- end -->"
# Options with a value that say nothing of what was measured.
LOCAL_OPTIONS = {"--facet", "--out", "--core", "--jobs", "--document"}


def script_name():
    """Of the running script, as documents name it."""
    return f"scripts/{pathlib.Path(sys.argv[0]).name}"


def begin_mark(name):
    return f"<!-- {name} -->"


def add_document_option(parser):
    parser.add_argument("--document", type=pathlib.Path, metavar="FILE",
                        help=f"also put what was measured into a document, between {begin_mark(script_name())} and "
                             f"{END} (scripts with several tables: a mark for each, with its name after a colon)")


def check_document(parser, arguments, name):
    """Ends with exit code 2 and one line if the document is not there or has no place for the part of this name."""
    if arguments.document is None:
        return
    if not arguments.document.is_file():
        parser.error(f"--document: {arguments.document}: no such file")
    if not re.search(f"^{re.escape(begin_mark(name))}$", arguments.document.read_text(encoding="utf-8"), re.MULTILINE):
        parser.error(f"--document: {arguments.document}: no line '{begin_mark(name)}' in it")


def put_between_marks(document, name, text):
    """Replaces the part of this name in the file. @return whether it has one; otherwise the file is untouched"""
    begin = begin_mark(name)
    head, found, rest = document.read_text(encoding="utf-8").partition(begin)
    _, ended, tail = rest.partition(END)
    if not found or not ended:
        return False
    document.write_text(f"{head}{begin}\n{text}\n{END}{tail}", encoding="utf-8")
    return True


def commit_of(facet):
    """The commit that a program says it was built from, "+changes" after it if the sources had been edited."""
    version = subprocess.run([facet, "--version"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"^commit +(\S+)", version, re.MULTILINE)
    return found.group(1) if found else "unknown"


def edited(facet):
    """What is not committed: a sentence, or "". Documents may be: tables are put into them."""
    if commit_of(facet).endswith("+changes"):
        return "the program was built from edited sources"
    root = pathlib.Path(__file__).resolve().parents[2]
    command = ["git", "-C", root, "status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs", ":!*.md"]
    changed = subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines()
    return f"edited files, the first of {len(changed)}: {changed[0][3:]}" if changed else ""


def measured_by(facet, script=None, local_options=LOCAL_OPTIONS, local_flags=frozenset()):
    """What made a table: the command without what is of this machine, logs by their names, and the program's commit."""
    words, given = [script or script_name()], iter(sys.argv[1:])
    for word in given:
        option, equals, _ = word.partition("=")
        if option in local_options:
            if not equals:
                next(given, None)
        elif word not in local_flags:
            words.append(pathlib.Path(word).name if pathlib.Path(word).is_dir() else word)
    return f"`{shlex.join(words)}`, commit {commit_of(facet)}."
