"""Usage: fits_test.py SAMARA [CLASS]

Fits from the command.
"""

import csv
import json
import pathlib
import re

from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Fits(Case):
    def capture(self):
        result = run("simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7144e-4", "--set", "thickness=2.55e-3",
                     "--set", "density=6338.5", "--set", "v(0)=0.15", "--until", "0.35", "--frames", "22")
        rows = list(csv.reader(result.stdout.splitlines()))
        column = rows[0].index("x[m]")
        lines = ["t[s],x[m]"] + [f"{row[0]},{float(row[column]) + 0.01}" for row in rows[1:]]
        return write("fall.csv", "\n".join(lines) + "\n")

    def fitted(self, *arguments):
        result = run("fit", *arguments, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        self.assertEqual(answer["schema"], "samara-fit/1")
        return next(c["value"] for c in answer["coefficients"] if c["name"] == "C_D")

    def test_a_simulated_fall_gives_back_its_coefficient(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        # The codebook's error is 1e-3 of the depth, and the drag acts on a part of it.
        self.assertAlmostEqual(self.fitted(path, capture), 1.2, delta=2e-2)
        self.assertAlmostEqual(self.fitted(path, capture, "--reference"), 1.2, delta=1e-6)

    def test_a_model_is_fitted_without_a_codebook(self):
        config = write("fit.toml", '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = 6338.5\n'
                       '[box]\nC_D = [0.5, 2.0]\n"v(0)" = [0.0, 0.5]\n')
        self.assertAlmostEqual(self.fitted("vertical_fall", self.capture(), "--config", config), 1.2, delta=1e-6)

    def test_control_characters_of_a_label_do_not_reach_the_terminal(self):
        rows = self.capture().read_text().splitlines()
        text = "\n".join([f"{rows[0]},drop"] + [f"{row},a\x1b[31m" for row in rows[1:]]) + "\n"
        write("labelled.csv", text)
        sidecar = write("labelled.toml", 'file = "labelled.csv"\ngroup_by = ["drop"]\n[columns]\n'
                        '"t[s]" = { quantity = "t", unit = "s" }\n"x[m]" = { quantity = "x", unit = "m" }\n')
        result = run("fit", book("coin", COIN_PLAN), sidecar)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("\\x1b", result.stdout)
        self.assertNotIn("\x1b", result.stdout + result.stderr)

    def test_the_result_is_written_to_a_file_too(self):
        target = FOLDER / "fit.json"
        result = run("fit", book("coin", COIN_PLAN), self.capture(), "-o", target)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("C_D", result.stdout)
        self.assertEqual(json.loads(target.read_text())["schema"], "samara-fit/1")

    def test_captures_left_out_are_predicted(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        test = write("unseen.csv", capture.read_text())
        result = run("fit", path, capture, "--reference", "--window", "0.2 s", "--left-out", test, "--ahead", "0.1 s", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        scores = {(p["predictor"], p["quantity"]): p for p in json.loads(result.stdout)["predictions"]}
        # The capture is simulated: the model that made it goes on as it did, and a line does not.
        self.assertLess(scores["model", "position, 0.1 s ahead"]["median"], 1e-6)
        self.assertGreater(scores["straight line", "position, 0.1 s ahead"]["median"], 1e-3)

    def test_a_prediction_needs_captures_a_window_and_a_time(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        self.check_error(run("fit", path, capture, "--ahead", "0.1 s"), 2, "--ahead", "--left-out")
        self.check_error(run("fit", path, capture, "--left-out", capture), 2, "--left-out", "--ahead")
        self.check_error(run("fit", path, capture, "--left-out", capture, "--ahead", "0.1 s"), 2, "--window")

    def test_a_time_of_a_prediction_that_is_none_is_a_wrong_call(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        for ahead in ("0", "-1 s"):
            self.check_error(run("fit", path, capture, "--left-out", capture, "--window", "0.2 s", f"--ahead={ahead}"), 2, "--ahead")

    def test_what_is_wrong_with_captures_left_out_is_found_before_the_fit(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        wrong = write("wrong.csv", capture.read_text().replace("x[m]", "y[m]"))
        target = FOLDER / "none.json"
        arguments = ("--window", "0.2 s", "--ahead", "0.1 s", "-o", target)
        self.check_error(run("fit", path, capture, "--left-out", wrong, *arguments), 3, "wrong.csv", '"x"')
        self.assertFalse(target.exists())
        self.check_error(run("fit", path, capture, "--left-out", f"{FOLDER}/./fall.csv", *arguments), 3, "fitted as well as left out")

    def test_no_file_that_was_read_is_overwritten(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        sidecar = write("side.toml", 'file = "fall.csv"\n[labels]\nfile = "labels.csv"\ncolumn = "name"\n')
        labels = write("labels.csv", "name,mass\nfall,1\n")
        before = capture.read_text()
        for target in (capture, labels, sidecar):
            for option in ("-o", "--report"):
                self.check_error(run("fit", path, sidecar, option, target), 2, target.name, "overwrite")
        self.assertEqual(capture.read_text(), before)

    def test_captures_in_a_wrong_unit_are_fitted_badly_and_suspected(self):
        lines = (ROOT / "examples" / "tumbling_card" / "card.csv").read_text().replace("x[mm],y[mm]", "x[m],y[m]")
        config = (ROOT / "examples" / "tumbling_card" / "fit.toml").read_text()
        config = re.sub(r'"([xy])\(0\)" = .*', r'"\1(0)" = [-2000, 2000]', config)
        config = "starts = 1\nmax_iterations = 3\n" + config
        result = run("fit", "falling_plate", write("mm.csv", lines), "--config", write("card.toml", config))
        self.assertIn(result.returncode, (0, 4), result.stderr)
        self.assertIn("in another unit?", result.stderr)

    def test_a_known_coordinate_without_a_box_is_told_so(self):
        config = write("known.toml", '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\n[known]\ndensity = "rho"\n'
                       '[box]\nC_D = [0.5, 2.0]\n"v(0)" = [0.0, 0.5]\n')
        self.check_error(run("fit", "vertical_fall", self.capture(), "--config", config), 3, "density", "[box]")


if __name__ == "__main__":
    main()
