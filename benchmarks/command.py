"""What the command costs: `points_csv`, a table of 100,000 points answered, from the start of the program to its end, beside the
library's batch of the same points on as many threads, for a cheap codebook (coin) and one whose answers take longer (plate7);
`difference` of the two, of the largest value; `version`, the least that a call takes; `mutations`, damaged inputs of each kind by the
calls of the library that the command makes, how often which exit code follows from them, and those that were not refused as
documented; and of a tenth as many the same by the command itself (`by_command`).
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))
sys.path.insert(0, str(ROOT / "tests" / "apps"))

import numpy as np  # noqa: E402

import mutations  # noqa: E402
import samara  # noqa: E402

COMMAND = ROOT / "build" / "release" / "apps" / "samara"
INPUT_FUZZ = ROOT / "build" / "release" / "tests" / "identification" / "input_fuzz"
PLATE = """model = "falling_plate_nd"
[fixed]
"theta(0)" = 0.4
[box]
C_T = [0.8, 1.4]
C_R = [2.0, 4.0]
A = [1.0, 1.8]
B = [0.9, 1.1]
mu1 = [0.15, 0.25]
inertia_ratio = [1.0, 1.2]
beta = [0.06, 0.08]
[time]
end = 4
[tolerance]
relative = 1e-3
[builder]
kind = "pgd"
strategy = "slabs"
"""
PLANS = {"coin": (ROOT / "examples" / "coin" / "plan.toml").read_text(), "plate7": PLATE}
ROWS, QUICK_ROWS = 100_000, 10_000


def report(case, metric, value, unit="1", **more):
    print(json.dumps({"bench": "command", "case": case, "metric": metric, "value": value, "unit": unit, **more}), flush=True)


def least(rounds, run):
    """Seconds: the least of several, which other work disturbed least."""
    best = float("inf")
    for _ in range(rounds):
        begin = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - begin)
    return best


def points_csv(case, folder, rows, rounds):
    plan, path, table, answers = (folder / f"{case}{ending}" for ending in (".toml", ".h5", ".csv", "_answers.csv"))
    plan.write_text(PLANS[case])
    subprocess.run([COMMAND, "build", plan, "-o", path], check=False, capture_output=True)
    book = samara.Codebook.open(path)
    lower, upper = (np.array([getattr(c, end) for c in book.coordinates]) for end in ("lower", "upper"))
    points = np.random.default_rng(27).uniform(lower, upper, (rows, len(lower)))
    header = ",".join(f"{c.name}[{c.unit}]" for c in book.coordinates)
    table.write_text(header + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in points.tolist()))
    ours = least(rounds, lambda: subprocess.run([COMMAND, "query", path, "--points", table, "-o", answers], check=True))
    library = least(rounds, lambda: book.at(points, threads=0))
    report(case, "points_csv", ours, "s", baseline="library", ratio=library / ours)
    values = book.at(points, threads=0).reshape(rows, -1)
    found = np.loadtxt(answers, delimiter=",", skiprows=1)[:, len(lower):]
    report(case, "difference", float(np.max(np.abs(found - values)) / np.max(np.abs(values))))


def damage(count):
    said = subprocess.run([INPUT_FUZZ, str(count)], check=False, stdout=subprocess.PIPE, text=True, errors="replace").stdout
    for kind, number, failures, slowest, codes in re.findall(r"^(\w+): (\d+) mutations, (\d+) failures, slowest ([\d.]+) s, exit codes (.*)$", said, re.M):
        report("mutations", f"{kind}_count", int(number))
        report("mutations", f"{kind}_failures", int(failures))
        report("mutations", f"{kind}_slowest", float(slowest), "s")
        for code, times in re.findall(r"(\d+): (\d+)", codes):
            report("mutations", f"{kind}_exit_{code}", int(times))
    wrong, seen = mutations.run(str(COMMAND), str(INPUT_FUZZ), count // 10)
    report("mutations", "by_command_count", sum(counts.total() for counts in seen.values()))
    report("mutations", "by_command_failures", len(wrong))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("case", nargs="?")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--pictures")  # all benchmarks have it
    arguments = parser.parse_args()
    wanted = lambda case: arguments.case in (None, case)  # noqa: E731
    with tempfile.TemporaryDirectory() as name:
        for case in PLANS:
            if wanted(case):
                points_csv(case, pathlib.Path(name), QUICK_ROWS if arguments.quick else ROWS, 3 if arguments.quick else 10)
    if wanted("version"):
        report("version", "time", least(5 if arguments.quick else 30, lambda: subprocess.run([COMMAND, "--version"], check=True, capture_output=True)), "s")
    if wanted("mutations"):
        damage(200 if arguments.quick else 10_000)


main()
