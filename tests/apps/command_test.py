"""Usage: command_test.py SAMARA [CLASS]

The command as its users see it: answers on stdout, one sentence on stderr, exit codes.
"""

import csv
import json
import math
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SAMARA = sys.argv[1]
HERE = tempfile.TemporaryDirectory()
FOLDER = pathlib.Path(HERE.name)

LINE_PLAN = """model = "constant_rate"
[box]
k = [1.0, 10.0]
[time]
end = 10.0
[tolerance]
relative = 1e-9
"""

COIN_PLAN = """model = "vertical_fall"
[fixed]
area = "4.7144e-4 m^2"
thickness = "2.55 mm"
density = "6338.5 kg/m^3"
[box]
C_D = [0.8, 1.6]
"v(0)" = [0.0, 0.4]
[time]
end = "0.4 s"
[tolerance]
relative = 1e-3
[builder]
kind = "pgd"
"""


def run(*arguments):
    return subprocess.run([SAMARA, *map(str, arguments)], capture_output=True, text=True, timeout=120)


def write(name, text):
    path = FOLDER / name
    path.write_text(text)
    return path


def book(name, plan):
    path = FOLDER / f"{name}.h5"
    if not path.exists():
        result = run("build", write(f"{name}.toml", plan), "-o", path)
        assert result.returncode == 0, result.stderr
    return path


class Case(unittest.TestCase):
    def check_error(self, result, code, *parts):
        """One sentence on stderr that holds the parts, nothing on stdout, the documented exit code."""
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stdout, "")
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("samara: "), lines[0])
        for part in parts:
            self.assertIn(part, lines[0])


