"""Evaluates codebook files with the lines of Python printed in docs/codebook_file.md and nothing of Samara.

h5py_test.py CODEBOOK_SAMPLES DOCUMENT: the program writes codebooks and reference values; the first block of
Python in the document must define evaluate(path, x) and agree with them.
"""

import csv
import pathlib
import re
import subprocess
import sys
import tempfile

program, document = sys.argv[1:]
snippet = re.search(r"```python\n(.*?)```", pathlib.Path(document).read_text(), re.S).group(1)
scope = {}
exec(compile(snippet, document, "exec"), scope)
lines = [line for line in snippet.splitlines() if line.strip()]
assert len(lines) <= 50, f"{len(lines)} lines: too long for what the document promises"

with tempfile.TemporaryDirectory() as directory:
    subprocess.run([program, "reference", directory], check=True)
    for table in sorted(pathlib.Path(directory).glob("*.csv")):
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(table.open())]
        answers = [scope["evaluate"](table.with_suffix(".h5"), row) for row in rows]
        for name in answers[0]:
            scale = max(abs(row[name]) for row in rows)
            error = max(abs(row[name] - answer[name]) for row, answer in zip(rows, answers)) / scale
            print(f"{table.stem}: {name} at {len(rows)} points: largest difference {error:.2g} of its size")
            assert error <= 1e-12
