"""Usage: synthesis_test.py SAMARA [CLASS]

`samara synthesize`: sequences of kinds and patterns, interrupted searches, its JSON and its page (in a real browser; skipped,
with exit code 77, without one).
"""

import csv
import json
import re
import signal
import subprocess
import time

import h5py
import numpy

import browser
from samara_case import FOLDER, LONGEST, SAMARA, Case, main, run, write

PLATES = """model = "falling_plate_nd"
[fixed]
beta = 0
inertia_ratio = 1.3
[axes]
C_T = { from = 0.8, to = 1.4 }
C_R = { from = 2, to = 4 }
A = { from = 1, to = 1.8 }
[sample]
count = 60
[releases]
tilt = [0.6]
[run]
until = 60
step = 0.05
"""

PLAN = """model = "falling_plate_nd"
[body]
inertia_ratio = 1.3
beta = 0
[release]
height = 40
tilt = 0.6
[box]
C_T = [0.8, 1.4]
C_R = [2, 4]
A = [1, 1.8]
[search]
beam = 8
children = 12
step = 0.02
sweeps = 1
"""
WINDOWS = """model = "falling_plate_nd"
[fixed]
beta = 0
inertia_ratio = 1.3
C_R = 3
A = 1.4
[box]
C_T = [0.8, 1.4]
"vx(0)" = [0, 3.5]
"vy(0)" = [0, 1.2]
"w(0)" = [-1.5, 1.5]
"theta(0)" = [-3.14159265358979324, 3.14159265358979324]
[time]
end = 0.1
[tolerance]
relative = 1e-3
"""
STEERED = PLAN.replace("beta = 0\n", "beta = 0\nC_R = 3\nA = 1.4\n").replace("C_R = [2, 4]\nA = [1, 1.8]\n", "")
SKETCH = '[path]\nfile = "slant.csv"\n'
HOSTILE = "<img src=x onerror=alert(1)>&</script>\"'"


def database():
    path = FOLDER / "plates.h5"
    if not path.exists():
        assert run("sweep", write("plates.toml", PLATES), "-o", FOLDER / "sweep.h5").returncode == 0
        assert run("database", FOLDER / "sweep.h5", "-o", path).returncode == 0
    return path


def plan(name, more="", text=PLAN):
    database()
    write("slant.csv", "x,y\n0,40\n16,0\n")
    return write(name, 'database = "plates.h5"\n' + text + more)


