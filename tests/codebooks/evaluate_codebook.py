"""Evaluates a codebook with h5py and NumPy alone, without Samara.

Usage: evaluate_codebook.py BOOK.h5 REFERENCE.csv
Every row of the reference holds a point and the values of all outputs there; ends with 1 if one differs.
"""

import sys

import h5py
import numpy as np


def interpolation_row(axis, x):
    """Weights of the axis' nodes at x: the Lagrange polynomials of the element that holds x."""
    nodes, borders, degree = axis[:], np.atleast_1d(axis.attrs["borders"]), int(axis.attrs["degree"])
    element = int(np.clip(np.searchsorted(borders, x) - 1, 0, len(borders) - 2))
    own = slice(element * degree, element * degree + degree + 1)
    row = np.zeros(len(nodes))
    for j in range(own.start, own.stop):
        others = np.delete(nodes[own], j - own.start)
        row[j] = np.prod((x - others) / (nodes[j] - others))
    return row


def evaluate(book, point):
    """{output: value} at {coordinate: value}, SI."""
    for piece in book["pieces"].values():
        axes = piece["axes"]
        if not all(a.attrs["lower"] <= point[n] <= a.attrs["upper"] for n, a in axes.items()):
            continue
        values = {}
        for group in piece["groups"].values():
            product = np.ones(group["weights"].shape[1])
            for name, axis in axes.items():
                product *= interpolation_row(axis, point[name]) @ group["factors"][name][:]
            values.update(zip([o.decode() for o in group["outputs"]], group["weights"][:] @ product))
        return values
    raise ValueError("outside the box")


def main():
    book = h5py.File(sys.argv[1], "r")
    assert book.attrs["format"].decode() == "samara-codebook"
    worst = 0.0
    rows = np.genfromtxt(sys.argv[2], delimiter=",", names=True, deletechars="", replace_space=" ")
    for row in rows:
        point = {name: row[name] for name in book["pieces/0/axes"]}
        for output, value in evaluate(book, point).items():
            worst = max(worst, abs(value - row[output]) / max(1.0, abs(row[output])))
    print(f"{len(rows)} points, largest difference {worst:.2e}")
    sys.exit(0 if worst < 1e-11 and len(rows) > 0 else 1)


if __name__ == "__main__":
    main()
