# SPDX-License-Identifier: Apache-2.0
"""Breaks every rule over the tree once, in small trees made for it, and comes close without breaking it."""
import os
import tempfile
import types
import unittest

import rules
import tables
from source import Tree, cpp_functions

SPDX = "// SPDX-License-Identifier: Apache-2.0\n"
SCRATCH = os.environ["KILN_BINARY_DIR"]
BARE = {"OVERWIDE_LINES": {}, "KERNEL_TESTS": {}, "HEAVY_HEADERS": {}, "WIDE_LINES_MAX": 0}


class RulesTest(unittest.TestCase):
    def found(self, rule, files, **changes):
        """What `rule` says of a tree of `files` under the tables with `changes`."""
        with tempfile.TemporaryDirectory(prefix="tree-", dir=SCRATCH) as root:
            for path, text in files.items():
                os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
                with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                    file.write(text)
            own = types.SimpleNamespace(**{**vars(tables), **BARE, **changes})
            return list(rule(Tree(root), own))

    def breaks(self, rule, files, **changes):
        found = self.found(rule, files, **changes)
        self.assertEqual(len(found), 1, found)
        return found[0]

    def keeps(self, rule, files, **changes):
        self.assertEqual(self.found(rule, files, **changes), [])

    def test_file_sizes(self):
        for path, most in (("a.cpp", 400), ("kernels/a.h", 210), ("README.md", 150), ("docs/a.md", 400)):
            self.breaks(rules.file_sizes, {path: "x\n" * (most + 1)})
            self.keeps(rules.file_sizes, {path: "x\n" * most})
        self.keeps(rules.file_sizes, {"api/openapi.json": "1\n" * 1000})

    def test_function_sizes(self):
        body = "    x();\n"
        self.breaks(rules.function_sizes, {"a.cpp": "void f(int a) {\n" + body * 69 + "}\n"})
        self.keeps(rules.function_sizes, {"a.cpp": "void f(int a) {\n" + body * 68 + "}\n"})
        self.keeps(rules.function_sizes, {"a.cpp": "struct A {\n" + "    void f() {}\n" * 99 + "};\n"})
        self.keeps(rules.function_sizes, {"a.cpp": "const int k[] = {\n" + "    1,\n" * 99 + "};\n"})
        self.breaks(rules.function_sizes, {"a.py": "def f():\n" + "    x()\n" * 70})
        self.keeps(rules.function_sizes, {"a.py": "def f():\n" + "    x()\n" * 69})

    def test_functions_are_seen_where_they_are(self):
        text = ("namespace a {\nclass B : public C {\n  public:\n    B()\n        : x_(1) {\n    }\n"
                "    int f() const {\n        auto g = [] { return '{'; };\n        // }\n"
                "        return \"}\"[0];\n    }\n};\n}\n")
        self.assertEqual(cpp_functions(text), [(3, 4), (7, 5)])
        self.assertEqual(cpp_functions('auto s = R"(void f() {)";\nint g(int n = 1\'000) {\n}\n'), [(2, 2)])

    def test_columns(self):
        self.breaks(rules.columns, {"a.cpp": "x" * 121})
        self.breaks(rules.columns, {"a.cpp": "x" * 120})
        self.keeps(rules.columns, {"a.cpp": "√" * 120}, WIDE_LINES_MAX=1)
        self.keeps(rules.columns, {"a.cpp": "x" * 100})
        self.keeps(rules.columns, {"a.cpp": "x" * 121}, OVERWIDE_LINES={"a.cpp": 1})
        self.breaks(rules.columns, {"a.cpp": ""}, OVERWIDE_LINES={"a.cpp": 1})
        self.breaks(rules.columns, {}, OVERWIDE_LINES={"a.cpp": 1})

    def test_licence_lines(self):
        for path in ("a.cpp", "a.h", "a.cl", "a.py", "a.sh", "a/CMakeLists.txt", ".ci/run"):
            self.breaks(rules.licence_lines, {path: "int x;\n"})
        self.keeps(rules.licence_lines, {"a.h": SPDX, "a.sh": "#!/bin/sh\n#" + SPDX, "a.md": "text"})

    def test_arrows(self):
        every = {path + "x.h": "" for path in tables.ARROWS if path.endswith("/")}
        every["server/compute/table.h"] = every["server/worker/bake.h"] = ""
        forbidden = [
            ("kernels/a.h", "server/base/x.h"), ("server/base/a.h", "server/spec/x.h"),
            ("server/store/a.cpp", "server/spec/x.h"), ("server/spec/a.cpp", "kernels/x.h"),
            ("server/compute/a.cpp", "server/image/x.h"), ("server/image/a.cpp", "server/compute/x.h"),
            ("server/http/a.cpp", "server/compute/x.h"), ("server/http/a.cpp", "server/compute/table.h"),
            ("server/worker/a.cpp", "server/http/x.h"), ("server/worker/bake.cpp", "server/store/x.h"),
            ("client/a.cpp", "server/store/x.h"), ("client/a.cpp", "server/worker/x.h"),
            ("tests/reference/a.cpp", "kernels/x.h"), ("elsewhere/a.cpp", "server/base/x.h"),
            ("server/http/a.cpp", "server/http/absent.h"), ("server/http/a.cpp", "x.h"),
        ]
        for path, name in forbidden:
            self.breaks(rules.arrows, {**every, path: f'#include "{name}"\n'})
        for path, name in (("server/http/a.cpp", "server/store/x.h"), ("client/a.cpp", "server/worker/bake.h"),
                           ("server/image/a.cpp", "server/compute/table.h"),
                           ("tests/http/a.cpp", "server/compute/x.h"), ("server/kilnd.cpp", "server/http/x.h")):
            self.keeps(rules.arrows, {**every, path: f'#include "{name}"\n'})

    def test_linked_arrows(self):
        room = "kiln_room({} a.cpp LINK kiln_base kiln_{})\n".format
        self.breaks(rules.linked_arrows, {"server/http/CMakeLists.txt": room("http", "compute")})
        self.breaks(rules.linked_arrows, {"server/image/CMakeLists.txt": room("image", "compute")})
        self.keeps(rules.linked_arrows, {"server/http/CMakeLists.txt": room("http", "store")})

    def test_banned_words(self):
        for text in ("// TO" "DO: later", "FIX" "ME", "X" "XX", "#if " "0\n#endif", "TEST(A, DIS" "ABLED_b)",
                     "GTEST_SK" "IP();", "see /wo" "rk/notes", '"/ho' 'me/me/x"'):
            self.breaks(rules.banned_words, {"a.cpp": text})
        self.keeps(rules.banned_words, {"a.cpp": "mkdtemp(\"a-XX" "XXXX\"); #include \"server/worker/a.h\"\n"
                                                 "#if 0x1\n#endif\nTODOS ~/.local $HOME/wo" "rk/x"})

    def test_heavy_headers(self):
        heavy = {"big/*": ["a.cpp"]}
        include = "#include <big/x.h>\n"
        self.breaks(rules.heavy_headers, {"a.cpp": include, "b.cpp": include}, HEAVY_HEADERS=heavy)
        self.breaks(rules.heavy_headers, {"a.cpp": ""}, HEAVY_HEADERS=heavy)
        self.keeps(rules.heavy_headers, {"a.cpp": include, "b.cpp": "// " + include}, HEAVY_HEADERS=heavy)

    def test_links(self):
        for target in ("absent.md", "../a.cpp", "#no-such-heading", "b.md#nor-here"):
            self.breaks(rules.links, {"docs/a.md": f"# A\n[x]({target})", "docs/b.md": "# B\n"})
        self.keeps(rules.links, {"docs/a.md": "# One: `two`\n[x](b.md) [y](#one-two) [z](https://x.org)",
                                 "docs/b.md": ""})

    def test_named_paths(self):
        self.breaks(rules.named_paths, {"a.md": "`server/gone.cpp`", "server/a.cpp": ""})
        self.breaks(rules.named_paths, {"a.md": "`server/*.h`", "server/a.cpp": ""})
        self.keeps(rules.named_paths, {"a.md": "`server/a.cpp` `server/*.cpp` `build/x` `and/or`", "server/a.cpp": ""})

    def test_kernel_tests(self):
        self.breaks(rules.kernel_tests, {"kernels/a.h": ""})
        self.breaks(rules.kernel_tests, {"kernels/a.h": ""}, KERNEL_TESTS={"a.h": ["tests/b.cpp"]})
        self.breaks(rules.kernel_tests, {}, KERNEL_TESTS={"a.h": []})
        self.keeps(rules.kernel_tests, {"kernels/a.h": "", "tests/kernels/test_a.cpp": ""})

    def test_packages(self):
        lists = {"deploy/apt-packages.txt": "a  # why\nb\n", "deploy/apt-packages-test.txt": "c\n"}
        self.keeps(rules.packages, lists)
        self.breaks(rules.packages, {**lists, "deploy/apt-packages-test.txt": "c\nb\n"})
        self.breaks(rules.packages, {**lists, "a.sh": "apt-get -q inst" "all d"})


if __name__ == "__main__":
    unittest.main()
