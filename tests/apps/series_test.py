"""Usage: series_test.py SAMARA [CLASS]

Fits of coefficients that change in time, from the command.
"""

import csv
import json
import math
import pathlib

from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Series(Case):
    """Coefficients that change in time, from a capture to its replay."""

    FILES = ROOT / "examples" / "changing_lift"

    def fitted(self, *arguments):
        return run("fit", "falling_plate", self.FILES / "plate.csv", "--config", self.FILES / "series.toml", *arguments)

    def series(self):
        path, answer = FOLDER / "series.h5", FOLDER / "series.json"
        if not path.exists():
            result = self.fitted("--series", path, "-o", answer)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("C_R", result.stdout)
        return path, json.loads(answer.read_text())

    def distance(self, result):
        """Root mean square of what a simulation misses of the capture's places, m."""
        self.assertEqual(result.returncode, 0, result.stderr)
        made = list(csv.DictReader(result.stdout.splitlines()))
        seen = list(csv.DictReader(line for line in (self.FILES / "plate.csv").read_text().splitlines() if line[0] != "#"))
        self.assertEqual(len(made), len(seen))
        squares = [(float(m["x[m]"]) - 1e-3 * float(s["x[mm]"])) ** 2 + (float(m["y[m]"]) - 1e-3 * float(s["y[mm]"])) ** 2
                   for m, s in zip(made, seen)]
        return (sum(squares) / len(squares)) ** 0.5

    def test_the_series_is_in_the_answer_with_its_errors(self):
        _, answer = self.series()
        self.assertEqual(answer["schema"], "samara-series/1")
        lift, = answer["series"]
        self.assertEqual(lift["name"], "C_R")
        for t, value, error in zip(answer["instants"], lift["values"], lift["standard_errors"]):
            # What plate.csv says of itself; beyond four errors once in 16,000.
            self.assertLess(abs(value - (3.0 + 0.8 * math.sin(2 * math.pi * t / 1.2))), 4 * error)
        self.assertGreater(max(lift["values"]) - min(lift["values"]), 1.0)

    def test_estimated_noise_does_not_hide_the_change(self):
        answer = FOLDER / "estimated.json"
        config = write("estimated.toml", 'noise = "estimated"\n' + (self.FILES / "series.toml").read_text())
        result = run("fit", "falling_plate", self.FILES / "plate.csv", "--config", config, "-o", answer)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("no change", result.stderr)
        lift, = json.loads(answer.read_text())["series"]
        for t, value, error in zip(json.loads(answer.read_text())["instants"], lift["values"], lift["standard_errors"]):
            self.assertLess(abs(value - (3.0 + 0.8 * math.sin(2 * math.pi * t / 1.2))), 4 * error)

    def test_info_and_query_know_the_codebook(self):
        path, answer = self.series()
        info = json.loads(run("info", path, "--json").stdout)
        self.assertEqual([(c["name"], c["unit"]) for c in info["coordinates"]], [("t", "s")])
        self.assertEqual(info["outputs"], [{"name": "C_R", "unit": "1"}])
        self.assertIn("standard errors", info["certificate"]["integrator"])
        shown = run("info", path).stdout
        self.assertIn("coefficients of falling_plate", shown)
        self.assertRegex(shown, r"certificate: met, largest error .* at \d+ times\n")
        for nothing in ("1 points", "0e+00", "; seed", "0 marches"):
            self.assertNotIn(nothing, shown)
        rows = list(csv.DictReader(run("query", path, "--at", str(answer["instants"][3])).stdout.splitlines()))
        self.assertAlmostEqual(float(rows[0]["C_R[1]"]), answer["series"][0]["values"][3], places=6)

    def test_the_replay_follows_the_capture_better_than_constant_coefficients(self):
        path, answer = self.series()
        end = ["--until", str(answer["instants"][-1]), "--frames", str(len(answer["fit"]["captures"][0]["times"]))]
        replay = self.distance(run("simulate", "falling_plate", "--coefficients", path, *end))
        sets = {**answer["replay"], "C_R": answer["series"][0]["constant"]}
        for n in answer["constant"]["captures"][0]["nuisances"]:
            name = n["name"].replace("offset of ", "")
            sets[name if name.endswith("(0)") else f"{name}(0)"] = n["value"]
        constant = self.distance(run("simulate", "falling_plate", *sum((["--set", f"{k}={v!r}"] for k, v in sets.items()), []), *end))
        self.assertLess(replay, 1e-3)
        self.assertGreater(constant, 2 * replay)
        # Ends of measured times are rounded.
        later = str(math.nextafter(answer["instants"][-1], math.inf))
        self.assertEqual(run("simulate", "falling_plate", "--coefficients", path, "--until", later, "--frames", "2").returncode, 0)

    def test_what_cannot_be_replayed_is_one_sentence(self):
        path, _ = self.series()
        self.check_error(run("simulate", "falling_plate", "--coefficients", path, "--until", "5"), 5, "series of coefficients", "5")
        self.check_error(run("simulate", "falling_plate", "--coefficients", path, "--set", "C_R=3"), 2, "C_R", "--set")
        self.check_error(run("simulate", "falling_rectangle", "--coefficients", path), 3, "series.h5", "coefficients of falling_plate")
        self.check_error(run("simulate", "vertical_fall", "--coefficients", book("coin", COIN_PLAN)), 3, "coin.h5", "time alone")

    def test_a_series_has_no_equations_to_be_certified_by(self):
        path, _ = self.series()
        self.check_error(run("validate", path), 3, "series.h5", "coefficients of falling_plate", "no equations")

    def test_the_replay_of_a_series_that_did_not_converge_says_so(self):
        path, _ = self.series()
        self.assertEqual(run("simulate", "falling_plate", "--coefficients", path, "--until", "1").stderr, "")
        missed = FOLDER / "missed.h5"
        config = write("missed.toml", "max_iterations = 1\n" + (self.FILES / "series.toml").read_text())
        result = run("fit", "falling_plate", self.FILES / "plate.csv", "--config", config, "--series", missed)
        self.assertNotEqual(result.returncode, 0)
        self.assertTrue(missed.exists(), result.stderr)
        result = run("simulate", "falling_plate", "--coefficients", missed, "--until", "1")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn('did not converge: the builder ended with "max_iterations"', result.stderr)

    def test_a_series_that_cannot_be_is_one_sentence(self):
        text = (self.FILES / "series.toml").read_text()
        for old, new, words in [('"80 ms"', '"3 s"', ["series.span is 3 s", "lasts"]),
                                ('["C_R"]', "[]", ["coefficients", "empty"]),
                                ('["C_R"]', '["C_R", "C_R"]', ["C_R", "twice"]),
                                ('["C_R"]', '["C_r"]', ["C_r", "did you mean"]),
                                ('["C_R"]', '["A"]', ['"A" is fixed'])]:
            self.assertIn(old, text)
            config = write("series.toml", text.replace(old, new))
            self.check_error(run("fit", "falling_plate", self.FILES / "plate.csv", "--config", config), 3, "series.toml", *words)
        for line in ["profiles = true", "bootstrap = 20"]:
            config = write("series.toml", f"{line}\n{text}")
            self.check_error(run("fit", "falling_plate", self.FILES / "plate.csv", "--config", config), 3, "series.toml", line.split()[0])
        self.check_error(self.fitted("--profiles"), 2, "--profiles", "[series]")
        plain = write("plain.toml", text.split("[series]")[0])
        self.check_error(run("fit", "falling_plate", self.FILES / "plate.csv", "--config", plain, "--series", FOLDER / "s.h5"), 2,
                         "--series", "[series]")


if __name__ == "__main__":
    main()
