"""What the tests of the command share: calling it as its users do, plans, and the form of errors."""

import csv
import functools
import io
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import tempfile
import unittest

SAMARA = sys.argv[1]
HERE = tempfile.TemporaryDirectory()
FOLDER = pathlib.Path(HERE.name)
SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "schemas"

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


# How much slower than usual a program may be, such as one with sanitizers.
PATIENCE = float(os.environ.get("SAMARA_TEST_PATIENCE", "1"))
LONGEST = 120 * PATIENCE


def closed(schema):
    """The same schema, by which no object holds what the schema does not name. Those that are published leave room for later fields."""
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    parts = {key: {name: closed(part) for name, part in value.items()} if key == "properties" else closed(value) for key, value in schema.items()}
    return {**parts, "additionalProperties": False} if "properties" in parts and "additionalProperties" not in parts else parts


@functools.cache
def schemas():
    """The published schemas, closed, by their addresses."""
    import jsonschema  # few tests need it

    every = {}
    for file in SCHEMAS.glob("*.json"):
        schema = json.loads(file.read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        every[schema["$id"]] = closed(schema)
    return every


def check_schema(answer):
    """An answer as JSON holds the schema that it names, and nothing else."""
    import jsonschema

    name, version = answer["schema"].split("/")
    schema = next(schema for address, schema in schemas().items() if address.endswith(f"/{name}-{version}.json"))
    jsonschema.Draft202012Validator(schema, resolver=jsonschema.RefResolver.from_schema(schema, store=schemas())).validate(answer)


def run(*arguments):
    """What the command does. An answer as JSON holds its schema, whoever asks."""
    result = subprocess.run([SAMARA, *map(str, arguments)], capture_output=True, text=True, timeout=LONGEST)
    if "--json" in arguments and result.stdout.startswith("{"):
        check_schema(json.loads(result.stdout))
    return result


def run_with_files_of_at_most(size, *arguments):
    """The same where no file may be larger, as on a disk that is full."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return subprocess.run([SAMARA, *map(str, arguments)], capture_output=True, text=True, timeout=LONGEST, preexec_fn=limit)


def write(name, text):
    path = FOLDER / name
    path.write_text(text)
    return path


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def book(name, plan):
    path = FOLDER / f"{name}.h5"
    if not path.exists():
        result = run("build", write(f"{name}.toml", plan), "-o", path)
        assert result.returncode == 0, result.stderr
    return path


class Case(unittest.TestCase):
    def pattern_page(self, *arguments):
        """The text of a page of samara patterns, and the data in it."""
        page = FOLDER / "patterns.html"
        result = run("patterns", *arguments, "--report", page)
        self.assertEqual(result.returncode, 0, result.stderr)
        text = page.read_text()
        # The licence and the library's own comment name its place; nothing is loaded from there.
        self.assertEqual(re.findall(r"(?:src|href)\s*=\s*[\"'](?!#)", text), [])
        self.assertIn("default-src 'none'", text)
        self.assertIn("Permission is hereby granted", text)
        self.assertEqual(text.count("</script>"), 3)
        return text, json.loads(re.search(r'id="patterns">(.*?)</script>', text, re.S)[1])

    def check_schema(self, answer):
        """An answer that did not come by run(), too. @returns the name of its schema"""
        check_schema(answer)
        return answer["schema"].split("/")[0]

    def check_error(self, result, code, *parts):
        """One sentence on stderr that holds the parts, nothing on stdout, the documented exit code."""
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stdout, "")
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("samara: "), lines[0])
        for part in parts:
            self.assertIn(part, lines[0])


def main():
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    result = unittest.main(module="__main__", argv=[sys.argv[0], *sys.argv[2:]], exit=False).result
    is_skipped = result.wasSuccessful() and 0 < result.testsRun <= len(result.skipped)
    sys.exit(77 if is_skipped else 0 if result.wasSuccessful() else 1)