class Answers(Case):
    def test_models_lists_every_model_and_explains_one(self):
        self.assertIn("vertical_fall", run("models").stdout)
        text = run("models", "vertical_fall").stdout
        for part in ["C_D", "kg/m^3", "8/3", "source"]:
            self.assertIn(part, text)
        models = json.loads(run("models", "--json").stdout)
        self.assertEqual(models["schema"], "samara-models/1")
        self.assertIn("quadratic_drag_fall", [m["name"] for m in models["models"]])

    def test_models_says_what_a_force_is_made_of(self):
        text = run("models", "falling_plate").stdout
        for part in ["affine in:", "C_T, C_R, A, B, mu1, mu2", "symmetries:", "translation of x", "force term",
                     "gravity and buoyancy", "(m + m11) vx' = "]:
            self.assertIn(part, text)
        self.assertLessEqual(max(len(line) for line in text.splitlines()), 110)
        model, = json.loads(run("models", "falling_plate", "--json").stdout)["models"]
        self.assertEqual(model["affine_in"], ["C_T", "C_R", "A", "B", "mu1", "mu2"])
        self.assertEqual(model["force_units"], {"force": "N/m", "torque": "N", "power": "W/m"})
        self.assertEqual([term["name"] for term in model["force_terms"]],
                         ["inertia", "translational lift", "rotational lift", "drag", "dissipation",
                          "gravity and buoyancy"])

    def test_every_model_is_explained_within_the_width_of_a_page(self):
        for line in run("models").stdout.splitlines():
            name = line.split()[0]
            text = run("models", name).stdout
            self.assertIn("source:", text)
            self.assertLessEqual(max(len(row) for row in text.splitlines()), 120, name)

    def test_simulate_runs_the_reference_plate(self):
        # The model sheet's state of I* = 1.1 at t = 5, thin plate.
        result = run("simulate", "falling_plate_nd", "--set", "beta=0", "--set", "w(0)=0.001", "--set",
                     "theta(0)=0.7853981633974483", "--until", "5", "--frames", "2")
        header, _, last = csv.reader(result.stdout.splitlines())
        self.assertEqual(header, ["t[1]", "vx[1]", "vy[1]", "w[1]", "theta[1]", "x[1]", "y[1]"])
        state = [0.755521995, -0.371934127, -0.058302197, -1.602042954, -2.633326975, -1.65421933]
        for value, expected in zip(last[1:], state):
            self.assertAlmostEqual(float(value), expected, delta=1e-6)

    def test_simulate_breaks_the_force_down_by_term(self):
        arguments = ["--set", "semi_chord=7 mm", "--set", "semi_thickness=0.5 mm", "--set", "density=2.7 g/cm^3"]
        result = run("simulate", "falling_plate", *arguments, "--until", "1", "--frames", "2001", "--forces")
        rows = list(csv.DictReader(result.stdout.splitlines()))
        powers = [name for name in rows[0] if name.endswith(".power[W/m]")]
        self.assertEqual(len(powers), 6)
        for name in ["drag.Fx[N/m]", "drag.Fy[N/m]", "dissipation.T[N]", "kinetic_energy[J/m]"]:
            self.assertIn(name, rows[0])
        # The energy gained is the work of all terms, by the trapezoidal rule: a part in 1e4 at this spacing.
        work = sum(float(row[name]) for row in rows for name in powers)
        work -= 0.5 * sum(float(row[name]) for row in (rows[0], rows[-1]) for name in powers)
        gain = float(rows[-1]["kinetic_energy[J/m]"]) - float(rows[0]["kinetic_energy[J/m]"])
        self.assertAlmostEqual(work * 1.0 / 2000, gain, delta=1e-4 * abs(gain))
        # Without the flag nothing but the states.
        plain = run("simulate", "falling_plate", *arguments, "--until", "1", "--frames", "2").stdout
        self.assertEqual(len(plain.splitlines()[0].split(",")), 7)

    def test_simulate_by_any_integrator_gives_the_same_fall(self):
        fall = ["simulate", "falling_plate_nd", "--set", "theta(0)=0.4", "--until", "2", "--frames", "3"]
        last = {}
        for integrator in [[], ["--integrator", "adaptive"], ["--integrator", "rk4", "--step", "0.005"]]:
            result = run(*fall, *integrator)
            self.assertEqual(result.returncode, 0)
            last[str(integrator)] = [float(v) for v in result.stdout.splitlines()[-1].split(",")]
        reference, *others = last.values()
        for other in others:
            for a, b in zip(reference, other):
                self.assertAlmostEqual(a, b, delta=1e-7)

    def test_simulate_refuses_steps_that_do_not_suit_the_integrator(self):
        fall = ["simulate", "constant_rate", "--set", "k=2"]
        self.check_error(run(*fall, "--integrator", "rk4"), 2, "--step was expected")
        self.check_error(run(*fall, "--step", "0.1"), 2, "no --step was expected")
        self.check_error(run(*fall, "--integrator", "rk4", "--step", "0"), 2, "--step")
        self.check_error(run(*fall, "--integrator", "rkmk", "--step", "0.1"), 2, "quaternion")

    def test_every_model_is_explained_on_few_pages(self):
        for model in json.loads(run("models", "--json").stdout)["models"]:
            lines = run("models", model["name"]).stdout.splitlines()
            self.assertLess(len(lines), 130, model["name"])
            self.assertLess(max(map(len, lines)), 125, model["name"])

    def test_simulate_prints_the_exact_fall(self):
        result = run("simulate", "quadratic_drag_fall", "--set", "C_D=1", "--until", "0.5", "--frames", "6")
        rows = list(csv.reader(result.stdout.splitlines()))
        self.assertEqual(rows[0], ["t[s]", "u[m/s]"])
        speed = math.sqrt(2 * 0.1 * 9.81 / (1.23 * 0.5))
        for t, u in rows[1:]:
            self.assertAlmostEqual(float(u), -speed * math.tanh(9.81 * float(t) / speed), delta=1e-8)

    def test_a_density_that_looks_like_grams_per_cubic_centimetre_is_warned_of(self):
        call = ["simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7e-4", "--set", "thickness=2.5e-3",
                "--until", "0.1"]
        result = run(*call, "--set", "density=6.3")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("warning: the solid has a density of 6.3 kg/m^3", result.stderr)
        self.assertEqual(run(*call, "--set", "density=6.3 g/cm^3").stderr, "")

    def test_values_may_carry_units(self):
        arguments = ["simulate", "vertical_fall", "--set", "C_D=1", "--set", "density=6.3 g/cm^3", "--set", "area=4.7 cm^2",
                     "--set", "thickness=2.5 mm", "--until", "100 ms", "--frames", "2"]
        plain = ["simulate", "vertical_fall", "--set", "C_D=1", "--set", "density=6300", "--set", "area=4.7e-4",
                 "--set", "thickness=2.5e-3", "--until", "0.1", "--frames", "2"]
        left, right = (list(csv.reader(run(*a).stdout.splitlines())) for a in (arguments, plain))
        self.assertEqual(left[0], right[0])
        for a, b in zip(left[2], right[2]):
            self.assertAlmostEqual(float(a), float(b), delta=1e-14)

    def test_query_gives_values_and_derivatives(self):
        path = book("line", LINE_PLAN)
        result = run("query", path, "--set", "k=4", "--at", "7", "2", "--gradient")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        rows = list(csv.reader(result.stdout.splitlines()))
        self.assertEqual(rows[0], ["t[1]", "k[1]", "u[1]", "du/dt[1]", "du/dk[1]"])
        # u = (10 / k - 1) t, so du/dt = 1.5 and du/dk = -10 t / k^2.
        for row, t in zip(rows[1:], [7.0, 2.0]):
            for got, exact in zip(map(float, row), [t, 4.0, 1.5 * t, 1.5, -10.0 * t / 16.0]):
                self.assertAlmostEqual(got, exact, delta=1e-6)

    def test_query_as_json_is_one_object_with_a_schema(self):
        path = book("line", LINE_PLAN)
        answer = json.loads(run("query", path, "--set", "k=4", "--json", "--gradient").stdout)
        self.assertEqual(answer["schema"], "samara-query/1")
        self.assertEqual(len(answer["outputs"][0]["values"]), 11)
        self.assertEqual(set(answer["outputs"][0]["gradient"]), {"t", "k"})
        self.assertTrue(answer["certificate_met"])

    def test_clamp_takes_the_nearest_point_and_says_so(self):
        path = book("line", LINE_PLAN)
        clamped = run("query", path, "--set", "k=11", "--at", "3", "--clamp")
        self.assertEqual(clamped.returncode, 0)
        self.assertIn("k was moved", clamped.stderr)
        self.assertEqual(clamped.stdout, run("query", path, "--set", "k=10", "--at", "3").stdout)

    def test_answers_go_to_a_file_when_asked(self):
        path = book("line", LINE_PLAN)
        target = FOLDER / "answer.csv"
        result = run("query", path, "--set", "k=4", "-o", target)
        self.assertEqual(result.stdout, "")
        self.assertEqual(target.read_text(), run("query", path, "--set", "k=4").stdout)

    def test_info_shows_axes_certificate_and_provenance(self):
        path = book("line", LINE_PLAN)
        text = run("info", path).stdout
        for part in ["constant_rate", "chebyshev", "certificate: met", "made by samara"]:
            self.assertIn(part, text)
        info = json.loads(run("info", path, "--json").stdout)
        self.assertEqual(info["schema"], "samara-info/1")
        self.assertTrue(info["certificate"]["met"])
        self.assertGreaterEqual(info["certificate"]["points"], 2000)

    def test_validate_certifies_again_on_other_points(self):
        path = book("line", LINE_PLAN)
        a = json.loads(run("validate", path, "--points", "500", "--seed", "3", "--json").stdout)["certificate"]
        b = json.loads(run("validate", path, "--points", "500", "--seed", "4", "--json").stdout)["certificate"]
        self.assertTrue(a["met"] and b["met"])
        self.assertEqual(a["points"], 500)
        self.assertNotEqual(a["outputs"][0]["worst"], b["outputs"][0]["worst"])


