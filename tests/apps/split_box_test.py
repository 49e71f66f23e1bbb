"""Usage: split_box_test.py SAMARA SAMPLES DOCUMENT

What `samara stats` makes of codebooks whose box is split into cells. SAMPLES writes two slabs of time by two cells;
the lines of Python in DOCUMENT evaluate them.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

import h5py
import numpy as np

samara, samples, document = sys.argv[1:]
scope = {}
exec(re.search(r"```python\n(.*?)```", pathlib.Path(document).read_text(), re.S).group(1), scope)


def rule(borders, points):
    """Gauss' nodes and weights in every interval between the borders."""
    x, w = np.polynomial.legendre.leggauss(points)
    half = np.diff(borders)[:, None] / 2
    return (borders[:-1, None] + half * (1 + x)).ravel(), (half * w).ravel()


def borders(path, axis):
    with h5py.File(path) as file:
        return np.unique([b for piece in file["pieces"].values() for b in piece[f"axes/{axis}"].attrs["borders"]])


with tempfile.TemporaryDirectory() as directory:
    subprocess.run([samples, "reference", directory], check=True)
    for name in ("pieces", "trains"):
        path = pathlib.Path(directory) / f"{name}.h5"
        result = subprocess.run([samara, "stats", path, "--json"], check=True, capture_output=True, text=True)
        assert "split into cells" in result.stderr, result.stderr
        stats = json.loads(result.stdout)
        times = stats["times"]
        assert times == sorted(set(times)) and stats["inputs"] == []
        # Squares of polynomials of degrees below 8 and, of v(0), of 1: exact.
        C_D, v0 = rule(borders(path, "C_D"), 8), rule(borders(path, "v(0)"), 2)
        weights = np.outer(C_D[1], v0[1]).ravel()
        for i in (0, len(times) // 3, len(times) - 1):
            points = [{"t": times[i], "C_D": a, "v(0)": b} for a in C_D[0] for b in v0[0]]
            answers = [scope["evaluate"](path, point) for point in points]
            for output in stats["outputs"]:
                values = np.array([answer[output["name"]] for answer in answers])
                mean = np.average(values, weights=weights)
                deviation = np.sqrt(np.average((values - mean) ** 2, weights=weights))
                size = np.abs(values).max()
                print(f"{name}: {output['name']} at t = {times[i]:.3f}: {mean:.6g} +- {deviation:.6g}")
                assert abs(output["mean"][i] - mean) <= 1e-10 * size, output["mean"][i]
                assert abs(output["deviation"][i] - deviation) <= 1e-10 * size, output["deviation"][i]
                assert "first_order" not in output
