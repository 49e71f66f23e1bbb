"""Usage: commands_test.py SAMARA [CLASS]

Plans that name a program instead of a model.
"""

import json
import math
import os
import pathlib
import random
import signal
import subprocess
import time

from samara_case import FOLDER, SAMARA, Case, main, run, write

# Each takes x and y; the body sees them and the number n of the line in this start.
PROGRAM = """import os, signal, sys, time
lines = sys.stdin.read().splitlines()
for n, line in enumerate(lines):
    x, y = map(float, line.split()[:2])
"""
GOOD = "    print(repr(1 / (x + y)), repr(x * y))\n"


def plan(name, body, command="", tail=""):
    program = write(f"{name}.py", PROGRAM + body)
    return write(f"{name}.toml", f"""title = "of a program"
[command]
run = ["python3", "{program}"]
inputs = {{ x = "m", y = "1" }}
outputs = {{ u = "N", v = "m" }}
{command}
[box]
x = [1.0, 2.0]
y = [0.5, 1.5]
[tolerance]
relative = 1e-4
assurance = 0.925
{tail}""")


def built(name, body=GOOD, *options, **parts):
    return run("build", plan(name, body, **parts), "-o", FOLDER / f"{name}.h5", *options)


def info(name):
    return json.loads(run("info", FOLDER / f"{name}.h5", "--json").stdout)


