"""What the page of `samara explore` costs in a real browser, and how far it is from the library; and what its animations are
worth. Bytes, times to open, per trajectory of 200 times and per frame (curves, charts and body); `difference` is the largest
from `samara query`, of each output's range, at random points, corners and borders of pieces.

The Khronos validator (npm: gltf-validator) is asked where SAMARA_NODE_MODULES leads to it; else its lines are not printed.
"""

import argparse
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "apps"))

from browser import PROGRAM, Browser  # noqa: E402
from glb_file import Glb, issues  # noqa: E402
from plans import card_plan, plate_plan  # noqa: E402

SAMARA = ROOT / "build" / "release" / "apps" / "samara"
CARD = card_plan({"qw(0)": 0.9961946980917455, "qx(0)": 0.0, "qy(0)": 0.08715574274765817},
                 {"C_D90": (0.248, 0.372), "C_T": (0.728, 1.092), "C_R": (0.488, 0.732)}, 0.3)
PLANS = {
    "coin": (ROOT / "examples" / "coin" / "plan.toml").read_text(),
    "plate3": plate_plan(3, 5),
    "plate7": plate_plan(7, 4),
    "body3d": CARD,
}
MEASURE = """(async () => {
  const {state, curves, render} = explorer, {coordinates} = state.book, least = (rounds, run) => {
    let best = Infinity;
    for (let k = 0; k < rounds; ++k) { const begin = performance.now(); run(k); best = Math.min(best, performance.now() - begin); }
    return best;
  };
  const point = (k) => coordinates.map((c, j) => j === 0 ? c.lower : c.lower + (c.upper - c.lower) * ((k * 0.618 + j * 0.37) % 1));
  const many = 20, trajectory = least(20, (k) => { for (let n = 0; n < many; ++n) curves.codebook.curve(curves.prepared, point(many * k + n)); }) / many;
  // The median of 30 frames, and the least of several of these: other work disturbs it least.
  const medians = [];
  for (let round = 0; round < 7; ++round) {
    const frames = [];
    for (let k = 0; k < 30; ++k) {
      const begin = performance.now();
      state.point = point(30 * round + k);
      render("point");
      // Charts are drawn in a microtask: a picture is finished when it can be read.
      await Promise.resolve();
      document.querySelector("#curves canvas").getContext("2d").getImageData(0, 0, 1, 1);
      frames.push(performance.now() - begin);
    }
    medians.push(frames.sort((a, b) => a - b)[15]);
    await new Promise((go) => setTimeout(go, 100));
  }
  const open = performance.getEntriesByType("navigation")[0];
  return {trajectory, frame: Math.min(...medians), open: open.domComplete - open.fetchStart};
})()"""


def report(case, metric, value, unit="1", **more):
    print(json.dumps({"bench": "explorer", "case": case, "metric": metric, "value": value, "unit": unit, **more}), flush=True)


def samara(*arguments):
    return subprocess.run([SAMARA, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def difference(page, book, points):
    """Largest difference from `samara query`, of the range in the certificate."""
    with h5py.File(book) as file:
        names = sorted(file["pieces/0/axes"], key=lambda name: file["pieces/0/axes"][name].attrs["index"])
        box = np.array([[min(p.attrs["lower"][k] for p in file["pieces"].values()), max(p.attrs["upper"][k] for p in file["pieces"].values())]
                        for k in range(len(names))])
        times = sorted({float(p.attrs["lower"][0]) for p in file["pieces"].values()} | {float(box[0, 1]), float(0.37 * box[0, 1])})
        ends = [sorted({float(e) for p in file["pieces"].values() for e in (p.attrs["lower"][k], p.attrs["upper"][k])}) for k in range(1, len(names))]
        ranges = {name: group.attrs["range"] for name, group in file["certificate"].items()}
    random = np.random.default_rng(26)
    asked = [*random.uniform(box[1:, 0], box[1:, 1], (points, len(names) - 1)).tolist(), *itertools.islice(itertools.product(*ends), points)]
    worst = 0.0
    for point in asked:
        settings = itertools.chain(*(("--set", f"{name}={value!r}") for name, value in zip(names[1:], point)))
        answer = json.loads(samara("query", book, *settings, "--json", "--at", *map(repr, times)))["outputs"]
        found = page.value(f"{json.dumps([[t, *point] for t in times])}.map((x) => explorer.curves.codebook.at(x))")
        # Beside the outputs of the file, the last ones follow from a model.
        for o, output in enumerate(answer[:len(found[0])]):
            worst = max(worst, float(np.max(np.abs(np.array(found)[:, o] - output["values"]))) / ranges[output["name"]])
    return worst


def explore(case, folder, points):
    book, page = folder / f"{case}.h5", folder / f"{case}.html"
    (folder / f"{case}.toml").write_text(PLANS[case])
    subprocess.run([SAMARA, "build", folder / f"{case}.toml", "-o", book], check=False, capture_output=True)
    samara("explore", book, "-o", page)
    report(case, "bytes", page.stat().st_size, "B")
    with Browser() as browser:
        browser.look(1200, 900)
        browser.open(page)
        measured = browser.value(MEASURE)
        report(case, "open_time", 1e-3 * measured["open"], "s")
        report(case, "trajectory_time", 1e-3 * measured["trajectory"], "s")
        report(case, "frame_time", 1e-3 * measured["frame"], "s")
        report(case, "difference", difference(browser, book, points))
    return book


def animate(book, folder):
    path, point = folder / "motion.glb", ["--set", "C_D90=0.3", "--set", "C_T=0.9", "--set", "C_R=0.6"]
    samara("query", book, *point, "-o", path)
    times = np.linspace(0.0, 0.3, 2001)
    outputs = {o["name"]: np.array(o["values"]) for o in json.loads(samara("query", book, *point, "--json", "--at", *map(repr, times.tolist())))["outputs"]}
    _, angle = Glb(path).worst(times, np.stack([outputs[n] for n in "xyz"], 1), np.stack([outputs["q" + n] for n in "wxyz"], 1))
    found = issues(path)
    if found is not None:
        report("glb", "errors", found[0])
        report("glb", "warnings", found[1])
    report("glb", "slerp_error", angle, "deg")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("case", nargs="?")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--pictures")  # all benchmarks have it; pages are looked at in a browser
    arguments = parser.parse_args()
    if PROGRAM is None:
        sys.exit("explorer: no browser is installed")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for case in PLANS:
            if arguments.case not in [None, case, *(["glb"] if case == "body3d" else [])]:
                continue
            book = explore(case, folder, 10 if arguments.quick else 50)
            if case == "body3d":
                animate(book, folder)


main()
