#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Finds functions, types, constants and macros declared in headers that nothing but their own tests uses.

Usage: dead_names.py [ROOT]      prints a line `file:line: name ...` for every finding; exit code 1 if there is any

Names are tokens: a name is alive as soon as any source outside tests/ contains it other than to declare or define it,
whatever scope it belongs to there. So what is found is dead, but not everything that is dead is found. Enumerators are
left out: configuration files choose them by their place in a list.
"""
import argparse
import re
import sys
from collections import defaultdict
from pathlib import Path

from tree import ROOT

FOLDERS = ("platform", "drivers", "estimator", "mesh", "app")

# Names that look dead, each with the reason why it stays.
ALLOWED = {
    "can_hold": "what tests of every table of parameters ask of a field",
    "camera_counters": "what a driver counts is part of its contract, which its tests hold it to",
    "can_counters": "likewise",
    "delta_p": "the third of preintegration's delta_q, delta_v, delta_p: tests compare all three with the truth",
    "make_description": "what CLI11 calls of a formatter",
    "make_footer": "likewise",
    "make_option": "likewise",
    "make_subcommand": "likewise",
    "nearest_in_direction": "a query for users of the library",
    "request_reset": "for users of the library",
    "sent": "likewise: what a driver counts",
    "unlock": "what std::lock_guard asks of a mutex",
}

TOKEN = re.compile(
    r"(?P<skipped>//[^\n]*|/\*.*?\*/|\s+)"
    r'|(?P<literal>R"(?P<raw>[^(]*)\(.*?\)(?P=raw)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\''
    r"|\.?\d(?:[eEpP][+-]|[\w.'])*)"
    r"|(?P<token>[A-Za-z_]\w*|::|->|\[\[|\]\]|.)",
    re.DOTALL,
)
NAME = re.compile(r"[A-Za-z_]\w*$")
CONSTANT = re.compile(r"k[A-Z0-9]\w*$")
TYPE_WORDS = {"class", "struct", "enum", "union"}
TYPE_GOES_ON = {"{", ":", ";", "final"}
# After one of these a name with a parenthesis is called, not declared.
EXPRESSION_WORDS = {
    "return", "else", "case", "throw", "new", "delete", "not", "and", "or", "do", "if", "while", "sizeof",
}
NO_FUNCTIONS = EXPRESSION_WORDS | {
    "for", "switch", "catch", "alignas", "alignof", "decltype", "static_assert", "noexcept", "explicit", "requires",
    "operator", "assert", "static_cast", "reinterpret_cast", "const_cast", "dynamic_cast", "defined", "typename",
    "template",
}
AFTER_A_DEFINITION = {"{", "const", "noexcept", "->", "override", "final", ":"}


class Source:
    """The tokens of one file, without comments and literals, and the line of each."""

    def __init__(self, text):
        self.tokens = [""]
        self.lines = [1]
        line = 1
        for match in TOKEN.finditer(text):
            if match.group("token"):
                self.tokens.append(match.group("token"))
                self.lines.append(line)
            elif match.group("literal"):
                self.tokens.append('"')
                self.lines.append(line)
            line += match.group().count("\n")
        self.tokens.append("")

    def after_parentheses(self, i):
        """The token behind the parentheses that open at i."""
        depth = 0
        for k in range(i, len(self.tokens)):
            depth += {"(": 1, ")": -1}.get(self.tokens[k], 0)
            if depth == 0:
                return self.tokens[k + 1] if k + 1 < len(self.tokens) else ""
        return ""

    def is_in_expression(self, i):
        """Whether what stands before i in its statement makes it part of an expression."""
        depth = 0
        found = False
        for k in range(i - 1, 0, -1):
            token = self.tokens[k]
            if token in {";", "{", "}", "#"}:
                break
            depth += {")": 1, "(": -1}.get(token, 0)
            if token == "template":
                return False
            found = found or depth < 0 or token in ("=", "?", "return")
        return found

    def declared_as(self, i):
        """What the name at i is declared or defined as: "type", "constant", "macro", "function"; None if it is used."""
        name, before, after = self.tokens[i], self.tokens[i - 1], self.tokens[i + 1]
        if before == "define" and self.tokens[i - 2] == "#":
            return "macro"
        if (before in TYPE_WORDS and after in TYPE_GOES_ON) or (before in ("using", "concept") and after == "="):
            return "type"
        is_constructor = before == "::" and self.tokens[i - 2] == name
        is_destructor = before == "~" and after == "("
        if is_constructor or is_destructor or self.qualifies_a_definition(i):
            return "type"
        if CONSTANT.match(name) and self.is_variable(i):
            return "constant"
        if after != "(" or name in NO_FUNCTIONS:
            return None
        if before == "::":
            return "function" if self.after_parentheses(i + 1) in AFTER_A_DEFINITION else None
        if before in {"&", "*", ">"} or (NAME.match(before) and before not in EXPRESSION_WORDS):
            return None if self.is_in_expression(i) else "function"
        return None

    def qualifies_a_definition(self, i):
        """Whether the name at i is the class in front of a member that is defined there."""
        if self.tokens[i + 1] != "::":
            return False
        member = self.tokens[i + 2]
        return member in (self.tokens[i], "~", "operator") or self.declared_as(i + 2) == "function"

    def is_variable(self, i):
        """Whether a variable is declared at i: its type stands before its name, and no expression around both."""
        before, after = self.tokens[i - 1], self.tokens[i + 1]
        has_type = before in ("&", "*", ">") or (NAME.match(before) and before not in EXPRESSION_WORDS)
        return has_type and after in ("=", "{", ";", "[") and not self.is_in_expression(i)


def members_of_types(source):
    """Positions where a name followed by a parenthesis is a constructor: its type is declared in the same file."""
    types = {source.tokens[i] for i in range(1, len(source.tokens) - 1) if source.declared_as(i) == "type"}
    return {i for i in range(1, len(source.tokens) - 1)
            if source.tokens[i] in types and source.tokens[i + 1] == "("
            and (source.tokens[i - 1] in ("explicit", ";", "{", "}", ":", "constexpr"))}


def find_dead(root):
    """(path, line, kind, name) of every finding, and the number of headers seen."""
    declared = {}
    uses = defaultdict(int)
    headers = 0
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp", ".in") or not file.is_file():
                continue
            path = file.relative_to(root).as_posix()
            headers += path.endswith(".h")
            source = Source(file.read_text(encoding="utf-8"))
            constructors = members_of_types(source)
            for i in range(1, len(source.tokens) - 1):
                name = source.tokens[i]
                if not NAME.match(name):
                    continue
                kind = source.declared_as(i)
                if kind is None and i not in constructors:
                    uses[name] += 1
                elif kind is not None and path.endswith(".h"):
                    declared.setdefault(name, (path, source.lines[i], kind, name))
    found = [place for name, place in declared.items() if uses[name] == 0 and name not in ALLOWED]
    return sorted(found), headers


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=ROOT)
    findings, headers = find_dead(parser.parse_args().root)
    for path, line, kind, name in findings:
        print(f"{path}:{line}: {kind} {name} is used by nothing but tests: remove it")
    print(f"dead names: {headers} headers, {len(findings)} findings")
    return 1 if findings or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
