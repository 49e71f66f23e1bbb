"""Usage: validated_commands_test.py SAMARA [CLASS]

Codebooks of programs certified again: by the program of a plan, never by one that stands in a file.
"""

import json
import pathlib

import commands_test
from commands_test import GOOD, PROGRAM, built
from samara_case import FOLDER, LINE_PLAN, Case, book, main, run, write


class ValidatedCommands(Case):
    """Certified again, by a program that the user names and no other."""

    @classmethod
    def setUpClass(cls):
        result = built("valid", tail="[builder]\nmax_calls = 3000\n")
        assert result.returncode == 0, result.stderr

    def changed(self, name, *changes):
        text = (FOLDER / "valid.toml").read_text()
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        return write(f"{name}.toml", text)

    def certificate(self, *options, code=0):
        result = run("validate", FOLDER / "valid.h5", "--json", *options)
        self.assertEqual(result.returncode, code, result.stderr)
        return json.loads(result.stdout)["certificate"]

    def test_it_is_measured_at_fresh_points(self):
        by_plan = self.certificate("--plan", FOLDER / "valid.toml")
        self.assertTrue(by_plan["met"])
        self.assertEqual(by_plan["points"], 40)
        self.assertIn("the command of the plan: python3", by_plan["integrator"])
        more = self.certificate("--plan", FOLDER / "valid.toml", "--points", "700", "--seed", "3")
        self.assertEqual((more["points"], more["seed"], more["failed_points"]), (700, 3, 0))
        self.assertNotEqual(more["outputs"][0]["worst"], by_plan["outputs"][0]["worst"])
        self.assertEqual(self.certificate("--plan", FOLDER / "valid.toml", "--points", "700", "--seed", "3"), more)
        self.assertIn("the command of the plan", run("validate", FOLDER / "valid.h5", "--plan", FOLDER / "valid.toml").stdout)

    def test_a_program_that_answers_otherwise_is_not_met(self):
        write("other.py", PROGRAM + "    print(repr(1.01 / (x + y)), repr(x * y))\n")
        certificate = self.certificate("--plan", self.changed("other", ("valid.py", "other.py")), code=4)
        self.assertFalse(certificate["met"])
        # u is at most 2/3, its range 0.38: one percent of it.
        self.assertAlmostEqual(certificate["max_error"], 0.01 * 0.667 / 0.38, delta=4e-3)

    def test_a_kept_program_works_too(self):
        program = write("valid_kept.py", commands_test.KeptCommands.HEAD + commands_test.KeptCommands.GOOD)
        text = self.changed("valid_kept", ("valid.py", "valid_kept.py"), ("[box]", "persistent = true\n[box]"))
        self.assertTrue(self.certificate("--plan", text, "--points", "500")["met"])
        self.assertEqual(len(pathlib.Path(f"{program}.starts").read_text().split()), 1)

    def test_one_that_fails_or_hangs_leaves_points_without_an_answer(self):
        write("fails.py", PROGRAM + "    if x > 1.9: sys.exit('too long')\n" + GOOD)
        result = run("validate", FOLDER / "valid.h5", "--plan", self.changed("fails", ("valid.py", "fails.py")))
        self.assertEqual(result.returncode, 4)
        self.assertIn('it said "too long"', result.stdout)
        write("stuck.py", PROGRAM + "    time.sleep(600)\n")
        text = self.changed("stuck", ("valid.py", "stuck.py"), ("[box]", 'timeout = "0.3 s"\n[box]'))
        result = run("validate", FOLDER / "valid.h5", "--plan", text)
        self.assertEqual(result.returncode, 4)
        self.assertIn("did not end within 0.3 s", result.stdout)

    def test_without_a_plan_it_says_what_to_do(self):
        self.check_error(run("validate", FOLDER / "valid.h5"), 2, "valid.h5 was sampled from a command", "--plan PLAN.toml")
        model = book("validated_line", LINE_PLAN)
        self.check_error(run("validate", model, "--plan", FOLDER / "valid.toml"), 2, "model constant_rate", "no --plan")

    def test_plans_that_do_not_fit_are_told_from_the_codebook(self):
        def refuse(parts, *changes):
            result = run("validate", FOLDER / "valid.h5", "--plan", self.changed("misfit", *changes))
            self.check_error(result, 3, "misfit.toml", *parts)
        refuse(["x goes from 1 to 2.5 in the plan, from 1 to 2 in the codebook"], ("[1.0, 2.0]", "[1.0, 2.5]"))
        refuse(['x is in "s" in the plan and in "m"'], ('x = "m"', 'x = "s"'))
        refuse(['output 1 is "w" in the plan and "u"'], ('u = "N"', 'w = "N"'))
        refuse(["the plan has 1 outputs, the codebook 2"], (', v = "m"', ""))
        refuse(["the plan has 1 free inputs, the codebook 2"], ("y = [0.5, 1.5]\n", ""), ("[box]", "[fixed]\ny = 1\n[box]"))
        refuse(["the plan has 1 fixed inputs, the codebook 0"], ('y = "1"', 'y = "1", z = "1"'), ("[box]", "[fixed]\nz = 1\n[box]"))
        refuse(['free input 1 is "y" in the plan and "x"'], ("x = [1.0, 2.0]\ny = [0.5, 1.5]", "y = [0.5, 1.5]\nx = [1.0, 2.0]"))
        refuse(["the plan has time, the codebook has none"], ("[tolerance]", "[time]\nend = 1\n[tolerance]"))
        result = run("validate", FOLDER / "valid.h5", "--plan", FOLDER / "valid.toml", "--points", "3001")
        self.check_error(result, 3, "valid.toml", "3001, more than the 3000 calls")
        result = run("validate", FOLDER / "valid.h5", "--plan", write("of_model.toml", LINE_PLAN))
        self.check_error(result, 3, "of_model.toml", "one of a model")
        self.check_error(run("validate", FOLDER / "valid.h5", "--plan", FOLDER / "nowhere.toml"), 3, "nowhere.toml")


