"""Runs the benchmark programs and writes benchmarks/results.md.

Usage: run.py DIRECTORY [NAME] [--quick]
"""

import json
import pathlib
import platform
import subprocess
import sys

NAMES = ["first_walk", "linear_engine", "nonlinear", "sampling", "models", "query"]


def run(program, arguments):
    print(f"running {program.name}", file=sys.stderr)
    output = subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout
    return [json.loads(line) for line in output.splitlines()]


def cpu_name():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def commit():
    result = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True)
    return result.stdout.strip() or "unknown"


def row(m):
    ratio = f"{m['ratio']:.3g}" if "ratio" in m else ""
    return f"| {m['case']} | {m['metric']} | {m['value']:.4g} | {m['unit']} | {m.get('baseline', '')} | {ratio} |"


def main():
    directory = pathlib.Path(sys.argv[1])
    quick = [a for a in sys.argv[2:] if a == "--quick"]
    names = [a for a in sys.argv[2:] if a != "--quick"] or NAMES
    unknown = [n for n in names if n not in NAMES]
    if unknown:
        sys.exit(f"unknown benchmark \"{unknown[0]}\"; known: {', '.join(NAMES)}")
    text = "# Results of the benchmarks\n\n"
    text += "Written by `./dev bench`. Times in seconds; ratio is the baseline's time over ours.\n\n"
    text += f"Commit {commit()}, {cpu_name()}, one thread.\n"
    for name in names:
        measurements = run(directory / name, quick)
        for m in measurements:
            print(json.dumps(m))
        text += f"\n## {name}\n\n| case | metric | value | unit | baseline | ratio |\n| --- | --- | --- | --- | --- | --- |\n"
        text += "\n".join(row(m) for m in measurements) + "\n"
    if names == NAMES:
        (pathlib.Path(__file__).parent / "results.md").write_text(text)


main()
