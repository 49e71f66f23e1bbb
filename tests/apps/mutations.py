"""Usage: mutations.py SAMARA INPUT_FUZZ COUNT [SEED]

Damaged inputs for the command, so many of each kind: plans (checked by --dry-run), captures, sidecars, exports and PEtab tables
(fitted) as tests/identification/input_fuzz writes them, and tables of points. Whatever they hold, the command ends within ten
seconds with a documented exit code, which is the one that input_fuzz has for the same calls of the library, and one sentence
where there is no answer. Prints failures and what was seen, and exits with 1 if there are failures.
"""

import collections
import concurrent.futures
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

TABLES = ["k,t[s]\n4,0.5\n5,1.5\n9.5,10\n", "t[ms];k\n100;4\n250; 5\n\"300\";+6\n", "# body: line\nk\n1\n2\n3\n"]
WORDS = ["nan", "inf", "-1", "0", "1e400", "1e-400", "''", '""', "[", "]", "{", "}", "=", "\n", "\x00", "\x1b[31m", "\u00b5", "m/s^2", "degC", "[box]", "[fixed]",
         "[[box]]", "true", "#", ",", "..", "1979-05-27", "9" * 400, "a." * 200, "model = 'falling_plate'\n", "\ufeff", "\r\n"]
LONGEST = 10.0
DOCUMENTED = {0, 2, 3, 4, 5}


def mutated(text, draw):
    data = bytearray(text.encode())
    for _ in range(draw.choice([1, 1, 2, 5, 20])):
        kind, at = draw.randrange(7), draw.randrange(len(data) + 1)
        end = min(len(data), at + draw.randrange(1, 30))
        if kind == 0:
            data[at:at] = draw.choice(WORDS).encode()
        elif kind == 1:
            del data[at:end]
        elif kind == 2 and at < len(data):
            data[at] = draw.randrange(256)
        elif kind == 3:
            lines = data.split(b"\n")
            draw.shuffle(lines)
            data = bytearray(b"\n".join(lines))
        elif kind == 4:
            data[at:at] = data[at:end]
        elif kind == 5:
            data = data[:at]
        else:
            digits = [k for k, c in enumerate(data) if chr(c).isdigit()]
            if digits:
                data[draw.choice(digits)] = ord(draw.choice("0123456789e.-"))
    return bytes(data)


def failure(samara, call, data, expected):
    """(what is wrong with the answer to one input or nothing, its exit code)."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    try:
        result = subprocess.run([samara, *call], input=data, capture_output=True, timeout=LONGEST, env=environment)
    except subprocess.TimeoutExpired:
        return f"took longer than {LONGEST:g} s", None
    code = result.returncode
    if code not in (DOCUMENTED if expected is None else {expected}):
        return f"ended with {code}, {expected} was expected: {result.stderr!r}", code
    said = [line for line in result.stderr.decode(errors="replace").splitlines() if not re.match(r"samara: (warning|note): ", line)]
    if (code != 0) != (len(said) == 1 and said[0].startswith("samara: ")):
        return f"ended with {code} and said {result.stderr!r}", code
    if b"\x1b" in result.stderr:
        return "sent control characters to the terminal", code
    return "", code


def built(samara, plan, book):
    subprocess.run([samara, "build", "-", "-o", book], input=plan, check=True, capture_output=True)
    return str(book)


def calls(samara, input_fuzz, folder, count, seed):
    """(kind, call, stdin, exit code or None) of every damaged input."""
    written = subprocess.run([input_fuzz, "--write", folder, str(count)], check=True, stdout=subprocess.PIPE, text=True).stdout
    source = built(samara, (folder / "source.toml").read_bytes(), folder / "source.h5")
    for line in written.splitlines():
        kind, code, path = line.split(" ", 2)
        yield kind, ["build", path, "--dry-run"] if kind == "plan" else ["fit", source, path], b"", int(code)
    line = built(samara, b'model = "constant_rate"\n[box]\nk = [1.0, 10.0]\n[time]\nend = 10.0\n[tolerance]\nrelative = 1e-9\n', folder / "line.h5")
    for k in range(count):
        draw = random.Random(seed * 1_000_003 + k)
        more, table = draw.choice([[], ["--set", "k=4"], ["--at", "0.5"]]), draw.choice(TABLES)
        yield "points", ["query", line, "--points", "-", *more], mutated(table, draw), None


def run(samara, input_fuzz, count, seed=1):
    """(what went wrong, the call, its input) of every input that was not taken as it should be; kind -> exit code -> how many."""
    seen, wrong = collections.defaultdict(collections.Counter), []
    with tempfile.TemporaryDirectory() as name:
        every = list(calls(samara, input_fuzz, pathlib.Path(name), count, seed))
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            answers = pool.map(lambda one: failure(samara, *one[1:]), every)
            for (kind, call, data, _), (what, code) in zip(every, answers):
                seen[kind][code] += 1
                if what:
                    wrong.append((what, call, data or pathlib.Path(call[-1] if kind != "plan" else call[1]).read_bytes()))
    return wrong, seen


if __name__ == "__main__":
    found, codes = run(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    for what, call, data in found:
        print(" ".join(call), what, data, sep="\n  ")
    for kind, counts in codes.items():
        print(f"{kind}: {sum(counts.values())} damaged inputs, exit codes {dict(sorted(counts.items()))}")
    print(f"{len(found)} failures")
    sys.exit(1 if found else 0)
