# SPDX-License-Identifier: Apache-2.0
"""The rules over the tree. Each takes the tree and the tables and yields what breaks it, as
"path:line: what is wrong"."""
import fnmatch
import os
import re

from source import cpp_functions, includes, python_functions

CPP = (".cpp", ".h", ".cl")
SCRIPTS = (".py", ".sh", ".cmake", "CMakeLists.txt", ".ci/run", "deploy/apt-packages.txt",
           "deploy/apt-packages-test.txt", "deploy/apt-packages-fuzz.txt")


def fits(path, pattern):
    return fnmatch.fnmatchcase(path, pattern)


def file_sizes(tree, tables):
    for path, text in tree.files.items():
        most = next(most for pattern, most in tables.FILE_LINES_MAX if fits(path, pattern))
        count = len(text.splitlines())
        if most is not None and count > most:
            yield f"{path}: {count} lines, at most {most}"


def function_sizes(tree, tables):
    for path, text in tree.having(*CPP, ".py").items():
        functions = python_functions(text) if path.endswith(".py") else cpp_functions(text)
        for line, count in functions:
            if count > tables.FUNCTION_LINES_MAX:
                yield f"{path}:{line}: a function of {count} lines, at most {tables.FUNCTION_LINES_MAX}"


def wide_lines(tree, tables):
    """How many lines lie between the aim and the limit."""
    return sum(tables.COLUMNS_AIM < len(line) <= tables.COLUMNS_MAX
               for text in tree.having(*CPP, *SCRIPTS).values() for line in text.splitlines())


def columns(tree, tables):
    for path, text in tree.having(*CPP, *SCRIPTS).items():
        lines = [number for number, line in enumerate(text.splitlines(), 1)
                 if len(line) > tables.COLUMNS_MAX]
        known = tables.OVERWIDE_LINES.get(path, 0)
        if len(lines) > known:
            at = ", ".join(map(str, lines))
            yield f"{path}: more than {tables.COLUMNS_MAX} columns in line {at}; {known} such lines may be"
        if len(lines) < known:
            yield f"{path}: lower its entry in OVERWIDE_LINES to {len(lines)}"
    for path in set(tables.OVERWIDE_LINES) - set(tree.files):
        yield f"{path}: is gone; remove it from OVERWIDE_LINES"
    count = wide_lines(tree, tables)
    if count > tables.WIDE_LINES_MAX:
        yield (f"{count} lines are wider than {tables.COLUMNS_AIM} columns, "
               f"at most {tables.WIDE_LINES_MAX} may be")


def licence_lines(tree, _tables):
    for path, text in tree.having(*CPP, *SCRIPTS).items():
        if not any("SPDX-License-Identifier: Apache-2.0" in line for line in text.splitlines()[:2]):
            yield f"{path}:1: SPDX-License-Identifier: Apache-2.0 is missing"


def allowed_folders(path, tables):
    keys = [key for key in tables.ARROWS if path.startswith(key)]
    if not keys:
        return None
    key = max(keys, key=len)
    own = key if key.endswith("/") else os.path.dirname(key) + "/"
    return [own, *tables.ARROWS[key]]


def arrows(tree, tables):
    for path, text in tree.having(*CPP).items():
        allowed = allowed_folders(path, tables)
        if allowed is None:
            yield f"{path}: belongs to no room of the table ARROWS"
            continue
        for line, name in includes(text, '""'):
            if not tree.exists(name) and name not in tables.GENERATED:
                yield f"{path}:{line}: \"{name}\" is no file, seen from the root of the project"
            elif "*" not in allowed and not any(
                    name.startswith(entry) if entry.endswith("/") else name == entry
                    for entry in allowed):
                yield f"{path}:{line}: may not include {name}"


def linked_arrows(tree, tables):
    """The same arrows in the CMake files: a room that links another can reach all of it."""
    for path, text in tree.having("CMakeLists.txt").items():
        folder = os.path.dirname(path) + "/"
        for room in re.findall(r"kiln_room\(([^)]*)\)", text):
            linked = re.findall(r"\bkiln_(\w+)", room.partition("LINK")[2])
            for name in linked:
                target = {"kernels": "kernels/", "bake": "server/worker/",
                          "measured_readers": "server/measured/"}.get(name, f"server/{name}/")
                reach = allowed_folders(folder, tables) or []
                if target != folder and not any(entry.startswith(target) for entry in reach):
                    # An image needs one header of compute, never its library.
                    yield f"{path}: kiln_room {room.split()[0]} may not link kiln_{name}"
                elif target not in reach:
                    yield f"{path}: kiln_room {room.split()[0]} may include of {target}, not link it"


