"""Fails if a source throws what is not of the family of base/errors.h: what callers catch is `samara::Error`."""

import pathlib
import re
import sys

ROOMS = ["base", "pgd", "models", "io", "codebooks", "flow", "identification", "motion", "python", "apps"]
FAMILY = set(re.findall(r"^class (\w+)", (pathlib.Path(sys.argv[1]) / "base" / "errors.h").read_text(), re.M))
# Of the family as well, for what stands between a throw and its catch within a room, or for one kind of text.
DERIVED = {"SamplingStopped", "SteppedEnd", "EquationError"}
# What Python raised goes on as pybind11 has it.
OTHERS = {("python", "py::error_already_set")}

COMMENTS_AND_TEXTS = re.compile(r'//[^\n]*|R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"', re.S)
THROW = re.compile(r"\bthrow\s+(?=[^;\s])")
KINDS = "|".join(sorted(FAMILY | DERIVED))
# Functions, lambdas and variables that give one of the family.
GIVES = re.compile(rf"\b(?:{KINDS})&? (?:\w+::)*(\w+)\s*[(;){{]|\b(\w+) = \[[^\]]*\]\([^)]*\) {{\s*return (?:{KINDS})\(")



def thrown(text):
    """Of what follows a throw, the last name that is not within brackets: `error` of `root.table("box").error(key, ..)`."""
    depth = 0
    outside = ""
    for c in text:
        depth -= c in ")]}"
        if c == ";" and depth == 0:
            break
        if depth == 0 and c not in "()[]{}":
            outside += c
        depth += c in "([{"
    names = re.sub(r"\s+", "", outside).removeprefix("samara::")
    return re.split(r"\.|->", names)[-1]


root = pathlib.Path(sys.argv[1])
sources = {}
for room in ROOMS:
    for file in sorted((root / room).rglob("*")):
        if file.suffix in (".h", ".cpp"):
            # Lines keep their numbers.
            sources[file.relative_to(root)] = COMMENTS_AND_TEXTS.sub(lambda match: "\n" * match[0].count("\n") + '""', file.read_text())
givers = {a or b for text in sources.values() for a, b in GIVES.findall(text)}
wrong = []
seen = 0
for file, text in sources.items():
    for kind in DERIVED:
        derives = re.search(rf"\bclass {kind}\b[^{{;]*{{", text)
        if derives and not re.search(rf": public (?:samara::)?(?:{KINDS})\b", derives[0]):
            wrong.append(f"{file}: {kind} is none of the family")
    for match in THROW.finditer(text):
        seen += 1
        what = thrown(text[match.end():match.end() + 4000])
        if what in FAMILY | DERIVED | givers or (file.parts[0], what) in OTHERS:
            continue
        wrong.append(f"{file}:{text.count(chr(10), 0, match.start()) + 1}: throws {what}")
print("\n".join(wrong) or f"{seen} throws, all of the family of base/errors.h")
sys.exit(1 if wrong or seen == 0 else 0)
