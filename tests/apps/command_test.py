"""Usage: command_test.py SAMARA [CLASS]

The command line as such: its help, options and their values, completion, manual pages, answers as JSON, schemas.
"""

import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import mutations
from samara_case import COIN_PLAN, FOLDER, LINE_PLAN, LONGEST, SAMARA, Case, book, main, rows, run, write

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
INPUT_FUZZ = sys.argv.pop(3) if len(sys.argv) > 3 else None  # for Mutations


def tree():
    return json.loads(run("help", "--json").stdout)["commands"]


class Help(Case):
    def test_every_command_ends_its_help_with_two_examples_and_a_page_that_is_there(self):
        for command in tree():
            shown = run(command["name"], "--help")
            self.assertEqual(shown.returncode, 0)
            self.assertEqual(run("help", command["name"]).stdout, shown.stdout)
            lines = shown.stdout.rstrip().splitlines()
            self.assertTrue(lines[-1].startswith("More: docs/"), command["name"])
            self.assertTrue((ROOT / command["page"]).exists(), command["page"])
            self.assertEqual(len(command["examples"]), 2)
            known = {name for option in command["options"] for name in option["names"]}
            for example in command["examples"]:
                self.assertRegex(example, rf"\bsamara {command['name']}\b")
                for word in re.findall(r"(?<=\s)--?[a-z][\w-]*", example.split(" | ")[0]):
                    self.assertIn(word, known, example)
            for line in lines:
                self.assertTrue(len(line) <= 110 or " " not in line.strip() or "{" in line, line)

    def test_without_a_word_it_helps_and_says_that_nothing_was_done(self):
        alone = run()
        self.assertEqual((alone.returncode, alone.stdout), (2, ""))
        self.assertEqual(alone.stderr, run("help").stdout)
        self.assertEqual(run("--help").stdout, run("help").stdout)
        self.check_error(run("help", "qeury"), 2, 'did you mean "query"?')

    def test_lines_fit_the_width_that_is_asked_for(self):
        for columns in ("60", "140"):
            result = subprocess.run([SAMARA, "query", "--help"], capture_output=True, text=True, env={**os.environ, "COLUMNS": columns})
            longest = max(len(line) for line in result.stdout.splitlines() if "samara" not in line)
            self.assertLessEqual(longest, int(columns))
            self.assertGreater(longest, int(columns) - 25)
        coin = book("coin", COIN_PLAN)
        for call in (["info", coin], ["validate", coin, "--points", "50"], ["build", FOLDER / "coin.toml", "-o", FOLDER / "wrapped.h5"]):
            self.assertLessEqual(max(map(len, run(*call).stdout.splitlines())), 110)
        fall = run("query", coin, "--set", "C_D=1.2", "--set", "v0=0.1", "--at", "0:0.016:0.4").stdout.splitlines()
        table = write("wrapped.csv", "\n".join(["t[s],x[m]", *(f"{row.split(',')[0]},{float(row.split(',')[4]) + 1e-3 * math.sin(k)}" for k, row in enumerate(fall[1:]))]))
        sentences = [line for line in run("fit", coin, table).stdout.splitlines() if "  " not in line.strip()]
        self.assertTrue(any("residual series" in line for line in sentences))
        self.assertLessEqual(max(map(len, sentences)), 110)

    def test_a_table_that_is_too_wide_is_parted_between_columns_and_loses_none(self):
        coin, names = book("coin", COIN_PLAN), [f"wide_{'n' * longer}" for longer in (1, 20, 25)]
        tables = []
        for name, drag in zip(names, ("1.1", "1.3", "1.2")):
            fall = rows(run("query", coin, "--set", f"C_D={drag}", "--set", "v0=0.1", "--at", "0:0.016:0.4").stdout)
            tables.append(write(f"{name}.csv", "t[s],x[m]\n" + "".join(f"{r['t[s]']},{float(r['x[m]']) + 1e-3 * math.sin(k)}\n" for k, r in enumerate(fall))))
        call = [SAMARA, "fit", coin, *tables[:2], "--left-out", tables[2], "--span", "0.2 s", "--ahead", "0.1 s"]
        shown = {}
        for columns in ("80", "160"):
            result = subprocess.run(call, capture_output=True, text=True, env={**os.environ, "COLUMNS": columns})
            self.assertEqual(result.returncode, 0, result.stderr)
            shown[columns] = result.stdout
        numbers = lambda text: sorted(number for line in text.splitlines() if line.startswith("wide_") for number in re.findall(r"\d\.\d+", line))
        self.assertGreater(len(numbers(shown["160"])), 10)
        self.assertEqual(numbers(shown["80"]), numbers(shown["160"]))
        lines = shown["80"].splitlines()
        heads = [k for k, line in enumerate(lines) if line.startswith("median of capture")]
        self.assertGreater(len(heads), 1)
        for k in heads:  # each number ends below its heading
            ends = [[cell.end() for cell in re.finditer(r"\S+(?: \S+)*", line)] for line in lines[k:k + 2]]
            self.assertIn(names[2], lines[k + 1])
            self.assertLessEqual(len(lines[k]), 80)
            self.assertEqual(ends[0][1:], ends[1][1:])
        # An id in another encoding is no reason to fail.
        other = os.fsencode(FOLDER) + b"/\xb5m.csv"
        shutil.copy(tables[0], other)
        self.assertEqual(subprocess.run([SAMARA, "fit", coin, other], capture_output=True).returncode, 0)

    def test_the_version_names_commit_format_build_and_licence(self):
        shown = run("--version").stdout
        self.assertEqual(run("-V").stdout, shown)
        for part in [r"^samara \d+\.\d+\.\d+$", r"^commit: \S+$", r"^codebook format: \d+\.\d+$", r"^build: .*SuiteSparse", r"^licence: BSD-3-Clause"]:
            self.assertRegex(shown, re.compile(part, re.M))

    def test_manual_pages_hold_every_option(self):
        self.assertIn(".TH SAMARA 1", run("help", "--man").stdout)
        for command in tree():
            page = run("help", command["name"], "--man").stdout
            for option in command["options"]:
                self.assertIn(option["names"][-1].replace("-", "\\-"), page)
            if shutil.which("man"):
                shown = subprocess.run(["man", "--warnings", "-l", "-"], input=page, capture_output=True, text=True)
                self.assertEqual((shown.returncode, shown.stderr), (0, ""), command["name"])

    def test_quiet_says_nothing_but_errors_and_verbose_says_more(self):
        plan, target = write("said.toml", LINE_PLAN), FOLDER / "said.h5"
        self.assertEqual(run("build", plan, "-o", target, "-q").stderr, "")
        usual, loud = run("build", plan, "-o", target).stderr, run("build", plan, "-o", target, "--verbose").stderr
        self.assertIn("built", usual)
        self.assertGreater(len(loud.splitlines()), len(usual.splitlines()))
        self.assertRegex(loud, r"took .* s of processor time and \d+ MB")
        self.check_error(run("query", target, "-q"), 2, "k is not set")
        self.assertEqual(run("query", target, "--set", "k=11", "--clamp", "-q").stderr, "")


