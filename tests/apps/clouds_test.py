"""Usage: clouds_test.py SAMARA [CLASS]

Many flights of one release in turbulence, as docs/flow.md says.
"""

import csv
import io
import json
import pathlib
import re
import shlex
import subprocess
import xml.dom.minidom

import h5py
import numpy as np

from samara_case import FOLDER, LONGEST, SAMARA, Case, main, run

PAGE = (pathlib.Path(__file__).resolve().parents[2] / "docs" / "flow.md").read_text()
CARD = ["immersed_body_in_gusts", *(f"--set={word}" for word in (
    "a=3.5cm", "b=2cm", "c=0.1mm", "density=1200", "C_D0=0.05", "C_D90=0.61", "C_T=1.81", "C_R=1.21", "C_w=2", "z(0)=2"))]
GUSTS = ["--turbulence", "uniform", "deviation=0.3", "scale=0.5"]


def cloud(*words):
    return run("simulate", *CARD, *GUSTS, *words)


class Clouds(Case):
    def test_the_line_of_the_page_runs_and_says_what_the_page_says(self):
        line, = [line for line in PAGE.splitlines() if line.startswith("samara simulate immersed_body_in_gusts") and "--turbulence" in line]
        result = subprocess.run([SAMARA, *shlex.split(line)[1:]], cwd=FOLDER, capture_output=True, text=True, timeout=LONGEST)
        self.assertEqual(result.returncode, 0, result.stderr)
        summary, = [line for line in PAGE.splitlines() if line.startswith("1000 realisations in uniform")]
        number = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
        self.assertEqual(number.sub("#", result.stderr.strip()), number.sub("#", summary))
        # Tumbling makes much of the last digits of a machine's functions: then it is another sample.
        for (said, error), (found, _) in zip(*(re.findall(r"(\S+) \+- ([0-9.]+)", text) for text in (summary, result.stderr))):
            self.assertAlmostEqual(float(found), float(said), delta=5 * float(error))
        with h5py.File(FOLDER / "cloud.h5") as file:
            self.assertEqual(file.attrs["format"], b"samara-cloud")
            landings = file["landings"][:]
            self.assertEqual(landings.shape, (1000, 5))
            self.assertEqual(file["kept"].shape, (20, 101, 13))
            np.testing.assert_allclose(landings[:, 4], 0.0, atol=1e-12)
            # Kept trajectories are those of the statistics: the cloud starts at one place.
            np.testing.assert_allclose(file["mean"][0], [0, 0, 2], atol=1e-15)
            self.assertEqual(file["flying"][0], 1000)
            self.assertEqual({status for status in file["status"][:]}, {b"landed"})
            np.testing.assert_allclose(file["covariance"][1], file["covariance"][1].T, rtol=0)
        picture = xml.dom.minidom.parse(str(FOLDER / "cloud.svg"))
        self.assertEqual(len(picture.getElementsByTagName("circle")), 1000)

    def test_statistics_are_those_of_the_kept_trajectories(self):
        path = FOLDER / "all.h5"
        self.assertEqual(cloud("--realisations", 200, "--keep", 200, "--until", 1, "--frames", 5, "-o", path).returncode, 0)
        with h5py.File(path) as file:
            places = file["kept"][:, :, :3]
            np.testing.assert_allclose(file["mean"][:], places.mean(0), rtol=1e-12, atol=1e-15)
            deviation = places.std(0, ddof=1)
            np.testing.assert_allclose(file["mean_error"][:], deviation / np.sqrt(200), rtol=1e-10, atol=1e-15)
            np.testing.assert_allclose(file["covariance"][4], np.cov(places[:, 4].T), rtol=1e-10)
        answer = cloud("--realisations", 200, "--until", 1, "--frames", 5)
        rows = list(csv.DictReader(io.StringIO(answer.stdout)))
        np.testing.assert_allclose([float(row["x.deviation[m]"]) for row in rows], deviation[:, 0], rtol=1e-10, atol=1e-15)
        as_json = json.loads(cloud("--realisations", 200, "--until", 1, "--frames", 5, "--json").stdout)
        np.testing.assert_allclose(as_json["times"][4]["mean_error"], deviation[4] / np.sqrt(200), rtol=1e-10)
        self.assertEqual(as_json["status"], {"flying": 200, "landed": 0, "left_flow": 0, "not_finite": 0})

    def test_a_seed_is_a_sample_and_a_realisation_can_be_seen_again(self):
        words = ["--realisations", 64, "--until", 0.5, "--frames", 3]
        first = cloud(*words).stdout
        self.assertEqual(cloud(*words, "--threads", 1).stdout, first)
        self.assertNotEqual(cloud(*words, "--seed", 2).stdout, first)
        for name, which in (("many", ["--realisations", 20, "--keep", 20]), ("one", ["--realisations", 1, "--first", 17, "--keep", 1])):
            cloud(*which, "--until", 0.5, "--frames", 3, "-o", FOLDER / f"{name}.h5")
        with h5py.File(FOLDER / "many.h5") as many, h5py.File(FOLDER / "one.h5") as one:
            self.assertTrue((many["kept"][17] == one["kept"][0]).all())

    def test_without_energy_the_stream_only_carries_the_body_that_moves_with_it(self):
        still = run("simulate", "sphere_flight", "--until", 0.5, "--frames", 3, "--integrator", "rk4", "--step", 1e-3)
        moved = run("simulate", "sphere_flight_in_gusts", "--until", 0.5, "--frames", 3, "--set", "vx(0)=2", "--realisations", 2,
                    "--turbulence", "k=0", "epsilon=1", "stream_x=2")
        at_rest = list(csv.DictReader(io.StringIO(still.stdout)))
        carried = list(csv.DictReader(io.StringIO(moved.stdout)))
        for a, b in zip(at_rest, carried):
            self.assertAlmostEqual(float(b["z.mean[m]"]), float(a["z[m]"]), delta=1e-10)
            self.assertAlmostEqual(float(b["x.mean[m]"]), 2 * float(a["t[s]"]), delta=1e-10)

    def test_pairs_and_early_stops_are_told(self):
        pairs = json.loads(cloud("--realisations", 64, "--antithetic", "--until", 0.3, "--frames", 2, "--json").stdout)
        self.assertTrue(pairs["antithetic"])
        stopped = json.loads(cloud("--realisations", 4096, "--relative-error", 0.05, "--until", 0.3, "--frames", 2, "--json").stdout)
        self.assertLess(stopped["realisations"], 4096)
        self.assertLessEqual(stopped["relative_error"], 0.05)

    def test_long_steps_are_warned_of_with_a_step_that_would_do(self):
        result = run("simulate", *CARD, "--turbulence", "k=1", "epsilon=20", "--realisations", 8, "--until", 1, "--frames", 11, "--step", 0.005)
        self.assertEqual(result.returncode, 0)
        self.assertRegex(result.stderr, r"warning: \d+ % of the steps of 0\.005 s are longer than 0\.3 of the time .* --step [0-9.e-]+ would do")


