"""Usage: reference_test.py SAMARA [CLASS]

The reference pages of plans and fit configs beside the command: whole numbers are taken to both ends of the range that a page
tells and refused beyond, and quantities are in the unit that it tells.
"""

import pathlib
import re

from samara_case import COIN_PLAN, LINE_PLAN, Case, book, main, run, write

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "reference"
ENTRY = re.compile(r"(?=\*\*`\[?(\w+)\]?`\*\*,? \(((?:[^()]|\([^()]*\))*)\))")
COMMAND_PLAN = '[command]\nrun = ["true"]\ninputs = { k = "m" }\noutputs = { u = "m" }\n[box]\nk = [1.0, 2.0]\n'
# Of keys whose refusal needs more than the key.
FIXED_HERE = {"length", "scale", "rotation", "range"}


def entries(page):
    """(section, key, what is told of it) of a page."""
    for section in re.split(r"^## ", (DOCS / page).read_text(), flags=re.M)[1:]:
        title, body = section.split("\n", 1)
        for key, what in ENTRY.findall(body):
            yield title.strip("`[]"), key, re.sub(r"\([^()]*\)", "", what).replace("\n  ", " ")


def with_key(plan, section, line):
    """A plan with a line more in a section, in place of one of the same key."""
    key = line.split(" = ")[0]
    lines = [old for old in plan.splitlines() if not old.startswith(f"{key} =")]
    head = f"[{section}]"
    if head not in lines:
        return "\n".join([*lines, head, line, ""])
    at = lines.index(head) + 1
    return "\n".join([*lines[:at], line, *lines[at:], ""])


def plan_with(section, key, value):
    if section == "box":
        return LINE_PLAN.replace("k = [1.0, 10.0]", f"k = {{ range = [1.0, 10.0], {key} = {value} }}")
    return with_key(COMMAND_PLAN if section == "command" else COIN_PLAN, section, f"{key} = {value}")


class ReferencePages(Case):
    def refused(self, plan):
        return run("build", write("told.toml", plan), "--dry-run")

    def test_whole_numbers_of_plans_have_the_ranges_that_the_page_tells(self):
        checked = 0
        for section, key, what in entries("plan.md"):
            ends = re.match(r"integer, ([\d,]+) to ([\d,]+)", what)
            if not ends or section not in ("box", "builder", "command"):
                continue
            lower, upper = (int(end.replace(",", "")) for end in ends.groups())
            for value in (lower, upper):
                self.assertEqual(self.refused(plan_with(section, key, value)).returncode, 0, f"{section} {key} = {value}")
            for value in (lower - 1, upper + 1):
                self.check_error(self.refused(plan_with(section, key, value)), 3, key, str(value))
            checked += 1
        self.assertGreater(checked, 5)

    def test_quantities_of_plans_are_in_the_unit_that_the_page_tells(self):
        checked = 0
        for section, key, what in entries("plan.md"):
            unit = re.match(r"quantity, (\S+?)[;,)]", what + ")")
            if not unit or section not in ("time", "command"):
                continue
            self.assertEqual(self.refused(plan_with(section, key, f'"0.2 {unit[1]}"')).returncode, 0, key)
            self.check_error(self.refused(plan_with(section, key, '"0.2 K"')), 3, key)
            checked += 1
        self.assertGreater(checked, 1)

    def test_quantities_and_counts_of_configs_are_those_that_the_page_tells(self):
        coin, capture = book("coin", COIN_PLAN), write("drop.csv", "t[s],x[m]\n" + "".join(f"{0.02 * k},{0.4 * (0.02 * k) ** 2}\n" for k in range(20)))
        checked = 0
        for section, key, what in entries("fit_config.md"):
            if section in ("series", "prediction") or key in FIXED_HERE:
                continue
            unit, count = re.match(r"quantity, (\S+?)[;,)]", what + ")"), re.match(r"integer, ([\d,]+) to ([\d,]+)", what)
            wrong = ['"0.2 K"'] if unit else [int(count[1].replace(",", "")) - 1, int(count[2].replace(",", "")) + 1] if count else []
            for value in wrong:
                result = run("fit", coin, capture, "--config", write("told_fit.toml", f"{key} = {value}\n"))
                self.check_error(result, 3, "told_fit.toml", key)
                checked += 1
        self.assertGreater(checked, 5)


if __name__ == "__main__":
    main()
