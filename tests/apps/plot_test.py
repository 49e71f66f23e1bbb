"""Usage: plot_test.py SAMARA CLASS

Pictures of codebooks, fits and tables: what is drawn stands where its numbers say.
"""

import json
import os
import re
import xml.etree.ElementTree as xml

import numpy as np

from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write

SVG = "{http://www.w3.org/2000/svg}"


def drawn(*arguments):
    path = FOLDER / "picture.svg"
    result = run("plot", *arguments, "-o", path)
    assert result.returncode == 0, result.stderr
    return xml.parse(path).getroot()


def texts(picture):
    return [element.text for element in picture.iter(SVG + "text")]


def curves(picture):
    """The corners of the lines that are data."""
    return [np.array(re.findall(r"[ML]([-\d.]+) ([-\d.]+)", path.get("d")), float)
            for path in picture.iter(SVG + "path") if path.get("stroke-width") == "1.8"]


def ticks(picture, axis):
    """Numbers at the ticks of the first panel, and where they stand."""
    anchor = "middle" if axis == "x" else "end"
    found = [(float(t.get(axis)), float(t.text)) for t in picture.iter(SVG + "text")
             if t.get("text-anchor") == anchor and re.fullmatch(r"-?[\d.]+(e[-+]\d+)?", t.text)]
    return np.array(found)


