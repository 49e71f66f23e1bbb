"""What it takes to build the last commit from nothing, and how large the libraries are. --quick counts only.
"""

import argparse
import json
import pathlib
import resource
import subprocess
import tempfile
import time

ROOMS = ["base", "io", "pgd", "models", "codebooks", "flow", "identification", "motion"]
ROOT = pathlib.Path(__file__).resolve().parent.parent


def report(metric, value, unit):
    print(json.dumps({"bench": "house", "case": "house", "metric": metric, "value": value, "unit": unit}), flush=True)


def seconds_of(verb):
    """Of a verb of ./dev in a fresh clone: on the clock, and of processors."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["git", "clone", "--quiet", ROOT, folder], check=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        begin = time.monotonic()
        subprocess.run(["./dev", verb], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        wall = time.monotonic() - begin
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def sources():
    return [f for room in ROOMS for f in (ROOT / room).rglob("*") if f.suffix in {".h", ".cpp"}]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("case", nargs="?", default="house")
    options.add_argument("--quick", action="store_true")
    options.add_argument("--pictures")  # there are none
    arguments = options.parse_args()
    if arguments.case != "house":
        return
    if not arguments.quick:
        wall, processors = seconds_of("demo")
        report("demo_seconds", wall, "s")
        report("demo_cpu_seconds", processors, "s")
        report("test_seconds", seconds_of("test")[0], "s")
    report("library_lines", sum(len(f.read_text().splitlines()) for f in sources()), "1")
    folders = [f.parent for f in sources()]
    report("files_in_largest_room", max(folders.count(folder) for folder in set(folders)), "1")


main()
