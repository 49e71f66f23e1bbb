"""Usage: comparisons_test.py SAMARA [CLASS]

Which model predicts captures that its fit has not seen, from the command.
"""

import csv
import json
import re

from samara_case import FOLDER, Case, book, main, run, write

HELD = '[fixed]\narea = "4.7144e-4 m^2"\nthickness = "2.55 mm"\ndensity = 6338.5\n{}'
FREE = '[box]\n{}"v(0)" = [-0.2, 0.5]\n[prediction]\nspan = "0.2 s"\nahead = "0.12 s"\n'
HEAD = 'cluster_by = ["drop"]\noutputs = ["x"]\n'


class Comparisons(Case):
    @classmethod
    def setUpClass(cls):
        """Four drops of a coin, each seen twice."""
        lines = ["t[s],x[m],drop,cam"]
        for drop in range(4):
            result = run("simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7144e-4", "--set", "thickness=2.55e-3",
                         "--set", "density=6338.5", "--set", f"v(0)={0.05 + 0.05 * drop}", "--until", "0.35", "--frames", "22")
            rows = list(csv.reader(result.stdout.splitlines()))
            column = rows[0].index("x[m]")
            for cam in "ab":
                lines += [f"{row[0]},{float(row[column]) + 2e-4 * ((7 * k + 3 * drop + ord(cam)) % 5 - 2)},{drop},{cam}" for k, row in enumerate(rows[1:])]
        write("drops.csv", "\n".join(lines) + "\n")
        cls.drops = write("drops.toml", 'file = "drops.csv"\ngroup_by = ["drop", "cam"]\n[columns]\n"t[s]" = { quantity = "t", unit = "s" }\n'
                          '"x[m]" = { quantity = "x", unit = "m" }\n')
        cls.right = write("right.toml", HEAD + HELD.format("") + FREE.format("C_D = [0.5, 2.0]\n"))
        cls.wrong = write("wrong.toml", HEAD + HELD.format("C_D = 0.7\n") + FREE.format(""))

    def compared(self, *arguments):
        result = run("compare", *arguments, "--model", "vertical_fall", "--left-out", self.drops, "--by", "drop", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        self.assertEqual(answer["schema"], "samara-compare/1")
        self.check_schema(answer)
        return answer

    def test_the_drag_that_the_drops_have_is_preferred_to_another(self):
        answer = self.compared(self.right, self.wrong)
        self.assertEqual([answer["folds"], answer["clusters"]], [4, 4])
        self.assertEqual([(m["name"], m["coefficients"]) for m in answer["models"]], [("right", 1), ("wrong", 0)])
        position, = answer["quantities"]
        self.assertEqual([position["quantity"], position["forecasts"]], ["position, 0.12 s ahead", 8])
        right, wrong = position["predictors"][:2]
        for statistic in ("median", "rms"):
            self.assertIsNone(right[statistic]["to_first"]["value"])
            difference = wrong[statistic]["to_first"]
            self.assertAlmostEqual(difference["value"], wrong[statistic]["value"] - right[statistic]["value"], places=12)
            self.assertGreater(difference["value"], 3 * difference["error"])
            self.assertGreater(difference["error"], 0)
            best = min((p for p in position["predictors"] if p["is_plain"]), key=lambda p: p[statistic]["value"])
            self.assertEqual(best["name"], position[f"best_plain_by_{statistic}"])
            self.assertAlmostEqual(right[statistic]["to_plain"]["value"], right[statistic]["value"] - best[statistic]["value"], places=12)

    def test_by_evidence_the_drag_that_the_drops_have_is_preferred_and_without_priors_it_is_said(self):
        def placed(config):
            text = config.read_text().replace("[-0.2, 0.5]", "[-1, 1]")  # far from what another drag asks of the start
            return text.replace("[box]\n", '[box]\n"x(0)" = [-0.1, 0.1]\n')
        right, wrong = write("right_placed.toml", placed(self.right)), write("wrong_placed.toml", placed(self.wrong))
        first, second = self.compared(right, wrong)["models"]
        self.assertEqual([first["evidence"]["to_first"], first["no_evidence"]], [0, ""])
        self.assertLess(second["evidence"]["to_first"], -20)
        self.assertAlmostEqual(second["evidence"]["to_first"], second["evidence"]["log"] - first["evidence"]["log"], places=9)
        self.assertEqual(first["evidence"]["values"], second["evidence"]["values"])
        self.assertEqual(first["evidence"]["unknowns"] - second["evidence"]["unknowns"], 1)
        result = run("compare", right, self.wrong, "--model", "vertical_fall", "--left-out", self.drops, "--by", "drop", "--folds", "2")
        self.assertIn("wrong                      none: the offset of x", result.stdout)

    def test_the_table_says_the_same_and_goes_to_a_file_as_json(self):
        target = FOLDER / "compared.json"
        result = run("compare", self.right, self.wrong, "--model", "vertical_fall", "--left-out", self.drops, "--by", "drop", "--folds", "2", "-o", target)
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(target.read_text())
        self.assertEqual([answer["folds"], answer["clusters"]], [2, 4])
        self.assertIn("position, 0.12 s ahead [m]: 8 forecasts of 4 clusters", result.stdout)
        wrong = answer["quantities"][0]["predictors"][1]
        row = next(line for line in result.stdout.splitlines() if line.startswith("  wrong ") and "+-" in line)
        self.assertEqual(float(re.split(r"\s+", row.strip())[1]), float(f"{wrong['median']['value']:.4g}"))
        again = self.compared(self.right, self.wrong, "--folds", "2")
        self.assertEqual(again["quantities"], answer["quantities"])

    def test_distributions_are_compared_by_their_score_and_mixtures_stand_beside_models(self):
        def spans_of(config):
            return config.read_text().replace('span = "0.2 s"\nahead = "0.12 s"', 'span = "0.15 s"\nahead = "0.05 s"\nstride = "30 ms"')
        mixed, wrong = write("mixed.toml", spans_of(self.right) + "mixture = true\n"), write("wrong_spans.toml", spans_of(self.wrong))
        position, = self.compared(mixed, wrong)["quantities"]
        names = [p["name"] for p in position["predictors"]]
        self.assertEqual(names[:3], ["mixed", "wrong_spans", "mixed, mixed"])
        self.assertTrue(next(p["is_plain"] for p in position["predictors"] if p["name"] == "mixture of baselines"))
        model, other = position["predictors"][:2]
        # A distribution scores better than its mean would, whose score is its distance, component by component.
        self.assertLess(model["crps"]["value"], model["rms"]["value"])
        self.assertGreater(model["crps"]["value"], 0)
        self.assertIsNone(other["crps"]["value"])
        self.assertIn(position["best_plain_by_crps"], names)
        table = run("compare", mixed, wrong, "--model", "vertical_fall", "--left-out", self.drops, "--by", "drop").stdout
        self.assertRegex(table.split("\ncrps ")[1], r"\n  wrong_spans +- +- +- *\n")
        self.assertNotIn("nan", table)

    def test_without_a_common_forecast_it_is_said_which_source_ends_where(self):
        short = book("short", 'model = "vertical_fall"\n' + HELD.format("") + '[box]\nC_D = [0.5, 2.0]\n"v(0)" = [-0.2, 0.5]\n'
                     '[time]\nend = "0.3 s"\n[tolerance]\nrelative = 1e-3\n')
        config = write("of_short.toml", HEAD + 'span = "0.25 s"\n[prediction]\nspan = "0.2 s"\nahead = "0.12 s"\n')
        rest = ["--left-out", self.drops, "--by", "drop", "--folds", "2"]

        def last_line(*arguments):
            result = run("compare", *arguments, *rest)
            self.assertEqual(result.returncode, 4, result.stderr)
            return result.stderr.strip().splitlines()[-1]
        line = last_line(config, "--model", short)
        self.assertIn('samara: no forecast is common to all models; of "of_short": predictions go to 0.1 s ahead, not to 0.12 s: the codebook ends there; '
                      "an `ahead` of at most 0.1 s was expected", line)
        self.assertEqual(run("compare", config, "--model", short, *rest, "--ahead", "0.1 s").returncode, 0)
        line = last_line(config, self.right, "--model", short, "vertical_fall")
        self.assertIn('of "of_short": predictions go to 0.1 s ahead', line)
        self.assertNotIn('of "right"', line)
        target = FOLDER / "none.json"
        result = run("compare", config, self.right, "--model", short, "vertical_fall", *rest, "--json", "-o", target)
        self.assertEqual(result.returncode, 4, result.stderr)
        for answer in json.loads(result.stdout), json.loads(target.read_text()):
            self.check_schema(answer)
            of_short, of_right = (model["no_forecast"] for model in answer["models"])
            self.assertTrue(of_short.startswith("predictions go to 0.1 s ahead, not to 0.12 s"), of_short)
            self.assertEqual(of_right, "")
        line = last_line(self.right, "--model", "vertical_fall", "--ahead", "1")
        self.assertIn("predictions go to 0.15 s ahead, not to 1 s: there is no frame to compare beyond; an `ahead` of at most 0.15 s was expected", line)
        line = last_line(config, "--model", short, "--span", "0.31")
        self.assertIn('of "of_short": no capture was predicted: the codebook ends at 0.3 s', line)
        nearer = write("nearer.toml", self.right.read_text().replace("0.12 s", "0.07 s"))
        line = last_line(self.right, nearer, "--model", "vertical_fall")
        self.assertIn("no forecast is common to all models, which make theirs of different captures, quantities or times ahead", line)

    def test_what_cannot_be_compared_is_refused_in_a_sentence(self):
        def refused(code, sentence, *arguments):
            self.check_error(run("compare", *arguments), code, sentence)
        rest = ["--left-out", self.drops, "--by", "drop"]
        refused(2, "2 models or codebooks for 3 configs", self.right, self.wrong, self.right, "--model", "vertical_fall", "quadratic_drag_fall", *rest)
        refused(2, 'no label "day"', self.right, "--model", "vertical_fall", "--left-out", self.drops, "--by", "day")
        refused(3, "folds is 5; 2 to 4", self.right, "--model", "vertical_fall", *rest, "--folds", "5")
        silent = write("silent.toml", self.right.read_text().split("[prediction]")[0])
        refused(3, "`ahead` in [prediction]", silent, "--model", "vertical_fall", *rest)
        refused(2, "ahead is -1 s", self.right, "--model", "vertical_fall", *rest, "--ahead", "-1")
        refused(2, "replicates is 1", self.right, "--model", "vertical_fall", *rest, "--replicates", "1")
        refused(2, "replicates is 2000000000; 2 to 1000000", self.right, "--model", "vertical_fall", *rest, "--replicates", "2000000000")
        refused(2, "which it would overwrite", self.right, "--model", "vertical_fall", *rest, "-o", self.right)


if __name__ == "__main__":
    main()
