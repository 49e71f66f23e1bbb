"""Pages of `samara explore`, and what they show, for the tests of it."""

import csv
import sys

from plans import card_plan
from samara_case import COIN_PLAN, FOLDER, book, run, write

SAMPLES = sys.argv.pop(3)
"""The program codebook_samples, third argument of these tests."""
HOSTILE = "<img src=x onerror=alert(1)>&</script>\"'"

CARD_PLAN = card_plan({"C_T": 0.91, "qw(0)": 0.99619469809, "qx(0)": 0.05, "qy(0)": 0.071}, {"C_D90": (0.25, 0.37), "C_R": (0.5, 0.7)}, 0.25)


def explored(*arguments, name="page", code=0):
    page = FOLDER / f"{name}.html"
    result = run("explore", *arguments, "-o", page)
    assert result.returncode == code, result.stderr
    return page


def fallen():
    """A capture of a coin, seen half a metre too deep, and the fit of it."""
    times = [f"{0.4 * k / 20:.17g}" for k in range(21)]
    result = run("query", book("coin", COIN_PLAN), "--set", "C_D=1.25", "--set", "v(0)=0.1", "--at", *times)
    rows = list(csv.DictReader(result.stdout.splitlines()))
    lines = ["t[s],x[m]", *(f"{row['t[s]']},{0.5 + float(row['x[m]']) + 1e-4 * (-1) ** k}" for k, row in enumerate(rows))]
    capture, fit = write("drop.csv", "\n".join(lines) + "\n"), FOLDER / "drop.json"
    if not fit.exists():
        assert run("fit", book("coin", COIN_PLAN), capture, "-o", fit).returncode == 0
    return capture, fit