class Syntheses(Case):
    def test_a_drawn_sequence_is_told_in_the_answer_beside_what_came_of_it(self):
        motion = plan("drawn.toml", "[sequence]\nlength = 6\nseed = 3\n", PLAN.replace("height = 40", "height = 90"))
        result = run("synthesize", motion, "-o", FOLDER / "drawn.csv", "--course", FOLDER / "drawn.h5", "--json")
        self.assertIn(result.returncode, (0, 4), result.stderr)
        # Of a course there is no date and no builder that took time.
        shown = run("info", FOLDER / "drawn.h5").stdout
        self.assertRegex(shown, r"certificate: met, largest error .* at \d+ times\n  a course that was planned, compared with itself\n")
        self.assertRegex(shown, r"made by samara \S+\n$")
        self.assertNotIn("0 marches", shown)
        answer = json.loads(result.stdout)
        self.assertEqual(self.check_schema(answer), "samara-motion")
        told = answer["sequence"]
        self.assertEqual((told["asked"], told["seed"], told["origin"]), (6, 3, "the database"))
        self.assertEqual([s["asked"] is not None for s in told["segments"]], [k < 6 for k in range(len(told["segments"]))])
        self.assertEqual(told["had"], sum(s["asked"] == s["got"] for s in told["segments"][:6]))
        self.assertEqual(answer["status"] == "found", told["had"] == 6)
        self.assertEqual(result.returncode, 0 if told["had"] == 6 else 4)
        self.assertAlmostEqual(answer["cost"]["total"], sum(v for k, v in answer["cost"].items() if k != "total"))
        # A swing is less than 0.6 pi of the angle between its events, a turn more: in the states that were written.
        with open(FOLDER / "drawn.csv") as file:
            table = list(csv.DictReader(file))
        names = {name.split("[")[0]: name for name in table[0]}
        t, theta = (numpy.array([float(row[names[c]]) for row in table]) for c in ("t", "theta"))
        for segment in told["segments"]:
            turn = numpy.interp(segment["end"], t, theta) - numpy.interp(segment["begin"], t, theta)
            if segment["got"] != "steady":
                self.assertEqual(segment["got"], ("turn" if abs(turn) >= 0.6 * numpy.pi else "swing") + ("+" if turn > 0 else "-"))

    def test_a_chain_of_counts_says_how_windows_follow_each_other(self):
        chain = {"schema": "samara-chain/1", "symbols": ["autorotation", "zigzag"], "counts": [[30, 0], [0, 30]]}
        self.check_schema(chain)
        write("chain.json", json.dumps(chain))
        motion = plan("chained.toml", "[sequence]\nchain = \"chain.json\"\nlength = 3\nevents = 2\n", PLAN.replace("height = 40", "height = 90"))
        answer = json.loads(run("synthesize", motion, "-o", FOLDER / "chained.csv", "--json").stdout)["sequence"]
        self.assertEqual((answer["origin"], len(answer["stretches"]), answer["asked"]), ("chain.json", 1, 1))
        self.assertEqual(answer["had"], int(answer["stretches"][0]["asked"] == answer["stretches"][0]["got"]))

    def test_what_cannot_be_meant_is_refused_with_its_line(self):
        for more, part in [("[sequence]\nkinds = [\"swing\"]\n", "expected one of swing-"),
                           ("[sequence]\npatterns = [\"helix\"]\n", "helix is 0 of 60 falls"),
                           ("[sequence]\nchain = \"plates.toml\"\nlength = 3\n", "plates.toml")]:
            self.check_error(run("synthesize", plan("bad.toml", more), "-o", FOLDER / "bad.csv"), 3, part)
        newer = FOLDER / "newer.h5"
        newer.write_bytes(database().read_bytes())
        with h5py.File(newer, "a") as file:
            file.attrs["format_version"] = numpy.bytes_("1.0")
        text = plan("bad.toml", SKETCH).read_text().replace("plates.h5", newer.name)
        self.check_error(run("synthesize", write("bad.toml", text), "-o", FOLDER / "bad.csv"), 3, "newer.h5", "a newer program wrote it")
        # None of the falls is within so small a box.
        narrow = PLAN.replace("C_T = [0.8, 1.4]", "C_T = [1.1, 1.1000001]")
        self.check_error(run("synthesize", plan("bad.toml", "[sequence]\npatterns = [\"zigzag\"]\n", narrow), "-o", FOLDER / "bad.csv"), 3,
                         "zigzag is 0 of 0 falls of the database within [box]; the nearest has C_T = 1.")
        write("rising.csv", "t,x,y\n0,0,40\n20,5,10\n20.5,5,25\n40,16,0\n")
        self.check_error(run("synthesize", plan("bad.toml", "[path]\nfile = \"rising.csv\"\n"), "-o", FOLDER / "bad.csv"), 3,
                         "rises by 30 in unit time from 20 on", "no fall of the database rises faster")
        other = PLAN.replace("inertia_ratio = 1.3", "inertia_ratio = 1.5")
        self.check_error(run("synthesize", plan("bad.toml", SKETCH, other), "-o", FOLDER / "bad.csv"), 3, "bad.toml:1", "inertia_ratio = 1.3")
        self.check_error(run("synthesize", plan("bad.toml", SKETCH), "-o", FOLDER / "bad.csv", "--resume"), 2, "to go on from")
        self.check_error(run("synthesize", plan("bad.toml", SKETCH), "-o", FOLDER / "bad.csv", "--report", FOLDER / "bad.toml"), 2, "overwrite")
        for named in re.findall(r'"([^"]+\.(?:h5|csv))"', plan("bad.toml", SKETCH).read_text()):
            kept = (FOLDER / named).read_bytes()
            self.check_error(run("synthesize", FOLDER / "bad.toml", "-o", FOLDER / "bad.csv", "--csv" if named.endswith("csv") else "--course", FOLDER / named), 2, "overwrit")
            self.assertEqual((FOLDER / named).read_bytes(), kept)
        kept = (FOLDER / "sweep.h5").read_bytes()
        self.check_error(run("synthesize", FOLDER / "bad.toml", "-o", FOLDER / "bad.csv", "--course", FOLDER / "sweep.h5"), 2,
                         'in the format "samara-sweep", and no codebook')
        self.assertEqual((FOLDER / "sweep.h5").read_bytes(), kept)
        self.check_error(run("synthesize", FOLDER / "bad.toml", "-o", FOLDER / "bad.csv", "--course", FOLDER / "both", "--csv", FOLDER / "both"), 2,
                         "--course and --csv both name")
        for words in (["--body", "disc"], ["--size", "1"], ["--unit", "mm"]):
            self.check_error(run("synthesize", FOLDER / "bad.toml", "-o", FOLDER / "bad.csv", *words), 2, ".glb or .usda was expected")

    def test_tangents_of_a_codebook_are_told_in_the_answer(self):
        windows = FOLDER / "windows.h5"
        self.assertEqual(run("build", write("windows.toml", WINDOWS), "-o", windows).returncode, 0)
        book = 'codebook = "windows.h5"\n'
        motion = write("steered.toml", book + STEERED + SKETCH)
        write("slant.csv", "x,y\n0,40\n16,0\n")
        result = run("synthesize", motion, "-o", FOLDER / "steered.csv", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        self.check_schema(answer)
        self.assertGreater(answer["codebook"]["windows"], 100)
        self.assertGreater(answer["codebook"]["share"], 0.3)
        self.assertLess(answer["codebook"]["share"], 1.0)
        words = run("synthesize", motion, "-o", FOLDER / "steered.csv").stdout
        self.assertIn(f"the codebook gave tangents of {100 * answer['codebook']['share']:.0f} %", words)
        self.assertIn(f"in {answer['codebook']['windows']} windows", words)
        without = json.loads(run("synthesize", write("steered.toml", STEERED + SKETCH), "-o", FOLDER / "steered.csv", "--json").stdout)
        self.assertNotIn("codebook", without)
        self.assertAlmostEqual(answer["deviation"] / without["deviation"], 1.0, delta=0.05)

        def refused(text, *parts):
            self.check_error(run("synthesize", write("bad.toml", text + SKETCH), "-o", FOLDER / "bad.csv"), 3, *parts)
        refused(book + STEERED.replace("inertia_ratio = 1.3", "inertia_ratio = 1.5"), "bad.toml:1", "the codebook has inertia_ratio = 1.3, the body has 1.5")
        refused(book + PLAN, "bad.toml:1", "no coordinate C_R")
        refused('codebook = "slant.csv"\n' + STEERED, "slant.csv")
        refused('codebook = "plates.toml"\n' + STEERED, "plates.toml")
        whole = windows.read_bytes()
        (FOLDER / "half.h5").write_bytes(whole[: len(whole) // 2])
        refused('codebook = "half.h5"\n' + STEERED, "half.h5")
        self.assertEqual(run("build", write("short.toml", WINDOWS.replace('"w(0)" = [-1.5, 1.5]\n', "")), "-o", FOLDER / "short.h5").returncode, 0)
        refused('codebook = "short.h5"\n' + STEERED, "bad.toml:1", 'a flow map needs an axis "w(0)"')

    def test_an_interrupted_search_goes_on_where_it_stopped(self):
        long = PLAN.replace("beam = 8", "beam = 60").replace("children = 12", "children = 48").replace("step = 0.02", "step = 0.01")
        motion, target = plan("long.toml", SKETCH, long), FOLDER / "long.csv"
        process = subprocess.Popen([SAMARA, "synthesize", motion, "-o", target], stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + LONGEST
        while not (FOLDER / "long.csv.lock").exists() and process.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=LONGEST)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("is kept: the same line goes on from there", errors)
        self.assertTrue((FOLDER / "long.csv.part").exists())
        self.assertFalse(target.exists())
        self.check_error(run("synthesize", plan("long.toml", SKETCH, long + "seed = 2\n"), "-o", target), 3, "belongs to another plan")

    def test_a_file_that_is_no_checkpoint_is_left_alone_by_a_search(self):
        motion, target, part = plan("door.toml", SKETCH), FOLDER / "door.csv", FOLDER / "door.csv.part"
        part.write_text("t,z\n0,1\n")
        for words in ([], ["--fresh"]):
            self.check_error(run("synthesize", motion, "-o", target, *words), 3, f"{part}: this is no checkpoint of a search for a motion, and would be lost")
            self.assertEqual(part.read_text(), "t,z\n0,1\n")
        part.write_text("")
        self.assertIn(run("synthesize", motion, "-o", target, "--fresh").returncode, (0, 4))
        self.assertFalse(part.exists())


class PageOfAMotion(Case):
    @classmethod
    def setUpClass(cls):
        cls.page = FOLDER / "motion.html"
        cls.plan = plan("page.toml", SKETCH + "# " + HOSTILE + "\n[landing]\nx = 16\n[sequence]\nkinds = [\"2 swing+\", \"swing-\"]\n")
        result = run("synthesize", cls.plan, "-o", FOLDER / "page.csv", "--report", cls.page, "--json")
        assert result.returncode in (0, 4), result.stderr
        cls.answer = json.loads(result.stdout)
        cls.text = cls.page.read_text()

    def test_the_page_is_complete_in_itself_and_runs_nothing_of_files(self):
        self.assertEqual(re.findall(r"(?:src|href)\s*=\s*[\"'](?!#)", self.text.replace(HOSTILE, "")), [])
        self.assertIn("default-src 'none'", self.text)
        self.assertNotIn("<img", self.text)
        self.assertEqual(self.text.count("</script>"), 3)

    def test_charts_are_drawn_and_numbers_are_those_of_the_json(self):
        if browser.PROGRAM is None:
            self.skipTest("no browser is here")
        with browser.Browser() as opened:
            opened.open(self.page, "#check")
            opened.until("document.documentElement.dataset.painted !== undefined")
            self.assertEqual(opened.complaints, [])
            self.assertEqual([r for r in opened.requests if not r.startswith("file:")], [])
            # The path, three coefficients, the invisible force.
            self.assertEqual(opened.value("document.documentElement.dataset.painted"), "5")
            rows = lambda id: opened.value(f"[...document.querySelectorAll('#{id} tr')].map((r) => [...r.children].map((c) => c.dataset.value || c.textContent))")
            status = rows("status")[1]
            self.assertEqual(status[0], self.answer["status"])
            self.assertAlmostEqual(float(status[2]), self.answer["deviation"], places=9)
            self.assertAlmostEqual(float(status[4]), self.answer["landing_miss"], places=9)
            cost = {name: float(value) for name, value in rows("cost")[1:]}
            for name, value in self.answer["cost"].items():
                self.assertAlmostEqual(cost[name], value, places=9)
            segments = rows("segments")[1:]
            self.assertEqual([(s[3] or None, s[4]) for s in segments], [(s["asked"], s["got"]) for s in self.answer["sequence"]["segments"]])
            self.assertEqual(len(rows("history")), 1 + len(self.answer["history"]))
            self.assertEqual(opened.value("document.getElementById('plan').textContent"), self.plan.read_text())
            self.assertIn(f"{self.answer['sequence']['had']} of 3 kinds as asked", opened.value("document.getElementById('sequence-says').textContent"))


if __name__ == "__main__":
    main()
