"""Usage: docs_test.py ROOT

What the documentation shows of the examples is what stands there; its links lead somewhere, its lines and those of
comments are short, its map has all pages, and its reference pages have all keys.
"""

import ast
import json
import pathlib
import re
import sys
import textwrap
import tomllib
import unittest

ROOT = pathlib.Path(sys.argv[1])
PAGES = sorted((ROOT / "docs").rglob("*.md"))
TEXTS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")]
FENCES = re.compile(r"^```.*?^```$", re.M | re.S)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def text(path):
    return (ROOT / path).read_text()


class Excerpts(unittest.TestCase):
    def test_plan_of_the_coin(self):
        self.assertIn(f"```toml\n{text('examples/coin/plan.toml')}```", text("docs/tutorials/demo.md"))

    def test_sidecar_of_the_coin(self):
        self.assertIn(f"```toml\n{text('examples/coin/coin.toml')}```", text("docs/captures.md"))

    def test_plan_of_a_command(self):
        self.assertIn(f"```toml\n{text('examples/command/settling.toml')}```", text("docs/programs.md"))

    def test_loop_of_a_program_that_is_kept(self):
        loop = text("examples/command/suspension.py").split("def main():\n")[1].split("\n\n")[0]
        self.assertIn(f"```python\n{textwrap.dedent(loop)}\n```", text("docs/programs.md"))

    def test_own_model(self):
        for name in ["predator_prey.toml", "plan.toml", "counts.toml", "fit.toml", "predator_prey.h", "own_model.cpp", "library.cpp"]:
            kind, page = ("toml", "own_models") if name.endswith("toml") else ("cpp", "compiled_models")
            self.assertIn(f"```{kind}\n{text('examples/own_model/' + name)}```", text(f"docs/{page}.md"))

    def test_sweep_of_the_card(self):
        self.assertIn(f"```toml\n{text('examples/falling_card/sweep.toml')}```", text("docs/pattern_maps.md"))
        self.assertIn(f"```toml\n{text('examples/drawn_fall/motion.toml')}```", text("docs/synthesis.md"))

    def test_queries(self):
        self.assertIn(f"```cpp\n{text('examples/query/query.cpp')}```", text("docs/queries.md"))

    def test_strategies(self):
        self.assertIn(f"```cpp\n{text('examples/nonlinear/strategies.cpp')}```", text("docs/strategies.md"))

    def test_wind_of_the_meadow(self):
        self.assertIn(f"```toml\n{text('examples/meadow/wind.toml')}```", text("docs/wind.md"))

    def test_flow(self):
        self.assertIn(f"```toml\n{text('examples/flow/square.toml')}```", text("docs/flow.md"))

    def test_profile(self):
        self.assertIn(f"```cpp\n{text('examples/profile/profile.cpp')}```", text("docs/fits.md"))

def anchors(page):
    """As sites make them of headings."""
    for heading in re.findall(r"^#+ (.*)$", FENCES.sub("", page.read_text()), re.M):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


class Links(unittest.TestCase):
    def test_links_lead_to_files_and_headings(self):
        seen = 0
        for page in PAGES + TEXTS:
            for target in LINK.findall(FENCES.sub("", page.read_text())):
                if re.match(r"\w+:", target):
                    continue
                seen += 1
                name, _, anchor = target.partition("#")
                file = (page.parent / name).resolve() if name else page
                self.assertTrue(file.exists(), f"{page.relative_to(ROOT)}: {target}")
                if anchor:
                    self.assertIn(anchor, list(anchors(file)), f"{page.relative_to(ROOT)}: {target}")
        self.assertGreater(seen, 100)

    def test_no_link_to_another_page_is_called_above_or_below(self):
        for page in PAGES + TEXTS:
            found = re.search(r"\[(?:above|below)\]\([^#)]", page.read_text())
            self.assertIsNone(found, f"{page.relative_to(ROOT)}: {found and found.group()}..: name the page")

    def test_pages_named_in_sources_exist(self):
        for folder in ("apps", "base", "codebooks", "flow", "identification", "io", "motion", "pgd", "python", "examples"):
            for file in (ROOT / folder).rglob("*"):
                if file.suffix not in (".h", ".cpp", ".py", ".toml"):
                    continue
                for name in re.findall(r"\bdocs/[\w/]+\.md", file.read_text()):
                    self.assertTrue((ROOT / name).exists(), f"{file.relative_to(ROOT)}: {name}")

    def test_sources_named_in_comments_exist(self):
        """By their name, or by the end of their path: `march.h`, `nonlinear/march.h`."""
        comments = re.compile(r"(?:^|\s)//.*|/\*.*?\*/", re.M | re.S)
        names = re.compile(r"(?<![\w./<>*])(?:samara/)?((?:\w+/)*\w+\.(?:h|cpp))\b")
        folders = ("apps", "base", "benchmarks", "codebooks", "examples", "flow", "identification", "io", "models", "motion", "pgd", "python", "tests")
        files = [file for folder in folders for file in (ROOT / folder).rglob("*") if file.suffix in (".h", ".cpp")]
        ends = {"/".join(file.parts[-count:]) for file in files for count in range(1, len(file.relative_to(ROOT).parts) + 1)}
        seen = 0
        for file in files:
            for comment in comments.findall(re.sub(r'"(?:[^"\\\n]|\\.)*"', '""', file.read_text())):
                for name in names.findall(comment):
                    seen += 1
                    self.assertTrue(name in ends, f"{file.relative_to(ROOT)}: {name}")
        self.assertGreater(seen, 100)

    def test_the_map_has_every_page(self):
        targets = {target.partition("#")[0] for target in LINK.findall(text("docs/index.md"))}
        for page in PAGES:
            name = str(page.relative_to(ROOT / "docs"))
            self.assertTrue(name in targets or name == "index.md", f"docs/index.md has no link to {name}")


