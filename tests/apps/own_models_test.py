"""Usage: own_models_test.py SAMARA [CLASS]

Models that are text, and libraries of them: what the command makes of good and bad ones.
"""

import json
import math
import os
import pathlib
import re
import shutil
import subprocess

from samara_case import FOLDER, SAMARA, Case, main, run, write

MODEL = """name = "decay"
[states]
x = { unit = "m", initial = 1 }
[parameters]
rate = { unit = "1/s", default = 0.5 }
[rates]
x = "-rate*x"
"""
BOX = """[box]
rate = [0.4, 0.6]
[time]
end = 1
"""


class OwnModels(Case):
    def test_a_file_is_shown_checked_and_integrated(self):
        path = write("decay.toml", MODEL)
        self.assertIn("x' = -rate*x", run("models", path).stdout)
        checked = run("models", path, "--check")
        self.assertEqual(checked.returncode, 0, checked.stdout)
        written = run("models", path, "--check", "-o", FOLDER / "check.txt")
        self.assertEqual((written.returncode, written.stdout, (FOLDER / "check.txt").read_text()), (0, "", checked.stdout))
        row = run("simulate", path, "--until", "2", "--frames", "2").stdout.splitlines()[-1]
        self.assertAlmostEqual(float(row.split(",")[1]), 0.36787944, delta=1e-7)

    def test_a_parameter_that_is_missing_is_explained_by_the_file_that_was_given(self):
        path = write("lacking.toml", MODEL.replace(", default = 0.5", ""))
        self.check_error(run("simulate", path, "--until", "1"), 2, "--set rate=.. 1/s", f"samara models {path} explains them")
        self.assertIn("rate", run("models", path).stdout)

    def test_rows_that_are_empty_are_told_by_the_first_of_them(self):
        path = write("bursting.toml", MODEL.replace("-rate*x", "rate*x^2").replace('"1/s", default = 0.5', '"1/(m s)", default = 1'))
        result = run("simulate", path, "--until", "2", "--frames", "9")
        self.assertEqual(result.returncode, 4)
        self.assertEqual(result.stdout.splitlines()[5:], ["1,", "1.25,", "1.5,", "1.75,", "2,"])
        self.assertIn("rows from t = 1 on are empty", result.stderr)  # it ends at 1 but for round-off

    def test_statistics_say_what_they_leave_out(self):
        write("squared.toml", MODEL + '[outputs]\ny = { value = "x^2", unit = "m^2" }\n')
        self.assertEqual(run("build", write("squared_plan.toml", 'model = "squared.toml"\n' + BOX), "-o", FOLDER / "squared.h5").returncode, 0)
        result = run("stats", FOLDER / "squared.h5", "--json")
        sentence = "what the model derives is left out, y: statistics are of what the codebook stores"
        self.assertIn(sentence, result.stderr)
        answer = json.loads(result.stdout)
        self.assertIn(sentence, answer["notes"])
        self.assertEqual([output["name"] for output in answer["outputs"]], ["x"])

    def test_info_shows_the_transform_of_an_axis(self):
        write("slow.toml", MODEL)
        for name, rate, told in (("plain", "[0.4, 0.6]", None), ("log", '{ range = [0.1, 1], transform = "log" }', "log")):
            plan = write(f"{name}_rate.toml", 'model = "slow.toml"\n' + BOX.replace("[0.4, 0.6]", rate))
            self.assertEqual(run("build", plan, "-o", FOLDER / "rate.h5", "--fresh").returncode, 0)
            head, time, row = run("info", FOLDER / "rate.h5").stdout.splitlines()[3:6]
            self.assertEqual("transform" in head, told is not None)
            if told:
                self.assertEqual((time.split()[-1], row.split()[-1]), ("none", told))

    def test_an_output_that_cannot_be_read_is_not_said_to_be_another_file(self):
        if not shutil.which("setpriv"):
            self.skipTest("root reads every file, and setpriv is missing")
        write("slow.toml", MODEL)
        plan, target = write("slow_plan.toml", 'model = "slow.toml"\n' + BOX), write("secret.h5", "x")
        target.chmod(0)
        without = ["setpriv", "--inh-caps=-all", "--bounding-set=-all"] if os.geteuid() == 0 else []
        result = subprocess.run([*without, SAMARA, "build", plan, "-o", target], capture_output=True, text=True, timeout=100)
        self.check_error(result, 2, "secret.h5", "is a file that cannot be read (Permission denied)")

    def test_outputs_are_integrated_queried_and_fitted(self):
        path = write("pendulum.toml", """name = "pendulum"
[states]
angle = { unit = "rad", initial = 0.5 }
spin = { unit = "rad/s" }
[parameters]
length = { unit = "m", above = 0 }
[rates]
angle = "spin"
spin = "-9.81 [m/s^2]/length*sin(angle)"
[outputs]
tip = { value = "length*sin(angle)", unit = "m", description = "how far the tip is aside" }
share = "cos(angle)"
""")
        self.assertIn("how far the tip is aside", run("models", path).stdout)
        rows = run("simulate", path, "--set", "length=1.1", "--until", "2", "--frames", "41").stdout.splitlines()
        self.assertEqual(rows[0], "t[s],angle[rad],spin[rad/s],tip[m],share[1]")
        for row in rows[1:]:
            _, angle, _, tip, share = map(float, row.split(","))
            self.assertAlmostEqual(tip, 1.1 * math.sin(angle), delta=1e-12)
            self.assertAlmostEqual(share, math.cos(angle), delta=1e-12)
        book = FOLDER / "pendulum.h5"
        plan = write("pendulum_plan.toml", 'model = "pendulum.toml"\n[box]\nlength = [0.8, 1.4]\n[time]\nend = 2\n'
                                           "[tolerance]\nrelative = 1e-6\n")
        self.assertEqual(run("build", plan, "-o", book).returncode, 0)

        def query(length, time):
            answer = json.loads(run("query", book, "--set", f"length={length}", "--at", time, "--gradient", "--json").stdout)
            return {o["name"]: (o["values"][0], {k: g[0] for k, g in o["gradient"].items()}) for o in answer["outputs"]}

        value, slopes = query(1.1, 1.3)["tip"]
        for name, step, ends in [("length", 1e-4, (query(1.1001, 1.3), query(1.0999, 1.3))), ("t", 1e-4, (query(1.1, 1.3001), query(1.1, 1.2999)))]:
            self.assertAlmostEqual(slopes[name], (ends[0]["tip"][0] - ends[1]["tip"][0]) / (2 * step), delta=1e-5)
        self.assertAlmostEqual(value, float(rows[27].split(",")[3]), delta=1e-5)
        # A camera sees the tip alone; the length is found by it.
        seen = ["t[s],tip[m]"] + [",".join([row.split(",")[0], row.split(",")[3]]) for row in rows[1:]]
        capture = write("tip.csv", "\n".join(seen) + "\n")
        for source, box in ((book, ""), (path, "[box]\nlength = [0.8, 1.4]\n")):
            config = write("tip_fit.toml", 'outputs = ["tip"]\n' + box)
            fitted = run("fit", source, capture, "--config", config, "-o", FOLDER / "tip.json")
            self.assertEqual(fitted.returncode, 0, fitted.stderr)
            found = json.loads((FOLDER / "tip.json").read_text())["coefficients"][0]
            self.assertAlmostEqual(found["value"], 1.1, delta=1e-4)
        # So it is where a codebook covers a part of the box, and the integrator the rest.
        part = write("pendulum_part.toml", plan.read_text().replace("[0.8, 1.4]", "[1.05, 1.4]"))
        self.assertEqual(run("build", part, "-o", FOLDER / "pendulum_part.h5").returncode, 0)
        config = write("tip_mixed.toml", 'outputs = ["tip"]\ncodebook = "pendulum_part.h5"\n[box]\nlength = [0.8, 1.4]\n')
        fitted = run("fit", path, capture, "--config", config, "-o", FOLDER / "tip_mixed.json")
        self.assertEqual(fitted.returncode, 0, fitted.stderr)
        mixed = json.loads((FOLDER / "tip_mixed.json").read_text())["coefficients"][0]
        self.assertAlmostEqual(mixed["value"], found["value"], delta=1e-5)
        for wrong, line in [('value = "length*sin(angl)"', 11), ('value = "length"', None), ('unit = "s"', None)]:
            key = wrong.split(" = ")[0]
            text = re.sub(key + ' = "[^"]*"', wrong, path.read_text().split("[outputs]")[1], count=1)
            result = run("models", write("wrong_outputs.toml", path.read_text().split("[outputs]")[0] + "[outputs]" + text))
            if wrong == 'value = "length"':
                self.assertEqual(result.returncode, 0)
            else:
                self.check_error(result, 3, "[outputs] tip")

    def test_derived_values_that_are_no_numbers_are_left_empty_and_told(self):
        path = write("halting.toml", MODEL.replace("-rate*x", "-rate*1 [m]") +
                     '[outputs]\nroot = "sqrt(x/1 [m])"\nlongest = "1 [m]/(x - abs(x))"\n')
        plan = write("halting_plan.toml", 'model = "halting.toml"\n' + BOX.replace("end = 1", "end = 4"))
        self.assertEqual(run("build", plan, "-o", FOLDER / "halting.h5").returncode, 0)
        for ask in (["simulate", path, "--until", "4", "--frames", "5"],
                    ["query", FOLDER / "halting.h5", "--set", "rate=0.5", "--at", "0:1:4"]):
            with self.subTest(ask[0]):
                result = run(*ask)
                self.assertEqual(result.returncode, 4, result.stderr)
                self.assertRegex(result.stderr, "root is no number in 2 of 5 rows, which are left empty")
                self.assertRegex(result.stderr, "longest is no number in [23] of 5 rows")  # x = 0 is round-off of a codebook
                rows = [line.split(",") for line in result.stdout.splitlines()[1:]]
                self.assertEqual([row[-2] for row in rows[3:]], ["", ""])
                self.assertAlmostEqual(float(rows[1][-2]), math.sqrt(0.5), delta=1e-3)
                self.assertEqual(rows[0][-1], "")
                self.assertAlmostEqual(float(rows[4][-1]), -0.5, delta=1e-3)
                answer = run(*ask, "--json")
                self.assertEqual(answer.returncode, 4)
                self.assertIn("null", answer.stdout)
        slopes = run("query", FOLDER / "halting.h5", "--set", "rate=0.5", "--at", "3", "--gradient")
        self.assertEqual(slopes.returncode, 4)
        self.assertIn("the derivative of root by rate is no number in 1 of 1 rows", slopes.stderr)

    def test_a_plan_that_holds_its_equations_is_shown_too(self):
        text = "[equations]\n" + MODEL.replace("[states]", "[equations.states]").replace("[parameters]", "[equations.parameters]")
        path = write("whole_plan.toml", text.replace("[rates]", "[equations.rates]") + BOX)
        self.assertIn("x' = -rate*x", run("models", path).stdout)
        self.assertEqual(run("build", path, "-o", FOLDER / "whole_plan.h5").returncode, 0)
        info = json.loads(run("info", FOLDER / "whole_plan.h5", "--json").stdout)
        self.assertEqual(info["model"]["name"], "decay")
        plan = write("plan_only.toml", 'model = "decay.toml"\n' + BOX)
        self.check_error(run("models", plan), 3, "the plan holds no [equations]")

    def test_stiff_equations_take_few_steps_by_backward_differences(self):
        path = write("stiff.toml", """name = "stiff"
[states]
x = { initial = 2 }
v = { unit = "1/s" }
[parameters]
mu = { default = 1000 }
w = { unit = "1/s", default = 1 }
[rates]
x = "v"
v = "mu*w*(1 - x^2)*v - w^2*x"
""")
        ask = ["simulate", path, "--until", "400", "--frames", "2"]
        failed = run(*ask)
        self.assertEqual(failed.returncode, 4)
        self.assertIn("BDF, of single trajectories, where equations are stiff", failed.stderr)
        done = run(*ask, "--integrator", "bdf")
        self.assertEqual(done.returncode, 0, done.stderr)
        # The slow branch: v = -x/(mu (x^2 - 1)) to order 1/mu^2, of which ln x - x^2/2 = t/mu + const is the integral.
        x = float(done.stdout.splitlines()[-1].split(",")[1])
        self.assertAlmostEqual(math.log(x) - x * x / 2, math.log(2) - 2 + 0.4, delta=1e-4)

    def test_the_plan_to_begin_with_holds_whatever_a_model_says_of_itself(self):
        path = write("said.toml", 'title = "\\"x\\"\\nend = 2"\n' + MODEL.replace('default = 0.5', 'description = "of\\nx"'))
        plan = run("plan", path)
        self.assertIn(f"# samara models {path} explains it", plan.stdout)
        begun = write("said_plan.toml", plan.stdout)
        self.assertEqual(run("build", begun, "--dry-run").returncode, 0, plan.stdout)

    def test_a_plan_in_another_folder_finds_its_model(self):
        for name in ("models", "plans"):
            (FOLDER / name).mkdir(exist_ok=True)
        model, plan = os.path.relpath(write("models/away.toml", MODEL)), FOLDER / "plans" / "away_plan.toml"
        result = run("plan", model, "-o", plan, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn('model = "../models/away.toml"', plan.read_text())
        self.assertEqual(run("build", plan, "--dry-run").returncode, 0)
        # Through a link, where names alone would lead elsewhere.
        link = FOLDER / "models" / "link"
        link.symlink_to(FOLDER / "plans")
        self.assertEqual(run("plan", model, "-o", link / "linked_plan.toml").returncode, 0)
        self.assertEqual(run("build", link / "linked_plan.toml", "--dry-run").returncode, 0)

    def test_a_model_is_not_overwritten_by_what_is_made_of_it(self):
        path = write("kept.toml", MODEL)
        plan = write("kept_plan.toml", 'model = "kept.toml"\n' + BOX)
        self.check_error(run("simulate", path, "-o", path), 2, "which it would overwrite")
        link = FOLDER / "kept.h5"
        link.symlink_to(path)
        self.check_error(run("build", plan, "-o", link, "--force"), 2, "which it would overwrite")
        self.assertEqual(path.read_text(), MODEL)

    def test_first_guesses_are_put_right(self):
        path = write("guess.toml", MODEL)
        self.check_error(run("build", path, "-o", FOLDER / "guess.h5"), 3, "are those of a model, not of a plan")
        other = FOLDER / "guess.txt"
        other.write_text(MODEL)
        self.check_error(run("models", other), 2, "a file of equations ends in .toml")

    def test_errors_name_the_line_of_what_is_wrong(self):
        for old, new, line in [('unit = "m"', 'unit = "cm"', 3), ("initial = 1", "initial = 1, scale = 0", 3),
                               ('unit = "1/s"', 'unit = "kHz"', 5), ('"-rate*x"', '"-rat*x"', 7), ('"-rate*x"', '"rate"', 7)]:
            self.check_error(run("models", write("wrong.toml", MODEL.replace(old, new))), 3, f"wrong.toml:{line}:")
        # A name that is taken is named where it is given the second time.
        for table in ('[outputs]\nx = "2*x"', '[let]\nrate = "2*x"'):
            self.check_error(run("models", write("taken.toml", MODEL + table + "\n")), 3, f"taken.toml:9: {table.split()[0]}", "given twice")

    def test_a_library_that_is_none_or_cut_short(self):
        whole = pathlib.Path(SAMARA).read_bytes()
        for name, content, words in [("empty.so", b"", "cannot be loaded"), ("text.so", b"text", "cannot be loaded"),
                                     ("cut.so", whole[: len(whole) // 2], "is cut short")]:
            (FOLDER / name).write_bytes(content)
            self.check_error(run("--model-library", FOLDER / name, "models"), 3, name, words)
        self.check_error(run("--model-library", FOLDER / "missing.so", "models"), 3, "missing.so")


if __name__ == "__main__":
    main()
