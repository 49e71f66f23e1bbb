"""Usage: changed_plans_test.py SAMARA [CLASS]

Plans that are changed in the call, those to begin with, and files of another kind that no answer replaces.
"""

import json
import os
import subprocess

from samara_case import COIN_PLAN, FOLDER, LINE_PLAN, SAMARA, Case, book, main, run, write


class ChangedPlans(Case):
    def test_a_call_overrides_the_plan_and_the_codebook_keeps_what_was_built(self):
        plan, target = write("changed.toml", COIN_PLAN), FOLDER / "changed.h5"
        result = run("build", plan, "-o", target, "--set", "C_D=0.9..1.1", "--set", "v0=10 cm/s", "--tolerance", "1e-2", "--threads", "1", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        built = json.loads(result.stdout)
        self.assertTrue(built["met"])
        info = json.loads(run("info", target, "--json").stdout)
        self.assertEqual([(c["name"], c["lower"], c["upper"]) for c in info["coordinates"][1:]], [("C_D", 0.9, 1.1)])
        self.assertEqual(info["model"]["fixed"]["v(0)"], 0.1)
        self.assertEqual(info["certificate"]["tolerance"], 1e-2)
        # The plan in the codebook says the same.
        kept = run("info", target, "--plan").stdout
        again = FOLDER / "again.h5"
        self.assertEqual(run("build", write("kept.toml", kept), "-o", again).returncode, 0)
        at = ["--set", "C_D=1.03", "--gradient"]
        self.assertEqual(run("query", again, *at).stdout, run("query", target, *at).stdout)

    def test_what_cannot_be_set_is_refused(self):
        plan, target = write("refused.toml", COIN_PLAN), FOLDER / "refused.h5"
        for options, part in [(["--set", "C_T=1"], "C_T"), (["--set", "C_D=2..1"], "lower < upper"), (["--set", "C_D=.."], "FROM..TO"), (["--set", "C_D"], "NAME=VALUE"),
                              (["--set", "C_D=1", "--set", "C_D=2"], "twice"), (["--tolerance", "2"], "relative"), (["--threads", "1.5"], "--threads"),
                              (["--set", "C_D=1", "--set", "v0=0"], "box")]:
            self.check_error(run("build", plan, "-o", target, *options), 2, part)
        self.check_error(run("build", plan), 2, "--output is required")
        self.assertFalse(target.exists())

    def test_a_dry_run_builds_nothing_and_says_what_would_be(self):
        target = FOLDER / "dry.h5"
        result = run("build", write("dry.toml", COIN_PLAN), "-o", target, "--dry-run", "--set", "v0=0.1")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("C_D from 0.8 to 1.6\n", result.stdout)
        self.assertIn("v(0) = 0.1 m/s", result.stdout)
        self.assertIn("t from 0 to 0.4 s\n", result.stdout)
        self.assertIn("nothing was built", result.stdout)
        result = run("build", write("dry.toml", COIN_PLAN), "--dry-run", "--set", "thickness=2..3 mm", "--set", "v0=0 m/s..0.1")
        self.assertIn("thickness from 0.002 to 0.003 m\n", result.stdout)
        self.assertIn("v(0) from 0 to 0.1 m/s\n", result.stdout)
        self.assertFalse(target.exists())
        self.check_error(run("build", write("dry.toml", COIN_PLAN.replace("0.8", "1.8")), "--dry-run"), 3, "dry.toml", "lower < upper")

    def test_the_plan_to_begin_with_builds(self):
        for model in ("vertical_fall", "constant_rate", "heat_rod"):
            plan, target = run("plan", model).stdout, FOLDER / f"begin_{model}.h5"
            result = subprocess.run([SAMARA, "build", "-", "-o", target], input=plan, capture_output=True, text=True)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(run("info", target, "--plan").stdout, plan)
        self.check_error(run("plan", "vertical_fal"), 2, "vertical_fall")

    def test_no_file_of_another_kind_is_lost_to_a_plan_or_a_flat_file(self):
        notes, flat, line = write("notes.txt", "mine\n"), write("notes.flat", "mine\n"), book("line", LINE_PLAN)
        self.check_error(run("plan", "vertical_fall", "-o", notes), 2, "notes.txt", "no plan")
        self.check_error(run("export", line, "--to", "flat", "-o", flat), 2, "notes.flat", "no flat file")
        self.assertEqual((notes.read_text(), flat.read_text()), ("mine\n", "mine\n"))
        sweep, plain = write("card_sweep.toml", ""), write("plain_notes", "mine\n")
        self.check_error(run("database", sweep, "-o", plain), 2, "plain_notes", "no database of motions")
        self.assertEqual(plain.read_text(), "mine\n")
        for name, call in (("twice.toml", ["plan", "vertical_fall"]), ("twice.flat", ["export", line, "--to", "flat"])):
            for _ in range(2):
                self.assertEqual(run(*call, "-o", FOLDER / name).returncode, 0)


    def test_a_picture_or_page_is_not_written_by_a_name_of_another_kind(self):
        line = book("line", LINE_PLAN)
        for call, name, ending in [(["plot", line, "-o"], "fall.png", ".svg"), (["explore", line, "-o"], "page.txt", ".html"),
                                   (["export", line, "--to", "flat", "-o"], "line.h", ".flat"), (["picture", line, "-o"], "k.jpg", ".png"),
                                   (["fit", line, write("two.csv", "t[s],x[m]\n0,0\n1,1\n"), "--report"], "fit.pdf", ".html"), (["patterns", line, "--report"], "page.csv", ".html")]:
            self.check_error(run(*call, FOLDER / name), 2, name, f"expected a name that ends in {ending}")
            self.assertFalse((FOLDER / name).exists())
        table = write("two.csv", "t[s],x[m]\n0,0\n1,1\n")
        for name in ("FALL.SVG", "run_0.2", "fall"):  # capitals are no other kind, and what is no word is no ending
            self.assertEqual(run("plot", table, "-o", FOLDER / name).returncode, 0)

    def test_hdf5_is_not_written_by_a_name_of_another_format(self):
        plan, config, capture = write("named_plan.toml", LINE_PLAN), write("named_config.toml", 'outputs = ["x"]\n'), write("named.csv", "t[s],x[m]\n0,0\n1,1\n")
        calls = [["build", plan, "-o"], ["build", plan, "--dry-run", "-o"], ["build", plan, "--force", "-o"], ["flow", plan, "-o"], ["sweep", plan, "-o"],
                 ["database", capture, "-o"], ["synthesize", plan, "-o", FOLDER / "named.glb", "--course"], ["fit", "vertical_fall", capture, "--config", config, "--series"]]
        for call, ending in zip(calls, [".csv", ".TSV", ".json", ".png", ".svg", ".html", ".txt", ".glb"]):
            named = FOLDER / f"of_hdf5{ending}"
            self.check_error(run(*call, named), 2, named.name, "but HDF5 is written; a name that ends in .h5 was expected")
            self.assertFalse(named.exists())
        mine = write("mine.csv", "a,b\n1,2\n")
        self.check_error(run("build", plan, "--force", "-o", mine), 2, "a name that ends in .h5 was expected")
        self.assertEqual(mine.read_text(), "a,b\n1,2\n")
        for name in ("plain_line", "line.hdf5", "LINE.H5", "line_0.2", "line.book"):
            self.assertEqual(run("build", plan, "-o", FOLDER / name).returncode, 0)

    def test_text_is_not_written_by_a_name_of_another_format(self):
        line, card = book("line", LINE_PLAN), ["--set", "semi_chord=5 mm", "--set", "semi_thickness=0.57 mm", "--set", "density=11340"]
        capture = write("named.csv", "t[s],x[m]\n0,0\n1,1\n")
        answers = [["query", line, "--set", "k=4"], ["simulate", "constant_rate", "--set", "k=2"], ["stats", line], ["info", line], ["validate", line],
                   ["models", "vertical_fall"], ["regime", "falling_plate", *card], ["patterns", capture],
                   ["body", "disc", "--size", "1 cm", "1 mm", "--density", "2700", "--fluid", "1000"]]
        calls = {"JSON": [["fit", "vertical_fall", capture], ["design", line, "--fit", capture], *([*call, "--json"] for call in answers),
                          ["compare", capture, "--model", line, "--left-out", capture, "--by", "drop"]],
                 "CSV": [*answers[:3], ["wind", capture, "--at", "0, 0, 2 m"], ["follow", line, capture, capture], ["ghost", "falling_plate", capture],
                         ["patterns", line, "--draw", "tumbling"]],
                 "TOML": [["plan", "vertical_fall"], ["info", line, "--plan"], [*answers[-1], "--toml"]],
                 "text": answers[3:]}
        calls = {kind: [[*call, "-o"] for call in some] for kind, some in calls.items()}
        calls["CSV"].append(["synthesize", capture, "-o", FOLDER / "named.glb", "--csv"])
        own = {"JSON": ".json", "CSV": ".csv", "TOML": ".toml", "text": ".txt"}
        others = [".json", ".csv", ".toml", ".h5", ".tsv", ".png", ".svg", ".html", ".hdf5", ".obj", ".stl", ".ply", ".H5", ".flat", ".vtu"]
        for kind, some in calls.items():
            foreign = [ending for ending in others if ending != own[kind]]
            for k, call in enumerate(some):
                for ending in {foreign[0], foreign[1], foreign[k % len(foreign)]}:
                    named = FOLDER / f"of_text{ending}"
                    self.check_error(run(*call, named), 2, named.name, f"but {kind} is written; a name that ends in {own[kind]} was expected")
                    self.assertFalse(named.exists())
        for call, names in ((["query", line, "--set", "k=4"], ["a.csv", "a.CSV", "a.txt", "a.dat", "a", "a_0.2"]), (["plan", "vertical_fall"], ["b.toml", "b.txt", "b.plan"]),
                            (["query", line, "--set", "k=4", "--json"], ["c.json", "c.txt", "c"]), (["info", line, "--plan"], ["d.toml"]), (["info", line], ["e.txt", "e.md"])):
            for name in names:
                self.assertEqual(run(*call, "-o", FOLDER / name).returncode, 0)

    def test_text_in_a_file_does_not_depend_on_the_terminal(self):
        line = book("line", LINE_PLAN)
        for command in ("info", "validate"):
            texts = []
            for columns in ("60", "150"):
                env = {**os.environ, "COLUMNS": columns}
                subprocess.run([SAMARA, command, line, "-o", FOLDER / "answer.txt"], env=env, check=True)
                texts.append((FOLDER / "answer.txt").read_text())
            self.assertEqual(*texts)


if __name__ == "__main__":
    main()
