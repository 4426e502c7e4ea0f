"""The check of one definition must be able to fail, and only then: planted clashes, and what looks like one."""

import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import one_definition


def problems(*sources, namespace="stonestack::search"):
    """What the check says of files with these contents, each in `namespace`."""
    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for number, source in enumerate(sources):
            paths.append(pathlib.Path(folder) / f"{number}.cpp")
            paths[-1].write_text(f"#include <map>\nnamespace {namespace} {{\n{source}\n}}  // namespace\n")
        return one_definition.check("planted", paths, {}) + one_definition.check_hidden("planted", paths)


CLASHES = {
    "type stonestack::search::A is": ("struct A { int a = 0; };", "class A final : public B {\n public:\n  ~A(); };"),
    "type stonestack::search::E is": ("enum E { kOne };", "enum class E : int { kOne };"),
    "type stonestack::search::T is": ("template <class V> struct T {};", "template <class V, int n> class T { V v[n]; };"),
    "type stonestack::search::X is": ("struct STONESTACK_EXPORT X { int a; };", "struct [[nodiscard]] X { int b; };"),
    "type stonestack::search::P is": (
        "A::A() : a_(1), b_{2} { go(); }\nA& A::operator=(A&& a) { return *this; }\nstruct P { int a; };",
        "std::vector<int> v{list[order[0]]};\nstruct P { int b; };",
    ),
    "name stonestack::search::N is": ("using N = std::map<int, int>;", "struct N { int n; };"),
    "alias stonestack::search::M is": ("using M = int;", "using M = double;"),
    "function stonestack::search::f(int, const A &) is": (
        "inline int f(int a, const A& b = {}) { return a; }",
        "[[nodiscard]] inline int f(int, const A& other) {\n  return 2;\n}",
    ),
    "function stonestack::search::operator==(A, A) is": (
        "inline bool operator==(A a, A b) { return true; }",
        "inline bool operator==(A c, A d) { return false; }",
    ),
    "function stonestack::search::refuse takes (const char *) in": (
        "namespace {\nvoid refuse(const char* command) {}\n}",
        "namespace {\n[[noreturn]] void refuse(const std::string& problem) {}\n}",
    ),
    "function stonestack::search::g takes (int, const A &) in": (
        "namespace {\nint g(int n, const A& a) { return n; }\n}",
        "namespace {\nint g(double x, const A& a) { return 1; }\n}",
    ),
    "variable stonestack::search::kMost is": ("inline constexpr int kMost = 3;", "inline constexpr double kMost{4.0};"),
}

NO_CLASHES = {
    "internal linkage": ("namespace {\nstruct A { int a; };\n}", "namespace {\nstruct A { double b; };\nint f() { return 1; }\n}"),
    "functions of anonymous namespaces for different things": (
        "namespace {\nint f(const A& a) { return 1; }\nint g(int n) { return n; }\n}",
        "namespace {\nint f(const B& b) { return 2; }\nint g(int n, int m) { return m; }\n}",
    ),
    "static functions and plain constants": ("static int f() { return 1; }\nconstexpr int k = 1;", "static int f() { return 2; }\nconstexpr int k = 2;"),
    "a declaration and the definition": ("struct A;\nint f(int a);\nextern int v;", "struct A { int a; };\nint f(int a) { return a; }"),
    "overloads": ("inline int f(int a) { return a; }", "inline int f(double a) { return 1; }"),
    "nested types": ("struct A { struct Inner { int a; }; };", "struct B { struct Inner { double b; }; };"),
    "members of different classes": ("int A::f() { return m_[n_[0]]; }\nA& A::operator=(A&& a) { return *this; }", "int B::f() { return 2; }"),
    "the same alias": ("using M = int;", "using M = int;"),
    "comments and text": ('// struct A {};\nconst char* t = "struct A { }";', "struct A { int a; };  /* struct A {}; */"),
    "local types": ("void f() { struct L { int a; }; }", "void g() { struct L { double b; }; }"),
    "members after a constructor with braces": (
        "A::A() : a_(1), b_{2} { go(); }\nstruct P { int a; };",
        "C::C() : a_{1} {}\nnamespace {\nstruct P { int b; };\n}",
    ),
}


class OneDefinition(unittest.TestCase):
    def test_planted_clashes_are_found(self):
        for expected, sources in CLASHES.items():
            with self.subTest(expected):
                found = problems(*sources)
                self.assertTrue(any(expected in problem for problem in found), found)

    def test_what_is_none_is_not_reported(self):
        for name, sources in NO_CLASHES.items():
            with self.subTest(name):
                self.assertEqual(problems(*sources), [])

    def test_rooms_may_use_the_same_name(self):
        with tempfile.TemporaryDirectory() as folder:
            paths = [pathlib.Path(folder) / "a.hpp", pathlib.Path(folder) / "b.hpp"]
            for path, room in zip(paths, ("kinematics", "search")):
                path.write_text(f"namespace stonestack::{room} {{ struct Target {{ int a; }}; }}")
            self.assertEqual(one_definition.check("planted", paths, {}), [])

    def test_a_nested_namespace_is_the_same_however_it_is_written(self):
        found = problems("namespace inner { struct A { int a; }; }", "}\nnamespace stonestack::search::inner { struct A {}; ")
        self.assertEqual(len(found), 1, found)


if __name__ == "__main__":
    unittest.main()
