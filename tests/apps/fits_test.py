"""Usage: fits_test.py SAMARA [CLASS]

Fits from the command.
"""

import csv
import json
import math
import pathlib
import re

from samara_case import COIN_PLAN, FOLDER, LINE_PLAN, Case, book, main, run, write

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

    def test_a_model_takes_from_a_codebook_what_that_covers(self):
        cover = book("coin6", COIN_PLAN.replace("relative = 1e-3", "relative = 1e-6"))
        rest = ('[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = 6338.5\n'
                '[box]\nC_D = [0.5, 2.0]\n"v(0)" = [0.0, 0.5]\n')
        config = write("covered.toml", f'codebook = "{cover.name}"\n' + rest)
        self.assertAlmostEqual(self.fitted("vertical_fall", self.capture(), "--config", config), 1.2, delta=2e-5)
        self.assertIn("by codebook and reference integrator", run("fit", "vertical_fall", self.capture(), "--config", config).stdout)
        self.check_error(run("fit", cover, self.capture(), "--config", config), 3, "covered.toml", "is one itself")
        for wrong, sentence in [(config.read_text().replace(cover.name, "none.h5"), "none.h5"),
                                (config.read_text().replace("6338.5", "6000"), 'holds "density" at 6338.5'),
                                (config.read_text().replace(cover.name, book("line", LINE_PLAN).name), 'is of "constant_rate"')]:
            self.check_error(run("fit", "vertical_fall", self.capture(), "--config", write("covered_wrong.toml", wrong)), 3, sentence)

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

    def test_a_codebook_that_misses_its_tolerance_is_told_in_the_file_of_the_fit_too(self):
        path, target = FOLDER / "rough.h5", FOLDER / "rough.json"
        plan = COIN_PLAN.replace('"v(0)" = [0.0, 0.4]', '"v(0)" = { range = [0.0, 0.4], nodes = 2 }')
        self.assertEqual(run("build", write("rough.toml", plan), "-o", path).returncode, 4)
        result = run("fit", path, self.capture(), "-o", target)
        fit = json.loads(target.read_text())
        told = fit["warnings"][fit["warning_kinds"].index("source")]
        self.assertIn("rough.h5 has no certificate that meets its tolerance", told)
        self.assertEqual(result.stderr.count(told), 1, result.stderr)

    def test_no_file_of_another_kind_is_lost_to_a_series(self):
        config = write("series_of_none.toml", 'outputs = ["x"]\n')
        other = write("notes_of_series.h5", "mine")
        self.check_error(run("fit", "vertical_fall", self.capture(), "--config", config, "--series", other), 2, str(other), "no codebook")
        self.assertEqual(other.read_text(), "mine")

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

    def sidecar_of(self, name, *lines):
        """Drops a and b of one table, each with its speed as a label."""
        rows = self.capture().read_text().splitlines()
        table = [f"{rows[0]},drop"] + [f"{row},{drop}" for drop in "abc" for row in rows[1:]]
        write(f"{name}.csv", "\n".join(table) + "\n")
        return write(f"{name}.toml", f'file = "{name}.csv"\ngroup_by = ["drop"]\n' + "\n".join(lines) +
                     '\n[columns]\n"t[s]" = { quantity = "t", unit = "s" }\n"x[m]" = { quantity = "x", unit = "m" }\n')

    def test_all_files_behind_left_out_are_left_out(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        unseen = [write(f"unseen{k}.csv", capture.read_text()) for k in range(3)]
        times = ("--span", "0.2 s", "--ahead", "0.1 s", "--json")
        for arguments in ((capture, "--left-out", *unseen), ("--left-out", *unseen, "--", path, capture)):
            call = arguments if path in arguments else (path, *arguments)
            result = run("fit", *times, *call) if path in arguments else run("fit", *call, *times)
            self.assertEqual(result.returncode, 0, result.stderr)
            answer = json.loads(result.stdout)
            self.assertEqual(answer["clusters"], 1)
            self.assertEqual([c["id"] for c in answer["captures"]], ["fall"])
            self.assertEqual({p["captures"] for p in answer["predictions"] if p["predictor"] == "model"}, {3})
            self.assertEqual({p["capture"] for p in answer["capture_predictions"]}, {"unseen0", "unseen1", "unseen2"})
        self.check_error(run("fit", path, capture, "--left-out", unseen[0], unseen[0], *times), 3, "unseen0", "twice")
        self.check_error(run("fit", path, "--left-out", *unseen, *times), 2, "CAPTURE", "--left-out", "unseen2.csv")

    def test_a_capture_by_two_names_of_its_file_is_given_twice(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        respelled, link = f"{FOLDER}/./fall.csv", FOLDER / "fall_link.csv"
        link.unlink(missing_ok=True)
        link.symlink_to(capture)
        config, unseen = write("plain_twice.toml", 'outputs = ["x"]\n'), write("unseen_once.csv", capture.read_text())
        for again in (capture, respelled, link):
            for more in ((), ("--config", config)):
                result = run("fit", path, capture, again, *more)
                self.check_error(result, 3, "is given twice")
                self.assertTrue(result.stderr.startswith(f"samara: {again}: capture"), result.stderr)
        times = ("--span", "0.2 s", "--ahead", "0.1 s")
        self.check_error(run("fit", path, capture, "--left-out", unseen, f"{FOLDER}/./unseen_once.csv", *times), 3, "./unseen_once.csv", "is left out twice")

    def test_a_value_too_many_is_no_input_of_another_kind(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        other = write("other.csv", capture.read_text())
        config = write("span.toml", 'span = "0.3 s"\n')
        for option, value in [("--config", config), ("--span", "0.3 s"), ("-o", FOLDER / "more.json"), ("--ahead", "0.1 s"),
                              ("--report", FOLDER / "more.html"), ("--series", FOLDER / "more.h5"), ("--sidecar", config),
                              ("--coefficients", config), ("--left-out-span", "0.1 s")]:
            self.check_error(run("fit", path, capture, option, value, other), 2, "other.csv", option.strip("-")[:1], "one row")
        self.assertFalse((FOLDER / "more.json").exists())
        # Flags take no values, and other commands no second input.
        self.assertEqual(run("fit", path, capture, "--reference", other).returncode, 0)
        self.check_error(run("query", path, "--set", "C_D=1.2", "v(0)=0.1"), 2, "v(0)=0.1")

    def test_notes_of_cleaning_are_no_warnings(self):
        config = write("plain_fit.toml", 'cluster_by = ["drop"]\n')
        sidecar = self.sidecar_of("noted", "least_frames = 12")
        sidecar.write_text(sidecar.read_text() + "[clean]\nframe_grid = true\noutliers = 5\n")
        target = FOLDER / "noted.json"
        result = run("fit", book("coin", COIN_PLAN), sidecar, "--config", config, "-o", target)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("multiples", result.stderr)
        self.assertEqual(len([line for line in result.stdout.splitlines() if line.startswith("note: ")]), 1)
        whole = re.sub(r"\n {4,}", " ", result.stdout)  # long lines go on below
        self.assertRegex(whole, r'note: capture ".": times set to multiples of .*; likewise 2 more: ')
        self.assertTrue(all("multiples" in c["notes"][0] for c in json.loads(target.read_text())["captures"]))

    def test_what_is_suspicious_about_many_captures_is_one_sentence(self):
        sidecar = self.sidecar_of("short", 'until = "0.1 s"')
        result = run("fit", book("coin", COIN_PLAN), sidecar)
        lines = [line for line in result.stderr.splitlines() if "frames" in line]
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertIn('capture "a": it has 7 frames; likewise 2 more: "b", "c"', lines[0])

    def test_the_span_of_a_prediction_is_a_setting_of_its_own(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        unseen = write("own_span.csv", capture.read_text())
        def frames(*arguments):
            result = run("fit", path, capture, "--left-out", unseen, "--json", *arguments)
            self.assertEqual(result.returncode, 0, result.stderr)
            answer = json.loads(result.stdout)
            counts = {p["quantity"]: p["count"] for p in answer["predictions"] if p["predictor"] == "model"}
            return answer["captures"][0]["frames"], counts["position, up to 0.1 s ahead"]
        # Frames every 1/60 s: 13 in 0.2 s; six lie in each tenth of a second.
        self.assertEqual(frames("--span", "0.2 s", "--left-out-span", "0.1 s", "--ahead", "0.1 s"), (13, 6))
        config = write("both.toml", '[prediction]\nwindow = "0.1 s"\nahead = "0.1 s"\n')
        self.assertEqual(frames("--config", config), (22, 6))
        self.assertEqual(frames("--config", config, "--span", "0.3 s"), (19, 6))
        self.check_error(run("fit", path, capture, "--left-out-span", "0.1 s"), 2, "--left-out-span", "--left-out")

    def test_coefficients_of_a_fit_go_into_a_prediction_without_one(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        fitted, unseen = FOLDER / "first.json", write("later.csv", capture.read_text())
        self.assertEqual(run("fit", path, capture, "-o", fitted).returncode, 0)
        value = json.loads(fitted.read_text())["coefficients"][0]["value"]
        times = ("--left-out-window", "0.2 s", "--ahead", "0.1 s")
        together = run("fit", path, capture, "--left-out", unseen, *times, "--json")
        alone = run("fit", path, "--coefficients", fitted, "--left-out", unseen, *times, "--json")
        self.assertEqual(alone.returncode, 0, alone.stderr)
        answer = json.loads(alone.stdout)
        self.assertEqual((answer["coefficients"], answer["captures"]), ([], []))
        # Nothing of the fit that gave them is told as if it were this one's.
        self.assertEqual([answer[key] for key in ("covariance", "clusters", "residuals", "residual_count", "cost", "whiteness")], [[], 0, [], 0, 0.0, None])
        self.assertEqual(answer["fixed"]["C_D"], value)
        self.assertEqual(answer["predictions"], json.loads(together.stdout)["predictions"])
        # A model holds what its config has no box for.
        config = write("held.toml", 'outputs = ["x"]\n[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = 6338.5\n'
                       '[box]\n"v(0)" = [0.0, 0.5]\n')
        held = run("fit", "vertical_fall", "--coefficients", fitted, "--left-out", unseen, *times, "--config", config)
        self.assertEqual(held.returncode, 0)
        self.assertNotIn("warning", held.stderr)
        # Coefficients belong to what was held where they were found, and to their model.
        heavier = write("heavier.toml", config.read_text().replace("6338.5", "1000.0"))
        doubted = run("fit", "vertical_fall", "--coefficients", fitted, "--left-out", unseen, *times, "--config", heavier)
        self.assertIn('found with "density" held at 6338.5; here it is 1000', doubted.stderr)
        other = write("other.json", fitted.read_text().replace('"vertical_fall"', '"quadratic_drag_fall"'))
        doubted = run("fit", path, "--coefficients", other, "--left-out", unseen, *times, "--json")
        self.assertIn('coefficients of the model "quadratic_drag_fall"; here they are those of "vertical_fall"', doubted.stderr)
        self.assertEqual(json.loads(doubted.stdout)["model"], "vertical_fall")
        self.check_error(run("fit", path, "--coefficients", fitted, "--left-out", capture, *times), 3, "fitted as well as left out")
        # Wherever it lies, and by its frames: another one in its place was not fitted.
        (FOLDER / "moved").mkdir()
        moved = write("moved/fall.csv", capture.read_text())
        self.check_error(run("fit", path, "--coefficients", fitted, "--left-out", moved, *times), 3, "fitted as well as left out")
        write("fall.csv", moved.read_text() + "0.4,0.35\n")
        another = run("fit", path, "--coefficients", fitted, "--left-out", capture, *times)
        self.assertEqual(another.returncode, 0)
        self.assertIn("has the name of a table that was fitted, and other contents", another.stderr)
        self.check_error(run("fit", path, "--coefficients", fitted), 2, "CAPTURE", "--left-out")
        self.check_error(run("fit", path, "--coefficients", fitted, "--left-out", unseen, *times, "--profiles"), 2, "--profiles")
        self.check_error(run("fit", path, capture, "--coefficients", capture), 3, "fall.csv", "JSON of a fit")
        wrong = write("wrong.json", fitted.read_text().replace('"C_D"', '"C_d"'))
        self.check_error(run("fit", path, capture, "--coefficients", wrong), 3, "wrong.json", "C_d", "C_D")

    def test_coefficients_of_a_fit_are_where_another_begins(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        fitted = FOLDER / "begin.json"
        self.assertEqual(run("fit", path, capture, "-o", fitted).returncode, 0)
        value = json.loads(fitted.read_text())["coefficients"][0]["value"]
        self.assertAlmostEqual(self.fitted(path, capture, "--coefficients", fitted), value, delta=1e-6)
        # Where nothing can begin.
        outside = write("outside.json", re.sub(r'("value": )1\.\d+', r"\g<1>5.5", fitted.read_text(), count=1))
        self.check_error(run("fit", path, capture, "--coefficients", outside), 3, "outside.json", "C_D", "5.5", "0.8 to 1.6")
        # Of a model that leaves it free, and of one that holds it.
        text = '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = 6338.5\n[box]\n"v(0)" = [0.0, 0.5]\n'
        for box, held in (("C_D = [0.5, 2.0]\n", False), ("m_a = [0.0, 1e-3]\n", True)):
            answer = json.loads(run("fit", "vertical_fall", capture, "--config", write("begin.toml", text + box), "--coefficients", fitted,
                                    "--json").stdout)
            self.assertEqual("C_D" in answer["fixed"], held)
            self.assertEqual([c["name"] for c in answer["coefficients"]], ["m_a" if held else "C_D"])

    def test_one_sidecar_serves_tables_that_lie_elsewhere(self):
        rows = self.capture().read_text().splitlines()
        (FOLDER / "elsewhere").mkdir(exist_ok=True)
        for name in ("one", "two"):
            write(f"elsewhere/{name}.csv", "\n".join(["time;depth"] + [row.replace(",", ";") for row in rows[1:]]) + "\n")
        sidecar = write("columns.toml", '[columns]\ntime = { quantity = "t", unit = "s" }\ndepth = { quantity = "x", unit = "m" }\n')
        result = run("fit", book("coin", COIN_PLAN), FOLDER / "elsewhere" / "*.csv", "--sidecar", sidecar, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(result.stdout)["clusters"], 2)
        self.check_error(run("fit", book("coin", COIN_PLAN), sidecar, "--sidecar", sidecar), 2, "--sidecar", "columns.toml", "table")
        target = FOLDER / "elsewhere" / "one.csv"
        self.check_error(run("fit", book("coin", COIN_PLAN), target, "--sidecar", sidecar, "-o", target), 2, "overwrite")

    def test_a_config_says_which_captures_are_fitted_and_which_left_out(self):
        path, sidecar = book("coin", COIN_PLAN), self.sidecar_of("split")
        def answer(text):
            config = write("split_fit.toml", '[prediction]\nwindow = "0.2 s"\nahead = "0.1 s"\n' + text)
            result = run("fit", path, sidecar, "--config", config, "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            fit = json.loads(result.stdout)
            return [c["id"] for c in fit["captures"]], sorted({p["capture"] for p in fit["capture_predictions"]})
        self.assertEqual(answer('left_out = { drop = "b" }\n'), (["a", "c"], ["b"]))
        self.assertEqual(answer('left_out = { drop = ["b"] }\nfitted = { id = ["c"] }\n'), (["c"], ["b"]))
        for folds in ("3", "{ count = 2 }", "{ count = 2, seed = 7 }"):
            self.assertEqual(answer(f"folds = {folds}\n"), (["a", "b", "c"], ["a", "b", "c"]))
        for text, words in [('left_out = { drop = "x" }', ["drop", '"x"']), ('left_out = { cam = "1" }', ["cam"]), ("folds = 0", ["folds", "2 to"]), ("folds = 1", ["folds"]),
                            ('folds = 4', ["folds", "2 to 3"]), ('folds = "many"', ["folds", "integer"]), ("folds = { seed = 1 }", ["count"]),
                            ("folds = { count = 2, seed = -1 }", ["seed", "0 or more"]), ('folds = 2\nleft_out = { drop = "a" }', ["left_out"]),
                            ('folds = 2\nhidden = ["C_D"]', ["C_D", "known"]), ('left_out = { drop = "a" }\nfitted = { drop = "a" }', ['"a"', "fitted as well"])]:
            config = write("bad_split.toml", '[prediction]\nwindow = "0.2 s"\nahead = "0.1 s"\n' + text)
            self.check_error(run("fit", path, sidecar, "--config", config), 3, "bad_split.toml", *words)

    def test_an_axis_upside_down_is_suspected_in_words(self):
        lines = ["t[s],x[m]"] + [f"{k / 60},{-0.4 * k / 60 - 3 * (k / 60) ** 2}" for k in range(22)]
        config = write("down.toml", '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = 6338.5\n'
                       '[box]\nC_D = [0.5, 2.0]\n"v(0)" = [-2.0, 2.0]\n')
        capture = write("upside_down.csv", "\n".join(lines) + "\n")
        for source in (("vertical_fall", capture, "--config", config), (book("coin", COIN_PLAN), capture)):
            result = run("fit", *source)
            self.assertIn('is an axis upside down? (flip = ["x"] in a sidecar turns it)', result.stderr)
        turned = write("upside_down.toml", 'flip = ["x"]\n')
        result = run("fit", "vertical_fall", capture, "--config", config)
        self.assertNotIn("upside down", result.stderr)
        pathlib.Path(turned).unlink()
        for source in (("vertical_fall", self.capture(), "--config", config), (book("coin", COIN_PLAN), self.capture())):
            result = run("fit", *source)
            self.assertNotIn("upside down", result.stderr)

    def test_lengths_of_a_body_in_balance_are_not_suspected(self):
        # It sinks 2 % faster than it would float: 0.1 m/s^2 at most, a hundredth of gravity.
        rows = "".join(f"{k / 30},{0.05 * (k / 30) ** 2}\n" for k in range(40))
        capture, balanced = write("balanced.csv", "t[s],x[m]\n" + rows), '[fixed]\narea = "100 cm^2"\nthickness = "1 cm"\n[box]\nC_D = [0.1, 2.0]\n"v(0)" = [-0.5, 0.5]\n'
        for density, is_suspected in (("1018.0", False), ("6338.5", True)):
            config = write("fit_of_balanced.toml", balanced.replace("[box]", f"density = {density}\n[box]"))
            result = run("fit", "vertical_fall", capture, "--config", config)
            self.assertEqual("gravity times 10^-2: are lengths" in result.stderr, is_suspected, result.stderr)

    def test_one_sidecar_is_for_any_number_of_tables_and_patterns(self):
        sidecar = write("depths.toml", 'frame_rate = "60 Hz"\ndecimal = ","\n[columns]\ndepth = { quantity = "x", unit = "cm" }\n')
        for k in range(3):
            write(f"depth_{k}.txt", "n;depth\n" + "".join(f'{i};{f"{0.4 * i + 0.02 * i * i * (1 + 0.1 * k):.4f}".replace(".", ",")}\n' for i in range(22)))
        path = book("coin", COIN_PLAN)
        result = run("fit", path, FOLDER / "depth_0.txt", FOLDER / "depth_[12].txt", "--sidecar", sidecar, "--json")
        self.assertIn(result.returncode, (0, 4), result.stderr)
        self.assertEqual([c["id"] for c in json.loads(result.stdout)["captures"]], ["depth_0", "depth_1", "depth_2"])
        # A sidecar that names no table says how it is given one.
        self.check_error(run("fit", path, sidecar), 3, "depths.toml", "file", "--sidecar")

    def test_a_petab_problem_is_fitted_and_written_back(self):
        model = write("decay.toml", 'name = "decay"\n[states]\nv = { initial = 2, unit = "m/s" }\n[parameters]\n'
                      'rate = { unit = "1/s", above = 0 }\n[rates]\nv = "-rate*v"\n')
        write("parameters_in.tsv", "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\nrate\tlin\t0.1\t5\t1\t1\n")
        write("observables.tsv", "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\t0.01\n")
        write("conditions.tsv", "conditionId\tv\nonly\t2\n")
        write("measurements.tsv", "observableId\tsimulationConditionId\tmeasurement\ttime\n" +
              "".join(f"speed\tonly\t{2 * math.exp(-0.8 * 0.1 * k)}\t{0.1 * k}\n" for k in range(1, 20)))
        problem = write("problem.yaml", "format_version: 1\nparameter_file: parameters_in.tsv\nproblems:\n- condition_files: [conditions.tsv]\n"
                        "  measurement_files: [measurements.tsv]\n  observable_files: [observables.tsv]\n")
        folder = FOLDER / "petab"  # does not exist yet
        result = run("fit", model, problem, "--petab", folder, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertAlmostEqual(json.loads(result.stdout)["coefficients"][0]["value"], 0.8, places=5)
        written = list(csv.DictReader((folder / "parameters.tsv").read_text().splitlines(), delimiter="\t"))
        self.assertAlmostEqual(float(written[0]["nominalValue"]), 0.8, places=5)
        simulated = list(csv.DictReader((folder / "simulations.tsv").read_text().splitlines(), delimiter="\t"))
        self.assertEqual(len(simulated), 19)
        self.assertAlmostEqual(float(simulated[0]["simulation"]), 2 * math.exp(-0.08), places=5)
        write("conditions.tsv", "conditionId\tw\nonly\t2\n")
        self.check_error(run("fit", model, problem), 3, "conditions.tsv", '"w"')
        self.check_error(run("fit", model, problem, "--config", problem), 2, "--config")
        self.check_error(run("fit", model, problem, "--petab", problem), 2, "--petab", "folder")
        write("parameters.tsv", (FOLDER / "parameters_in.tsv").read_text())
        own = write("own.yaml", problem.read_text().replace("parameters_in", "parameters"))
        self.check_error(run("fit", model, own, "--petab", FOLDER), 2, "parameters.tsv")
        self.check_error(run("fit", model, write("any.csv", "t[s],v[m/s]\n"), "--petab", folder), 2, "--petab")
        unmade, twice = FOLDER / "unmade", FOLDER / "twice.json"
        self.check_error(run("fit", model, problem, "--petab", unmade, "-o", twice, "--report", twice), 2, "two files")
        self.assertFalse(unmade.exists())

    def test_petab_starts_with_bounds_of_their_own_in_each_condition_are_refused(self):
        model = write("slowed.toml", 'name = "slowed"\n[states]\nv = { initial = 2, unit = "m/s" }\n[parameters]\n'
                      'rate = { unit = "1/s", above = 0 }\n[rates]\nv = "-rate*v"\n')
        write("of_starts.tsv", "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\nrate\tlin\t0.1\t5\t1\t1\n"
              "v_slow\tlin\t1\t3\t2\t1\nv_fast\tlin\t2\t8\t5\t1\n")
        write("speeds.tsv", "observableId\tobservableFormula\tnoiseFormula\nspeed\tv\t0.01\n")
        write("starts.tsv", "conditionId\tv\nslow\tv_slow\nfast\tv_fast\n")
        write("slowing.tsv", "observableId\tsimulationConditionId\tmeasurement\ttime\n" +
              "".join(f"speed\t{name}\t{v * math.exp(-0.08 * k)}\t{0.1 * k}\n" for name, v in (("slow", 2), ("fast", 5)) for k in range(1, 20)))
        problem = write("starts.yaml", "format_version: 1\nparameter_file: of_starts.tsv\nproblems:\n- condition_files: [starts.tsv]\n"
                        "  measurement_files: [slowing.tsv]\n  observable_files: [speeds.tsv]\n")
        self.check_error(run("fit", model, problem), 3, "starts.tsv", "v(0)", "in different conditions: bounds and priors that are the same were expected")
        write("of_starts.tsv", (FOLDER / "of_starts.tsv").read_text().replace("\t1\t3\t", "\t1\t8\t").replace("\t2\t8\t", "\t1\t8\t"))
        self.assertEqual(run("fit", model, problem).returncode, 0)

    def test_a_prediction_needs_captures_a_span_and_a_time(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        self.check_error(run("fit", path, capture, "--ahead", "0.1 s"), 2, "--ahead", "--left-out")
        self.check_error(run("fit", path, capture, "--left-out", capture), 2, "--left-out", "--ahead")
        self.check_error(run("fit", path, capture, "--left-out", capture, "--ahead", "0.1 s"), 2, "--span")

    def test_a_time_of_a_prediction_that_is_none_is_a_wrong_call(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        for ahead in ("0", "-1 s"):
            self.check_error(run("fit", path, capture, "--left-out", capture, "--span", "0.2 s", f"--ahead={ahead}"), 2, "--ahead")

    def test_what_is_wrong_with_captures_left_out_is_found_before_the_fit(self):
        path, capture = book("coin", COIN_PLAN), self.capture()
        wrong = write("wrong.csv", capture.read_text().replace("x[m]", "y[m]"))
        target = FOLDER / "none.json"
        arguments = ("--span", "0.2 s", "--ahead", "0.1 s", "-o", target)
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

    def test_a_doubt_about_a_known_mass_does_not_lose_the_fit(self):
        rows = self.capture().read_text().splitlines()
        write("heavy.csv", "\n".join([f"{rows[0]},rho"] + [f"{row},6338500" for row in rows[1:]]) + "\n")
        sidecar = write("heavy.toml", 'file = "heavy.csv"\ngroup_by = ["rho"]\n[columns]\n'
                        '"t[s]" = { quantity = "t", unit = "s" }\n"x[m]" = { quantity = "x", unit = "m" }\n')
        config = write("heavy_fit.toml", '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\n[known]\ndensity = "rho"\n'
                       '[box]\ndensity = [6e6, 7e6]\nC_D = [0.5, 2.0]\n"v(0)" = [0.0, 0.5]\n')
        answer, page = FOLDER / "heavy.json", FOLDER / "heavy.html"
        result = run("fit", "vertical_fall", sidecar, "--config", config, "-o", answer, "--report", page)
        self.assertIn(result.returncode, (0, 4), result.stderr)
        self.assertTrue(answer.exists() and page.exists(), result.stderr)
        self.assertIn("a density 10^3 times as small would leave", result.stderr)

    def test_a_camera_that_is_none_is_refused_in_one_sentence(self):
        example = ROOT / "examples" / "tumbling_card"
        for camera, word in [("{}", "neither"), ('{ rotation = "1 deg", axes = ["x", "x"] }', "twice"),
                             ('{ rotation = "1 deg", axes = ["x", "theta"] }', "rad"),
                             ('{ rotation = "1 deg", axes = ["x", "vx"] }', "m/s")]:
            config = write("camera.toml", f"camera = {camera}\n" + (example / "fit.toml").read_text())
            self.check_error(run("fit", "falling_plate", example / "card.csv", "--config", config), 3, "camera.toml", "camera", word)


if __name__ == "__main__":
    main()