class Plots(Case):
    def test_a_trajectory_stands_where_the_query_says(self):
        picture = drawn(book("coin", COIN_PLAN), "--set", "C_D=1.25", "--outputs", "x")
        curve, = curves(picture)
        places, heights = ticks(picture, "x"), ticks(picture, "y")
        to_time, to_depth = np.polyfit(places[:, 0], places[:, 1], 1), np.polyfit(heights[:, 0] - 4.0, heights[:, 1], 1)
        times = np.polyval(to_time, curve[:, 0])
        answer = json.loads(run("query", book("coin", COIN_PLAN), "--set", "C_D=1.25", "--set", "v(0)=0.2", "--json",
                                "--at", *(repr(0.4 * k / 300) for k in range(301))).stdout)
        expected = next(o["values"] for o in answer["outputs"] if o["name"] == "x")
        np.testing.assert_allclose(times, np.linspace(0.0, 0.4, 301), atol=4e-4)
        np.testing.assert_allclose(np.polyval(to_depth, curve[:, 1]), expected, atol=2e-3 * max(expected))
        self.assertIn("x [m]", texts(picture))

    def test_errors_stay_below_the_tolerance_of_a_codebook_that_meets_it(self):
        # Its coordinates are not in the order of the alphabet.
        plan = COIN_PLAN.replace("C_D = [0.8, 1.6]", "g = [9.5, 10.0]\nC_D = [0.8, 1.6]")
        picture = drawn(book("order", plan), "--of", "error", "--points", "8")
        self.assertEqual(len(curves(picture)), 4)  # largest and median of two outputs
        rule = next(p for p in picture.iter(SVG + "path") if p.get("stroke") == "#777")
        height = float(re.match(r"M[\d.]+ ([\d.]+)", rule.get("d")).group(1))
        for largest, median in zip(curves(picture)[::2], curves(picture)[1::2]):
            self.assertGreaterEqual(largest[:, 1].min(), height)  # downwards
            self.assertGreaterEqual(median[:, 1].min(), largest[:, 1].min())

    def test_ranks_and_indices_are_drawn(self):
        self.assertIn("Largest rank", texts(drawn(book("coin", COIN_PLAN), "--of", "ranks")))
        picture = drawn(book("coin", COIN_PLAN), "--of", "indices")
        self.assertEqual(len(curves(picture)), 8)
        self.assertIn("C_D, total", texts(picture))

    def test_fits_show_captures_and_profiles(self):
        times = [repr(0.4 * k / 20) for k in range(21)]
        result = run("query", book("coin", COIN_PLAN), "--set", "C_D=1.25", "--set", "v(0)=0.1", "--at", *times)
        lines = result.stdout.splitlines()
        column = lines[0].split(",").index("x[m]")
        rows = [f"{t},{float(line.split(',')[column]) + 1e-4 * (-1) ** k}" for k, (t, line) in enumerate(zip(times, lines[1:]))]
        capture, fit = write("drop.csv", "\n".join(["t[s],x[m]", *rows]) + "\n"), FOLDER / "drop.json"
        self.assertEqual(run("fit", book("coin", COIN_PLAN), capture, "--profiles", "-o", fit).returncode, 0)
        picture = drawn(fit)
        self.assertEqual(sum(c.get("r") == "2.6" for c in picture.iter(SVG + "circle")), 21)
        self.assertEqual(len(curves(picture)), 1)
        picture = drawn(fit, "--of", "profiles")
        self.assertIn("C_D: identified", texts(picture))
        svg = FOLDER / "refused.svg"
        self.check_error(run("plot", fit, "--of", "ranks", "-o", svg), 2, "captures, profiles was expected")
        self.check_error(run("plot", fit, "--capture", "drip", "-o", svg), 2, "did you mean", "drop")

    def test_captures_of_one_id_are_told_apart_by_their_files(self):
        times = [0.02 * k for k in range(21)]
        falls = {"slow": 0.5, "fast": 0.8}
        files = []
        for name, speed in falls.items():
            (FOLDER / name).mkdir(exist_ok=True)
            files.append(write(f"{name}/drop.csv", "t[s],x[m]\n" + "".join(f"{t},{speed * t * t}\n" for t in times)))
        fit, svg = FOLDER / "namesakes.json", FOLDER / "refused.svg"
        self.assertIn(run("fit", book("coin", COIN_PLAN), *files, "-o", fit).returncode, (0, 4))
        known = [capture["file"] for capture in json.loads(fit.read_text())["captures"]]
        pictures = [drawn(fit, "--capture", f"drop, {file}") for file in known]
        points = [[c.get("cy") for c in picture.iter(SVG + "circle") if c.get("r") == "2.6"] for picture in pictures]
        ticks = [texts(picture) for picture in pictures]
        self.assertEqual([len(p) for p in points], [21, 21])
        self.assertNotEqual((points[0], ticks[0]), (points[1], ticks[1]))
        self.check_error(run("plot", fit, "--capture", "drop", "-o", svg), 2, 'has 2 captures "drop"', *known)

    def test_tables_are_drawn_column_by_column(self):
        table = write("table.csv", "t[s],x[m],v[m/s]\n0,0,1\n1,,2\n2,4,3\n3,5,4\n")
        picture = drawn(table)
        self.assertEqual([len(curve) for curve in curves(picture)], [3, 4])
        self.assertEqual(len(curves(drawn(table, "--outputs", "v"))), 1)

    def test_a_name_that_is_no_utf8_does_not_end_an_answer_as_json(self):
        path = FOLDER / os.fsdecode(b"caf\xe9.svg")
        result = run("plot", write("named.csv", "t[s],x[m]\n0,0\n1,2\n"), "-o", path, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(result.stdout)["output"], str(FOLDER / "caf\ufffd.svg"))
        self.assertTrue(path.exists())

    def test_a_column_that_is_constant_but_for_its_last_bit_is_drawn(self):
        table = write("held.csv", "t[s],g[m/s^2]\n0,9.81\n1,9.810000000000002\n")
        self.assertEqual(len(curves(drawn(table))), 1)

    def test_bad_calls_are_told_in_one_sentence(self):
        svg, path = FOLDER / "refused.svg", book("coin", COIN_PLAN)
        self.check_error(run("plot", path, "--of", "profiles", "-o", svg), 2, "trajectories, error, ranks, indices was expected")
        self.check_error(run("plot", path, "--set", "C_D=7", "-o", svg), 5, "C_D")
        self.check_error(run("plot", path, "--of", "error", "--points", "0", "-o", svg), 2, '--points is "0", expected 1 to 100000')
        self.check_error(run("plot", path, "--of", "error", "--points", "100001", "-o", svg), 2, '--points is "100001", expected 1 to 100000')
        self.check_error(run("plot", path, "--of", "ranks", "--set", "C_D=1", "-o", svg), 2, "--set is of trajectories")
        self.check_error(run("plot", path, "--of", "ranks", "--outputs", "x", "-o", svg), 2, "--outputs is of trajectories, error, indices, table")
        self.check_error(run("plot", path, "--points", "9", "-o", svg), 2, "--points is of error, and not of trajectories")
        self.check_error(run("plot", write("two.csv", "t[s],x[m]\n1,2\n"), "--capture", "a", "-o", svg), 2, "--capture is of captures")
        self.check_error(run("plot", write("one.csv", "t[s]\n1\n"), "-o", svg), 3, "one column")
        self.check_error(run("plot", write("none.json", "{}"), "-o", svg), 3, "JSON of a fit")
        self.check_error(run("plot", path, "-o", path), 2, "which it would overwrite")
        self.assertFalse(svg.exists())


if __name__ == "__main__":
    main()
