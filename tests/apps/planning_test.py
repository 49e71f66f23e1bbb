"""Usage: planning_test.py SAMARA [CLASS]

synthesize and ghost: answers, files, and what they refuse.
"""

import csv
import json
import math
import pathlib
import random
import re
import shutil

import numpy

from glb_file import Glb, issues
from samara_case import FOLDER, Case, main, run, write

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples" / "drawn_fall"
PLATE = ["--set", "semi_chord=5 mm", "--set", "semi_thickness=0.57 mm", "--set", "density=11340"]
BOX = ["--box", "C_T=0.8..1.4", "--box", "C_R=2..4", "--box", "A=1..1.8"]


def planned():
    """The example with a search of seconds: its answer, and the files beside it."""
    files = {kind: FOLDER / f"fall.{kind}" for kind in ("glb", "csv", "svg")} | {"h5": FOLDER / "course.h5"}
    answer = FOLDER / "answer.json"
    if not answer.exists():
        shutil.copy(EXAMPLE / "s.csv", FOLDER / "s.csv")
        text = (EXAMPLE / "motion.toml").read_text() + "\n[search]\nbeam = 24\nchildren = 16\nsweeps = 0\n"
        result = run("synthesize", write("motion.toml", text.replace("10 mm", "20 mm")), "-o", files["glb"], "--course",
                     files["h5"], "--csv", files["csv"], "--picture", files["svg"], "--json")
        assert result.returncode == 0, result.stderr
        answer.write_text(result.stdout)
    return json.loads(answer.read_text()), files


