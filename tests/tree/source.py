# SPDX-License-Identifier: Apache-2.0
"""Files of a tree, and what the rules need to know of C++ and Python text."""
import ast
import os
import re

SKIPPED = {".git", "build", "out", "__pycache__", "node_modules"}


class Tree:
    """Path from the root → text, of every text file that is part of the project."""

    def __init__(self, root):
        self.root = root
        self.files = {}
        for folder, folders, names in os.walk(root):
            folders[:] = sorted(set(folders) - SKIPPED)
            for name in sorted(set(names) - SKIPPED):  # in a linked work tree .git is a file
                path = os.path.join(folder, name)
                try:
                    with open(path, encoding="utf-8") as file:
                        self.files[os.path.relpath(path, root)] = file.read()
                except (UnicodeDecodeError, FileNotFoundError):
                    pass  # a picture; a file that went away meanwhile

    def having(self, *endings):
        return {path: text for path, text in self.files.items() if path.endswith(endings)}

    def exists(self, path):
        return os.path.exists(os.path.join(self.root, path))


TOKEN = re.compile(r'''
    //(?:\\\n|[^\n])* | /\*.*?\*/                        # comments
  | R"(?P<mark>[^()\\\s]{0,16})\(.*?\)(?P=mark)"         # raw strings
  | "(?:\\.|[^"\\\n])*" | (?<![\w])'(?:\\.|[^'\\\n])+'   # strings and characters; not 1'000
  | ^[ \t]*\#(?:\\\n|[^\n])*                             # preprocessor lines
''', re.X | re.S | re.M)


def blanked(text):
    """C++ text whose comments, strings and preprocessor lines are blanks; line breaks stay."""
    return TOKEN.sub(lambda token: re.sub(r"[^\n]", " ", token.group()), text)


CONTAINER = re.compile(r"^\s*(?:template\s*<.*>\s*)?(?:inline\s+)?"
                       r"(?:namespace|class|struct|union|enum|extern|typedef|using|concept)\b", re.S)


def is_function(head):
    """Whether the block after `head`, the text since the last statement, is a function's body."""
    head = re.sub(r"^\s*(?:public|private|protected)\s*:(?!:)", "", head)
    if CONTAINER.match(head) and not head.rstrip().endswith(")"):
        return False
    return "(" in head and not head.rstrip().endswith("=")


def cpp_functions(text):
    """(first line, number of lines) of each function outside of functions."""
    text = blanked(text)
    found, open_blocks = [], []  # of each block: is it a function, the first line of its head
    head_start = 0
    for match in re.finditer(r"[{};]", text):
        at, mark = match.start(), match.group()
        inside = any(function for function, _ in open_blocks)
        if mark == "{":
            head = text[head_start:at]
            first = head_start + len(head) - len(head.lstrip())
            open_blocks.append((not inside and is_function(head), text.count("\n", 0, first) + 1))
        elif mark == "}" and open_blocks:
            function, first_line = open_blocks.pop()
            if function:
                found.append((first_line, text.count("\n", 0, at) + 2 - first_line))
        head_start = at + 1
    return found


def python_functions(text):
    nodes = (ast.FunctionDef, ast.AsyncFunctionDef)
    return [(node.lineno, node.end_lineno + 1 - node.lineno)
            for node in ast.walk(ast.parse(text)) if isinstance(node, nodes)]


def includes(text, brackets):
    """What a file includes in "" or <>, with line numbers. Lines of a comment do not count."""
    pattern = r'^[ \t]*#[ \t]*include[ \t]*' + brackets[0] + r'([^">\n]+)' + brackets[1]
    return [(text.count("\n", 0, match.start()) + 1, match.group(1))
            for match in re.finditer(pattern, text, re.M)]
