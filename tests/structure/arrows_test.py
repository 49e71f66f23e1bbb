"""Fails if a room or a sub-room includes a header of one it may not know, or if the sub-rooms here, those that are built
and those of docs/architecture.md are not the same in the same order."""

import pathlib
import re
import sys

MAY_INCLUDE = {
    "base": set(),
    "pgd": {"base"},
    "models": {"base"},
    "io": {"base"},
    "codebooks": {"base", "pgd", "models", "io"},
    "flow": {"base", "pgd", "models", "io", "codebooks"},
    "identification": {"base", "pgd", "models", "io", "codebooks"},
    "motion": {"base", "pgd", "models", "io", "codebooks", "identification"},
    "python": {"base", "pgd", "models", "io", "codebooks", "flow", "identification", "motion"},
    "apps": {"base", "pgd", "models", "io", "codebooks", "flow", "identification", "motion"},
}

# The sub-rooms of a room, from the lowest upwards: each may include those that stand before it.
SUB_ROOMS = {
    "base": [""],
    "io": [""],
    "python": ["src"],
    "pgd": ["axes", "tensors", "fields", "cross", "linear", "sampling", "evolution", "nonlinear", "checks"],
    "models": ["interface", "checks", "bodies", "added_mass", "equations", "integrators", "batch", "trajectories", "fields", "law_tools", "laws", "wakes", "stochastic", "wind"],
    "codebooks": [
        "model", "book", "file", "plan", "source", "query/kernels", "query", "statistics", "certify", "fields", "build", "composition", "figures", "capi",
    ],
    "flow": ["grid", "pressure", "momentum", "turbulence", "march", "files", "books"],
    "identification": [
        "smoothing", "captures/exports", "captures", "forecasts", "statistics", "problem", "pages", "report",
        "solve/starts", "solve", "fit", "following", "design", "series", "petab", "files", "explorer",
    ],
    "motion": ["records", "search", "events", "chains", "patterns", "sweeps", "database", "bodies", "courses", "ghost", "planning", "pages", "capi"],
    "apps": ["terminal", "options", "inputs", "pictures", "air", "flow", "books", "fit", "models", "motion", ""],
}
MOST_FILES = 40
SUFFIXES = {".h", ".cpp"}

root = pathlib.Path(sys.argv[1])
wrong = []
seen = 0
rooms_told = (root / "docs" / "architecture.md").read_text().split("\n## ")[0]
for room, order in SUB_ROOMS.items():
    named = [sub_room for sub_room in order if sub_room]
    listing = (root / room / "CMakeLists.txt").read_text()
    built = re.search(r"SUB_ROOMS\s+(.*?)\s+HEADERS", listing, re.S)
    if built:
        sub_rooms = built[1].split()
        # What is built as a part of its own lists its sources.
        parts = re.findall(r"^samara_room_part\(\w+ SOURCES (\w+)/", listing, re.M)
        expected = [sub_room for sub_room in named if sub_room in sub_rooms or sub_room not in parts]
        if sub_rooms != expected:
            wrong.append(f"{room}/CMakeLists.txt builds {sub_rooms}, expected {expected}")
    told = re.search(rf"^- `{room}/`:.*?(?=^- `|\Z)", rooms_told, re.M | re.S)[0]
    items = re.findall(r"^  - `([\w/]+)/`:", told, re.M)
    if items and items != [sub_room for sub_room in named if "/" not in sub_room]:
        wrong.append(f"docs/architecture.md has {items} in {room}/, expected {named}")
    wrong += [f"docs/architecture.md does not tell of {room}/{sub_room}/" for sub_room in named if f"`{sub_room}/`" not in told]
for room, allowed in MAY_INCLUDE.items():
    order = SUB_ROOMS[room]
    for file in sorted((root / room).rglob("*")):
        if file.suffix not in SUFFIXES:
            continue
        sub_room = str(file.parent.relative_to(root / room)).replace(".", "")
        if sub_room not in order:
            wrong.append(f"{file.relative_to(root)}: stands in no sub-room of {room}/")
            continue
        for number, line in enumerate(file.read_text().splitlines(), 1):
            match = re.match(r'\s*#include "(?:samara/([a-z_]+)/)?(?:([a-z_/]+)/)?[a-z0-9_]+\.h"', line)
            if not match or "/" not in match.group(0):  # what the build writes has no folder
                continue
            seen += 1
            here = f"{file.relative_to(root)}:{number}: {room}/{sub_room}"
            # Headers of the command are no part of the library.
            other_room, other_sub_room = match.group(1) or room, match.group(2) or ""
            if other_room != room:
                if other_room not in allowed:
                    wrong.append(f"{here} may not include {other_room}/")
            elif other_sub_room not in order or order.index(other_sub_room) > order.index(sub_room):
                wrong.append(f"{here} may not include {match.group(0).split()[1]}")
    for sub_room in order:
        count = sum(f.suffix in SUFFIXES for f in (root / room / sub_room).iterdir())
        if count > MOST_FILES:
            wrong.append(f"{room}/{sub_room} has {count} files, {MOST_FILES} at most")
print("\n".join(wrong) or f"{seen} includes, all along the arrows")
sys.exit(1 if wrong or seen == 0 else 0)
