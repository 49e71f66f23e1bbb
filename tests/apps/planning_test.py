"""Usage: planning_test.py SAMARA [CLASS]

synthesize and ghost: answers, files, and what they refuse.
"""

import csv
import json
import math
import pathlib
import shutil

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


class Planning(Case):
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
        for ours, theirs in zip(fall, rows(again)):
            self.assertLess(abs(ours["x"] - theirs["x"]) + abs(ours["y"] - theirs["y"]), 1e-6)

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
        ghost = json.loads(result.stdout)
        self.assertEqual(ghost["schema"], "samara-ghost/1")
        self.assertLess(ghost["force"]["rms"], 1e-3)
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
        self.assertGreater(moved["box"]["force"]["rms"], 20 * own["box"]["force"]["rms"])
        self.assertIn("force_in_box", frames.read_text().splitlines()[0])

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
        ]:
            result = run("synthesize", write("wrong.toml", changed), "-o", FOLDER / "wrong.glb")
            self.assertEqual(result.returncode, 3, result.stderr)
            self.assertIn(sentence, result.stderr)
        self.assertEqual(run("synthesize", FOLDER / "motion.toml", "-o", FOLDER / "fall.txt").returncode, 2)
        for more, code in [(["--box", "C_t=1..2"], 2), (["--box", "density=1..2"], 2), (["--box", "C_T=2..1"], 2)]:
            self.assertEqual(run("ghost", "falling_plate", files["csv"], *PLATE, *more).returncode, code)


if __name__ == "__main__":
    main()
