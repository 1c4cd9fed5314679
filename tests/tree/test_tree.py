# SPDX-License-Identifier: Apache-2.0
"""Holds the rules over this tree."""
import os
import re
import shutil
import subprocess
import unittest

import rules
import tables
from source import Tree

ROOT = os.environ["KILN_SOURCE_DIR"]
CLANG_FORMAT = shutil.which("clang-format-14")  # other versions break lines elsewhere


class TreeTest(unittest.TestCase):
    tree = Tree(ROOT)

    def test_finds_the_tree(self):
        for path in ("CMakeLists.txt", "kernels/lane.h", "server/kilnd.cpp", "client/main.cpp"):
            self.assertIn(path, self.tree.files)

    def test_rules(self):
        for rule in rules.RULES:
            with self.subTest(rule.__name__):
                found = list(rule(self.tree, tables))
                self.assertFalse(found, "\n" + "\n".join(found))
        count = rules.wide_lines(self.tree, tables)
        if count < tables.WIDE_LINES_MAX:
            print(f"WIDE_LINES_MAX in tests/tree/tables.py can go down to {count}")

    @unittest.skipIf(CLANG_FORMAT is None, "clang-format-14 is not installed")
    def test_format(self):
        files = sorted(self.tree.having(".cpp", ".h"))
        said = subprocess.run([CLANG_FORMAT, "--dry-run", *files], cwd=ROOT, capture_output=True,
                              text=True, check=True).stderr
        unformatted = set(re.findall(r"^([^:\n]+):\d+:\d+: warning: code should", said, re.M))
        found = sorted(unformatted - tables.UNFORMATTED)
        self.assertFalse(found, "run: clang-format-14 -i " + " ".join(found))
        stale = sorted(tables.UNFORMATTED - unformatted)
        self.assertFalse(stale, "formatted now: remove from UNFORMATTED")


if __name__ == "__main__":
    unittest.main()
