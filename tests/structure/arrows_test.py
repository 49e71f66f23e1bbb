"""Fails if a room includes a header of a room it may not know (docs/architecture.md)."""

import pathlib
import re
import sys

MAY_INCLUDE = {
    "base": set(),
    "pgd": {"base"},
    "models": {"base"},
    "io": {"base"},
    "codebooks": {"base", "pgd", "models", "io"},
    "identification": {"base", "pgd", "models", "io", "codebooks"},
}

root = pathlib.Path(sys.argv[1])
wrong = []
seen = 0
for room, allowed in MAY_INCLUDE.items():
    for file in sorted((root / room).rglob("*")):
        if file.suffix not in {".h", ".cpp"}:
            continue
        for number, line in enumerate(file.read_text().splitlines(), 1):
            match = re.match(r'\s*#include "samara/([a-z_]+)/', line)
            if not match:
                continue
            seen += 1
            if match.group(1) != room and match.group(1) not in allowed:
                wrong.append(f"{file.relative_to(root)}:{number}: {room}/ may not include {match.group(1)}/")
print("\n".join(wrong) or f"{seen} includes, all along the arrows")
sys.exit(1 if wrong or seen == 0 else 0)
