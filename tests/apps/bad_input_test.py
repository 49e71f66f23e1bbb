"""Usage: bad_input_test.py SAMARA [CLASS]

What is wrong in plans, captures and codebooks: one sentence on stderr, the documented exit code.
"""

import csv
import json
import math
import random
import subprocess

from samara_case import COIN_PLAN, LINE_PLAN, FOLDER, SAMARA, Case, book, main, run, write


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

    def test_numbers_whose_squares_are_none(self):
        for ends in ["-1e308, 1e308", "1.0, 1e200"]:
            self.check_error(self.build(LINE_PLAN.replace("1.0, 10.0", ends)), 3, "bad.toml:3", "[box] k", "expected at most 1e+60 in size")
        self.check_error(self.build(LINE_PLAN.replace("[box]", "[fixed]\nrate = -1e308\n[box]")), 3, "bad.toml:3", "rate", "-1e+308")
        self.check_error(self.build(LINE_PLAN.replace("end = 10.0", "end = 1e308")), 3, "bad.toml:5", "end", "1e+308")

    def test_a_time_too_short_for_any_step(self):
        for end in ("1e-300", "5e-324"):
            self.check_error(self.build(LINE_PLAN.replace("end = 10.0", f"end = {end}")), 3, "bad.toml:5", "end", "expected at least 1e-60")

    def test_values_that_do_not_fit_together(self):
        plan = """model = "immersed_body"
[fixed]
a = 0.035
b = 0.02
c = 1e-4
density = 1200.0
"qw(0)" = 0.0
[box]
C_T = [1.0, 2.0]
[time]
end = 0.01
"""
        self.check_error(self.build(plan), 3, "bad.toml:1", "initial quaternion")

    def test_a_plan_without_end(self):
        self.check_error(run("build", "/dev/zero", "-o", FOLDER / "never.h5"), 3, "/dev/zero", "more than 256 MB")

    def test_a_plan_from_a_pipe(self):
        target = FOLDER / "piped.h5"
        result = subprocess.run([SAMARA, "build", "/dev/stdin", "-o", target], input=LINE_PLAN, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(run("info", target, "--json").stdout)["provenance"]["plan"], LINE_PLAN)

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
        for target, reason in [(folder, "directory"), ("", "is empty"), ("/dev/null", "not a regular file")]:
            # There is not even a plan: the output is complained about first.
            self.check_error(run("build", FOLDER / "none.toml", "-o", target), 2, reason)

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
        self.check_error(run("fit", book("coin", COIN_PLAN), capture, "--span", "-1"), 2, "span")

    def test_a_header_without_units(self):
        self.check_error(self.fit("t,x\n" + self.ROWS), 3, "capture.csv", "unit")

    def test_times_that_do_not_increase(self):
        rows = self.ROWS.splitlines(keepends=True)
        rows[5], rows[6] = rows[6], rows[5]
        self.check_error(self.fit("t[s],x[m]\n" + "".join(rows)), 3, "capture.csv:8", "increas")

    def test_a_number_that_is_none(self):
        self.check_error(self.fit("t[s],x[m]\n" + self.ROWS.replace("0.1,", "0.1x,", 1)), 3, "capture.csv:")

    def test_positions_whose_squares_are_none(self):
        rows = "".join(f"{i / 60},{0.2e198 * (i + 1) / 60}\n" for i in range(12))
        self.check_error(self.fit("t[s],x[m]\n" + rows), 3, "capture.csv:2", '"x[m]" has 3.3', "at most 1e+60 in size")

    def test_a_missing_file(self):
        self.check_error(run("fit", book("coin", COIN_PLAN), FOLDER / "none.csv"), 3, "none.csv")

    def test_a_single_frame(self):
        self.check_error(self.fit("t[s],x[m]\n0,0.1\n"), 3, "capture.csv", "at least 3")

    def test_a_value_that_is_infinite(self):
        self.check_error(self.fit("t[s],x[m]\n" + self.ROWS.replace("0.1,", "0.1,inf\n0.11,", 1)), 3, "capture.csv:", "inf")

    def test_a_header_that_is_not_utf8(self):
        path = FOLDER / "capture.csv"
        path.write_bytes("t[s],x[µm]\n0,1\n".encode("latin-1"))
        self.check_error(run("fit", book("coin", COIN_PLAN), path), 3, "capture.csv:1", "0xb5", "save the table as UTF-8")