class Lines(unittest.TestCase):
    """Tables of more than three columns may be longer: they cannot be wrapped."""

    WIDTH = 100

    def test_lines_are_short(self):
        for page in PAGES + TEXTS:
            for number, line in enumerate(page.read_text().splitlines(), 1):
                is_table = line.startswith("|") and line.count("|") > 4
                if len(line) > self.WIDTH and not is_table:
                    self.fail(f"{page.relative_to(ROOT)}:{number} has {len(line)} characters, expected at most {self.WIDTH}: "
                              "./dev format wraps prose, a backslash ends a part of a line for the shell")

    COMMENT = re.compile(r"\s*(//|/\*|\* )|.*///<")
    COMMENT_WIDTH = 120

    def test_lines_of_comments_are_short(self):
        """The formatter of sources leaves comments as they are."""
        seen = 0
        for folder in ("apps", "base", "benchmarks", "codebooks", "examples", "flow", "identification", "io", "models",
                       "motion", "pgd", "python", "tests"):
            for file in sorted((ROOT / folder).rglob("*")):
                if file.suffix not in (".h", ".cpp"):
                    continue
                for number, line in enumerate(file.read_text().splitlines(), 1):
                    if self.COMMENT.match(line):
                        seen += 1
                        self.assertLessEqual(len(line), self.COMMENT_WIDTH, f"{file.relative_to(ROOT)}:{number}: wrap the comment")
        self.assertGreater(seen, 10000)

    def test_lines_to_type_are_marked_as_such(self):
        """tests/apps/pages_test.py runs what stands in sh fences."""
        for page in PAGES + TEXTS:
            for fence in FENCES.findall(page.read_text()):
                kind = fence.splitlines()[0]
                if kind == "```sh elsewhere":
                    continue
                if kind not in ("```sh", "```sh slow"):
                    self.assertNotRegex(fence, r"(?m)^samara ", f"{page.relative_to(ROOT)}: a line to type in a fence {kind}")
                else:
                    tests = text("tests/apps/pages_test.py") + text("tests/apps/measured_test.py")
                    self.assertTrue(f'"{page.relative_to(ROOT)}"' in tests, f"no test types the lines of {page.relative_to(ROOT)}")


class Wrapping(unittest.TestCase):
    """docs/wrap_pages.py, which ./dev format calls."""

    LONG = "word " * 30
    PAGE = f"""# A heading that is long: {LONG}

{LONG}`code that stays in one piece` {LONG}- 1. end.

- an item: {LONG}
  and its second line
  1. an item in it: {LONG}

| a | table | {LONG} |

```toml
key = "{LONG}"
```

    indented = {LONG}
"""

    def test_words_stay_and_lines_become_short(self):
        sys.path.insert(0, str(ROOT / "docs"))
        sys.dont_write_bytecode = True
        import wrap_pages

        before = self.PAGE.splitlines()
        after = wrap_pages.pages_lines(before)
        self.assertEqual(" ".join(before).split(), " ".join(after).split())
        self.assertEqual(wrap_pages.pages_lines(after), after)
        long = [line for line in after if len(line) > wrap_pages.WIDTH]
        self.assertEqual([line[:4] for line in long], ["# A ", "| a ", "key ", "    "])
        self.assertTrue(any("`code that stays in one piece`" in line for line in after))
        self.assertFalse([line for line in after if line.startswith(("1.", "- 1."))])
        self.assertEqual([line[:5] for line in after if line.startswith("  1.")], ["  1. "])
        self.assertGreater(len([line for line in after if line.startswith("     word")]), 0)


