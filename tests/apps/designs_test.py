"""Usage: designs_test.py SAMARA [CLASS]

The next experiment from the command.
"""

import csv
import json

from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write


class Designs(Case):
    def fall(self, name, speed):
        """A capture of a coin, 1 mm off where and now."""
        result = run("simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7144e-4", "--set", "thickness=2.55e-3",
                     "--set", "density=6338.5", "--set", f"v(0)={speed}", "--until", "0.35", "--frames", "22")
        rows = list(csv.reader(result.stdout.splitlines()))
        column = rows[0].index("x[m]")
        lines = ["t[s],x[m]"]
        for k, row in enumerate(rows[1:]):
            lines.append(f"{row[0]},{float(row[column]) + 1e-3 * ((7 * k) % 5 - 2)}")
        return write(name, "\n".join(lines) + "\n")

    def fitted(self):
        path = FOLDER / "fit.json"
        if not path.exists():
            result = run("fit", book("coin", COIN_PLAN), self.fall("a.csv", 0.1), self.fall("b.csv", 0.12), "-o", path)
            self.assertEqual(result.returncode, 0, result.stderr)
        return path

    def designed(self, *arguments):
        result = run("design", book("coin", COIN_PLAN), "--fit", self.fitted(), *arguments, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        self.assertEqual(answer["schema"], "samara-design/1")
        return answer

    def test_a_fit_with_a_delay_has_no_design_and_is_told_so(self):
        config = write("delayed.toml", 'delay = { range = ["0 s", "20 ms"] }\n')
        path = FOLDER / "delayed.json"
        fit = run("fit", book("coin", COIN_PLAN), self.fall("a.csv", 0.1), self.fall("b.csv", 0.12), "--config", config, "-o", path)
        self.assertEqual(fit.returncode, 0, fit.stderr)
        self.check_error(run("design", book("coin", COIN_PLAN), "--fit", path), 3, '"delay" among its unknowns, which designs do not know')

    def test_a_reversed_release_is_refused_in_plain_words(self):
        self.check_error(run("design", book("coin", COIN_PLAN), "--fit", self.fitted(), "--set", "v(0)=0.3..0.1"), 2,
                         'the release "v(0)" is to lie from 0.3 to 0.1')

    def changed_fit(self, change):
        fit = json.loads(self.fitted().read_text())
        change(fit)
        return write("changed.json", json.dumps(fit))

    def test_more_captures_leave_smaller_errors(self):
        one, two = self.designed(), self.designed("--captures", 2)
        self.assertEqual([len(one["captures"]), len(two["captures"])], [1, 2])
        self.assertEqual([c["name"] for c in one["coordinates"]], ["v(0)"])
        self.assertAlmostEqual(one["duration"], 0.35)
        self.assertEqual(one["frames"], 22)
        errors = [answer["coefficients"][0]["error_expected"] for answer in (one, two)]
        self.assertLess(errors[1], errors[0])
        self.assertLess(errors[0], one["coefficients"][0]["error_now"])

    def test_what_is_set_holds(self):
        answer = self.designed("--set", "v(0)=15 cm/s", "--frames", 11, "--duration", "300 ms", "--noise", "x=0.1 mm", "--times", 2)
        self.assertEqual(answer["captures"][0]["release"], {"v(0)": 0.15})
        self.assertIsNone(answer["random_error"])
        self.assertEqual(answer["outputs"][0]["noise"], 1e-4)
        self.assertEqual(len(answer["times"]), 2)
        self.assertEqual(answer["lengths"][-1]["duration"], 0.3)
        answer = self.designed("--set", "v0=10 cm/s..20 cm/s", "--release", "v@0")
        self.assertTrue(0.1 <= answer["captures"][0]["release"]["v(0)"] <= 0.2)

    def test_the_answer_is_written_to_a_file_too(self):
        target = FOLDER / "design.json"
        result = run("design", book("coin", COIN_PLAN), "--fit", self.fitted(), "-o", target)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("mean error expected", result.stdout)
        self.assertEqual(json.loads(target.read_text())["schema"], "samara-design/1")

    def test_a_model_needs_the_config_of_its_fit(self):
        result = run("design", "vertical_fall", "--fit", self.fitted())
        self.check_error(result, 2, "vertical_fall", "--config")
        config = write("fit.toml", '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = "6338.5 kg/m^3"\n'
                       '[box]\nC_D = [0.8, 1.6]\n"v(0)" = [0.0, 0.4]\n')
        by_model = run("design", "vertical_fall", "--fit", self.fitted(), "--config", config, "--json")
        self.assertEqual(by_model.returncode, 0, by_model.stderr)
        error = json.loads(by_model.stdout)["coefficients"][0]["error_expected"]
        # The codebook keeps to 1e-3 of the depth.
        self.assertAlmostEqual(error / self.designed()["coefficients"][0]["error_expected"], 1.0, delta=0.02)

    def test_a_fit_that_cannot_be_gone_on_with_is_refused(self):
        def renamed(fit):
            fit["coefficients"][0]["name"] = "C_X"

        def of_another_model(fit):
            fit["model"] = "falling_plate"

        def with_noise(value):
            def change(fit):
                fit["noise"] = [{"outputs": ["x"], "unit": "m", "value": value, "estimated": True}]
            return change

        for change, part in ((renamed, '"C_X"'), (of_another_model, '"falling_plate"'), (with_noise(-1e-3), "noise of x"),
                             (with_noise(None), "noise of x"), (lambda fit: fit.update(setup={}), "the JSON of a fit")):
            result = run("design", book("coin", COIN_PLAN), "--fit", self.changed_fit(change))
            self.check_error(result, 3, "changed.json", part)
        self.check_error(run("design", book("coin", COIN_PLAN), "--fit", FOLDER / "none.json"), 3, "none.json")

    def test_a_file_of_a_fit_without_setup_is_read(self):
        older = self.changed_fit(lambda fit: (fit.pop("setup"), fit.pop("naive_covariance")))
        result = run("design", book("coin", COIN_PLAN), "--fit", older, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertAlmostEqual(json.loads(result.stdout)["error"], self.designed()["error"], places=9)

    def test_noise_is_a_difference_of_temperatures(self):
        model = write("cooling.toml", 'name = "cooling"\n[states]\nT = { unit = "K", initial = 350 }\n[parameters]\n'
                      'rate = { unit = "1/s", default = 0.5 }\n[rates]\nT = "-rate*(T - 300 [K])"\n')
        cup = write("cup.csv", run("simulate", model, "--until", 2, "--frames", 21).stdout)
        config, fit = write("cup_fit.toml", '[loss.scale]\nT = "1 K"\n[box]\nrate = [0.4, 0.6]\n"T(0)" = [340, 360]\n'), FOLDER / "cup.json"
        fitted = run("fit", model, cup, "--config", config, "-o", fit)
        self.assertEqual(fitted.returncode, 0, fitted.stderr)
        self.assertEqual(run("design", model, "--fit", fit, "--config", config, "--noise", "T=1 K").returncode, 0)
        self.check_error(run("design", model, "--fit", fit, "--config", config, "--noise", "T=1 degC"), 2, "T: ", "difference of temperatures")

    def test_wrong_calls_are_refused(self):
        for arguments, part in ((["--captures", "0"], "captures is 0"), (["--duration", "0"], "duration"),
                                (["--duration", "1 s"], "0.4 s"), (["--duration", "nan"], "finite"),
                                (["--criterion", "E"], "D or A"), (["--for", "C_L"], '"C_L"'),
                                (["--set", "v"], "NAME=VALUE"), (["--set", "u=1"], '"u"'),
                                (["--set", "v(0)=1"], "v(0)"), (["--set", "C_D=1.1"], '"C_D"'),
                                (["--noise", "x=-1 mm"], "noise"), (["--release", "C_D"], '"C_D"'),
                                (["--seen", "y"], '"y"'), (["--frames", "1"], "frames is 1"),
                                (["--times", "23"], "times is 23"), (["--draws", "0"], "draws is 0")):
            result = run("design", book("coin", COIN_PLAN), "--fit", self.fitted(), *arguments)
            self.check_error(result, 2, part)


if __name__ == "__main__":
    main()