class Commands(Case):
    @classmethod
    def setUpClass(cls):
        result = built("good")
        assert result.returncode == 0, result.stderr

    def test_a_program_without_time_becomes_a_codebook_without_time(self):
        described = info("good")
        self.assertEqual([c["name"] for c in described["coordinates"]], ["x", "y"])
        self.assertTrue(described["certificate"]["met"])
        self.assertEqual(described["certificate"]["points"], 40)
        self.assertIn("the command itself: python3", described["certificate"]["integrator"])
        self.assertEqual(described["build"]["builder"], "sampling")
        self.assertIn("calls with those of the checks", run("info", FOLDER / "good.h5").stdout)

    def test_it_answers_with_gradients(self):
        answer = json.loads(run("query", FOLDER / "good.h5", "--set", "x=1.3", "--set", "y=0.7", "--gradient", "--json").stdout)
        u, v = answer["outputs"]
        # Ranges: 0.38 and 2.5; derivatives of polynomials of degree 10 are worse by some tens.
        self.assertAlmostEqual(u["values"][0], 0.5, delta=1e-4 * 0.4)
        self.assertAlmostEqual(u["gradient"]["x"][0], -0.25, delta=2e-3)
        self.assertAlmostEqual(v["gradient"]["y"][0], 1.3, delta=2e-3)
        self.assertEqual(list(answer["coordinates"]), ["x", "y"])
        table = run("query", FOLDER / "good.h5", "--set", "x=1.3", "--set", "y=0.7").stdout.splitlines()
        self.assertEqual(table[0], "x[m],y[1],u[N],v[m]")
        self.assertEqual(len(table), 2)

    def test_outside_the_box_is_5(self):
        self.check_error(run("query", FOLDER / "good.h5", "--set", "x=3", "--set", "y=0.7"), 5, "x = 3", "outside")

    def test_what_needs_a_model_or_time_says_so(self):
        book = FOLDER / "good.h5"
        self.check_error(run("query", book, "--set", "x=1.3", "--set", "y=0.7", "--at", "1"), 2, "--at needs time")
        capture = write("c.csv", "t[s],u[N]\n0,1\n1,2\n2,3\n")
        self.check_error(run("fit", book, capture), 3, "good.h5", "a fit needs time")
        self.check_error(run("fit", book, capture, "--reference"), 3, "good.h5", "sampled from a command")
        self.check_error(run("simulate", book), 2, "good.h5")

    def test_a_program_with_time_answers_at_all_times(self):
        body = "    print(*(repr(w) for t in map(float, line.split()[2:]) for w in (math.exp(-x * t), y * t)))\n"
        result = built("timed", body.replace("    print", "    import math\n    print", 1), tail="[time]\nend = 2\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([c["name"] for c in info("timed")["coordinates"]], ["t", "x", "y"])
        rows = run("query", FOLDER / "timed.h5", "--set", "x=1.5", "--set", "y=1", "--at", "0.3", "--at", "1.7").stdout.splitlines()[1:]
        for row in rows:
            t, x, y, u, v = map(float, row.split(","))
            self.assertAlmostEqual(u, math.exp(-1.5 * t), delta=1e-4)
            self.assertAlmostEqual(v, t, delta=3e-4)
        # Its captures give back the inputs; only lengths have a loss scale by default.
        times = [0.1 * k for k in range(20)]
        capture = write("measured.csv", "t[s],u[N],v[m]\n" + "".join(f"{t},{math.exp(-1.3 * t)},{0.8 * t}\n" for t in times))
        self.check_error(run("fit", FOLDER / "timed.h5", capture), 2, 'output "u" [N] has no loss scale', "loss.scale")
        config = write("scale.toml", '[loss.scale]\nu = "10 mN"\n')
        answer = json.loads(run("fit", FOLDER / "timed.h5", capture, "--config", config, "--json").stdout)
        found = {c["name"]: c["value"] for c in answer["coefficients"]}
        self.assertAlmostEqual(found["x"], 1.3, delta=1e-3)
        self.assertAlmostEqual(found["y"], 0.8, delta=1e-3)
        self.check_error(run("fit", FOLDER / "timed.h5", capture, "--reference"), 3, "timed.h5", "sampled from a command")

    def test_fixed_inputs_go_to_their_places(self):
        write("fixed.py", PROGRAM + GOOD)
        text = plan("fixed", GOOD).read_text().replace("x = [1.0, 2.0]\n", "").replace("[box]", "[fixed]\nx = 1.5\n[box]")
        result = run("build", write("fixed.toml", text), "-o", FOLDER / "fixed.h5")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(info("fixed")["model"]["fixed"], {"x": 1.5})
        u = float(run("query", FOLDER / "fixed.h5", "--set", "y=1").stdout.splitlines()[1].split(",")[1])
        self.assertAlmostEqual(u, 0.4, delta=1e-4)


class KeptCommands(Case):
    """Programs that are kept between batches."""

    HEAD = """import math, os, sys, time
print(os.getpid(), file=open(sys.argv[0] + ".starts", "a"))
for head in sys.stdin:
    lines = [sys.stdin.readline() for _ in range(int(head))]
    for line in lines:
        x, y = map(float, line.split()[:2])
"""
    GOOD = "        print(repr(1 / (x + y)), repr(x * y))\n    sys.stdout.flush()\n"

    def built(self, name, body, *options, command="", tail=""):
        text = plan(name, "", command="persistent = true\n" + command, tail=tail)
        program = write(f"{name}.py", self.HEAD + body)
        result = run("build", text, "-o", FOLDER / f"{name}.h5", *options)
        starts = pathlib.Path(f"{program}.starts").read_text().split()
        for process in starts:
            with self.assertRaises(ProcessLookupError):
                os.kill(int(process), 0)
        return result, len(starts)

    def test_one_start_gives_the_codebook_of_many(self):
        result, starts = self.built("kept", self.GOOD)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(starts, 1)
        self.assertEqual(built("anew").returncode, 0)
        for x in ("1.0", "1.234", "1.9"):
            at = ["--set", f"x={x}", "--set", "y=1.111", "--gradient"]
            self.assertEqual(run("query", FOLDER / "kept.h5", *at).stdout, run("query", FOLDER / "anew.h5", *at).stdout)

    def test_with_time_lines_of_several_lengths_go_to_one_start(self):
        body = ("        times = map(float, line.split()[2:])\n"
                "        print(*(repr(w) for t in times for w in (math.exp(-x * t), y * t)))\n"
                "    sys.stdout.flush()\n")
        result, starts = self.built("kept_timed", body, tail="[time]\nend = 2\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(starts, 1)

    def test_a_failure_names_the_point_and_is_taken_up_again(self):
        result, starts = self.built("kept_bad", "        if x > 1.7: sys.exit('too long')\n" + self.GOOD)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertRegex(result.stderr, "x = (1.[789]|2)")
        self.assertIn('it said "too long"', result.stderr)
        self.assertEqual(starts, 2)  # the second finds the point
        result, starts = self.built("kept_bad", self.GOOD, "--resume")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(starts, 3)

    def test_it_ends_with_a_samara_that_is_killed(self):
        program = write("orphan.py", self.HEAD + "        time.sleep(0.01)\n" + self.GOOD)
        text = write("orphan.toml", plan("orphan_plan", "", command="persistent = true").read_text().replace("orphan_plan.py", "orphan.py"))
        process = subprocess.Popen([SAMARA, "build", text, "-o", FOLDER / "orphan.h5"], stderr=subprocess.PIPE)
        starts = pathlib.Path(f"{program}.starts")
        while process.poll() is None and not (starts.exists() and starts.read_text()):
            time.sleep(0.02)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGKILL)
        process.communicate()
        for _ in range(500):
            try:
                os.kill(int(starts.read_text()), 0)
            except ProcessLookupError:
                return
            time.sleep(0.02)
        self.fail("the program goes on")

    def test_one_that_does_not_flush_or_hangs_is_killed(self):
        body = "        sys.stdout = open(1, 'w', closefd=False)\n" + self.GOOD.replace("    sys.stdout.flush()\n", "")
        result, _ = self.built("kept_silent", body, command='timeout = "2 s"')
        self.check_error(result, 4, "did not answer within 2 s and was killed", "must flush")


class FailingCommands(Case):
    """One sentence, the code 4, no codebook, nobody left running."""

    def check_failure(self, name, body, *parts, command=""):
        result = built(name, body, command=command)
        self.check_error(result, 4, *parts)
        self.assertFalse((FOLDER / f"{name}.h5").exists())

    def test_a_program_that_is_missing(self):
        text = plan("missing", GOOD).read_text().replace('"python3"', '"no_such_program"')
        result = run("build", write("missing.toml", text), "-o", FOLDER / "missing.h5")
        self.check_error(result, 4, '"no_such_program" cannot be started: No such file', "at x = ")

    def test_one_that_ends_with_a_code(self):
        self.check_failure("code", "    sys.exit('no licence')\n", "ended with the code 1", 'it said "no licence"', "x = ", "y = ")

    def test_one_that_is_killed(self):
        self.check_failure("killed_program", "    os.kill(os.getpid(), signal.SIGKILL)\n", "ended by signal 9")

    def test_one_that_hangs(self):
        file = FOLDER / "pid"
        body = f"    open({str(file)!r}, 'w').write(str(os.getpid()))\n    time.sleep(1000)\n"
        self.check_failure("hangs", body, "did not end within 6 s and was killed", command='timeout = "6 s"')
        with self.assertRaises(ProcessLookupError):
            os.kill(int(file.read_text()), 0)

    def test_one_that_prints_rubbish(self):
        self.check_failure("rubbish", "    print('no idea')\n", 'printed "no idea", expected numbers')

    def test_one_that_prints_lines_too_few_or_too_many(self):
        self.check_failure("mute", "    pass\n", "printed 0 lines for 1 points")
        self.check_failure("talks", GOOD + GOOD, "printed 2 lines for 1 points")

    def test_one_that_prints_other_numbers_of_numbers(self):
        self.check_failure("short", "    print(1.0)\n", "with 1 numbers, expected 2")

    def test_one_that_prints_what_is_no_finite_number(self):
        self.check_failure("nan", "    print(1.0, 'nan')\n", "v is nan, expected a finite number", "x = ")
        self.check_failure("inf", "    print('inf', 1.0)\n", "u is inf, expected a finite number")

    def test_limits_that_leave_no_result(self):
        program = plan("few", GOOD, tail="[builder]\nmax_calls = 3\n")
        text = program.read_text()
        program.write_text(text.replace("assurance = 0.925\n", ""))
        result = run("build", program, "-o", FOLDER / "few.h5")
        self.check_error(result, 4, "ended before it had a result", "3 allowed")

    def test_calls_that_led_to_no_result_are_kept_and_it_is_said_where(self):
        result = built("broken", "    if n > 0 or x > 1.5: sys.exit(3)\n" + GOOD, command="batch = 1")
        self.check_error(result, 4, "ended before it had a result", "are kept in", "broken.h5.checkpoint", "a changed plan needs --fresh")
        self.assertTrue((FOLDER / "broken.h5.checkpoint").exists())


class BadCommands(Case):
    def refuse(self, change, *parts):
        text = plan("refused", GOOD).read_text()
        self.assertIn(change[0], text)
        result = run("build", write("refused.toml", text.replace(*change, 1)), "-o", FOLDER / "refused.h5")
        self.check_error(result, 3, *parts)

    def test_wrong_plans_are_refused_with_their_line(self):
        self.refuse(('run = ["python3"', 'go = ["python3"'), "refused.toml:3", "go", "run")
        self.refuse(("[command]", 'model = "vertical_fall"\n[command]'), "beside a model")
        self.refuse(("[tolerance]", '[builder]\nkind = "pgd"\n[tolerance]'), "kind", "can only be sampled")
        self.refuse(("x = [1.0, 2.0]", "z = [1.0, 2.0]"), "the command has no input of this name", "x")
        self.refuse(("x = [1.0, 2.0]\n", ""), "[command.inputs] x: is given no values")
        self.refuse(('x = "m"', 'x = "mm"'), 'the unit "mm"', 'here "m"')
        self.refuse(('x = "m"', 'x = "metres"'), "metres")
        self.refuse(('x = "m"', 'u = "m"'), "taken by another")
        self.refuse(('x = "m"', '"x/y" = "m"'), "is no name")
        self.refuse(("assurance = 0.925", "assurance = 0.999\n[builder]\nmax_calls = 100"),
                    "takes 3000 points", "the 100 calls that max_calls")
        self.refuse(("assurance = 0.925", "assurance = 1"), "expected 0.7 to")
        self.refuse(("[box]", "certificate_points = 40\n[box]"), "is no key any more", "assurance")
        self.refuse(("[box]", "timeout = -1\n[box]"), "timeout", "more than 0")
        self.refuse(("[box]", "persistent = 1\n[box]"), "refused.toml", "persistent", "true or false")
        self.refuse(("x = [1.0, 2.0]", "x = { range = [1.0, 2.0], nodes = 5 }"), "prescribes nodes")
        self.refuse(("relative = 1e-4", "relative = 1e-4\nabsolute = { w = 1 }"), "no output of this name")


class ResumedCommands(Case):
    """Builds that were stopped go on without asking twice, to the same codebook."""

    def same(self, left, right):
        one, two = info(left), info(right)
        for described in (one, two):
            del described["provenance"], described["bytes"]
        # The programs have other names, and so have their plans.
        text = json.dumps(one).replace(f"{left}.py", "P"), json.dumps(two).replace(f"{right}.py", "P")
        self.assertEqual(*text)
        for x in ("1.0", "1.234", "1.9"):
            at = ["--set", f"x={x}", "--set", "y=1.111", "--gradient"]
            self.assertEqual(run("query", FOLDER / f"{left}.h5", *at).stdout, run("query", FOLDER / f"{right}.h5", *at).stdout)

    def test_a_program_that_failed_and_was_mended(self):
        log = FOLDER / "mended.log"
        logged = GOOD + f"    open({str(log)!r}, 'a').write(line + '\\n')\n"
        bad = "    if x > 1.7: sys.exit('too long')\n" + logged
        result = built("mended", bad)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("too long", result.stderr)
        # Started again for the point that failed, the program has seen others of its batch twice.
        before = set(log.read_text().splitlines())
        log.write_text("")
        self.assertTrue((FOLDER / "mended.h5.checkpoint").exists())
        result = built("mended", logged, "--resume")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse((FOLDER / "mended.h5.checkpoint").exists())
        after = log.read_text().splitlines()
        self.assertEqual(len(after), len(set(after)))
        self.assertFalse(before & set(after))
        self.assertEqual(built("undisturbed").returncode, 0)
        self.same("mended", "undisturbed")

    def test_builds_that_are_killed_again_and_again(self):
        self.assertEqual(built("whole", command="batch = 20").returncode, 0)
        log = FOLDER / "kills.log"
        # Slow enough that storing every batch is cheap.
        body = GOOD + f"    open({str(log)!r}, 'a').write(line + '\\n'); __import__('time').sleep(0.002)\n"
        target = FOLDER / "kills.h5"
        random.seed(5)
        kills, text = 0, plan("kills", body, command="batch = 20")
        while not target.exists():
            process = subprocess.Popen([SAMARA, "build", text, "-o", target], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            try:
                process.wait(random.uniform(0.3, 1.0) if kills < 6 else 100)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                kills += 1
            process.communicate()
        self.assertGreater(kills, 1)
        lines = log.read_text().splitlines()
        # Of every kill, no more than the batch that was being asked, and one before it, is asked again.
        self.assertLessEqual(len(lines) - len(set(lines)), 40 * kills)
        self.same("whole", "kills")


if __name__ == "__main__":
    main()
