"""Usage: fits_test.py SAMARA [CLASS]

Fits from the command.
"""

import csv
import json

from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write


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


if __name__ == "__main__":
    main()