class BadClouds(Case):
    def refused(self, words, sentence, start=(*CARD, *GUSTS)):
        result = run("simulate", *start, *words)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertIn(sentence, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1)

    def test_numbers_outside_their_meaning(self):
        ten = ["--realisations", 10]
        self.refused(["--realisations", 0], "--realisations is 0, expected a whole number from 1 on")
        self.refused([*ten, "--seed", -1], "--seed is -1, expected a whole number from 0 on")
        self.refused([*ten, "--step", 0], "--step is 0, expected more than 0")
        self.refused([*ten, "--ground", 3], "expected below the start")
        self.refused([*ten, "--states", "speed"], 'has no state "speed"')
        self.refused([*ten, "--body-radius", -1], "--body-radius is -1, expected 0 or more")
        self.refused([*ten, "--set", "gust_x=1"], "gust_x was given a value; realisations set it step by step")
        self.refused([*ten, "--relative-error", 0], "--relative-error is 0, expected more than 0")
        self.refused(["--realisations", 3, "--antithetic"], "an even number")
        self.refused([*ten, "-o", FOLDER / "cloud.txt"], "expected a name that ends in .csv or .h5")
        self.refused([*ten, "--keep", 3, "-o", FOLDER / "cloud.csv"], "trajectories go into a file that ends in .h5")

    def test_more_than_memory_holds(self):
        self.refused(["--realisations", 100000, "--keep", 100000, "--frames", 10001], "which would take 104")
        self.refused(["--realisations", 10, "--frames", 2900000], "frames were expected")

    def test_flows_that_are_none(self):
        ten = ["--realisations", 10]
        self.refused(ten, "without a flow that differs between them: --turbulence or --wind was expected", CARD)
        for words, sentence in ((["swirling", "k=1"], "expected uniform or decaying"),
                                (["k=1"], "neither of epsilon and scale"),
                                (["k=1", "deviation=1", "epsilon=1"], "both of k and deviation"),
                                (["k=-1", "epsilon=1"], "k is -1 m^2/s^2, expected 0 or more"),
                                (["k=1", "epsilon=0"], "epsilon is 0 m^2/s^3, expected more than 0"),
                                (["k=nan", "epsilon=1"], "k is nan, expected a finite number"),
                                (["k=1", "epsilon=1", "wind=2"], "wind")):
            self.refused([*ten, "--turbulence", *words], sentence, CARD)

    def test_words_of_another_kind_of_run(self):
        self.refused([], "--turbulence is of realisations: --realisations was expected")
        self.refused(["--ground", 0], "--ground is of realisations", CARD)
        self.refused(["--realisations", 10, "--forces"], "--forces is of single trajectories")
        self.refused(["--realisations", 10, "--integrator", "adaptive"], "--integrator is adaptive: realisations take steps of rk4")
        self.refused([*GUSTS, "--realisations", 10], "it cannot fly through gusts", ["immersed_body", *CARD[1:]])


if __name__ == "__main__":
    main()
