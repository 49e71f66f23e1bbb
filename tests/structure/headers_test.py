"""Fails if an installed header includes a third-party library other than Eigen or a header of ours that is not installed,
if a source has no header of its own name, or if one uses fmt that only the precompiled headers include."""

import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
# Each file there is one law or field, and defines the function of its name that the registry declares.
ALL_OF_ONE_KIND = {"models/fields", "models/laws", "models/wakes"}
STRATEGIES = "pgd/nonlinear/*_strategy.cpp"  # each one strategy, which strategy.h declares
OF_THE_STANDARD_LIBRARIES = {"limits.h", "math.h", "stddef.h", "stdint.h", "stdio.h", "stdlib.h", "string.h", "experimental/simd"}
wrong = []
installed = set()
asked = []  # where an installed header includes one of ours, and which
for room in ["base", "pgd", "models", "io", "codebooks", "flow", "identification", "motion"]:
    listing = (root / room / "CMakeLists.txt").read_text()
    block = re.search(r"samara_room\(\w+\s.*?HEADERS(.*?)(EXCEPT|PUBLIC|PRIVATE|\))", listing, re.S)
    for name in re.findall(r"\S+\.h", block.group(1)):
        installed.add(f"samara/{room}/{name}")
        for number, line in enumerate((root / room / name).read_text().splitlines(), 1):
            match = re.match(r"\s*#include \"(samara/[^\"]+)\"", line)
            if match:
                asked.append((f"{room}/{name}:{number}", match.group(1)))
            match = re.match(r"\s*#include <([^>]+)>", line)
            # The standard library's headers have neither slash nor suffix, but for those of C.
            if match and match.group(1) not in OF_THE_STANDARD_LIBRARIES and not match.group(1).startswith("Eigen/") and re.search(r"[/.]", match.group(1)):
                wrong.append(f"{room}/{name}:{number}: {match.group(1)} in an installed header")
    for file in sorted((root / room).rglob("*.cpp")):
        name = file.relative_to(root)
        if str(name.parent) not in ALL_OF_ONE_KIND and not name.match(STRATEGIES) and not file.with_suffix(".h").exists():
            wrong.append(f"{name} has no header of its own name")


def includes_fmt(file, depth=1):
    text = file.read_text()
    if "#include <fmt/" in text:
        return True
    named = [name.removeprefix("samara/") for name in re.findall(r'^#include "([^"]+)"', text, re.M)]
    found = [path for name in named for path in (root / name, file.parent / name) if path.is_file()]
    return depth > 0 and any(includes_fmt(path, depth - 1) for path in found)


for room in ["base", "pgd", "models", "io", "codebooks", "flow", "identification", "motion", "apps", "python", "tests", "benchmarks"]:
    for file in sorted((root / room).rglob("*.cpp")):
        if "fmt::" in file.read_text() and not includes_fmt(file):
            wrong.append(f"{file.relative_to(root)} uses fmt and does not include it")
wrong += [f"{place}: {header} is not installed" for place, header in asked if header not in installed]
print("\n".join(wrong) or f"{len(installed)} installed headers, third-party includes: Eigen only")
sys.exit(1 if wrong or not installed else 0)
