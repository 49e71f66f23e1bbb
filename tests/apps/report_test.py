"""Usage: report_test.py SAMARA [CLASS]

The page that `samara fit --report` writes, as a file and in a real browser (skipped, with exit code 77, without one).
"""

import csv
import html.parser
import json
import re
import shutil
import subprocess
import sys

from samara_case import COIN_PLAN, FOLDER, LONGEST, Case, book, main, run, write

BROWSER = next(filter(None, map(shutil.which, ["chromium-headless-shell", "chromium", "chromium-browser",
                                               "google-chrome"])), None)
HOSTILE = "<img src=x onerror=alert(1)>&</script>\"'"


def fall(C_D, v, wiggle=1e-4):
    """Times and depths of a coin, with a pattern of `wiggle` m that is no motion."""
    result = run("simulate", "vertical_fall", "--set", f"C_D={C_D}", "--set", "area=4.7144e-4", "--set",
                 "thickness=2.55e-3", "--set", "density=6338.5", "--set", f"v(0)={v}", "--until", "0.35", "--frames", "22")
    rows = list(csv.reader(result.stdout.splitlines()))
    x, speed = rows[0].index("x[m]"), rows[0].index("v[m/s]")
    pattern = [0, 1, -1, 0, -1, 1, 1]
    return [(row[0], float(row[x]) + wiggle * pattern[k % 7], float(row[speed])) for k, row in enumerate(rows[1:])]


def captures(name, ids):
    """A table of several captures, with the sidecar that tells them apart. Each id is quoted as CSV asks for."""
    lines = ["t[s],x[m],drop"]
    for k, label in enumerate(ids):
        quoted = '"' + label.replace('"', '""') + '"'
        lines += [f"{t},{x},{quoted}" for t, x, _ in fall(1.2, 0.05 + 0.25 * k / len(ids))]
    write(f"{name}.csv", "\n".join(lines) + "\n")
    return write(f"{name}.toml", f'file = "{name}.csv"\ngroup_by = ["drop"]\n[columns]\n'
                 '"t[s]" = { quantity = "t", unit = "s" }\n"x[m]" = { quantity = "x", unit = "m" }\n')


def fitted(*arguments, code=0):
    """The JSON of a fit, and the file with its page."""
    page, answer = FOLDER / "fit.html", FOLDER / "fit.json"
    result = run("fit", *arguments, "-o", answer, "--report", page)
    assert result.returncode == code, result.stderr
    return json.loads(answer.read_text()), page


class Report(Case):
    def test_the_page_is_complete_in_itself(self):
        _, page = fitted(book("coin", COIN_PLAN), captures("three", ["a", "b", "c"]), "--profiles")
        text = page.read_text()
        # The licence and the library's own comment name its place; nothing is loaded from there.
        self.assertEqual(re.findall(r"(?:src|href)\s*=\s*[\"'](?!#)", text), [])
        self.assertIn("default-src 'none'", text)
        self.assertIn("Permission is hereby granted", text)

    def test_what_stands_in_files_cannot_become_markup(self):
        _, page = fitted(book("coin", COIN_PLAN), captures("hostile", [HOSTILE, "b"]))
        text = page.read_text()
        self.assertNotIn("<img", text)
        self.assertEqual(text.count("</script>"), 3)

    def test_the_page_replaces_neither_an_input_nor_the_other_output(self):
        path, capture = book("coin", COIN_PLAN), captures("kept", ["a"])
        self.check_error(run("fit", path, capture, "--report", capture), 2, "which it would overwrite")
        target = FOLDER / "both"
        self.check_error(run("fit", path, capture, "-o", target, "--report", target), 2, "two files were expected")
        self.assertFalse(target.exists())

    def test_a_folder_that_is_not_there_is_told_before_the_work(self):
        self.check_error(run("fit", book("coin", COIN_PLAN), captures("kept", ["a"]), "--report", FOLDER / "no" / "fit.html"),
                         2, "fit.html")

    def test_profiles_are_made_only_when_asked_for(self):
        path, capture = book("coin", COIN_PLAN), captures("three", ["a", "b", "c"])
        self.assertEqual(fitted(path, capture)[0]["profiles"], [])
        profile, = fitted(path, capture, "--profiles")[0]["profiles"]
        self.assertEqual((profile["name"], profile["shape"]), ("C_D", "identified"))
        lower, upper = profile["interval"]
        self.assertTrue(lower < profile["best"] < upper)
        config = write("profiles.toml", "profiles = true\n")
        self.assertEqual(len(fitted(path, capture, "--config", config)[0]["profiles"]), 1)


