"""Fails if two sources of a folder, of the small folders of a room, or of the command, give an anonymous namespace the
same name: they may share a compilation (SAMARA_UNITY_BUILD, samara_compile_together), where the two would meet."""

import collections
import pathlib
import re
import sys

ALONE = re.compile(r"models/(laws|wakes)/(?!registry|ambient_flow)")  # compiled one by one, with flags of their own
FEW = 5  # sources: a folder of no more may be a small one, whose sources meet those of others in its room
ROOMS = ["base", "pgd", "models", "io", "codebooks", "flow", "identification", "motion", "python", "apps", "tests"]
ACROSS_FOLDERS = {"apps"}

# At the start of a line, as the formatter has it: constants, types, aliases, and functions with what they take.
CONSTANT = re.compile(r"^(?:inline )?(?:static )?(?:constexpr|const) [^=;({]*?(\w+)(?: =|\[|\{|\()", re.M)
TYPE = re.compile(r"^(?:struct|class|enum class|enum) (\w+)", re.M)
ALIAS = re.compile(r"^using (\w+) = ([^;]*);", re.M)
FUNCTION = re.compile(r"^(?! |using|struct|class|enum|constexpr|const |template|return|//|namespace)[\w:<>,&*\[\] ]*?[ &*](\w+)\(([^{;]*?)\)(?: const)?(?: noexcept)? \{", re.M)


def names_of(file):
    """Names, and what makes two of them the same."""
    text = file.read_text()
    for block in re.findall(r"^namespace \{\n(.*?)^\}  // namespace$", text, re.M | re.S):
        for match in CONSTANT.finditer(block):
            yield match.group(1), file
            for further in re.findall(r", (k\w+) =", block[match.start():block.find(";", match.start())]):
                yield further, file
        for match in TYPE.finditer(block):
            yield match.group(1), file
        for match in FUNCTION.finditer(block):
            kinds = [re.sub(r"\s*\b\w+(?: = .*)?$", "", p.strip()) for p in match.group(2).split(",")]
            yield f"{match.group(1)}({', '.join(kinds)})", file
        for match in ALIAS.finditer(block):
            yield match.group(1), match.group(2)  # two of the same are one


root = pathlib.Path(sys.argv[1])
wrong = []
seen = 0
for room in ROOMS:
    first = {}
    files = [f for f in sorted((root / room).rglob("*.cpp")) if not ALONE.match(str(f.relative_to(root)))]
    beside = collections.Counter(f.parent for f in files)
    for file in files:
        library = pathlib.Path(room, file.relative_to(root).parts[1] if room == "tests" else "")
        meets = {library if room in ACROSS_FOLDERS else file.parent}
        if beside[file.parent] <= FEW:
            meets.add((library, "small folders"))
        for name, meaning in names_of(file):
            seen += 1
            for scope in meets:
                other, known = first.setdefault((scope, name), (file, meaning))
                if known != meaning:
                    wrong.append(f"{file.relative_to(root)}: {name} is also in {other.name}")
print("\n".join(wrong) or f"{seen} names, each of one source")
sys.exit(1 if wrong or seen == 0 else 0)
