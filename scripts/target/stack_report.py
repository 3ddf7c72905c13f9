#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Says how much stack the estimator, the mesher and the plane finder need, and whether any of it calls itself.

Usage: stack_report.py [--objdump PROGRAM] [--frame-limit BYTES] [--depth-limit BYTES] [--su FOLDER] FACET_PROGRAM
  FACET_PROGRAM   not stripped, x86-64 or AArch64
  --su FOLDER     build folder with the *.su files of GCC's -fstack-usage: the largest frames by source line

Frames and calls are read from the program's own instructions. Followed are direct calls and jumps to functions inside
the program; not followed are calls through pointers (in the hot path only the stage observer's) and shared libraries.
The default limits leave room for three temporaries of Eigen in a thread of 1 MB.
Exit codes: 0 within the limits; 1 a limit is exceeded or something calls itself; 2 bad input.
"""
import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOTS = (
    r"^facet::Estimator::(add_imu|add_frame|set_planes|keyframe_view)\(",
    r"^facet::Mesher::update\(",
    r"^facet::PlaneFinder::update\(",
)
# Functions that call themselves to a bounded depth, each with its reason.
BOUNDED = (
    (r"^void std::__introsort_loop<", "std::sort: at most 2 log2(n) deep"),
    (r"^facet::Delaunay::(arrange|build)\(", "halves its points: at most log2(n) deep"),
)
OWN_SOURCES = ("estimator/", "mesh/", "platform/")

HEADER = re.compile(r"^([0-9a-f]+) <(.*)>:$")
CALL = re.compile(r"^\s+[0-9a-f]+:\s+(?:bnd )?(call|callq|jmp|jmpq|bl|b)\s+(?:0x)?([0-9a-f]+) <")
X86_PUSH = re.compile(r":\s+push\s")
X86_SUB = re.compile(r":\s+sub\s+\$(0x[0-9a-f]+),%rsp")
X86_ALIGN = re.compile(r":\s+and\s+\$(0x[0-9a-f]+),%rsp")
X86_DYNAMIC = re.compile(r":\s+sub\s+%r\w+,%rsp")
ARM_STORE = re.compile(r":\s+st[pr]\s.*\[sp, #-(\d+)\]!")
ARM_SUB = re.compile(r":\s+sub\s+sp, sp, #(0x[0-9a-f]+)(?:, lsl #(\d+))?")
ARM_MOV = re.compile(r":\s+mov\s+(x\d+), #(0x[0-9a-f]+)")
ARM_MOVK = re.compile(r":\s+movk\s+(x\d+), #(0x[0-9a-f]+)(?:, lsl #(\d+))?")
ARM_DYNAMIC = re.compile(r":\s+sub\s+sp, sp, (x\d+)")


class BadInput(Exception):
    pass


class Function:
    def __init__(self, name):
        self.name = name
        self.frame = 0  # bytes, return address or link register included
        self.dynamic = False  # also reserves what it only knows at run time
        self.calls = set()  # addresses of other functions
        self.self_call = False


def short(name):
    """A name without template arguments and parameters, to be read."""
    text, depth = "", 0
    for letter in re.split(r" \[(?:clone|with) ", name)[0].replace("(anonymous namespace)::", ""):
        depth += letter in "<("
        if depth == 0:
            text += letter
        depth -= letter in ">)"
    text = re.sub(r"\s*\bconst\b\s*", "", text)
    return text.split(" ")[-1] if " " in text and "operator" not in text else text


def add_x86(function, line):
    if X86_PUSH.search(line):
        function.frame += 8
    elif match := X86_SUB.search(line):
        bytes_ = int(match.group(1), 16)
        function.frame += bytes_ if bytes_ < 1 << 31 else 0  # sub $-128 gives stack back
    elif match := X86_ALIGN.search(line):
        function.frame += (1 << 64) - int(match.group(1), 16)
    elif X86_DYNAMIC.search(line):
        function.dynamic = True


def add_arm(function, line, constants):
    if match := ARM_STORE.search(line):
        function.frame += int(match.group(1))
    elif match := ARM_SUB.search(line):
        function.frame += int(match.group(1), 16) << int(match.group(2) or 0)
    elif match := ARM_MOV.search(line):
        constants[match.group(1)] = int(match.group(2), 16)
    elif match := ARM_MOVK.search(line):
        shift = int(match.group(3) or 0)
        known = constants.get(match.group(1), 0)
        constants[match.group(1)] = (known & ~(0xFFFF << shift)) | int(match.group(2), 16) << shift
    elif match := ARM_DYNAMIC.search(line):
        # A frame too large for an immediate comes through x12 or x16, set just before; anything else is an alloca.
        if match.group(1) in ("x12", "x16") and match.group(1) in constants:
            function.frame += constants[match.group(1)]
        else:
            function.dynamic = True


def parse(lines):
    """Functions by address from objdump's text."""
    functions = {}
    function, address, arm, constants = None, 0, None, {}
    for line in lines:
        if match := HEADER.match(line):
            address = int(match.group(1), 16)
            function = functions[address] = Function(match.group(2))
            function.frame = 0 if arm else 8  # x86: the return address
            constants = {}
            continue
        if arm is None and "file format" in line:
            arm = "aarch64" in line
        if function is None:
            continue
        if match := CALL.match(line):
            target = int(match.group(2), 16)
            if target != address:
                function.calls.add(target)
            elif match.group(1) in ("call", "callq", "bl"):
                function.self_call = True
        elif arm:
            add_arm(function, line, constants)
        else:
            add_x86(function, line)
    inside = {address for address, function in functions.items() if "@plt" not in function.name}
    for function in functions.values():
        function.calls &= inside
    return functions


def reachable(functions, roots):
    seen, todo = set(), list(roots)
    while todo:
        address = todo.pop()
        if address not in seen:
            seen.add(address)
            todo += functions[address].calls
    return seen


def order_and_cycles(functions, addresses):
    """Addresses, callees before callers, and groups that call each other in a circle (Tarjan, without recursion)."""
    index, low, on_stack, stack = {}, {}, set(), []
    order, cycles = [], []
    for start in sorted(addresses):
        if start in index:
            continue
        work = [(start, iter(sorted(functions[start].calls)))]
        index[start] = low[start] = len(index)
        stack.append(start)
        on_stack.add(start)
        while work:
            address, callees = work[-1]
            for callee in callees:
                if callee not in index:
                    index[callee] = low[callee] = len(index)
                    stack.append(callee)
                    on_stack.add(callee)
                    work.append((callee, iter(sorted(functions[callee].calls))))
                    break
                if callee in on_stack:
                    low[address] = min(low[address], index[callee])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[address])
                if low[address] == index[address]:
                    group = []
                    while True:
                        member = stack.pop()
                        on_stack.discard(member)
                        group.append(member)
                        if member == address:
                            break
                    order += group
                    if len(group) > 1 or functions[address].self_call:
                        cycles.append(group)
    return order, cycles


