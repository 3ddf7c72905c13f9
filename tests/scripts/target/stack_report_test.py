#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/target/stack_report.py on disassemblies whose frames and calls are known."""
import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/target"))
sys.dont_write_bytecode = True
import stack_report  # noqa: E402

X86 = """
facet:     file format elf64-x86-64

Disassembly of section .text:

0000000000001000 <facet::Estimator::add_frame(facet::StereoFrame const&)>:
    1000:	push   %rbp
    1001:	mov    %rsp,%rbp
    1004:	and    $0xffffffffffffffe0,%rsp
    1008:	sub    $0x100,%rsp
    100f:	call   2000 <facet::solve(int)>
    1014:	jmp    1000 <facet::Estimator::add_frame(facet::StereoFrame const&)>
    1019:	jmp    1005 <facet::Estimator::add_frame(facet::StereoFrame const&)+0x5>

0000000000002000 <facet::solve(int)>:
    2000:	push   %rbx
    2001:	sub    $0xffffffffffffff80,%rsp
    2005:	sub    %rax,%rsp
    2008:	call   3000 <(anonymous namespace)::twice(int)>
    200d:	call   9000 <memcpy@plt>
    2012:	jmp    3000 <(anonymous namespace)::twice(int)>

0000000000003000 <(anonymous namespace)::twice(int)>:
    3000:	sub    $0x20,%rsp
    3004:	call   {twice} <x>

0000000000004000 <facet::Estimator::add_imu(facet::ImuSample const&)>:
    4000:	ret

0000000000005000 <facet::Mesher::update(facet::KeyframeView const&)>:
    5000:	call   6000 <void std::__introsort_loop<int*>(int*, int*)>

0000000000006000 <void std::__introsort_loop<int*>(int*, int*)>:
    6000:	call   6000 <void std::__introsort_loop<int*>(int*, int*)>

0000000000007000 <facet::PlaneFinder::update(facet::HorizonMesh const&)>:
    7000:	ret

0000000000008000 <facet::not_hot()>:
    8000:	sub    $0xfffff,%rsp
    8004:	call   8000 <facet::not_hot()>

0000000000009000 <memcpy@plt>:
    9000:	sub    $0xfffff,%rsp
"""

ARM = """
facet:     file format elf64-littleaarch64

0000000000001000 <facet::Estimator::add_frame(int)>:
    1000:	stp	x29, x30, [sp, #-64]!
    1004:	str	d8, [sp, #-16]!
    1008:	sub	sp, sp, #0x1, lsl #12
    100c:	sub	sp, sp, #0x20
    1010:	bl	2000 <facet::solve(int)>
    1014:	b.ne	1000 <facet::Estimator::add_frame(int)>

0000000000002000 <facet::solve(int)>:
    2000:	mov	x12, #0x4c00                	// #19456
    2004:	movk	x12, #0x1, lsl #16
    2008:	sub	sp, sp, x12
    200c:	sub	sp, sp, x3
    2010:	b	2000 <facet::solve(int)>
"""


class StackReport(unittest.TestCase):
    def report(self, text, frame_limit=10000, depth_limit=10000):
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            wrong = stack_report.report(stack_report.parse(text.splitlines()), frame_limit, depth_limit)
        return wrong, output.getvalue()

    def test_frames_of_x86(self):
        functions = stack_report.parse(X86.format(twice="2000").splitlines())
        self.assertEqual(functions[0x1000].frame, 8 + 8 + 32 + 0x100)
        self.assertEqual(functions[0x2000].frame, 8 + 8)
        self.assertTrue(functions[0x2000].dynamic)
        self.assertEqual(functions[0x2000].calls, {0x3000})
        self.assertFalse(functions[0x1000].self_call, "a jump to its own start is a loop")
        self.assertTrue(functions[0x6000].self_call)

    def test_frames_of_aarch64(self):
        functions = stack_report.parse(ARM.splitlines())
        self.assertEqual(functions[0x1000].frame, 64 + 16 + 4096 + 32)
        self.assertEqual(functions[0x1000].calls, {0x2000})
        self.assertEqual(functions[0x2000].frame, 0x14C00)
        self.assertTrue(functions[0x2000].dynamic)
        self.assertFalse(functions[0x2000].self_call)

    def test_limits(self):
        text = X86.format(twice="4000")
        wrong, output = self.report(text)
        self.assertEqual(wrong, [])
        self.assertIn("deepest chain from facet::Estimator::add_frame: 368 bytes", output)
        self.assertIn("std::__introsort_loop: std::sort", output)
        self.assertNotIn("not_hot", output)
        self.assertEqual(len(self.report(text, frame_limit=303)[0]), 1)
        self.assertEqual(self.report(text, frame_limit=304)[0], [])
        self.assertEqual(len(self.report(text, depth_limit=367)[0]), 1)

    def test_recursion_is_found(self):
        for target in ("3000", "2000"):  # itself, a circle of two
            wrong, _ = self.report(X86.format(twice=target))
            self.assertEqual(len(wrong), 1, target)
            self.assertIn("recursion", wrong[0])

    def test_a_stripped_program_is_refused(self):
        with self.assertRaises(stack_report.BadInput):
            self.report("x: file format elf64-x86-64\n")

    def test_notes_of_the_compiler(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "estimator/x.dir/a.cpp.su"
            file.parent.mkdir(parents=True)
            file.write_text(
                "../../estimator/imu/a.cpp:12:6:void facet::a(const std::array<int, 3>&)\t96\tstatic\n"
                "../../estimator/imu/a.cpp:20:6:void facet::b()\t160\tdynamic,bounded\n",
                encoding="utf-8",
            )
            other = Path(folder) / "app/b.cpp.su"
            other.parent.mkdir()
            other.write_text("app/b.cpp:1:1:int main()\t999\tstatic\n", encoding="utf-8")
            self.assertEqual(
                stack_report.read_su(Path(folder)),
                [
                    (160, "dynamic,bounded", "estimator/imu/a.cpp:20", "facet::b"),
                    (96, "static", "estimator/imu/a.cpp:12", "facet::a"),
                ],
            )
            with self.assertRaises(stack_report.BadInput):
                stack_report.read_su(Path(folder) / "mesh")


if __name__ == "__main__":
    unittest.main()