class Page(html.parser.HTMLParser):
    """The document as the browser left it: elements with attributes and the text inside."""

    VOID = {"meta", "img", "br", "hr", "input", "link"}

    def __init__(self, text):
        super().__init__()
        self.elements, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        element = {"tag": tag, "text": "", "inside": list(self.open), **dict(attributes)}
        self.elements.append(element)
        if tag not in self.VOID:
            self.open.append(element)

    def handle_endtag(self, tag):
        while self.open and self.open.pop()["tag"] != tag:
            pass

    def handle_data(self, data):
        for element in self.open:
            element["text"] += data

    def all(self, tag, **attributes):
        return [e for e in self.elements if e["tag"] == tag and all(e.get(k.replace("_", "-")) == v
                                                                    for k, v in attributes.items())]

    def one(self, tag, **attributes):
        found = self.all(tag, **attributes)
        assert len(found) == 1, f"{len(found)} of {tag} {attributes}"
        return found[0]

    def inside(self, tag, outer):
        return [e for e in self.elements if e["tag"] == tag and any(o is outer for o in e["inside"])]


class ReportInBrowser(Case):
    def opened(self, page):
        result = subprocess.run([BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000",
                                 "--window-size=1200,900", "--dump-dom", f"{page.as_uri()}#check"],
                                capture_output=True, text=True, timeout=LONGEST)
        self.assertEqual(result.returncode, 0, result.stderr)
        opened = Page(result.stdout)
        self.assertEqual(opened.one("pre", id="errors")["text"], "")
        return opened

    def numbers(self, opened, row):
        return [float(cell["data-value"]) for cell in opened.inside("td", row) if "data-value" in cell]

    def test_charts_are_drawn_and_numbers_are_those_of_the_json(self):
        answer, page = fitted(book("coin", COIN_PLAN), captures("three", ["a", "b", HOSTILE]), "--profiles")
        opened = self.opened(page)
        # Capture and model, residuals, and one profile.
        self.assertEqual(len(opened.all("canvas")), 3)
        self.assertEqual(opened.one("html")["data-painted"], "3")

        coefficient, = answer["coefficients"]
        line = opened.one("tr", data_name="C_D")
        # A digit more or less is the browser's; the doubles are the same.
        self.assertEqual(self.numbers(opened, line),
                         [coefficient["value"], coefficient["standard_error"], coefficient["naive_standard_error"]])
        self.assertAlmostEqual(float(opened.inside("td", line)[1]["text"]), coefficient["value"], delta=1e-5)
        self.assertIn(coefficient["verdict"], line["text"])
        self.assertIn(answer["profiles"][0]["verdict"], opened.one("div", data_shape="identified")["text"])
        self.assertEqual(opened.one("p", id="status")["text"], answer["message"])
        self.assertEqual(opened.one("p", id="whiteness")["text"], answer["whiteness"]["sentence"])

        rows = opened.inside("tr", opened.one("table", id="captures"))[1:]
        self.assertEqual([self.numbers(opened, row)[2] for row in rows],
                         [capture["residuals"][0]["rms"] for capture in answer["captures"]])
        # Hostile labels are shown as what they are.
        self.assertEqual(opened.all("img"), [])
        self.assertEqual(opened.all("option")[2]["text"], HOSTILE)

    def test_a_hundred_captures_stand_in_one_page(self):
        answer, page = fitted(book("coin", COIN_PLAN), captures("hundred", [f"drop {k:02d}" for k in range(100)]))
        opened = self.opened(page)
        self.assertEqual([o["text"] for o in opened.all("option")], [c["id"] for c in answer["captures"]])
        self.assertEqual(len(opened.all("option")), 100)
        self.assertEqual(opened.one("html")["data-painted"], "2")

    def test_two_outputs_have_two_charts_each(self):
        rows = [f"{t},{x},{v}" for t, x, v in fall(1.2, 0.1)]
        capture = write("two.csv", "\n".join(["t[s],x[m],v[m/s]", *rows]) + "\n")
        config = write("two_fit.toml", 'loss = { kind = "huber", scale = { x = "1 mm", v = "10 mm/s" } }\n')
        opened = self.opened(fitted(book("coin", COIN_PLAN), capture, "--config", config)[1])
        self.assertEqual(opened.one("html")["data-painted"], "4")

    def test_a_path_is_drawn_where_two_outputs_are_lengths(self):
        result = run("simulate", "sphere_flight", "--until", "0.5", "--frames", "21", "--set", "vx(0)=5")
        rows = list(csv.DictReader(result.stdout.splitlines()))
        capture = write("flight.csv", "\n".join(["t[s],x[m],z[m]", *(f"{r['t[s]']},{r['x[m]']},{r['z[m]']}" for r in rows)]) + "\n")
        config = write("flight_fit.toml", '[box]\nC_D = [0.3, 0.6]\n"vx(0)" = [4.0, 6.0]\n')
        opened = self.opened(fitted("sphere_flight", capture, "--config", config)[1])
        self.assertEqual(opened.one("html")["data-painted"], "5")

    def test_a_coefficient_that_is_not_determined_is_said_to_be_so(self):
        # Without added mass, thickness and drag coefficient count by their ratio only.
        rows = [f"{t},{x}" for t, x, _ in fall(1.2, 0.1)]
        capture = write("ratio.csv", "\n".join(["t[s],x[m]", *rows]) + "\n")
        config = write("ratio_fit.toml", '[fixed]\narea = 4.7144e-4\ndensity = 6338.5\nm_a = 0.0\n[box]\nC_D = [0.6, 2.0]\n'
                       'thickness = ["2 mm", "3 mm"]\n"v(0)" = [-0.4, 0.8]\n')
        answer, page = fitted("vertical_fall", capture, "--config", config, code=4)
        self.assertEqual(answer["status"], "not_determined")
        opened = self.opened(page)
        self.assertIn("not determined", opened.one("tr", data_name="C_D")["text"])
        self.assertEqual([e["text"] for e in opened.inside("li", opened.one("ul", **{"class": "claims"}))],
                         ["C_D only relative to thickness (ratio)"])

    def test_the_page_of_patterns_draws_its_diagram_its_map_and_its_features(self):
        plan = write("plates.toml", """model = "falling_plate"
[fixed]
semi_thickness = "1 mm"
[axes]
semi_chord = { from = "3 mm", to = "14 mm", count = 5 }
density = { from = 1500, to = 9000, count = 4 }
[releases]
tilt = ["10 deg", "60 deg"]
[run]
until = 1
step = "1 ms"
keep = "trajectories"
""")
        sweep, page = FOLDER / "plates.h5", FOLDER / "plates.html"
        for call in (("sweep", plan, "-o", sweep), ("patterns", sweep, "--report", page)):
            self.assertEqual(run(*call).returncode, 0)
        answer = json.loads(run("patterns", sweep, "--json").stdout)
        opened = self.opened(page)
        # Diagram, map, features.
        self.assertEqual(opened.one("html")["data-painted"], "3")
        self.assertEqual(len(opened.inside("tr", opened.one("table", id="bodies"))), 1 + 20)
        rows = opened.inside("tr", opened.one("table", id="releases"))[1:]
        self.assertEqual([self.numbers(opened, row)[:8] for row in rows],
                         [list(map(float, release["counts"].values())) for release in answer["releases"]])
        # The slice is the whole of this grid, both releases beside each other.
        names = list(answer["releases"][0]["counts"])
        totals = [sum(release["counts"][name] for release in answer["releases"]) for name in names]
        sliced = [self.numbers(opened, row)[0] for row in opened.inside("tr", opened.one("table", id="slice"))[1:]]
        self.assertAlmostEqual(sum(sliced), 100.0)
        shown = {row["data-pattern"]: self.numbers(opened, row)[0]
                 for row in opened.inside("tr", opened.one("table", id="feature-shares"))[1:]}
        self.assertTrue(all(count <= totals[names.index(name)] for name, count in shown.items()))
        self.assertTrue(opened.all("table", id="chain") or opened.all("p", id="no-chain"))

    def with_posterior(self):
        """A fit with draws of two coefficients, and its page."""
        config = write("posterior.toml", 'shared = ["C_D", "v(0)"]\nposterior = { samples = 2400, seed = 1 }\n')
        return fitted(book("coin", COIN_PLAN), captures("one", ["a"]), "--config", config)

    def changed(self, page, change):
        """The page with other JSON in it."""
        text = page.read_text()
        begin = text.index('id="fit">') + len('id="fit">')
        end = text.index("</script>", begin)
        fit = json.loads(text[begin:end])
        change(fit)
        return write("changed.html", text[:begin] + json.dumps(fit).replace("<", "\\u003c") + text[end:])

    def test_draws_of_a_posterior_are_shown_one_by_one_and_in_pairs(self):
        answer, page = self.with_posterior()
        draws = answer["posterior"]["coefficient_draws"]
        self.assertEqual([len(column) for column in draws], [2000, 2000])
        for column, unknown in zip(draws, answer["posterior"]["unknowns"]):
            outside = sum(not unknown["lower"] <= value <= unknown["upper"] for value in column)
            # 5 % of the draws are; some hundred effective ones tell it to a third of that.
            self.assertTrue(0.02 * len(column) < outside < 0.09 * len(column))
        opened = self.opened(page)
        self.assertEqual([e["data-name"] for e in opened.all("div", **{"class": "marginal"})], ["C_D", "v(0)"])
        self.assertEqual(len(opened.all("div", **{"class": "pair"})), 1)
        self.assertNotIn("only", opened.one("p", id="pairs")["text"])
        # Capture and model, residuals, two marginals, one pair.
        self.assertEqual(opened.one("html")["data-painted"], "5")
        first = opened.inside("tr", opened.one("table", id="posterior"))[1]
        of_json = answer["posterior"]["unknowns"][0]
        self.assertEqual(self.numbers(opened, first), [of_json[key] for key in ["median", "lower", "upper", "mean", "deviation",
                                                                                "rhat", "effective"]])

    def test_a_posterior_without_draws_is_a_table(self):
        _, page = self.with_posterior()
        opened = self.opened(self.changed(page, lambda fit: fit["posterior"].pop("coefficient_draws")))
        opened.one("table", id="posterior")
        self.assertEqual(opened.one("html")["data-painted"], "2")

    def test_of_many_coefficients_the_page_says_which_pairs_it_shows(self):
        _, page = self.with_posterior()

        def multiply(fit):
            posterior = fit["posterior"]
            # The second draws of four copies are turned around, so that they hang together with the others less.
            for k in range(2, 8):
                fit["coefficients"].append({**fit["coefficients"][k % 2], "name": f"c{k}"})
                draws = posterior["coefficient_draws"][k % 2]
                posterior["coefficient_draws"].append(draws[::-1] if k > 3 else draws)
                posterior["unknowns"].insert(k, {**posterior["unknowns"][k % 2], "name": f"c{k}"})
            # A coefficient that no draw moves has no correlation.
            posterior["coefficient_draws"][7] = [1.0] * len(posterior["coefficient_draws"][7])

        opened = self.opened(self.changed(page, multiply))
        self.assertIn("of the 8 coefficients, only the 6", opened.one("p", id="pairs")["text"])
        self.assertEqual(len(opened.all("div", **{"class": "pair"})), 15)
        self.assertEqual(opened.one("html")["data-painted"], str(2 + 8 + 15))


if __name__ == "__main__":
    if "ReportInBrowser" in sys.argv and BROWSER is None:
        print("SKIPPED: none of chromium-headless-shell, chromium, google-chrome is installed")
        sys.exit(77)
    main()