def deepest(functions, order):
    """For every address the bytes of the deepest chain of calls from it, and its next link. A circle counts once."""
    depth, following = {}, {}
    for address in order:
        best = max((callee for callee in functions[address].calls if callee in depth), key=depth.get, default=None)
        depth[address] = functions[address].frame + (depth[best] if best is not None else 0)
        following[address] = best
    return depth, following


def read_su(folder):
    """(bytes, kind, file:line, function) of all functions of the project's hot path folders."""
    frames = []
    for file in sorted(Path(folder).rglob("*.su")):
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            where, bytes_, kind = line.rsplit("\t", 2)
            match = re.match(r"(.*?):(\d+):\d+:(.*)$", where)
            relative = file.relative_to(folder).as_posix()
            if match and relative.startswith(OWN_SOURCES):
                name = "/".join(match.group(1).split("/")[-3:])
                frames.append((int(bytes_), kind, f"{name}:{match.group(2)}", short(match.group(3))))
    if not frames:
        raise BadInput(f"{folder}: no .su files; build with -DFACET_FOR_PACKAGE=ON")
    return sorted(set(frames), reverse=True)


def report(functions, frame_limit, depth_limit):
    """Prints; returns what is wrong."""
    roots = [address for address, function in functions.items()
             if any(re.match(root, function.name) for root in ROOTS) and "[clone" not in function.name]
    names = {short(functions[address].name) for address in roots}
    for root in ROOTS:
        if not any(re.match(root, functions[address].name) for address in roots):
            raise BadInput(f"the program has no function {root}: stripped, or renamed?")
    hot = reachable(functions, roots)
    order, cycles = order_and_cycles(functions, hot)
    depth, following = deepest(functions, order)
    wrong = []

    print(f"hot path: {len(hot)} functions reached from {', '.join(sorted(names))}")
    print("\nlargest frames in the hot path (bytes)")
    for address in sorted(hot, key=lambda a: -functions[a].frame)[:12]:
        print(f"{functions[address].frame:9}  {short(functions[address].name)}")
        if functions[address].frame > frame_limit:
            wrong.append(f"{short(functions[address].name)}: frame of {functions[address].frame} bytes")
    dynamic = sorted({short(functions[address].name) for address in hot if functions[address].dynamic})
    print(f"\nfunctions that also reserve stack at run time: {len(dynamic)}"
          " (Eigen's temporaries, 128 KiB each at most: EIGEN_STACK_ALLOCATION_LIMIT)")
    for name in dynamic:
        print(f"           {name}")

    for root in sorted(roots, key=lambda a: -depth[a]):
        print(f"\ndeepest chain from {short(functions[root].name)}: {depth[root]} bytes")
        address = root
        while address is not None:
            print(f"{functions[address].frame:9}  {short(functions[address].name)}")
            address = following[address]
        if depth[root] > depth_limit:
            wrong.append(f"{short(functions[root].name)}: {depth[root]} bytes deep")

    print("\nfunctions that call themselves, directly or in a circle")
    told = set()
    for group in cycles:
        name = ", ".join(sorted(short(functions[address].name) for address in group))
        if name in told:
            continue
        told.add(name)
        reasons = [why for pattern, why in BOUNDED if all(re.match(pattern, functions[a].name) for a in group)]
        print(f"           {name}: {reasons[0] if reasons else 'NOT BOUNDED as far as is known'}")
        if not reasons:
            wrong.append(f"{name}: recursion")
    if not cycles:
        print("           none")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--objdump", default="objdump")
    parser.add_argument("--frame-limit", type=int, default=160 * 1024)
    parser.add_argument("--depth-limit", type=int, default=256 * 1024)
    parser.add_argument("--su", type=Path)
    arguments = parser.parse_args()
    try:
        if not arguments.program.is_file():
            raise BadInput(f"{arguments.program}: no such file")
        command = [arguments.objdump, "--disassemble", "--demangle", "--no-show-raw-insn", str(arguments.program)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, errors="replace") as process:
            functions = parse(process.stdout)
        if process.returncode != 0:
            raise BadInput(f"{arguments.objdump} failed on {arguments.program}")
        wrong = report(functions, arguments.frame_limit, arguments.depth_limit)
        if arguments.su:
            print("\nlargest frames by source, from -fstack-usage (bytes)")
            for bytes_, kind, where, name in read_su(arguments.su)[:12]:
                print(f"{bytes_:9}  {kind:16} {where:44} {name}")
    except (BadInput, OSError) as error:
        print(f"stack_report: {error}", file=sys.stderr)
        return 2
    verdict = "EXCEEDED" if wrong else "kept"
    print(f"\nlimits: frame {arguments.frame_limit}, chain {arguments.depth_limit} bytes: {verdict}")
    for line in wrong:
        print(f"  {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