def rows(path):
    with open(path) as file:
        return [{key.split("[")[0]: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


# Long and over a wide box: solutions of such falls part within a metre or two.
LEAF = """model = "immersed_body"
[body]
a = "3.5 cm"
b = "2 cm"
c = "0.1 mm"
density = "400 kg/m^3"
C_D0 = 0.05
C_w = 2
[release]
height = "6 m"
tilt = "20 deg"
axis = "35 deg"
[landing]
x = "1 m"
y = "0 m"
[box]
C_D90 = [0.6, 2.7]
C_T = [0.3, 2.7]
C_R = [0.3, 2.7]
[search]
beam = 4
children = 6
sweeps = 0
"""


def worst_angle(times, turns, at, truth):
    """The largest angle between attitudes and what lies between keys, by the shorter way."""
    turns = numpy.array(turns, float) / numpy.linalg.norm(turns, axis=1, keepdims=True)
    before = numpy.clip(numpy.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    share = numpy.clip((at - times[before]) / (times[before + 1] - times[before]), 0, 1)
    first, second = turns[before], turns[before + 1]
    cosine = (first * second).sum(1)
    second = second * numpy.where(cosine < 0, -1, 1)[:, None]
    angle = numpy.arccos(numpy.clip(abs(cosine), 0, 1))
    sine = numpy.where(angle < 1e-6, 1, numpy.sin(angle))
    weights = [numpy.where(angle < 1e-6, part, numpy.sin(part * angle) / sine)[:, None] for part in (1 - share, share)]
    shown = weights[0] * first + weights[1] * second
    shown /= numpy.linalg.norm(shown, axis=1, keepdims=True)
    truth = truth / numpy.linalg.norm(truth, axis=1, keepdims=True)
    return (2 * numpy.arccos(numpy.clip(abs((shown * truth).sum(1)), 0, 1))).max()


class Planning(Case):
    def test_a_long_fall_over_a_wide_box_is_written_as_it_was_found(self):
        files = {kind: FOLDER / f"leaf.{kind}" for kind in ("glb", "csv", "h5")}
        result = run("synthesize", write("wide.toml", LEAF), "-o", files["glb"], "--csv", files["csv"], "--course", files["h5"], "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        self.assertEqual(self.check_schema(answer), "samara-motion")
        self.assertLess(answer["replayed_until"], answer["end"])
        fall = rows(files["csv"])
        seen = {name: numpy.array([row[name] for row in fall]) for name in fall[0]}
        times, places = Glb(files["glb"]).channel("translation")
        self.assertAlmostEqual(times[-1], answer["end"], places=5)
        for shown, name in zip(numpy.transpose(places), ["x", "z", "y"]):  # glTF has y up, and z south
            numpy.testing.assert_allclose(shown, numpy.interp(times, seen["t"], seen[name]) * (-1 if name == "y" else 1), atol=2e-5)
        # No turn comes out backwards: every step lies within half a degree between keys, as players turn between them.
        keys, turns = Glb(files["glb"]).channel("rotation")
        truth = numpy.stack([seen["qx"], seen["qz"], -seen["qy"], seen["qw"]], axis=1)
        self.assertLess(worst_angle(keys, turns, seen["t"], truth), math.radians(0.5))
        # Of 24 keys a second that would not hold.
        every = numpy.linspace(0, len(truth) - 1, int(24 * answer["end"])).astype(int)
        self.assertGreater(worst_angle(seen["t"][every], truth[every], seen["t"], truth), math.radians(20))
        ghost = json.loads(run("ghost", "immersed_body", files["csv"], "--coefficients", files["h5"], "--json").stdout)
        self.assertLess(ghost["force"]["rms"], 1e-3)
        self.check_error(run("plot", files["h5"], "--of", "error", "-o", FOLDER / "course.svg"), 2, "of time alone has no box")

    def test_a_sketch_is_followed_and_the_file_replays_the_fall(self):
        answer, files = planned()
        self.assertEqual(answer["status"], "found")
        self.assertLess(answer["deviation"], 0.02)
        self.assertEqual(answer["schema"], "samara-motion/1")
        self.assertLess(answer["ghost"]["force_max"], 1e-2)
        fall = rows(files["csv"])
        again = FOLDER / "again.csv"
        result = run("simulate", "falling_plate", "--coefficients", files["h5"], "--until", answer["end"], "--frames",
                     len(fall), "-o", again)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(answer["replayed_until"], answer["end"])
        for ours, theirs in zip(fall, rows(again)):
            # What is written is of the plan's steps; this is what replayed_until promises of CVODES.
            self.assertLess(math.hypot(ours["x"] - theirs["x"], ours["y"] - theirs["y"]), 0.1 * answer["semi_length"])

    def test_the_motion_is_a_sound_file_for_viewers(self):
        answer, files = planned()
        self.assertIn(issues(files["glb"]), [None, [0, 0, 0, 0]])  # None: there is no validator here
        times, turns = Glb(files["glb"]).channel("rotation")
        self.assertLess(abs(times[-1] - answer["end"]), 1e-4)
        # Players take the shorter way between keys: no turn is lost or taken backwards.
        net = sum(2.0 * math.atan2(b[2] * a[3] - b[3] * a[2], b[3] * a[3] + b[2] * a[2]) for a, b in zip(turns, turns[1:]))
        fall = rows(files["csv"])
        self.assertAlmostEqual(net, fall[-1]["theta"] - fall[0]["theta"], places=2)
        self.assertIn("<svg", files["svg"].read_text())

    def test_the_ghost_of_the_written_fall_is_none_and_of_a_shifted_one_is_large(self):
        _, files = planned()
        result = run("ghost", "falling_plate", files["csv"], "--coefficients", files["h5"], "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        clean = json.loads(result.stdout)
        self.assertEqual(self.check_schema(clean), "samara-ghost")
        self.assertLess(clean["force"]["rms"], 1e-3)
        self.assertFalse(clean["noise"]["decides"])
        self.assertEqual(result.stderr, "")
        own = json.loads(run("ghost", "falling_plate", files["csv"], *PLATE, *BOX, "--json").stdout)
        lines = files["csv"].read_text().splitlines()
        x = [name.split("[")[0] for name in lines[0].split(",")].index("x")
        shifted = [lines[0]]
        for line in lines[1:]:  # as a follower does that moves the root along a sketch
            cells = line.split(",")
            cells[x] = repr(float(cells[x]) * 1.5)
            shifted.append(",".join(cells))
        path = write("shifted.csv", "\n".join(shifted) + "\n")
        frames = FOLDER / "ghost.csv"
        moved = json.loads(run("ghost", "falling_plate", path, *PLATE, *BOX, "--json", "-o", frames).stdout)
        self.assertEqual(self.check_schema(moved), "samara-ghost")
        self.assertGreater(moved["box"]["force"]["rms"], 20 * own["box"]["force"]["rms"])
        self.assertIn("force_in_box", frames.read_text().splitlines()[0])

    def test_a_path_whose_ghost_is_its_noise_is_warned_of(self):
        _, files = planned()
        lines = files["csv"].read_text().splitlines()
        names = [name.split("[")[0] for name in lines[0].split(",")]
        shaken, noise = [lines[0]], random.Random(5)
        for line in lines[1:]:
            cells = line.split(",")
            for at in (names.index("x"), names.index("y")):
                cells[at] = repr(float(cells[at]) + noise.gauss(0, 1e-4))
            shaken.append(",".join(cells))
        path = write("shaken.csv", "\n".join(shaken) + "\n")
        result = run("ghost", "falling_plate", path, "--coefficients", files["h5"])
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("hardly more than what the noise", result.stderr)
        found = float(re.search(r"noise of a frame (\S+) m,", result.stdout).group(1))
        self.assertAlmostEqual(found, 1e-4, delta=2e-5)

    def test_a_line_by_formula_is_a_sketch_like_any_other(self):
        planned()
        text = (FOLDER / "motion.toml").read_text().replace('file = "s.csv"',
            'side_to_side = { descent_speed = "20 cm/s", horizontal_speed = "25 cm/s", vertical_speed = "4 cm/s", angular_frequency = "8 rad/s" }')
        out = FOLDER / "formula.csv"
        answer = json.loads(run("synthesize", write("formula.toml", text.replace("20 mm", "1 m")), "-o", out, "--json").stdout)
        fall, best = rows(out), 0.0
        for row in fall:  # x over the height fallen, by (3.6): z is monotonic, and found by halving
            low, high = 0.0, 10.0
            for _ in range(60):
                t = 0.5 * (low + high)
                z = 0.3 - 0.2 * t - 0.04 / 16 * (math.cos(16 * t) - 1)
                low, high = (t, high) if z > row["y"] else (low, t)
            best += (row["x"] + 0.25 / 8 * math.sin(8 * t)) ** 2
        self.assertAlmostEqual(answer["deviation"], math.sqrt(best / len(fall)), delta=2e-3 * answer["deviation"] + 1e-5)
        self.assertLess(answer["deviation"], 0.02)

    def test_a_deviation_that_is_missed_has_an_exit_code_of_its_own(self):
        planned()
        text = (FOLDER / "motion.toml").read_text().replace("20 mm", "0.1 mm")
        out = FOLDER / "missed.csv"
        result = run("synthesize", write("missed.toml", text), "-o", out)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("was asked", result.stderr)
        self.assertTrue(out.exists())

    def test_wrong_plans_paths_and_boxes_get_a_sentence(self):
        _, files = planned()
        rising = write("rising.csv", "x,y\n0,0.3\n0,0.31\n")
        text = (FOLDER / "motion.toml").read_text()
        for changed, sentence in [
            (text.replace("s.csv", rising.name), "goes down"),
            (text.replace('height = "30 cm"', 'height = "60 cm"'), "under the release"),
            (text.replace("C_T", "C_t"), "did you mean"),
            (text.replace("[path]", "[way]"), "path"),
            (text.replace("s.csv", write("above.csv", "t,x,y\n0,0,0.3\n0.5,0,0.4\n1,0,0\n").name), "above the release"),
            (text.replace('file = "s.csv"', 'side_to_side = { descent_speed = 0.1, horizontal_speed = 1, vertical_speed = 0.2, '
                          'angular_frequency = 5 }'), "goes down"),
            (text.replace('file = "s.csv"', 'file = "s.csv"\nside_to_side = { descent_speed = 1 }'), "one of them"),
            (text.replace('file = "s.csv"', 'rose = { descent_speed = 1 }'), "rose"),
            (text.replace("s.csv", write("seconds.csv", "x[mm],y[s]\n0,300\n0,0\n").name), "seconds.csv:1: the column y is in s"),
        ]:
            result = run("synthesize", write("wrong.toml", changed), "-o", FOLDER / "wrong.glb")
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertIn(sentence, result.stderr)
        self.assertEqual(run("synthesize", FOLDER / "motion.toml", "-o", FOLDER / "fall.txt").returncode, 2)
        empty = write("empty.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")
        self.check_error(run("synthesize", FOLDER / "motion.toml", "-o", FOLDER / "wrong.glb", "--body", empty, "--unit", "mm"), 3, "empty.obj")
        self.assertFalse((FOLDER / "wrong.glb").exists())
        short = text.replace("[body]", 'duration = "0.5 ms"\n[body]', 1)
        self.check_error(run("synthesize", write("short.toml", short), "-o", FOLDER / "short.csv"), 4, "a smaller step in [search]")
        self.assertFalse((FOLDER / "short.csv").exists())
        turned = write("turned.csv", files["csv"].read_text().replace("theta[rad]", "theta[m]", 1))
        self.check_error(run("ghost", "falling_plate", turned, "--coefficients", files["h5"]), 3, "theta is in m")
        for more, code in [(["--box", "C_t=1..2"], 2), (["--box", "density=1..2"], 2), (["--box", "C_T=2..1"], 2)]:
            self.assertEqual(run("ghost", "falling_plate", files["csv"], *PLATE, *more).returncode, code)


if __name__ == "__main__":
    main()