class Schemas(unittest.TestCase):
    """Answers as JSON, docs/schemas; samara_case.py compares each that a test asks for with its schema."""

    OF_PAGES = {"samara-patterns-page/1", "samara-motion-page/1"}  # what pages carry is nobody else's

    def test_every_answer_has_a_schema_and_every_schema_a_call(self):
        written = set()
        for folder in ("apps", "codebooks", "flow", "identification", "motion"):
            for file in (ROOT / folder).rglob("*.cpp"):
                written |= set(re.findall(r'"(samara-[a-z-]+/[0-9]+)"', file.read_text()))
        published = {f"{stem}/{version}" for stem, version in (file.stem.rsplit("-", 1) for file in (ROOT / "docs" / "schemas").glob("*.json"))}
        self.assertEqual(written - self.OF_PAGES, published)
        tests = "".join(file.read_text() for file in (ROOT / "tests" / "apps").glob("*_test.py"))
        for name in published:
            # By its whole name, or without the version, as check_schema() gives it.
            self.assertRegex(tests, f'"{name.split("/")[0]}(/[0-9]+)?"', f"no test asks for {name}")


class Texts(unittest.TestCase):
    """A formatter that takes a file for another kind breaks what is shown of it."""

    def test_what_is_shown_of_files_can_be_read(self):
        readers = {"toml": tomllib.loads, "json": json.loads, "python": ast.parse}
        seen = 0
        for page in PAGES + TEXTS:
            for fence in FENCES.findall(page.read_text()):
                kind, _, body = fence.removeprefix("```").removesuffix("```").partition("\n")
                if kind in readers:
                    seen += 1
                    with self.subTest(page=page.name, text=body[:60]):
                        readers[kind](body)
        self.assertGreater(seen, 40)


class Reference(unittest.TestCase):
    """Every key that a reader of files knows has a place on its page: `key`, or `[key]`."""

    READERS = {
        "docs/reference/plan.md": ["codebooks/plan/*.cpp", "codebooks/model/model_file.cpp"],
        "docs/reference/fit_config.md": ["identification/problem/fit_config.cpp", "identification/problem/prior_formats.cpp", "identification/series/series_config.cpp",
                                         "identification/fit/prediction_config.cpp"],
        "docs/reference/sidecar.md": ["identification/captures/sidecar.cpp"],
        "docs/reference/sweep.md": ["motion/sweeps/sweep_plan.cpp"],
        "docs/reference/flow_plan.md": ["flow/files/flow_plan.cpp"],
        "docs/reference/wind.md": ["codebooks/model/wind_file.cpp"],
        "docs/reference/motion_plan.md": ["motion/planning/motion_plan.cpp", "motion/planning/motion_sequence.cpp"],
    }

    def test_all_keys_are_told(self):
        for page, patterns in self.READERS.items():
            told = set(re.findall(r"`\[?\[?(\w+)\]?\]?`", text(page)))
            known = set()
            for file in (file for pattern in patterns for file in ROOT.glob(pattern)):
                for call in re.findall(r"(?:expect_keys|check_keys)\(([^;]*)\);", file.read_text(), re.S):
                    known |= set(re.findall(r'"(\w+)"', call))
            self.assertGreater(len(known), 10)
            self.assertEqual(known - told, set(), f"{page} does not tell of these keys")

    # Where the defaults stand in the code; keys that have another name there; those whose default depends on other keys.
    DEFAULTS = {
        "docs/reference/plan.md": ["codebooks/plan/plan.h"],
        "docs/reference/fit_config.md": ["identification/problem/fit_options.h", "identification/problem/priors.h"],
    }
    OTHER_NAMES = {"starts": "count", "bootstrap": "replicates", "posterior": "samples", "scale": "length_scale"}
    DEPEND = {"max_nodes", "max_rank", "guards", "absolute", "initial"}

    def test_numbers_that_are_told_as_defaults_are_those_of_the_code(self):
        # Keys of a table may stand within what is told of it.
        entry = re.compile(r"(?=\*\*`\[?(\w+)\]?`\*\*,? \(((?:[^()]|\([^()]*\))*)\))")
        number = r"[-+\d][-+\d.,e]*"
        for page, headers in self.DEFAULTS.items():
            told, known = {}, {}
            for key, what in entry.findall(text(page)):
                found = re.search(rf"\bdefault ((?:{number}\s*)+|`true`|`false`)(mm)?", re.sub(r"\([^()]*\)", "", what))
                if found and key not in self.DEPEND:
                    scale = 1e-3 if found[2] else 1.0
                    value = found[1].strip("`") if found[1].startswith("`") else tuple(scale * float(v) for v in re.sub(r",(?=\s|$)", " ", found[1]).replace(",", "").split())
                    told.setdefault(self.OTHER_NAMES.get(key, key), set()).add(value)
            for header in headers:
                for key, value in re.findall(r"^\s+[\w:<>, ]+ (\w+) =\s+(\{[^;]*\}|[^;]+);", text(header), re.M):
                    if re.fullmatch(rf"\{{?\s*{number}(, *{number})*\s*\}}?", value):
                        known.setdefault(key, set()).add(tuple(float(v.replace("'", "")) for v in value.strip("{} ").split(",")))
                    elif value in ("true", "false"):
                        known.setdefault(key, set()).add(value)
            self.assertGreater(len(told), 7, page)
            for key, values in told.items():
                self.assertEqual(values, known.get(key), f"{page}: {key}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