class Interrupts(Case):
    def test_ctrl_c_ends_any_command_with_a_sentence_and_130(self):
        for stop in (signal.SIGINT, signal.SIGTERM):
            # It waits for the points.
            process = subprocess.Popen([SAMARA, "query", book("line", LINE_PLAN), "--points", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            while not int(re.search(r"SigCgt:\s*(\w+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1], 16) >> (stop - 1) & 1:
                time.sleep(0.01)
            process.send_signal(stop)
            out, err = process.communicate(timeout=20)
            self.assertEqual((process.returncode, out), (130, ""))
            self.assertEqual(err, "\nsamara: interrupted\n")


class Heartbeats(Case):
    """Off a terminal, work that takes long says so every half minute: here of a clock that runs two hundred times as fast."""

    CLOCK = """#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>
int clock_gettime(clockid_t clock, struct timespec* t) {
  static int (*real)(clockid_t, struct timespec*);
  if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
  const int failed = real(clock, t);
  const long long now = 200 * (t->tv_sec * 1000000000LL + t->tv_nsec);
  t->tv_sec = now / 1000000000;
  t->tv_nsec = now % 1000000000;
  return failed;
}
"""

    def test_a_build_in_a_pipe_says_that_it_goes_on(self):
        if "san.so" in subprocess.run(["ldd", SAMARA], capture_output=True, text=True).stdout or not shutil.which("cc"):
            self.skipTest("no clock can be put before those of a sanitizer, or there is no compiler")
        clock = FOLDER / "clock.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-x", "c", write("clock.c", self.CLOCK), "-o", clock], check=True)
        plan = write("long.toml", COIN_PLAN.replace("1e-3", "1e-5"))
        result = subprocess.run([SAMARA, "build", plan, "-o", FOLDER / "long.h5"], capture_output=True, text=True, timeout=LONGEST, env={**os.environ, "LD_PRELOAD": str(clock)})
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"(?m)^\w+ \d+ %, \d+ (s|min)")


class Options(Case):
    """No option makes an input of what is left over, and none takes an input for a value."""

    def test_a_value_too_many_is_refused_behind_every_option_of_every_command(self):
        line, surplus = book("line", LINE_PLAN), write("surplus.csv", "t[s],x[m]\n0,0\n1,1\n2,2\n")
        values = {"INT": "3", "UINT": "3", "FLOAT": "0.5"}
        by_name = {"--set": "k=2", "--turbulence": "uniform", "--fit": surplus, "--points": "5"}
        checked = 0
        for command in tree():
            if command["name"] in ("help", "completion"):
                continue
            inputs = [line] if command["inputs"] else []
            for option in command["options"]:
                if not option["value"] or option["names"][-1] == "--left-out":
                    continue
                value = option["choices"][0] if option["choices"] else by_name.get(option["names"][-1], values.get(option["value"], "1"))
                result = run(command["name"], *inputs, option["names"][-1], value, surplus)
                self.assertEqual(result.returncode, 2, f"{command['name']} {option['names']}: {result.stdout}{result.stderr}")
                self.assertEqual(result.stdout, "")
                checked += 1
        self.assertGreater(checked, 100)
        self.assertFalse([name for name in os.listdir(".") if name == "1"])

    def test_an_option_before_the_input_leaves_it_alone(self):
        line = book("line", LINE_PLAN)
        usual = run("query", line, "--set", "k=4", "--at", "0.1").stdout
        self.assertEqual(run("query", "--at", "0.1", line, "--set", "k=4").stdout, usual)
        self.assertEqual(run("query", "--at", "0.1", "--set", "k=4", line).stdout, usual)
        two = run("query", line, "--set", "k=4", "--at", "0.1", "0.2").stdout
        self.assertEqual(run("query", "--at", "0.1", "0.2", line, "--set", "k=4").stdout, two)
        self.assertEqual(run("stats", "--quantiles", "0.5", "0.9", line).returncode, 0)
        svg = FOLDER / "before.svg"
        self.assertEqual(run("plot", "--outputs", "u", line, "-o", svg).returncode, 0)
        for option in ("--at", "--set", "--points"):
            self.check_error(run("query", option, line), 2, "BOOK")

    def test_a_file_left_out_before_the_inputs_is_the_only_one(self):
        result = run("fit", "--left-out", "a.csv", book("coin", COIN_PLAN), "none.csv", "--ahead", "0.1", "--span", "0.1")
        self.check_error(result, 3, "none.csv: the file does not exist")  # the codebook is the source, this the capture

    def test_v0_stands_for_the_initial_value(self):
        coin = book("coin", COIN_PLAN)
        usual = run("query", coin, "--set", "C_D=1", "--set", "v(0)=0.1").stdout
        for name in ("v0", "v@0"):
            self.assertEqual(run("query", coin, "--set", "C_D=1", "--set", f"{name}=0.1").stdout, usual)
        self.check_error(run("query", coin, "--set", "C_D=1", "--set", "v0=0.1", "--set", "v(0)=0.1"), 2, "twice")
        self.check_error(run("query", coin, "--set", "C_D=1", "--set", "w0=0.1"), 2, 'unknown name "w0"')

    def test_what_is_missing_is_said_in_words_of_the_command(self):
        self.check_error(run("simulate", "vertical_fall", "--set", "C_D=1.2"), 2,
                         "--set density=.. kg/m^3, --set area=.. m^2, --set thickness=.. m; samara models vertical_fall")

    def test_what_is_missing_for_a_ghost_is_said_in_the_same_words(self):
        self.check_error(run("ghost", "vertical_fall", write("path.csv", "t[s],x[m]\n0,0\n")), 2, "--set density=.. kg/m^3", "samara models vertical_fall explains them")

    def test_inches_feet_pounds_and_degrees_are_understood(self):
        coin = book("coin", COIN_PLAN)
        ask = ["query", coin, "--set", "C_D=1", "--at", "0.1"]
        self.assertEqual(run(*ask, "--set", "v0=4 in/s").stdout, run(*ask, "--set", "v0=0.1016").stdout)
        self.assertEqual(run(*ask, "--set", "v0=1 ft/s").returncode, 0)
        self.check_error(run(*ask, "--set", "v0=4 inches/s"), 2, 'did you mean "in"?')

    def test_derivatives_have_units_of_their_own(self):
        header = run("query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v0=0.1", "--gradient").stdout.splitlines()[0]
        self.assertEqual(header, "t[s],C_D[1],v(0)[m/s],v[m/s],x[m],dv/dt[m/s^2],dv/dC_D[m/s],dv/dv(0)[1],dx/dt[m/s],dx/dC_D[m],dx/dv(0)[s]")

    def test_the_unit_of_a_plain_number_is_not_printed(self):
        line = book("line", LINE_PLAN)
        for shown in (run("info", line).stdout, run("validate", line, "--points", "100").stdout, run("models", "constant_rate").stdout):
            self.assertNotRegex(shown, r"\d 1[,;\s]|\[1\]|\s1  (parameter|initial|required)")

    def test_values_are_rounded_by_their_errors(self):
        coin = book("coin", COIN_PLAN)
        path = rows(run("query", coin, "--set", "C_D=1.2", "--set", "v0=0.1", "--at", "0:0.016:0.4").stdout)
        rough = write("rough.csv", "t[s],x[m]\n" + "".join(f"{r['t[s]']},{float(r['x[m]']) + 1e-3 * math.sin(17.0 * k * k)}\n" for k, r in enumerate(path)))
        fitted = run("fit", coin, rough)
        answer = next(c for c in json.loads(run("fit", coin, rough, "--json").stdout)["coefficients"] if c["name"] == "C_D")
        shown = re.search(r"(?m)^C_D +([\d.]+) - +- +([\d.]+) ", fitted.stdout)  # of one cluster: the naive error
        self.assertIsNotNone(shown, fitted.stdout)
        self.assertNotRegex(fitted.stdout, r"(?m)^C_D +[\d.]+ 1 ")  # a unit "1"
        # No digit of the value stands after the last one of its error.
        decimals = [len(text.partition(".")[2]) for text in shown.groups()]
        self.assertLessEqual(decimals[0], decimals[1], fitted.stdout)
        self.assertAlmostEqual(float(shown[1]), answer["value"], delta=0.51 * 10.0 ** -decimals[0])

    def test_counts_are_written_in_full_as_far_as_they_are_read_at_a_glance(self):
        self.assertRegex(run("info", book("coin", COIN_PLAN)).stdout, r"a table of all nodes would take \d+: \d+ numbers in place of \d+\n")

    def test_a_default_that_is_told_by_its_formula_is_told_once(self):
        shown = " ".join(run("models", "vertical_fall").stdout.split())
        self.assertIn("default: a thin disc moving broadside: 8/3 fluid_density (area/pi)^(3/2)", shown)

    def test_a_measured_height_leads_to_the_model_that_has_one(self):
        for shown in (run("models").stdout, run("models", "quadratic_drag_fall").stdout):
            self.assertRegex(shown, r"quadratic_drag_fall:? .*\(vertical_fall: with the height\)")


class Completion(Case):
    def complete(self, *words):
        script = f'{run("completion", "bash").stdout}\nCOMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _samara; printf "%s\\n" "${{COMPREPLY[@]}}"'
        result = subprocess.run(["bash", "-c", script, "bash", SAMARA, *map(str, words)], capture_output=True, text=True, cwd=FOLDER)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.splitlines()

    def test_bash_completes_commands_options_models_choices_and_names(self):
        self.assertEqual(self.complete("qu"), ["query"])
        self.assertEqual(self.complete("query", "coin.h5", "--gr"), ["--gradient"])
        self.assertIn("vertical_fall", self.complete("simulate", "vert"))
        self.assertEqual(self.complete("simulate", "vertical_fall", "--integrator", "rk"), ["rk4", "rkmk"])
        self.assertEqual(self.complete("simulate", "vertical_fall", "--set", "de"), ["density="])
        self.assertEqual(self.complete("query", book("coin", COIN_PLAN), "--set", ""), ["C_D=", "v0="])
        self.assertEqual(self.complete("build", write("named.toml", COIN_PLAN), "--set", "thi"), ["thickness="])
        self.assertEqual(self.complete("build", "-o", "none.h5", FOLDER / "named.toml", "--set", "thi"), ["thickness="])
        self.assertEqual(self.complete("compare", "free.toml", "--model", "vertical"), ["vertical_fall"])
        write("beside.csv", "")
        self.assertIn("beside.csv", self.complete("fit", "besi"))
        write("with a blank.h5", "")
        self.assertEqual(self.complete("info", "with"), ["with a blank.h5"])

    def test_every_shell_gets_every_option(self):
        for shell in ("bash", "zsh", "fish"):
            script = run("completion", shell).stdout
            for command in tree():
                for option in command["options"]:
                    name = option["names"][-1]
                    self.assertIn(f"-l {name[2:]}" if shell == "fish" else name, script)
            if shutil.which(shell):
                checked = subprocess.run([shell, "-n"], input=script, capture_output=True, text=True)
                self.assertEqual((checked.returncode, checked.stderr), (0, ""))
        self.check_error(run("completion"), 2, "bash, zsh or fish")
        self.check_error(run("completion", "tcsh"), 2, "tcsh")


    def test_fish_completes_as_a_reader_would_see_it(self):
        if not shutil.which("fish"):
            self.skipTest("fish is not installed")
        script = write("samara.fish", run("completion", "fish").stdout)
        path = {**os.environ, "PATH": f"{pathlib.Path(SAMARA).parent}:{os.environ['PATH']}"}
        asked = {"samara qu": "query", "samara query a.h5 --gr": "--gradient", "samara simulate vert": "vertical_fall", "samara completion z": "zsh",
                 "samara help bui": "build", "samara simulate vertical_fall --set de": "density=", f"samara query {book('coin', COIN_PLAN)} --set v": "v0="}
        lines = "".join(f"complete -C '{words}'; echo ==\n" for words in asked)
        shown = subprocess.run(["fish", "--no-config", "-c", f"source {script}\n{lines}"], capture_output=True, text=True, env=path)
        answers = [answer.split() for answer in shown.stdout.split("==\n")]
        for word, answer in zip(asked.values(), answers):
            self.assertEqual(answer[:1], [word], shown.stdout + shown.stderr)


class SchemasAndFiles(Case):
    """Every --json is one object whose schema is published and holds; -o is where the answer goes."""

    @classmethod
    def setUpClass(cls):
        coin = book("coin", COIN_PLAN)
        fall = run("simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7144e-4", "--set", "thickness=2.55e-3", "--set", "density=6338.5", "--until", "0.35",
                   "--frames", "22").stdout.splitlines()
        drop = write("drop.csv", "\n".join(["t[s],x[m]", *(f"{r.split(',')[0]},{r.split(',')[2]}" for r in fall[1:])]) + "\n")
        fit = FOLDER / "drop.json"
        assert run("fit", coin, drop, "-o", fit).returncode == 0
        wind = write("wind.toml", '[mean]\nprofile = "uniform"\nspeed = 3.0\n')
        card = ["--set", "semi_chord=1cm", "--set", "semi_thickness=0.5mm", "--set", "density=2700"]
        cls.calls = [
            ["models"], ["models", "vertical_fall"], ["simulate", "constant_rate", "--set", "k=2", "--until", "5"], ["info", coin], ["stats", coin, "--quantiles", "0.5"],
            ["query", coin, "--set", "C_D=1", "--set", "v0=0.1", "--gradient"], ["validate", coin, "--points", "50"], ["fit", coin, drop, "--profiles"],
            ["body", "disc", "--size", "1 cm", "1 mm", "--density", "2700", "--fluid", "1000"], ["design", coin, "--fit", fit], ["wind", wind], ["help"],
            ["build", FOLDER / "coin.toml", "--dry-run"], ["plan", "vertical_fall"], ["build", FOLDER / "coin.toml", "-o", FOLDER / "schema.h5"], ["regime", "falling_plate", *card],
            ["plot", coin, "-o", FOLDER / "schema.svg"], ["explore", coin, "-o", FOLDER / "schema.html"], ["patterns", write("fall.csv", plate())]]

    def test_every_answer_holds_the_schema_that_it_names(self):
        seen = set()
        for call in self.calls:
            with self.subTest(call=call):
                result = run(*call, "--json")
                self.assertIn(result.returncode, (0, 4), result.stderr)
                seen.add(json.loads(result.stdout)["schema"])
        # The others are where what they describe is tested; tests/structure looks that each is somewhere.
        self.assertEqual(seen, {
            "samara-models/1", "samara-simulate/1", "samara-info/1", "samara-stats/1", "samara-query/1", "samara-validate/1",
            "samara-fit/1", "samara-body/1", "samara-design/1", "samara-wind/1", "samara-help/1", "samara-plan/1",
            "samara-build/1", "samara-regime/1", "samara-file/1", "samara-patterns/1"})

    def test_an_answer_goes_to_the_file_that_o_names_and_nowhere_else(self):
        target = FOLDER / "answer.txt"
        for call in self.calls:
            if call[0] in ("models", "info", "stats", "query", "validate", "body", "regime", "patterns", "simulate"):
                with self.subTest(call=call):
                    result = run(*call, "-o", target)
                    self.assertIn(result.returncode, (0, 4), result.stderr)
                    self.assertEqual(result.stdout, "")
                    self.assertEqual(target.read_text(), run(*call).stdout)
                    self.assertNotEqual(target.read_text(), "")


def plate():
    """A falling plate as a table."""
    result = run("simulate", "falling_plate", "--set", "semi_chord=1 cm", "--set", "semi_thickness=0.5 mm", "--set", "density=2700", "--set", "C_T=1.2", "--set", "C_R=3",
                 "--set", "A=1.4", "--set", "mu1=0.2", "--set", "theta(0)=0.5", "--until", "1", "--frames", "101")
    table = rows(result.stdout)
    return "t[s],x[m],y[m],theta[rad]\n" + "".join(f"{r['t[s]']},{r['x[m]']},{r['y[m]']},{r['theta[rad]']}\n" for r in table)


class Mutations(Case):
    def test_damaged_inputs_end_as_documented(self):
        wrong, seen = mutations.run(SAMARA, INPUT_FUZZ, 12, seed=27)
        self.assertEqual(wrong, [])
        self.assertEqual(set(seen), {"plan", "csv", "sidecar", "export", "petab", "points"})


if __name__ == "__main__":
    main()
