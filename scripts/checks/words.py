#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Finds words that engineers of this field do not use, in whatever a person reads, and says what to write instead.

Usage: words.py [ROOT]      prints a line `file:line: "phrase": write "..."` for every finding; exit code 1 if any

Looked at are documents (without code), comments of headers, texts in the program's sources (help, errors, parameters),
names of tests, and comments and texts of scripts. Names in code, keys of files and columns are not looked at.
"""
import argparse
import io
import re
import sys
import tokenize
from pathlib import Path

from tree import ROOT, project_files

# What is written in place of a phrase. Case does not count; a phrase may run over the end of a line.
PHRASES = (
    (r"told", "reported, given"),
    (r"tells? (?:the|a|an|what|that|of|us|no|nothing|little|least|most|more)", "shows, reports"),
    (r"anew", "again; restarted"),
    (r"put upon|upon", "injected, added to; on"),
    (r"in turns|by turns", "interleaved, alternating"),
    (r"at (?:a|the) desk", "offline"),
    (r"wanted", "target, requested"),
    (r"in silence", "undetected error"),
    (r"(?:a|what a|as a) good (?:one|calibration) leaves|leaves unknown", "1 sigma of a good calibration"),
    (r"(?<!address\s)claim(?:s|ed|ing)?", "report, reported or predicted sigma"),
    (r"processor time|processor's (?:time|clock)|time of the processor", "CPU time"),
    (r"as wrong as|calibrations? as (?:good|real)", "perturbed by K sigma"),
    (r"(?:nothing|not) was chosen on|looked at only after|kept(?:-| )aside", "held out"),
    (r"planes right|right / found", "correct planes"),
    (r"mesh to the truth", "median mesh error"),
    (r"for ever", "permanently"),
    (r"(?<!there\s)is none(?!\sof)", "is not a ..., not detected"),
    (r"is no number|are no numbers", "is NaN"),
    (r"place and yaw", "position and yaw"),
    (r"disc(?!\sof)", "disk"),
    (r"besides what is there", "in addition"),
    (r"hangs on", "depends on"),
    (r"thereof|whereof|thereupon|henceforth", "of it; then"),
    (r"perfect calibration", "exact calibration"),
    (r"goes? astray|went astray|led astray", "diverges"),
)
# Between two words may stand the end of a line and the mark of a comment.
GAP = r"\s+(?:(?:///?|#+)\s+)?"
FINDER = re.compile(r"(?<![\w-])(?:" + "|".join(f"({phrase.replace(' ', GAP)})" for phrase, _ in PHRASES)
                    + r")(?![\w-])", re.IGNORECASE)
CODE = re.compile(r"^```.*?^```|`[^`\n]*`|\]\([^)\s]*\)|<!--.*?-->", re.MULTILINE | re.DOTALL)
CPP = re.compile(r'(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<raw>R"(?P<mark>[^(\n]*)\(.*?\)(?P=mark)")'
                 r'|(?P<text>"(?:\\.|[^"\\\n])*")|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
# Names in comments of headers.
NAME = re.compile(r"`[^`\n]*`|@param\s+\w+")
SHELL = re.compile(r'(?<![\w$])#[^\n]*|\b(?:say|die|echo) "(?:\\.|\$\{[^}]*\}|[^"\\])*"')
VARIABLE = re.compile(r"\$\{[^}\n]*\}|\$\w+")
# Where texts are what a person reads: help, errors, meanings of parameters.
PROGRAM = ("app/", "drivers/", "estimator/", "mesh/", "platform/")
TESTS = re.compile(r'(?:TEST_CASE|SCENARIO|SECTION|GIVEN|WHEN|THEN)\(\s*((?:"(?:\\.|[^"\\\n])*"\s*)+)')
MANUAL_PAGE = "app/packaging/facet.1"
SCRIPTS = ("scripts/", ".ci/")


def blank(match):
    """Nothing, with the lines that it had."""
    return "\n" * match.group().count("\n")


def kept_only(text, spans):
    """The text with everything but the spans made blank, its lines kept."""
    kept, end = [], 0
    for begin, stop in spans:
        kept += [re.sub(r"[^\n]", " ", text[end:begin]), text[begin:stop]]
        end = stop
    return "".join([*kept, re.sub(r"[^\n]", " ", text[end:])])


def prose_of_cpp(path, text):
    """What of a C++ file a person reads who is no developer of it."""
    if path.startswith("tests/"):
        return kept_only(text, [match.span(1) for match in TESTS.finditer(text)])
    has_texts = path.startswith(PROGRAM)
    spans = [match.span() for match in CPP.finditer(text)
             if (match.group("comment") and path.endswith(".h"))
             or (has_texts and (match.group("text") or match.group("raw")) and " " in match.group())]
    return NAME.sub(blank, kept_only(text, spans))


def prose_of_python(text):
    """Comments and texts of a Python program."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    kinds = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)}
    return kept_only(text, [(starts[token.start[0] - 1] + token.start[1], starts[token.end[0] - 1] + token.end[1])
                            for token in tokenize.generate_tokens(io.StringIO(text).readline)
                            if token.type in kinds and (token.type == tokenize.COMMENT or " " in token.string)])


def prose_of_shell(text):
    """Comments and quoted texts of a shell program."""
    text = VARIABLE.sub(lambda match: " " * len(match.group()), text)
    return kept_only(text, [match.span() for match in SHELL.finditer(text)])


def findings(path, text, language=None):
    """(line, phrase, suggestion) of each phrase in a file's prose."""
    if path.endswith(".md"):
        text = CODE.sub(blank, text)
    elif path.endswith((".h", ".cpp")):
        text = prose_of_cpp(path, text)
    elif language == "python":
        text = prose_of_python(text)
    elif language == "shell":
        text = prose_of_shell(text)
    for match in FINDER.finditer(text):
        phrase = " ".join(match.group().split())
        yield text.count("\n", 0, match.start()) + 1, phrase, PHRASES[match.lastindex - 1][1]


def documents(root):
    skipped = {"build", "out", "node_modules"}
    for file in sorted(root.rglob("*.md")):
        folders = file.relative_to(root).parts[:-1]
        if not any(name in skipped or name.startswith(".") for name in folders):
            yield file.relative_to(root).as_posix()
    if (root / MANUAL_PAGE).is_file():
        yield MANUAL_PAGE


def check_tree(root):
    """All findings below root as `file:line: text`, and the number of files seen."""
    files = [(path, None) for path in documents(root)] + [(path, "c++") for path in project_files(root, {"c++"})]
    for language in ("python", "shell", "yaml"):
        files += [(path, language) for path in project_files(root, {language})
                  if path.startswith(SCRIPTS) and path != "scripts/checks/words.py"]
    found = [f'{path}:{line}: "{phrase}": write "{instead}"' for path, language in files
             for line, phrase, instead in findings(path, (root / path).read_text(encoding="utf-8"), language)]
    return found, len(files)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=ROOT)
    arguments = parser.parse_args()
    found, files = check_tree(arguments.root)
    for finding in found:
        print(finding)
    print(f"words: {files} files, {len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
