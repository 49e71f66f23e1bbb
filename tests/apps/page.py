"""What stands on a page of the documentation for its readers to type, and what it says that they will see.

On a page, ```sh fences hold lines for a shell, one after the other in one folder; a line that ends otherwise than well
says so ("# exit code 5"). What a fence of ```text shows is what the fence before it prints, where ".." stands for
anything. A fence that follows "`NAME`:" is the text of that file. Lines in ```sh slow take long: they are typed where
SAMARA_SLOW_PAGES is set, as ./dev check does. Those in ```sh elsewhere need what no page brings, such as a compiled program
or a mesh of yours: other tests run the like. Lines that need $SAMARA_DATA are those of measured_test.py.
"""

import os
import pathlib
import re
import shutil
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```(\w*)( slow| elsewhere)?\n(.*?)^```$", re.M | re.S)
FILE = re.compile(r"`([\w.]+\.(?:toml|csv|tsv|json|yaml))`(?:(?!\n\n)[^`])*:\n\n$")
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
TOKEN = re.compile(rf"\.\.|{NUMBER}(?:\.\.)?|[A-Za-z_]+|\S")
CLOSE = 0.02  # digits differ from one machine to another


def steps(text):
    """("file", name, text), ("run", lines) and ("see", text) in the order of the page."""
    for match in FENCE.finditer(text):
        kind, where, body = match.groups()
        name = FILE.search(text[:match.start()][-400:])
        if kind == "sh":
            is_left = "$SAMARA_DATA" in body or where == " elsewhere" or where == " slow" and not os.environ.get("SAMARA_SLOW_PAGES")
            yield ("left" if is_left else "run"), body
        elif kind == "text":
            yield "see", body
        elif name and kind in ("toml", "csv", "json", "yaml"):
            yield "file", name.group(1), body


def same(expected, found):
    if expected.endswith("..") and len(expected) > 2:  # the first digits of a number
        return found.startswith(expected[:-2])
    if re.fullmatch(NUMBER, expected) and re.fullmatch(NUMBER, found):
        return abs(float(expected) - float(found)) <= CLOSE * max(abs(float(expected)), abs(float(found)))
    return expected == found


def line_is_seen(expected, found):
    """Whether the line of a page tells of this line: token by token, ".." for any of them."""
    want, have = TOKEN.findall(expected), TOKEN.findall(found)
    reached = {0}  # how many of `have` are told of
    for token in want:
        if token == "..":
            reached = set(range(min(reached), len(have) + 1))
        else:
            reached = {k + 1 for k in reached if k < len(have) and same(token, have[k])}
        if not reached:
            return False
    return len(have) in reached


def unseen(text, output):
    """The first line of the page's text that the output does not have where it should; None if all is there."""
    lines, at, anywhere = output.splitlines(), 0, False
    for expected in text.splitlines():
        if expected == "..":
            anywhere = True
            continue
        places = range(at, len(lines)) if anywhere else range(at, min(at + 1, len(lines)))
        place = next((k for k in places if line_is_seen(expected, lines[k])), None)
        if place is None:
            return expected
        at, anywhere = place + 1, False
    return None if anywhere or at == len(lines) else f"(the end, after {at} of {len(lines)} lines)"


class Reader:
    """Somebody who types what a page says, into a shell in a folder that holds the examples."""

    def __init__(self, samara, folder, seconds):
        self.folder, self.seconds = pathlib.Path(folder), seconds
        shutil.copytree(ROOT / "examples", self.folder / "examples", dirs_exist_ok=True)
        programs = self.folder / ".programs"
        programs.mkdir(exist_ok=True)
        (programs / "samara").unlink(missing_ok=True)
        (programs / "samara").symlink_to(pathlib.Path(samara).resolve())
        self.place = self.folder
        self.printed = []  # by what was typed, in order
        # The distribution's Python before another one: it has NumPy.
        self.environment = {**os.environ, "PATH": f"{programs}:/usr/bin:{os.environ['PATH']}"}

    def type(self, lines):
        """What was printed, on stdout and stderr as a terminal shows them, and the exit code."""
        place = self.folder / ".place"
        script = f"set -e\ntrap 'pwd > {place}' EXIT\n{lines}"
        result = subprocess.run(["bash", "-c", script], cwd=self.place, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True, timeout=self.seconds)
        self.place = pathlib.Path(place.read_text().strip())
        self.printed.append(result.stdout)
        return self.printed[-1], result.returncode

    def walk(self, test, text):
        """The whole page; @returns how many fences of lines it has"""
        count, output = 0, ""
        for kind, *what in steps(text):
            if kind == "file":
                (self.place / what[0]).write_text(what[1])
            elif kind == "run":
                code = re.search(r"# exit code (\d+)$", what[0].strip())
                output, ended = self.type(what[0])
                test.assertEqual(ended, int(code.group(1)) if code else 0, f"{what[0]}{output}")
                count += 1
            elif kind == "left":
                output = None
            elif output is not None:
                line = unseen(what[0], output)
                test.assertIsNone(line, f"the page says\n{line}\nbut what is printed is\n{output}")
        return count
