"""Fails if a source or test file is named in no CMakeLists.txt of its folder or those above, and would not be built, or a
class of tests of the command neither there nor in ./dev, and would not be run."""

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
apps = root / "tests" / "apps"
run = (apps / "CMakeLists.txt").read_text() + (root / "dev").read_text()
for file in sorted(apps.glob("*_test.py")):
    for name in re.findall(r"^class (\w+)\((?:\w+\.)?\w*Case\)", file.read_text(), re.M):
        seen += 1
        if not re.search(rf"\b{name}\b", run):
            missing.append(f"{file.relative_to(root)}: {name} is run neither by CMakeLists.txt nor by ./dev")
print("\n".join(missing) or f"{seen} sources and classes of tests, all of them built and run")
sys.exit(1 if missing or seen == 0 else 0)
