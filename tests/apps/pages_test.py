"""Usage: pages_test.py SAMARA [CLASS]

The pages of the documentation are walked as their readers do: every line that they show for a shell is run, and prints
what the page says (page.py has the rules). A page of its own folder and class each, so that they run side by side.
"""

import re
import tempfile

from page import ROOT, Reader, line_is_seen, steps, unseen
from samara_case import LONGEST, SAMARA, Case, main


PAGES = {
    "ReadMe": "README.md",
    "Install": "docs/install.md",
    "FirstCodebook": "docs/tutorials/first_codebook.md",
    "CommandPage": "docs/reference/commands.md",
    "DragFromAFilm": "docs/tutorials/drag_from_a_film.md",
    "Separation": "docs/explanation/separation.md",
    "ModelsPage": "docs/models.md",
    "ModelChecksPage": "docs/model_checks.md",
    "WakesPage": "docs/wakes.md",
    "OwnModelsPage": "docs/own_models.md",
    "BodiesPage": "docs/bodies.md",
    "ExplorePage": "docs/explore.md",
    "MotionPage": "docs/motion.md",
    "SynthesisPage": "docs/synthesis.md",
    "PlansPage": "docs/plans.md",
    "BuildersPage": "docs/builders.md",
    "CertificatePage": "docs/certificate.md",
    "ProgramsPage": "docs/programs.md",
    "FieldPage": "docs/field_of_space.md",
    "QueriesPage": "docs/queries.md",
    "StatisticsPage": "docs/statistics.md",
    "FlatFilePage": "docs/flat_file.md",
    "CapturesPage": "docs/captures.md",
    "CleaningPage": "docs/cleaning.md",
    "FittingPage": "docs/fitting.md",
    "PetabPage": "docs/petab.md",
    "FitsPage": "docs/fits.md",
    "UnstableMotionPage": "docs/unstable_motion.md",
    "CamerasPage": "docs/cameras_and_clocks.md",
    "ChangingCoefficientsPage": "docs/changing_coefficients.md",
    "PredictionsPage": "docs/predictions.md",
    "ForecastsPage": "docs/forecasts.md",
    "ComparisonsPage": "docs/comparisons.md",
    "FollowingPage": "docs/following.md",
    "NextExperimentPage": "docs/next_experiment.md",
    "FlowPage": "docs/flow.md",
    "MovingBodyPage": "docs/moving_body.md",
    "FlowBooksPage": "docs/flow_books.md",
    "TurbulencePage": "docs/turbulence.md",
    "WakeFlightsPage": "docs/wake_flights.md",
    "GustsPage": "docs/explanation/gusts.md",
    "WindPage": "docs/wind.md",
    "WhereALeafLands": "docs/tutorials/where_a_leaf_lands.md",
    "PatternsPage": "docs/patterns.md",
    "PatternMapsPage": "docs/pattern_maps.md",
    "FilmedPatternsPage": "docs/filmed_patterns.md",
    "PatternNamesPage": "docs/explanation/pattern_names.md",
    "StrategiesPage": "docs/strategies.md",
}


def walk(test, page):
    text = (ROOT / page).read_text()
    with tempfile.TemporaryDirectory() as folder:
        reader = Reader(SAMARA, folder, LONGEST)
        reader.walk(test, text)
    test.assertTrue(any(kind in ("run", "left") for kind, *_ in steps(text)), f"{page} shows no lines to run")
    if not reader.printed:
        test.skipTest(f"all lines of {page} are left to ./dev check or to other tests")
    return text, reader.printed


def leaves_land_as_told(test, page):
    """On a machine with other vectors the last digits differ, and the motion is chaotic."""
    text, printed = walk(test, page)
    landing = re.compile(r"x = ([0-9.]+) \+- ([0-9.]+) m\s+\(deviation\s+([0-9.]+)\s+m\)")
    told, now = [[[float(x) for x in found] for found in landing.findall(t) if float(found[1]) > 0.0]  # not of the calm wind
                 for t in (text, "".join(printed))]
    test.assertEqual((len(told), len(now)), (2, 2))
    for (mean, error, deviation), (mean_now, _, deviation_now) in zip(told, now):
        test.assertLess(abs(mean_now - mean), 4.0 * error)
        test.assertLess(abs(deviation_now / deviation - 1.0), 0.2)
    for count in re.findall(r"(\d+) landed", "".join(printed)):
        test.assertGreater(int(count), 990)


CHECKS = {"WhereALeafLands": leaves_land_as_told}
for name, page in PAGES.items():
    globals()[name] = type(name, (Case,), {"test_the_lines_run": lambda self, page=page, check=CHECKS.get(name, walk): check(self, page)})


class ReadersOfPages(Case):
    """What tells a page that is right from one that is not."""

    def test_lines_are_told_from_others(self):
        self.assertTrue(line_is_seen("C_D .. 0.6 .. 2 ..", "C_D   1.17 1  0.095  0.6 .. 2 0.88 to 1.5"))
        self.assertTrue(line_is_seen("largest error 0.000257", "largest error 0.000258"))
        self.assertTrue(line_is_seen("0.1,0.4082..,0.02346..", "0.1,0.4082164726051049,0.023464228763283003"))
        self.assertFalse(line_is_seen("largest error 0.000257", "largest error 0.000357"))
        self.assertFalse(line_is_seen("certificate: met, ..", "certificate: missed, largest error 0.1"))
        self.assertFalse(line_is_seen("three words here", "three words"))

    def test_outputs_are_seen_in_order_and_whole(self):
        self.assertIsNone(unseen("a\n..\nd\n", "a\nb\nc\nd\n"))
        self.assertEqual(unseen("b\n..\n", "a\nb\n"), "b")
        self.assertEqual(unseen("..\nb\n..\na\n", "a\nb\n"), "a")
        self.assertIsNotNone(unseen("a\n", "a\nb\n"))

    def test_slow_lines_and_those_of_measured_sets_are_left_to_others(self):
        page = "```sh slow\nfalse\n```\n\n```text\nnothing\n```\n\n```sh\nls $SAMARA_DATA/none\n```\n\n```sh\necho seen\n```\n\n```text\nseen\n```\n"
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(Reader(SAMARA, folder, LONGEST).walk(self, page), 1)

    def test_a_wrong_exit_code_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(AssertionError):
                Reader(SAMARA, folder, LONGEST).walk(self, "```sh\nfalse\n```\n")
            Reader(SAMARA, folder, LONGEST).walk(self, "```sh\nsamara models nonsense  # exit code 2\n```\n")


if __name__ == "__main__":
    main()