class DoubtfulCaptures(Case):
    """Captures that can be read and fitted, and are wrong: the report says what is."""

    CONFIG = """segments = "1 s"
step = "5 ms"
loss = { kind = "huber", scale = { x = "1 mm", y = "1 mm", theta = "3 deg" } }
starts = 1
[fixed]
semi_chord = "1 cm"
semi_thickness = "0.5 mm"
density = DENSITY
C_T = 1.2
A = 1.4
mu1 = 0.2
[box]
C_R = [1, 6]
"vx(0)" = [-2, 2]
"vy(0)" = [-2, 2]
"w(0)" = [-100, 100]
"theta(0)" = [-100, 100]
"""

    def rows(self):
        result = run("simulate", "falling_plate", "--set", "semi_chord=1 cm", "--set", "semi_thickness=0.5 mm", "--set",
                     "density=2700", "--set", "C_T=1.2", "--set", "C_R=3", "--set", "A=1.4", "--set", "mu1=0.2", "--set",
                     "theta(0)=0.5", "--until", "0.5", "--frames", "31")
        self.assertEqual(result.returncode, 0, result.stderr)
        table = list(csv.DictReader(result.stdout.splitlines()))
        noise = random.Random(1)
        return [[float(r["t[s]"]), float(r["x[m]"]) + noise.gauss(0, 3e-4), float(r["y[m]"]) + noise.gauss(0, 3e-4),
                 float(r["theta[rad]"]) + noise.gauss(0, 0.01)] for r in table]

    def warnings(self, rows, header="t[s],x[m],y[m],theta[rad]", density="2700.0"):
        """What the report warns of, on stderr and in the JSON alike; one sentence per line."""
        capture = write("plate.csv", "\n".join([header] + [",".join(map(repr, row)) for row in rows]) + "\n")
        config = write("fit_of_plate.toml", self.CONFIG.replace("DENSITY", density))
        result = run("fit", "falling_plate", capture, "--config", config, "--json")
        self.assertIn(result.returncode, (0, 4), result.stderr)
        fit = json.loads(result.stdout)
        said, kinds = fit["warnings"], fit["warning_kinds"]
        self.assertEqual(len(kinds), len(said))
        for sentence, kind in zip(said, kinds):
            self.assertIn(sentence, result.stderr)
            if "never changes" in sentence:
                self.assertEqual(kind, "captures")
        return " | ".join(said)

    def test_a_good_capture_raises_no_doubt(self):
        said = self.warnings(self.rows())
        for word in ["unit", "order", "never changes", "mass", "degrees"]:
            self.assertNotIn(word, said)

    def test_constant_positions(self):
        first = self.rows()[0]
        said = self.warnings([[t, *first[1:]] for t, *_ in self.rows()])
        self.assertIn("x never changes over 31 frames", said)
        self.assertIn("y never changes over 31 frames", said)

    def test_millimetres_as_metres(self):
        self.assertIn("another unit", self.warnings([[t, 1e3 * x, 1e3 * y, a] for t, x, y, a in self.rows()]))

    def test_degrees_as_radians(self):
        self.assertRegex(self.warnings([[t, x, y, math.degrees(a)] for t, x, y, a in self.rows()]), "theta.*degrees")

    def test_frames_in_another_order_than_their_times(self):
        rows = self.rows()
        order = list(range(len(rows)))
        random.Random(2).shuffle(order)
        self.assertIn("out of order", self.warnings([[r[0], *rows[k][1:]] for r, k in zip(rows, order)]))

    def test_a_mass_that_is_wrong_by_a_thousand_is_named(self):
        self.assertRegex(self.warnings(self.rows(), density="2.7e6"), "mass of the body is in doubt: a density 10\\^3 times as small")


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


if __name__ == "__main__":
    main()
