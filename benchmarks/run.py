"""Runs the benchmark programs and writes benchmarks/results.md, and pictures into DIRECTORY/pictures.

Usage: run.py DIRECTORY [NAME [CASE]] [--quick]. One case, or quick runs, are printed only.
"""

import json
import os
import pathlib
import platform
import subprocess
import sys

NAMES = ["first_walk", "linear_engine", "nonlinear", "sampling", "models", "flow", "realise", "wind", "query", "identification", "prediction", "motion", "doors"]
# Scripts, which run only when they are asked for: the house is built twice from nothing, and Python or a browser may not be there.
SCRIPTS = ["house", "python", "explorer", "command"]


# Programs that measure cases of a script which are not Python's to measure.
PARTS = {"command": ["command_eval"]}


def run(name, directory, arguments):
    print(f"running {name}", file=sys.stderr)
    program = [sys.executable, pathlib.Path(__file__).parent / f"{name}.py"] if name in SCRIPTS else [directory / name]
    # Draws that nobody may choose are seeded with the commit.
    environment = {**os.environ, "SAMARA_COMMIT": commit()}
    programs = [program] + [[directory / part] for part in PARTS.get(name, [])]
    outputs = [subprocess.run([*p, *arguments], check=True, stdout=subprocess.PIPE, text=True, env=environment).stdout for p in programs]
    return [json.loads(line) for output in outputs for line in output.splitlines()]


def cpu_name():
    """With the widest registers: kernels are compiled for them, and instances of one name differ in them."""
    said = dict(line.split(":", 1) for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if ":" in line)
    said = {key.strip(): value.strip() for key, value in said.items()}
    flags = said.get("flags", "").split()
    registers = next((f", {name}" for flag, name in [("avx512f", "AVX-512"), ("avx2", "AVX2")] if flag in flags), "")
    return said.get("model name", platform.processor()) + registers


def commit():
    """Of the sources; this program's own results are no change of them."""
    def git(*arguments):
        return subprocess.run(["git", *arguments], capture_output=True, text=True).stdout.strip()
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ":/", ":(top,exclude)benchmarks/results.md")
    return (git("describe", "--always") or "unknown") + ("-dirty" if changed else "")


def row(m):
    ratio = f"{m['ratio']:.3g}" if "ratio" in m else ""
    return f"| {m['case']} | {m['metric']} | {m['value']:.4g} | {m['unit']} | {m.get('baseline', '')} | {ratio} |"


def sections_of(text):
    """Heading -> text of the section."""
    parts = text.split("\n## ")
    return {part.split("\n", 1)[0]: part.split("\n", 1)[1].strip() for part in parts[1:]}


def main():
    directory = pathlib.Path(sys.argv[1])
    quick = [a for a in sys.argv[2:] if a == "--quick"]
    name, *case = [a for a in sys.argv[2:] if a != "--quick"] or [None]
    if name not in [None, *NAMES, *SCRIPTS]:
        sys.exit(f"unknown benchmark \"{name}\"; known: {', '.join(NAMES + SCRIPTS)}")
    if len(case) > 1:
        sys.exit(f"\"{case[1]}\" is one argument too many; expected [NAME [CASE]] [--quick]")
    names = [name] if name else NAMES
    path = pathlib.Path(__file__).parent / "results.md"
    sections = sections_of(path.read_text()) if path.exists() else {}
    measured = commit()
    for name in names:
        measurements = run(name, directory, [*quick, "--pictures", directory / "pictures", *case])
        if case and not measurements:
            sys.exit(f"the benchmark {name} has no case \"{case[0]}\"")
        for m in measurements:
            print(json.dumps(m))
        table = "\n".join(row(m) for m in measurements)
        sections[name] = (f"Commit {measured}, {cpu_name()}.\n\n"
                          f"| case | metric | value | unit | baseline | ratio |\n| --- | --- | --- | --- | --- | --- |\n{table}")
        if not quick and not case:
            text = "# Results of the benchmarks\n\nWritten by `./dev bench [NAME]`, section by section. Times in seconds; "
            text += "ratio is the baseline's time over ours. Two quiet runs of nine sections, 100 times and 55 ratios, an hour apart on one virtual machine, "
            text += "differed by 5 % and 4 % in the median; one in ten by more than 36 % and 17 %.\n"
            text += "".join(f"\n## {n}\n\n{sections[n]}\n" for n in NAMES + SCRIPTS if n in sections)
            path.write_text(text)


main()
