"""Usage: streams_test.py SAMARA [CLASS]

Standard streams that are closed, full, or pipes whose reader has gone: what was asked for survives the loss of stderr, and
the loss of an answer is told.
"""

import json
import os
import signal
import subprocess

from samara_case import COIN_PLAN, FOLDER, LINE_PLAN, LONGEST, SAMARA, Case, book, main, run, write

COIN = ["--set", "C_D=1.2", "--set", "area=4.7144e-4", "--set", "thickness=2.55e-3", "--set", "density=6338.5"]
GONE = "reader gone"


def redirected(redirection, arguments):
    """As a shell starts it: `2>&-`, or with a pipe on stderr whose reader has gone."""
    if redirection is not GONE:
        return subprocess.run(["sh", "-c", f'exec "$0" "$@" {redirection}', SAMARA, *map(str, arguments)],
                              capture_output=True, text=True, timeout=LONGEST)
    reader, writer = os.pipe()
    os.close(reader)
    try:
        return subprocess.run([SAMARA, *map(str, arguments)], stdout=subprocess.PIPE, stderr=writer, text=True, timeout=LONGEST,
                              restore_signals=True)
    finally:
        os.close(writer)


class Streams(Case):
    @classmethod
    def setUpClass(cls):
        cls.line, cls.coin = book("line", LINE_PLAN), book("coin", COIN_PLAN)
        missed = FOLDER / "missed.h5"
        plan = COIN_PLAN.replace('"v(0)" = [0.0, 0.4]', '"v(0)" = { range = [0.0, 0.4], nodes = 2 }')
        assert run("build", write("missed.toml", plan), "-o", missed).returncode == 4
        fall = run("simulate", "vertical_fall", *COIN, "--until", "0.35", "--frames", "22")
        rows = [row.split(",") for row in fall.stdout.splitlines()]
        capture = write("fall.csv", "\n".join(["t[s],x[m]"] + [f"{row[0]},{row[2]}" for row in rows[1:]]) + "\n")
        # Every command, with words on stderr and without, done, refused and missed.
        cls.calls = [
            ["models"], ["models", "vertical_fall"], ["models", "nothing_like_it"], ["--help"], ["--version"], ["frobnicate"],
            ["simulate", "constant_rate", "--set", "k=2"], ["simulate", "vertical_fall", *COIN, "--set", "density=6.3"],
            ["simulate", "constant_rate", "--set", "k=nan"],
            ["build", FOLDER / "line.toml", "-o", FOLDER / "again.h5"], ["build", FOLDER / "missed.toml", "-o", FOLDER / "again.h5"],
            ["build", FOLDER / "none.toml", "-o", FOLDER / "never.h5"],
            ["info", cls.line], ["info", missed], ["info", FOLDER / "none.h5"],
            ["stats", cls.line], ["stats", missed], ["stats", FOLDER / "none.h5"],
            ["query", cls.line, "--set", "k=4"], ["query", cls.line, "--set", "k=11", "--clamp"], ["query", cls.line, "--set", "k=11"],
            ["query", missed, "--set", "C_D=1", "--set", "v(0)=0.1", "--json"],
            ["validate", cls.line, "--points", "100"], ["validate", missed, "--points", "100"], ["validate", FOLDER / "none.h5"],
            ["fit", cls.coin, capture], ["fit", missed, capture, "--json"], ["fit", cls.coin, FOLDER / "none.csv"],
        ]

    def test_words_that_are_lost_cost_neither_the_answer_nor_the_exit_code(self):
        for arguments in self.calls:
            usual = run(*arguments)
            for redirection in ["2>&-", "2>/dev/full", GONE]:
                with self.subTest(call=arguments, stderr=redirection):
                    result = redirected(redirection, arguments)
                    self.assertEqual(result.returncode, usual.returncode)
                    if "fit" not in map(str, arguments):  # which says how long it took
                        self.assertEqual(result.stdout, usual.stdout)
                    else:
                        self.assertEqual(bool(result.stdout), bool(usual.stdout))

    def test_words_for_a_closed_stream_do_not_get_into_a_file(self):
        for redirection in ["2>&-", "<&- 2>&-"]:
            target = FOLDER / "clean.h5"
            result = redirected(redirection, ["build", FOLDER / "missed.toml", "-o", target])
            self.assertEqual(result.returncode, 4)
            self.assertTrue(run("info", target).stdout.startswith("MISSED ITS TOLERANCE"))
        target = FOLDER / "clean.csv"
        self.assertEqual(redirected("<&- >&- 2>&-", ["query", self.line, "--set", "k=11", "--clamp", "-o", target]).returncode, 0)
        self.assertEqual(target.read_text(), run("query", self.line, "--set", "k=10").stdout)

    def test_an_answer_that_is_lost_is_told_and_exits_with_2(self):
        for arguments in self.calls:
            usual = run(*arguments)
            if not usual.stdout:
                continue
            for redirection, reason in [(">/dev/full", "No space left on device"), (">&-", "Bad file descriptor")]:
                with self.subTest(call=arguments, stdout=redirection):
                    result = redirected(redirection, arguments)
                    self.assertEqual(result.returncode, 2)
                    self.assertIn(f"samara: the answer cannot be written to stdout: {reason}", result.stderr)

    def test_everything_lost_at_once_is_no_crash(self):
        for arguments in self.calls:
            usual = run(*arguments)
            for redirection in [">&- 2>&-", "<&- >&- 2>&-", ">/dev/full 2>/dev/full"]:
                with self.subTest(call=arguments, streams=redirection):
                    self.assertEqual(redirected(redirection, arguments).returncode, 2 if usual.stdout else usual.returncode)

    def test_a_closed_stdin_that_is_asked_for_is_told(self):
        for arguments in (["query", self.line, "--points", "-"], ["build", "-", "-o", FOLDER / "nothing.h5"]):
            result = redirected("<&-", arguments)
            self.assertEqual(result.returncode, 3)
            self.assertIn("samara: stdin: is closed, or a directory; expected a ", result.stderr)

    def test_a_closed_stdout_named_as_the_output_is_refused(self):
        result = redirected(">&-", ["query", self.line, "--set", "k=4", "-o", "/dev/stdout"])
        self.assertEqual(result.returncode, 2)
        self.assertIn("cannot write", result.stderr)

    def test_an_output_that_is_a_stream_is_added_to_the_file_that_the_stream_leads_to(self):
        log, query = FOLDER / "log.txt", ["query", self.line, "--set", "k=4"]
        for redirection in [f'-o /dev/stdout >>"{log}"', f'-o /dev/stderr 2>>"{log}"', f'-o /dev/fd/3 3>>"{log}"', f'-o "{log}" >>"{log}"']:
            with self.subTest(redirection):
                log.write_text("header\n")
                self.assertEqual(redirected(redirection, query).returncode, 0)
                self.assertEqual(log.read_text(), "header\n" + run(*query).stdout)
        log.write_text("header\n")
        result = redirected(f'-o /dev/stdout --force >>"{log}"', ["build", FOLDER / "line.toml"])
        self.assertEqual(result.returncode, 2)
        self.assertIn("it is where stdout leads; a file of its own was expected", result.stderr)
        self.assertEqual(log.read_text(), "header\n")

    def test_no_stream_takes_a_file_in_hdf5_which_is_said_before_any_work(self):
        pipe = FOLDER / "pipe.h5"
        os.mkfifo(pipe)
        for call in (["build", FOLDER / "line.toml"], ["flow", FOLDER / "none.toml"], ["sweep", FOLDER / "none.toml"], ["database", FOLDER / "none.h5"]):
            for output, sentence in (("/dev/stdout", "it is not a regular file"), (pipe, "it is not a regular file"), ("/dev/null", "it is not a regular file"),
                                     ("-", 'the output is "-", but HDF5 goes to no stream; the name of a file was expected')):
                with self.subTest(call=call, output=output):
                    self.check_error(run(*call, "-o", output), 2, sentence)

    def test_a_stream_that_was_written_has_no_size(self):
        result = run("plot", self.line, "-o", "/dev/null", "--json")
        self.assertIsNone(json.loads(result.stdout)["bytes"], result.stderr)

    def test_a_reader_that_goes_away_ends_the_command_as_any_other(self):
        process = subprocess.Popen([SAMARA, "info", str(self.line)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        process.stdout.close()
        self.assertEqual(process.stderr.read(), "")
        self.assertEqual(process.wait(), -signal.SIGPIPE)
        process.stderr.close()


if __name__ == "__main__":
    main()