class NothingOfAFileIsExecuted(Case):
    """A codebook and a checkpoint name the program that they come from, which leaves a trace wherever it runs."""

    @classmethod
    def setUpClass(cls):
        cls.trace = FOLDER / "trace"
        body = f"    open({str(cls.trace)!r}, 'a').write('executed')\n"
        timed = "    print(*(repr(w) for t in line.split()[2:] for w in (x * float(t), y)))\n"
        result = built("traced", body + timed, tail="[time]\nend = 1\n")
        assert result.returncode == 0, result.stderr
        result = built("stopped", body + "    if x > 1.7: sys.exit('no more')\n" + GOOD)
        assert result.returncode == 4 and (FOLDER / "stopped.h5.checkpoint").exists(), result.stderr
        # The clean program of the same answers.
        write("clean.py", PROGRAM + timed)
        write("clean.toml", (FOLDER / "traced.toml").read_text().replace("traced.py", "clean.py"))
        assert cls.trace.exists()
        cls.trace.unlink()

    def tearDown(self):
        self.assertFalse(self.trace.exists())

    def test_by_verbs_that_read_a_codebook(self):
        traced = FOLDER / "traced.h5"
        self.assertIn("traced.py", run("info", traced).stdout)
        for verb in (["info", traced, "--json"], ["stats", traced], ["query", traced, "--set", "x=1.5", "--set", "y=1"]):
            self.assertEqual(run(*verb).returncode, 0, verb)
        self.check_error(run("validate", traced), 2, "--plan PLAN.toml")
        capture = write("trace.csv", "t[s],v[m]\n" + "".join(f"{0.1 * k},1\n" for k in range(9)))
        run("fit", traced, capture)
        run("simulate", "constant_rate", "--coefficients", traced, "--end", "1")

    def test_by_validate_with_the_plan_of_another_program(self):
        result = run("validate", FOLDER / "traced.h5", "--plan", FOLDER / "clean.toml")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("clean.py", result.stdout)

    def test_by_resuming_the_checkpoint_of_another_plan(self):
        checkpoint = FOLDER / "stopped.h5.checkpoint"
        before = checkpoint.read_bytes()
        write("goes_on.py", PROGRAM + GOOD)
        text = write("goes_on.toml", (FOLDER / "stopped.toml").read_text().replace("stopped.py", "goes_on.py"))
        self.check_error(run("build", text, "-o", FOLDER / "stopped.h5", "--resume"), 3, "checkpoint", "another plan")
        self.assertEqual(checkpoint.read_bytes(), before)


if __name__ == "__main__":
    main()