# Spelled in pieces, so that this file keeps its own rule.
BANNED = {
    r"\b(TO" r"DO|FIX" r"ME|X" r"XX)\b": "do it, or file an issue",
    r"^[ \t]*#[ \t]*if[ \t]+0\b": "dead code",
    r"\bDIS" r"ABLED_": "a test that never runs",
    r"\bGTEST_SK" r"IP\(\)(?!\s*<<)": "a skipped test says why",
    r"(?<![\w.~$}/*-])/(work|farm|home|root|Users)/": "a path of one machine",
}


def banned_words(tree, _tables):
    for path, text in tree.files.items():
        for pattern, why in BANNED.items():
            for match in re.finditer(pattern, text, re.M):
                line = text.count("\n", 0, match.start()) + 1
                yield f"{path}:{line}: \"{match.group().strip()}\": {why}"


def heavy_headers(tree, tables):
    for path, text in tree.having(*CPP).items():
        for line, name in includes(text, "<>"):
            for header, users in tables.HEAVY_HEADERS.items():
                if fits(name, header) and not any(fits(path, user) for user in users):
                    yield f"{path}:{line}: <{name}> belongs to {', '.join(users)} alone"
    for header, users in tables.HEAVY_HEADERS.items():
        for user in users:
            users_text = "".join(text for path, text in tree.files.items() if fits(path, user))
            if not any(fits(name, header) for _, name in includes(users_text, "<>")):
                yield f"{user}: does not include <{header}>; remove it from HEAVY_HEADERS"


def anchor(title):
    """The name that a heading gets on common hosts."""
    return re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-")


def links(tree, _tables):
    for path, text in tree.having(".md").items():
        for match in re.finditer(r"\]\(([^)\s]+)\)", text):
            target, _, fragment = match.group(1).partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            line = text.count("\n", 0, match.start()) + 1
            file = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
            if not tree.exists(file):
                yield f"{path}:{line}: the link to {target} leads nowhere"
            elif fragment and file.endswith(".md") and fragment not in {
                    anchor(title) for title in re.findall(r"^#+ (.*)", tree.files[file], re.M)}:
                yield f"{path}:{line}: {file} has no heading #{fragment}"


def named_paths(tree, _tables):
    """`server/spec/words.cpp` in a document is a promise that it is there."""
    tops = {path.split("/")[0] for path in tree.files if "/" in path}
    for path, text in tree.having(".md").items():
        for match in re.finditer(r"`([\w.-]+(?:/[\w.*-]+)+/?)`", text):
            name = match.group(1)
            known = tree.exists(name) or any(fits(file, name) for file in tree.files)
            if name.split("/")[0] in tops and not known:
                yield f"{path}:{text.count(chr(10), 0, match.start()) + 1}: there is no {name}"


def kernel_tests(tree, tables):
    for path in tree.files:
        folder, name = os.path.split(path)
        if folder != "kernels" or not name.endswith(".h"):
            continue
        tests = tables.KERNEL_TESTS.get(name, [f"tests/kernels/test_{name[:-2]}.cpp"])
        for test in tests:
            if not tree.exists(test):
                yield f"{path}: its test {test} does not exist"
    for name in tables.KERNEL_TESTS:
        if not tree.exists(f"kernels/{name}"):
            yield f"kernels/{name}: is gone; remove it from KERNEL_TESTS"


def packages(tree, tables):
    seen = {}
    for path in tables.PACKAGE_LISTS:
        for number, line in enumerate(tree.files.get(path, "").splitlines(), 1):
            for name in line.partition("#")[0].split():
                if name in seen:
                    yield f"{path}:{number}: {name} is named in {seen[name]} already"
                seen[name] = f"{path}:{number}"
    for path, text in tree.having(".sh", ".ci/run", ".md", ".cmake", "Dockerfile").items():
        for match in re.finditer(r"\bapt(-get)? (-\S+ )*install\b", text):
            if path != tables.PACKAGE_INSTALLER:
                line = text.count("\n", 0, match.start()) + 1
                yield f"{path}:{line}: packages are installed by {tables.PACKAGE_INSTALLER} alone"


RULES = [file_sizes, function_sizes, columns, licence_lines, arrows, linked_arrows, banned_words,
         heavy_headers, links, named_paths, kernel_tests, packages]
