"""Usage: bad_calls_test.py SAMARA [CLASS]

Calls that are wrong by themselves: one sentence on stderr, exit code 2, and no file lost.
"""

import json
import re
import subprocess

from samara_case import COIN_PLAN, LINE_PLAN, FOLDER, SAMARA, Case, book, main, run, write


class BadCalls(Case):
    def test_wrong_calls_are_explained_and_exit_with_2(self):
        path = book("line", LINE_PLAN)
        self.check_error(run("query", path), 2, "k is not set")
        self.check_error(run("query", path, "--set", "kk=4"), 2, "kk", "k")
        self.check_error(run("query", path, "--set", "k"), 2, "NAME=VALUE")
        self.check_error(run("query", path, "--set", "k=4", "--set", "k=5"), 2, "twice")
        self.check_error(run("query", path, "--set", "k=nan"), 2, "k", "finite")
        self.check_error(run("query", path, "--set", "k=4 m"), 2, "k", "4 m")
        self.check_error(run("simulate", "vertical_fal"), 2, "vertical_fall")
        self.check_error(run("simulate", "constant_rate", "--set", "k=2", "--until", "-1"), 2, "--until")
        self.check_error(run("models", "nothing_like_it"), 2, "nothing_like_it")
        self.check_error(run("simulate", "constant_rate", "--set", "k=2", "--forces"), 2, "--forces",
                         "constant_rate")
        self.check_error(run("fit", "vertical_fall", "x.csv"), 2, "--config")
        for arguments in [[], ["unknown"], ["query"], ["query", path, "--frobnicate"]]:
            self.assertEqual(run(*arguments).returncode, 2)

    def test_a_value_too_many_is_refused_behind_every_option(self):
        path, surplus = book("line", LINE_PLAN), FOLDER / "surplus.csv"
        surplus.write_text("t[s],x[m]\n0,0\n1,1\n2,2\n")
        plan, out = write("line_again.toml", LINE_PLAN), FOLDER / "surplus_out"
        inputs = {"models": ["constant_rate"], "simulate": ["constant_rate"], "build": [plan], "info": [path], "query": [path],
                  "stats": [path], "explore": [path, "-o", out], "plot": [path, "-o", out], "validate": [path], "fit": [path, surplus]}
        values = {"--set": "k=2", "--until": "1", "--frames": "3", "--integrator": "rk4", "--step": "0.1", "--at": "1", "--points": "5",
                  "--seed": "3", "--size": "1", "--added-mass": "panels", "--draws": "300", "--keep": "3", "--threads": "1", "--speed": "1", "--length": "1", "--times": "9",
                  "--columns": "1", "--of": "ranks"}
        checked = 0
        for command, row in inputs.items():
            options = re.findall(r"^  (?:-\w,)?(--[\w-]+) (?:TEXT|INT|UINT)", run(command, "--help").stdout, re.M)
            for option in options:
                if option in ("--left-out", "--outputs", "--turbulence"):  # take all: see fits_test.py, clouds_test.py, and names nobody knows
                    continue
                given = row[:1] if option == "--output" and "-o" in row else row
                value = values.get(option, out)
                result = run(command, *given, option, value, surplus)
                self.assertEqual(result.returncode, 2, f"{command} {option}: {result.stdout}{result.stderr}")
                self.assertEqual(result.stdout, "")
                self.assertIn("surplus.csv", result.stderr, f"{command} {option}")
                self.assertFalse(out.exists())
                checked += 1
        self.assertGreater(checked, 20)

    def test_a_word_that_is_no_command_is_named_with_the_nearest(self):
        self.check_error(run("qqqq"), 2, '"qqqq" is not a command', "known: models, simulate, plan, build")
        self.check_error(run("biuld", "plan.toml"), 2, 'did you mean "build"?')

    def test_an_unknown_option_before_any_command_is_named(self):
        self.check_error(run("--foo", "build", "plan.toml"), 2, 'samara has no option "--foo"; did you mean --force, behind the command?')
        for call in [["--foo"], ["--zzzzzzzz=3", "models"], ["-x"]]:
            self.check_error(run(*call), 2, f'samara has no option "{call[0].split("=")[0]}"', "known before a command:", "--model-library")
        self.check_error(run("--json"), 2, '"--json" stands before a command, expected behind one that has it, as in samara models --json')
        self.check_error(run("--versoin"), 2, 'samara has no option "--versoin"; did you mean --version?')
        self.check_error(run("--quite", "build", "plan.toml"), 2, "did you mean --quiet, behind the command?")
        self.check_error(run("-q", "build", "plan.toml"), 2, '"-q" stands before the command, expected behind it: samara build -q')
        self.check_error(run("--model-library", "none.so", "biuld"), 2, '"biuld" is not a command; did you mean "build"?')
        self.check_error(run("-"), 2, '"-" is not a command')

    def test_what_has_no_effect_or_no_meaning_is_refused(self):
        self.check_error(run("fit", "vertical_fall", "x.csv", "--reference"), 2, "--reference", "integrated anyway")
        for seed in ["-1", "1" * 23, "1.5", "0x10"]:
            self.check_error(run("validate", book("line", LINE_PLAN), "--seed", seed), 2, f"--seed is {seed}, expected a whole number from 0 on")

    def test_what_an_option_does_not_take_is_said_in_one_form(self):
        line = book("line", LINE_PLAN)
        for call, sentence in [(["validate", line, "--points", "-1"], '--points is "-1", expected 1 to 100000000'),
                               (["validate", line, "--seed", ""], "--seed is empty"),
                               (["simulate", "constant_rate", "--integrator", "euler"], '--integrator is "euler", expected one of cvodes, bdf, adaptive, rk4'),
                               (["stats", line, "--quantiles", "most"], '--quantiles is "most", expected a number'),
                               (["query", line, "--gradiant"], 'query has no option "--gradiant"; did you mean --gradient?'),
                               (["info", "-x"], 'info has no option "-x"'),
                               (["info", "-x", FOLDER / "none.h5"], 'info has no option "-x"'),
                               (["plot", line, "--titel", "a"], 'plot has no option "--titel"; did you mean --title?'),
                               (["validate", line, "--points", "0", "--point", "3"], 'validate has no option "--point"; did you mean --points?'),
                               (["query", line, "--zzzzzzzzzzzzz=3"], 'query has no option "--zzzzzzzzzzzzz"'),
                               (["validate", line, "again.h5"], 'validate does not take "again.h5" as well'),
                               (["query", line, "--set"], "--set stands without a value, expected one after it"),
                               (["query", line, "--set", "k=4", "--at"], "--at stands without a value, expected one after it"),
                               (["plot", line, "--title", "a", "--title", "b", "-o", "p.svg"], "--title is given twice, expected once"),
                               (["plot", line, "--title", "a", "--title", "b", "--title", "c", "-o", "p.svg"], "--title is given 3 times, expected once"),
                               (["completion", "tcsh"], 'SHELL is "tcsh", expected one of bash, zsh, fish'),
                               (["info", ""], "BOOK is empty")]:
            result = run(*call)
            self.check_error(result, 2, sentence)
            self.assertNotIn(": is", result.stderr)

    def test_every_command_refuses_files_of_another_kind(self):
        kinds = [write("empty", ""), write("none.txt", "hello\nworld\n"), write("list.json", "[1, 2]"), write("other.toml", "a = 1\n"),
                 write("w\u00eeth \u00fcnicode.csv", "t[s],x[m]\n0,\u00fcn\u00ef\n"), FOLDER, FOLDER / "is not there", "/dev/null"]
        (FOLDER / "zero").write_bytes(bytes(1000))
        kinds.append(FOLDER / "zero")
        commands = [c for c in json.loads(run("help", "--json").stdout)["commands"] if c["inputs"] and c["name"] not in ("help", "completion")]
        for k, command in enumerate(commands):
            needed = [word for option in command["options"] if option["required"] for word in (option["names"][-1], "flat" if option["names"][-1] == "--to" else "1")]
            result = run(command["name"], *[kinds[k % len(kinds)]] * max(1, sum(i["required"] for i in command["inputs"])), *needed)
            with self.subTest(command=command["name"], file=kinds[k % len(kinds)]):
                self.check_error(result, result.returncode)
                self.assertIn(result.returncode, (2, 3))

    def test_a_file_in_the_place_of_another_is_named_by_what_it_is(self):
        line, never = book("line", LINE_PLAN), FOLDER / "never.h5"
        plan, capture = write("a_plan.toml", LINE_PLAN), write("a_capture.csv", "t[s],x[m]\n0,0\n1,1\n2,2\n")
        sidecar = write("a_sidecar.toml", 'file = "a_capture.csv"\ngroup_by = ["t"]\n')
        config = write("a_config.toml", 'outputs = ["x"]\ncluster_by = ["drop"]\n')
        picture, archive = FOLDER / "picture.png", FOLDER / "arrays.npz"
        picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
        archive.write_bytes(b"PK\x03\x04" + bytes(100))
        for call, parts in [(("build", line), ("line.h5: is an HDF5 file, such as a codebook (samara info shows it), expected a plan of a codebook",)),
                            (("build", capture), ("a_capture.csv: is a table, expected a plan of a codebook",)),
                            (("build", sidecar), ("a_sidecar.toml: is a sidecar, expected a plan of a codebook",)),
                            (("build", config), ("a_config.toml: is a config of a fit, expected a plan of a codebook",)),
                            (("build", picture), ("picture.png: is a PNG picture, expected a plan of a codebook",)),
                            (("build", archive), ("arrays.npz: is an archive (zip, npz), expected a plan of a codebook",)),
                            (("sweep", plan), ("a_plan.toml: is a plan of a codebook, expected a plan of a sweep",)),
                            (("flow", plan), ("a_plan.toml: is a plan of a codebook, expected a plan of a flow",))]:
            with self.subTest(call=call):
                self.check_error(run(*call, "-o", never), 3, *parts)
        self.assertFalse(never.exists())
        for command in ("query", "info", "stats", "validate"):
            for path, kind in ((plan, "a text"), (capture, "a text"), (picture, "a PNG picture"), (archive, "an archive")):
                with self.subTest(command=command, path=path):
                    self.check_error(run(command, path), 3, path.name, f"is not an HDF5 file but {kind}", "expected a codebook")
        for path, sentence in ((plan, "is a plan of a codebook, expected a sidecar"), (config, "is a config of a fit, expected a sidecar"),
                               (line, "is an HDF5 file, such as a codebook (samara info shows it), expected a table"),
                               (picture, "is a PNG picture, expected a table")):
            with self.subTest(path=path):
                self.check_error(run("fit", line, path), 3, f"{path.name}: {sentence}")
        for path, sentence in ((sidecar, "is a sidecar, expected a config of a fit"), (capture, "is a table, expected a config of a fit"),
                               (line, "is an HDF5 file, such as a codebook (samara info shows it), expected a config of a fit")):
            with self.subTest(path=path):
                self.check_error(run("fit", line, capture, "--config", path), 3, f"{path.name}: {sentence}")
        self.check_error(run("design", line, "--fit", line), 3, "line.h5: is an HDF5 file", "expected the JSON of a fit (samara fit -o)")
        self.check_error(run("query", line, "--points", line), 3, "line.h5: is an HDF5 file", "expected a table of points")
        self.check_error(run("fit", plan, capture), 3, "a_plan.toml", "is that of a plan", "the codebook that samara build makes of the plan")

    def test_a_sidecar_in_the_place_of_the_model_is_told_as_one(self):
        sidecar = write("swapped.toml", '[columns]\nt = { quantity = "t", unit = "s" }\n')
        self.check_error(run("fit", sidecar, write("swapped.csv", "t[s],x[m]\n0,0\n1,1\n")), 3, "swapped.toml:1: columns: is that of a sidecar, expected a model or a codebook here")

    def test_an_option_with_an_empty_value_is_not_one_that_was_not_given(self):
        path = book("line", LINE_PLAN)
        for call in [["query", path, "--set", "k=4", "-o", ""], ["fit", path, "x.csv", "--config", ""], ["fit", path, "x.csv", "--window", ""],
                     ["simulate", "constant_rate", "--set", "k=2", "--coefficients", ""], ["models", ""]]:
            self.check_error(run(*call), 2, "is empty")

    def test_times_and_frames_that_cannot_be_are_refused_before_any_work(self):
        line = ["simulate", "constant_rate", "--set", "k=2"]
        for until in ["1e-300", "1e-320"]:
            self.check_error(run(*line, "--until", until), 2, f"--until is {until}, expected at least",
                             "of the characteristic time")
        self.check_error(run(*line, "--until", "1e100"), 2, "--until is 1e100, expected at most 1e+60 in size")
        self.check_error(run("simulate", "constant_rate", "--set", "k=-1e308"), 2, "k is -1e308, expected at most 1e+60 in size")
        self.check_error(run(*line, "--until", "inf"), 2, "--until is inf, expected a finite number")
        for frames in ["2.5", "1e3", "99999999999999999999", "many"]:
            self.check_error(run(*line, "--frames", frames), 2, f"--frames is {frames}, expected a whole number")
        for frames in ["1", "-5", "10000001"]:
            self.check_error(run(*line, "--frames", frames), 2, f"--frames is {frames}, expected 2 to 10000000")
        self.check_error(run("simulate", "sphere_flight", "--forces", "--frames", "10000000"), 2,
                         "--frames is 10000000, which would take 18.7 GB with 39 columns; expected at most 10683")

    def test_help_names_every_option_and_exits_with_0(self):
        self.assertEqual(run("--help").returncode, 0)
        for command in ["models", "simulate", "build", "info", "query", "validate", "fit"]:
            result = run(command, "--help")
            self.assertEqual(result.returncode, 0)
            self.assertIn("--help", result.stdout)


    def test_an_answer_lost_to_a_full_or_closed_stdout_is_told(self):
        path = book("line", LINE_PLAN)
        for arguments in [["info", path], ["query", path, "--set", "k=4", "--json"], ["models"], ["--help"], ["--version"]]:
            with open("/dev/full", "w") as full:
                result = subprocess.run([SAMARA, *map(str, arguments)], stdout=full, stderr=subprocess.PIPE, text=True)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertEqual(result.stderr, "samara: the answer cannot be written to stdout: No space left on device\n")
        closed = subprocess.run(["sh", "-c", 'exec "$0" info "$1" >&-', SAMARA, path], stderr=subprocess.PIPE, text=True)
        self.assertEqual(closed.returncode, 2)
        self.assertIn("stdout", closed.stderr)

    def test_an_output_of_a_fit_is_checked_before_the_fit(self):
        # The capture does not exist: the output is complained about first.
        result = run("fit", book("coin", COIN_PLAN), FOLDER / "none.csv", "-o", FOLDER / "nowhere" / "a.json")
        self.check_error(result, 2, "nowhere")

    def test_two_outputs_of_a_fit_in_one_file_are_refused_also_through_links(self):
        problem = write("two_outputs.yaml", "format_version: 1\nparameter_file: p.tsv\nproblems:\n- condition_files: [c.tsv]\n"
                        "  measurement_files: [m.tsv]\n  observable_files: [o.tsv]\n")
        folder, linked = FOLDER / "two_outputs", FOLDER / "two_outputs_linked"
        folder.mkdir()
        linked.symlink_to(folder)
        fit = ["fit", "constant_rate", problem, "--petab", folder]
        for output in (folder / "parameters.tsv", linked / "simulations.tsv"):
            self.check_error(run(*fit, "-o", output), 2, "--output and --petab both name", "two files")
        self.check_error(run("fit", "constant_rate", problem, "-o", folder / "a", "--report", linked / "a"), 2, "two files")
        self.assertEqual(list(folder.iterdir()), [])

    def test_an_input_is_not_overwritten_by_the_output(self):
        path, plan = book("line", LINE_PLAN), write("self.toml", LINE_PLAN)
        before = path.read_bytes()
        self.check_error(run("query", path, "--set", "k=4", "-o", path), 2, "overwrite")
        (FOLDER / "link.h5").unlink(missing_ok=True)
        (FOLDER / "link.h5").symlink_to(path)
        self.check_error(run("query", path, "--set", "k=4", "-o", FOLDER / "link.h5"), 2, "overwrite")
        self.check_error(run("build", plan, "-o", plan), 2, "overwrite")
        self.assertEqual(plan.read_text(), LINE_PLAN)
        capture = write("kept.csv", "t[s],x[m]\n")
        self.check_error(run("fit", path, capture, "-o", capture), 2, "overwrite")
        self.assertEqual(path.read_bytes(), before)

    def test_inputs_that_other_inputs_name_are_not_overwritten_either(self):
        line = book("line", LINE_PLAN)
        table = write("named.csv", "t[s],x[m]\n" + "".join(f"{k / 50},{k * k / 9000}\n" for k in range(60)))
        sidecar = write("names.toml", 'file = "named.csv"\n[labels]\nfile = "marks.csv"\ncolumn = "name"\n')
        labels = write("marks.csv", "name,drop\nnamed,1\n")
        config = write("with_book.toml", f'codebook = "{line.name}"\n')
        cube = write("cube.obj", "v 0 0 0\n")
        body = write("of_mesh.toml", 'model = "kirchhoff_body"\n[body]\nmesh = "cube.obj"\nunit = "cm"\n'
                     'density = "2000 kg/m^3"\nfluid_density = "1000 kg/m^3"\n')
        kept = {file: file.read_bytes() for file in (line, table, labels, cube)}
        compared = ["compare", config, "--model", line, "--left-out", sidecar, "--by", "drop", "-o"]
        for call in ([*compared, table], [*compared, labels],
                     ["patterns", sidecar, "-o", table], ["patterns", sidecar, "-o", labels],
                     ["patterns", table, "--labels", labels, "-o", labels],
                     ["ghost", "falling_plate", sidecar, "-o", table],
                     ["regime", "falling_plate", "--sweep", line, "-o", line],
                     ["fit", "vertical_fall", sidecar, "--config", config, "-o", line],
                     ["simulate", "kirchhoff_body", "--body", cube, "-o", cube]):
            with self.subTest(call=call):
                self.check_error(run(*call), 2, "which it would overwrite")
        self.check_error(run("patterns", table, "-o", FOLDER / "two", "--report", FOLDER / "two"), 2, "two files were expected")
        self.assertNotEqual(run("build", body, "-o", cube, "--force").returncode, 0)
        for file, content in kept.items():
            self.assertEqual(file.read_bytes(), content)


if __name__ == "__main__":
    main()
