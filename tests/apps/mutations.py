"""Usage: mutations.py SAMARA COUNT [SEED]

Damaged inputs for the command: plans (checked by --dry-run) and tables of points. Whatever they hold, the command ends within ten
seconds with a documented exit code, and one sentence where that is not 0. Prints failures, and exits with 1 if there are any.
"""

import concurrent.futures
import os
import pathlib
import random
import subprocess
import sys
import tempfile

PLANS = ["""model = "vertical_fall"
title = "a coin in water"
[fixed]
density = "6.339 g/cm^3"
thickness = "2.55 mm"
"x(0)" = "-5 cm"
[box]
C_D = [0.8, 1.6]
area = { range = ["4.5 cm^2", 4.9e-4], nodes = 9 }
"v(0)" = ["0 m/s", "30 cm/s"]
[time]
end = "500 ms"
[tolerance]
relative = 1e-4
absolute = { x = "1 um", v = 1e-5 }
[builder]
kind = "pgd"
strategy = "slabs"
max_calls = 100000
threads = 2
seed = 7
""", """model = "heat_rod"
[fixed]
length = "10 cm"
[box]
conductivity = { range = [20.0, 60.0], transform = "log" }
left = ["20 degC", "80 degC"]
right = [300.0, 350.0]
amplitude = [-20.0, 20.0]
[time]
end = "10 min"
[tolerance]
relative = 1e-3
""", """title = "own"
[equations]
name = "decay"
[equations.states]
n = { initial = 1.0 }
[equations.parameters]
k = { unit = "1/s" }
[equations.rates]
n = "-k*n"
[box]
k = [0.5, 2.0]
"n(0)" = [0.9, 1.1]
[time]
end = 3.0
""", """[command]
run = ["true"]
inputs = { x = "m", y = "1" }
outputs = { u = "N" }
timeout = "2 s"
[box]
x = [1.0, 2.0]
[fixed]
y = 0.5
"""]
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


def failure(samara, call, data):
    """What is wrong with the answer to one input; empty: nothing."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    try:
        result = subprocess.run([samara, *call], input=data, capture_output=True, timeout=LONGEST, env=environment)
    except subprocess.TimeoutExpired:
        return f"took longer than {LONGEST:g} s"
    if result.returncode not in DOCUMENTED:
        return f"ended with {result.returncode}: {result.stderr!r}"
    said = [line for line in result.stderr.decode(errors="replace").splitlines() if not line.startswith("samara: warning: ")]
    if (result.returncode != 0) != (len(said) == 1 and said[0].startswith("samara: ")):
        return f"ended with {result.returncode} and said {result.stderr!r}"
    if b"\x1b" in result.stderr:
        return "sent control characters to the terminal"
    return ""


def failures(samara, count, seed=1):
    """(what went wrong, the input) of every input that was not taken as it should be."""
    with tempfile.TemporaryDirectory() as folder:
        book = pathlib.Path(folder) / "line.h5"
        plan = b'model = "constant_rate"\n[box]\nk = [1.0, 10.0]\n[time]\nend = 10.0\n[tolerance]\nrelative = 1e-9\n'
        subprocess.run([samara, "build", "-", "-o", book], input=plan, check=True, capture_output=True)

        def one(k):
            draw = random.Random(seed * 1_000_003 + k)
            if k % 4 == 3:
                call, text = ["query", str(book), "--points", "-", *draw.choice([[], ["--set", "k=4"], ["--at", "0.5"]])], draw.choice(TABLES)
            else:
                call, text = ["build", "-", "--dry-run"], draw.choice(PLANS)
            data = mutated(text, draw)
            return failure(samara, call, data), call, data

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            return [(what, call, data) for what, call, data in pool.map(one, range(count)) if what]


if __name__ == "__main__":
    found = failures(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    for what, call, data in found:
        print(" ".join(call), what, data, sep="\n  ")
    print(f"{sys.argv[2]} damaged inputs, {len(found)} failures")
    sys.exit(1 if found else 0)