class BadPlans(Case):
    def build(self, text):
        target = FOLDER / "never.h5"
        result = run("build", write("bad.toml", text), "-o", target)
        self.assertFalse(target.exists())
        return result

    def test_an_unknown_key(self):
        self.check_error(self.build(LINE_PLAN.replace("[box]", "[bos]")), 3, "bad.toml:2", "bos", "box")

    def test_a_reversed_interval(self):
        self.check_error(self.build(LINE_PLAN.replace("[1.0, 10.0]", "[10.0, 1.0]")), 3, "bad.toml:3", "k", "lower < upper")

    def test_an_empty_interval(self):
        self.check_error(self.build(LINE_PLAN.replace("[1.0, 10.0]", "[2.0, 2.0]")), 3, "bad.toml:3", "k", "lower < upper")

    def test_nan(self):
        self.check_error(self.build(LINE_PLAN.replace("10.0]", "nan]")), 3, "bad.toml:3", "nan")

    def test_a_parameter_of_another_model(self):
        self.check_error(self.build(LINE_PLAN.replace("k =", "C_D =")), 3, "bad.toml:3", "C_D", "constant_rate")

    def test_an_unknown_model(self):
        self.check_error(self.build(LINE_PLAN.replace("constant_rate", "constant_rat")), 3, "constant_rate")

    def test_a_missing_plan(self):
        self.check_error(run("build", FOLDER / "none.toml", "-o", FOLDER / "x.h5"), 3, "none.toml")

    def test_an_output_that_cannot_be_written(self):
        plan = write("line.toml", LINE_PLAN)
        self.check_error(run("build", plan, "-o", FOLDER / "nowhere" / "x.h5"), 2, "nowhere")


    def test_every_output_that_cannot_be_written_is_refused_before_the_build(self):
        folder = FOLDER / "folder.h5"
        folder.mkdir(exist_ok=True)
        for target, reason in [(folder, "directory"), ("", "names no file"), ("/dev/null", "not a regular file")]:
            # There is not even a plan: the output is complained about first.
            self.check_error(run("build", FOLDER / "none.toml", "-o", target), 2, "cannot write", reason)

    def test_a_title_with_control_characters(self):
        self.check_error(self.build('title = "a\\u0000b"\n' + LINE_PLAN), 3, "bad.toml:1", "title", "\\x00")


    def test_control_characters_of_a_file_do_not_reach_the_terminal(self):
        for code in ["\\u001b[31m", "\\u009b31m", "\\n"]:
            result = self.build(LINE_PLAN.replace("constant_rate", "constant_rat" + code))
            self.check_error(result, 3, "bad.toml:1", "\\x")
            self.assertNotIn("\x1b", result.stderr)
            self.assertNotIn("\x9b", result.stderr)


