"""Usage: own_models_test.py SAMARA [CLASS]

Models that are text, and libraries of them: what the command makes of good and bad ones.
"""

import json
import pathlib

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
        row = run("simulate", path, "--until", "2", "--frames", "2").stdout.splitlines()[-1]
        self.assertAlmostEqual(float(row.split(",")[1]), 0.36787944, delta=1e-7)

    def test_a_plan_that_holds_its_equations_is_shown_too(self):
        text = "[equations]\n" + MODEL.replace("[states]", "[equations.states]").replace("[parameters]", "[equations.parameters]")
        path = write("whole_plan.toml", text.replace("[rates]", "[equations.rates]") + BOX)
        self.assertIn("x' = -rate*x", run("models", path).stdout)
        self.assertEqual(run("build", path, "-o", FOLDER / "whole_plan.h5").returncode, 0)
        info = json.loads(run("info", FOLDER / "whole_plan.h5", "--json").stdout)
        self.assertEqual(info["model"]["name"], "decay")
        plan = write("plan_only.toml", 'model = "decay.toml"\n' + BOX)
        self.check_error(run("models", plan), 3, "the plan holds no [equations]")

    def test_a_model_is_not_overwritten_by_what_is_made_of_it(self):
        path = write("kept.toml", MODEL)
        plan = write("kept_plan.toml", 'model = "kept.toml"\n' + BOX)
        self.check_error(run("simulate", path, "-o", path), 2, "which it would overwrite")
        self.check_error(run("build", plan, "-o", path, "--force"), 2, "which it would overwrite")
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

    def test_a_library_that_is_none_or_cut_short(self):
        whole = pathlib.Path(SAMARA).read_bytes()
        for name, content, words in [("empty.so", b"", "cannot be loaded"), ("text.so", b"text", "cannot be loaded"),
                                     ("cut.so", whole[: len(whole) // 2], "is cut short")]:
            (FOLDER / name).write_bytes(content)
            self.check_error(run("--model-library", FOLDER / name, "models"), 3, name, words)
        self.check_error(run("--model-library", FOLDER / "missing.so", "models"), 3, "missing.so")


if __name__ == "__main__":
    main()
