#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Tests of scripts/checks/dead_names.py on small trees with names that are used, and names that are not."""
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "scripts/checks"))
sys.dont_write_bytecode = True
import dead_names  # noqa: E402


class DeadNames(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def dead(self, header, source="", elsewhere="", test=""):
        self.write("mesh/a.h", header)
        self.write("mesh/a.cpp", source)
        self.write("app/run/b.cpp", elsewhere)
        self.write("tests/mesh/a_test.cpp", test)
        return [f"{kind} {name}" for _, _, kind, name in dead_names.find_dead(self.root)[0]]

    def test_a_function_that_nothing_calls(self):
        header = "class A {\npublic:\n    int area(int side) const;\n};\n"
        source = "int A::area(int side) const { return side * side; }\n"
        self.assertEqual(self.dead(header, source, "A a;"), ["function area"])
        self.assertEqual(dead_names.find_dead(self.root)[0][0][:2], ("mesh/a.h", 3))
        self.assertEqual(self.dead(header, source, "A a; int x = a.area(1);"), [])

    def test_tests_keep_nothing_alive(self):
        self.assertEqual(self.dead("void f();\n", "void f() {}\n", test="void t() { f(); }"), ["function f"])

    def test_a_call_in_the_own_source_keeps_alive(self):
        self.assertEqual(self.dead("void f();\nvoid g();\n", "void f() {}\nvoid g() { f(); }\n"), ["function g"])
        source = "int f() { return 1; }\nint g() { return f(); }\n"
        self.assertEqual(self.dead("int f();\nint g();\n", source, "g();"), [])
        self.assertEqual(self.dead("int f();\n", "int f() { return 1; }\n", "const int x = 2 * f();"), [])

    def test_a_function_defined_in_its_header(self):
        self.assertEqual(self.dead("inline bool f(int x) { return x > 0; }\n"), ["function f"])
        self.assertEqual(self.dead("template <int N = 3>\nvoid f() {}\n"), ["function f"])

    def test_a_definition_by_its_whole_name_is_no_use(self):
        header = "struct A {\n    static int f(int x);\n};\n"
        source = "int A::f(int x) { return x; }\n"
        self.assertEqual(self.dead(header, source, "A a;"), ["function f"])
        self.assertEqual(self.dead(header, source, "const int x = A::f(1);"), [])

    def test_types(self):
        header = ("class A {\npublic:\n    explicit A(int x);\n    ~A();\n};\n"
                  "using B = int;\nenum class C : int { kOne };\n")
        source = "A::A(int x) {}\nA::~A() {}\n"
        self.assertEqual(self.dead(header, source), ["type A", "type B", "type C"])
        self.assertEqual(self.dead(header, source, "A a; B b; C c;"), [])

    def test_names_of_templates_and_tags_are_not_declared(self):
        self.assertEqual(self.dead("template <class T>\nstruct A {};\nusing B = A<struct Tag>;\n", "", "B b;"), [])

    def test_constants_and_macros(self):
        header = "#define A_MACRO 1\ninline constexpr int kOne = 1;\nconstexpr int kTwo = 2;\n"
        self.assertEqual(self.dead(header), ["macro A_MACRO", "constant kOne", "constant kTwo"])
        self.assertEqual(self.dead(header, "static_assert(kOne < kTwo);", "int x = A_MACRO;"), [])

    def test_enumerators_are_left_out(self):
        self.assertEqual(self.dead("enum class A { kOne, kTwo = 4 };\n", "", "A a;"), [])

    def test_comments_and_literals_keep_nothing_alive(self):
        literals = 'const char* x = "f()"; const char* y = R"(f())";'
        self.assertEqual(self.dead("void f();\n", "// f();\n/* f(); */\n", literals), ["function f"])


if __name__ == "__main__":
    unittest.main()