class BadCaptures(Case):
    def fit(self, text, sidecar=None):
        path = write("capture.csv", text)
        if sidecar is not None:
            path = write("side.toml", 'file = "capture.csv"\n' + sidecar)
        return run("fit", book("coin", COIN_PLAN), path)

    ROWS = "".join(f"{i / 60},{0.2 * i / 60}\n" for i in range(12))

    def test_a_missing_column(self):
        sidecar = '[columns]\ntime = { quantity = "t", unit = "s" }\ndeep = { quantity = "x", unit = "m" }\n'
        self.check_error(self.fit("time,depth\n" + self.ROWS, sidecar), 3, "deep", "depth")

    def test_a_canonical_table_without_the_column_of_an_output(self):
        self.check_error(self.fit("t[s],deep[m]\n" + self.ROWS), 3, "capture.csv", "v, x")

    def test_a_canonical_table_with_another_unit(self):
        self.check_error(self.fit("t[s],x[s]\n" + self.ROWS), 3, "capture.csv", '"x" in s; m')

    def test_pixels_without_a_scale(self):
        self.check_error(self.fit("t[s],x[px]\n" + self.ROWS), 3, "capture.csv", "px", "[scale]")

    def test_a_config_that_cannot_be(self):
        capture = write("good.csv", "t[s],x[m]\n" + self.ROWS)
        for text, word in [("[fixed]\nC_D = 9.0\n", "C_D"), ('shared = ["C_D"]\n[fixed]\nC_D = 1.0\n', "fixed"),
                           ("[box]\nC_D = [2.0, 1.0]\n", "C_D"), ("[box]\nC_D = [0.1, 1.0]\n", "C_D"),
                           ('cluster_by = ["drop"]\n', "drop"), ('shared = ["nothing"]\n', "nothing"),
                           ("starts = 10001\n", "10000")]:
            config = write("config.toml", text)
            self.check_error(run("fit", book("coin", COIN_PLAN), capture, "--config", config), 3, "config.toml", word)
        config = write("config.toml", "[fixed]\ndensity = -1.0\narea = 1e-4\nthickness = 1e-3\n[box]\nC_D = [1.0, 2.0]\n")
        self.check_error(run("fit", "vertical_fall", capture, "--config", config), 3, "config.toml", "density")
        self.check_error(run("fit", book("coin", COIN_PLAN), capture, "--window", "-1"), 2, "window")

    def test_a_header_without_units(self):
        self.check_error(self.fit("t,x\n" + self.ROWS), 3, "capture.csv", "unit")

    def test_times_that_do_not_increase(self):
        rows = self.ROWS.splitlines(keepends=True)
        rows[5], rows[6] = rows[6], rows[5]
        self.check_error(self.fit("t[s],x[m]\n" + "".join(rows)), 3, "capture.csv:8", "increas")

    def test_a_number_that_is_none(self):
        self.check_error(self.fit("t[s],x[m]\n" + self.ROWS.replace("0.1,", "0.1x,", 1)), 3, "capture.csv:")

    def test_a_missing_file(self):
        self.check_error(run("fit", book("coin", COIN_PLAN), FOLDER / "none.csv"), 3, "none.csv")


