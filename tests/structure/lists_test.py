"""Fails if a source or test file is named in no CMakeLists.txt of its folder or those above: it would not be built."""

import pathlib
import re
import sys

# The libraries and the command take the sources of their folders as they lie there.
ROOMS = ["benchmarks", "examples", "python", "tests"]

root = pathlib.Path(sys.argv[1])
missing = []
seen = 0
for room in ROOMS:
    for file in sorted((root / room).rglob("*.cpp")):
        seen += 1
        folder = file.parent
        listed = False
        while folder != root and not listed:
            lists = folder / "CMakeLists.txt"
            if lists.exists():
                text = lists.read_text()
                # A function may add the ending.
                listed = str(file.relative_to(folder)) in text or re.search(rf"\({file.stem}\b", text) is not None
            folder = folder.parent
        if not listed:
            missing.append(f"{file.relative_to(root)} is in no CMakeLists.txt")
print("\n".join(missing) or f"{seen} sources, all of them built")
sys.exit(1 if missing or seen == 0 else 0)