class BadCodebooks(Case):
    def test_a_truncated_file(self):
        whole = book("line", LINE_PLAN).read_bytes()
        for part in [0.0, 0.01, 0.5, 0.99]:
            path = FOLDER / "short.h5"
            path.write_bytes(whole[: int(part * len(whole))])
            self.check_error(run("query", path, "--set", "k=4"), 3, "short.h5")

    def test_a_foreign_file(self):
        self.check_error(run("info", write("foreign.h5", "not HDF5 at all\n" * 100)), 3, "foreign.h5")

    def test_a_missing_file(self):
        self.check_error(run("validate", FOLDER / "none.h5"), 3, "none.h5")

    def test_a_query_outside_the_box(self):
        path = book("line", LINE_PLAN)
        self.check_error(run("query", path, "--set", "k=11"), 5, "k = 11", "[1, 10]")
        self.check_error(run("query", path, "--set", "k=4", "--at", "10.5"), 5, "t = 10.5", "[0, 10]")


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

    def test_a_word_that_is_no_command_is_named_with_the_nearest(self):
        self.check_error(run("foo"), 2, '"foo" is not a command', "known: models, simulate, build")
        self.check_error(run("biuld", "plan.toml"), 2, 'did you mean "build"?')

    def test_what_has_no_effect_or_no_meaning_is_refused(self):
        self.check_error(run("fit", "vertical_fall", "x.csv", "--reference"), 2, "--reference", "integrated anyway")
        self.check_error(run("validate", book("line", LINE_PLAN), "--seed", "-1"), 2, "--seed", "-1")

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


class Builds(Case):
    def test_a_build_that_misses_its_tolerance_is_written_marked_and_exits_with_4(self):
        plan = COIN_PLAN.replace('"v(0)" = [0.0, 0.4]', '"v(0)" = { range = [0.0, 0.4], nodes = 2 }')
        path = FOLDER / "missed.h5"
        result = run("build", write("missed.toml", plan), "-o", path)
        self.assertEqual(result.returncode, 4)
        self.assertIn("missed", result.stderr)
        query = run("query", path, "--set", "C_D=1", "--set", "v(0)=0.1")
        self.assertEqual(query.returncode, 0)
        self.assertIn("missed its tolerance", query.stderr)
        self.assertEqual(run("validate", path).returncode, 4)

    def test_a_killed_build_leaves_no_file_and_resumes_to_the_same_codebook(self):
        plan = write("kill.toml", COIN_PLAN.replace("1e-3", "1e-4"))
        whole, killed = FOLDER / "whole.h5", FOLDER / "killed.h5"
        self.assertEqual(run("build", plan, "-o", whole).returncode, 0)
        process = subprocess.Popen([SAMARA, "build", plan, "-o", killed], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        checkpoint = pathlib.Path(f"{killed}.checkpoint")
        while process.poll() is None and not checkpoint.exists():
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertFalse(killed.exists())
        self.assertTrue(checkpoint.exists())
        self.assertEqual(run("build", plan, "-o", killed, "--resume").returncode, 0)
        self.assertFalse(checkpoint.exists())
        left, right = (json.loads(run("info", p, "--json").stdout) for p in (whole, killed))
        for info in (left, right):
            del info["provenance"]
        left.pop("bytes"), right.pop("bytes")
        self.assertEqual(left, right)
        at = ["--set", "C_D=1.1", "--set", "v(0)=0.13", "--gradient"]
        self.assertEqual(run("query", whole, *at).stdout, run("query", killed, *at).stdout)


    def build_with_files_of_at_most(self, size, plan, target):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        return subprocess.run([SAMARA, "build", plan, "-o", target], capture_output=True, text=True, timeout=120, preexec_fn=limit)

    def test_a_full_disk_is_one_sentence_about_the_checkpoint_and_one_about_the_codebook(self):
        target = FOLDER / "full.h5"
        result = self.build_with_files_of_at_most(1000, write("full.toml", COIN_PLAN), target)
        self.assertEqual(result.returncode, 2, result.stderr)
        warning, *_, error = result.stderr.strip().splitlines()
        self.assertIn("samara: warning: no checkpoint: cannot write", warning)
        self.assertIn(f'samara: cannot write "{target}": File too large', error)
        self.assertEqual(len(result.stderr.strip().splitlines()), 2, result.stderr)
        self.assertFalse(target.exists())

    def test_a_build_whose_file_cannot_be_written_at_the_end_keeps_its_checkpoint(self):
        target = FOLDER / "kept.h5"
        plan = write("kept.toml", COIN_PLAN.replace("1e-3", "1e-4"))
        checkpoint = pathlib.Path(f"{target}.checkpoint")
        self.assertEqual(run("build", plan, "-o", target).returncode, 0)
        # The checkpoints, without certificate, fit where the codebook does not.
        result = self.build_with_files_of_at_most(target.stat().st_size - 100, plan, target)
        self.assertEqual(result.returncode, 2)
        self.assertNotIn("no checkpoint", result.stderr)
        self.assertTrue(checkpoint.exists())
        self.assertEqual(run("build", plan, "-o", target, "--resume").returncode, 0)
        self.assertFalse(checkpoint.exists())


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


if __name__ == "__main__":
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
