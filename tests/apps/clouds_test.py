"""Usage: clouds_test.py SAMARA [CLASS]

Many flights of one release in turbulence, as docs/turbulence.md says.
"""

import csv
import io
import json
import pathlib
import re
import shlex
import signal
import subprocess
import time
import xml.dom.minidom

import h5py
import numpy as np

from samara_case import FOLDER, LINE_PLAN, LONGEST, SAMARA, Case, book, main, run, run_with_files_of_at_most, write

PAGE = (pathlib.Path(__file__).resolve().parents[2] / "docs" / "turbulence.md").read_text()
CARD = ["immersed_body_in_gusts", *(f"--set={word}" for word in (
    "a=3.5cm", "b=2cm", "c=0.1mm", "density=1200", "C_D0=0.05", "C_D90=0.61", "C_T=1.81", "C_R=1.21", "C_w=2", "z(0)=2"))]
GUSTS = ["--turbulence", "uniform", "deviation=0.3", "scale=0.5"]


def cloud(*words):
    return run("simulate", *CARD, *GUSTS, *words)


class Clouds(Case):
    def test_the_line_of_the_page_runs_and_says_what_the_page_says(self):
        line, = [line for line in PAGE.replace("\\\n", "").splitlines()
                 if line.startswith("samara simulate immersed_body_in_gusts") and "--turbulence" in line]
        result = subprocess.run([SAMARA, *shlex.split(line)[1:]], cwd=FOLDER, capture_output=True, text=True, timeout=LONGEST)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("1000 realisations in uniform turbulence, k = 0.135 m^2/s^2", result.stderr)
        # Tumbling makes much of the last digits of a machine's functions: then it is another sample.
        (said, error), (found, _) = (map(float, re.search(r"x = ([0-9.]+) \+-\s+([0-9.]+)", text).groups()) for text in (PAGE, result.stderr))
        self.assertAlmostEqual(found, said, delta=5 * error)
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

    def test_an_interrupted_cloud_goes_on_to_the_same_bits(self):
        def line(path):
            return ["simulate", *CARD, *GUSTS, "--realisations", 12000, "--until", 0.5, "--frames", 3, "--step", "2 ms", "-o", path]
        path, whole = FOLDER / "parts.h5", FOLDER / "whole.h5"
        kept = FOLDER / "parts.h5.checkpoint"
        begun = subprocess.Popen([SAMARA, *map(str, line(path))], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while begun.poll() is None and not kept.exists():
            time.sleep(0.002)
        begun.send_signal(signal.SIGINT)
        _, said = begun.communicate(timeout=LONGEST)
        self.assertEqual(begun.returncode, 130, said)
        self.assertIn("parts.h5.checkpoint keeps what is done", said)
        with h5py.File(path) as file:
            self.assertLess(file.attrs["realisations"], 12000)
        resumed = run(*line(path))
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        self.assertRegex(resumed.stderr, r"parts.h5.checkpoint holds \d+ realisations of this call")
        self.assertFalse(kept.exists())
        self.assertEqual(run(*line(whole)).returncode, 0)
        with h5py.File(path) as one, h5py.File(whole) as other:
            for name in ["mean", "mean_error", "covariance", "covariance_error", "half_turns", "flying"]:
                np.testing.assert_array_equal(one[name][:], other[name][:])

    def test_a_cloud_whose_files_cannot_be_written_keeps_its_checkpoint(self):
        def line(path, picture):
            return ["simulate", *CARD, *GUSTS, "--realisations", 1536, "--until", 0.5, "--frames", 3, "--step", "2 ms", "-o", path, "--picture", picture]
        path, whole, picture = FOLDER / "full.h5", FOLDER / "not_full.h5", FOLDER / "full.svg"
        kept = FOLDER / "full.h5.checkpoint"
        drawn = run(*line(path, "/dev/full"))
        self.assertEqual(drawn.returncode, 2, drawn.stderr)
        self.assertIn('cannot write "/dev/full"', drawn.stderr)
        self.assertTrue(kept.exists())
        path.unlink()  # it came before the picture
        written = run_with_files_of_at_most(1000, *line(path, picture))
        self.assertEqual(written.returncode, 2, written.stderr)
        self.assertIn("File too large", written.stderr)
        self.assertFalse(picture.exists())
        self.assertTrue(kept.exists())
        resumed = run(*line(path, picture))
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        self.assertRegex(resumed.stderr, r"full.h5.checkpoint holds \d+ realisations of this call")
        self.assertFalse(kept.exists())
        self.assertEqual(run(*line(whole, picture)).returncode, 0)
        with h5py.File(path) as one, h5py.File(whole) as other:
            for name in ["mean", "mean_error", "covariance", "half_turns", "flying"]:
                np.testing.assert_array_equal(one[name][:], other[name][:])

    def test_an_interrupted_cloud_is_told_before_flights_that_are_no_numbers(self):
        # So much drag that steps of 2 ms end in no numbers, and so many flights that they do not end by themselves.
        wild = ["simulate", *(word.replace("C_D90=0.61", "C_D90=1e6") for word in CARD), *GUSTS, "--realisations", 4000000, "--until", 0.5,
                "--frames", 3, "--step", "2 ms"]
        kept = FOLDER / "wild.h5.checkpoint"
        begun = subprocess.Popen([SAMARA, *map(str, wild), "-o", FOLDER / "wild.h5"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while begun.poll() is None and not kept.exists():
            time.sleep(0.002)
        begun.send_signal(signal.SIGINT)
        _, said = begun.communicate(timeout=LONGEST)
        self.assertEqual(begun.returncode, 130, said)
        self.assertIn("not_finite", said)
        # Without a file to write, another one's checkpoint is none of it.
        write(".checkpoint", "")
        begun = subprocess.Popen([SAMARA, *map(str, wild)], cwd=FOLDER, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(0.5)
        begun.send_signal(signal.SIGINT)
        _, said = begun.communicate(timeout=LONGEST)
        self.assertIn(begun.returncode, (130, -signal.SIGINT), said)  # the latter if it had not begun
        self.assertNotIn("checkpoint", said)

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
        self.assertEqual(as_json["schema"], "samara-cloud/1")
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

    def test_files_say_what_was_flown(self):
        words = ["--realisations", 4, "--until", 0.1, "--frames", 2, "--ground", -5, "--C0", 2.1]
        cloud(*words, "-o", FOLDER / "said.h5")
        as_json = json.loads(cloud(*words, "--json").stdout)
        with h5py.File(FOLDER / "said.h5") as file:
            values = dict(zip(file["value_names"].asstr()[:], file["values"][:]))
            self.assertEqual(file.attrs["ground"], -5)
            self.assertEqual(file.attrs["C_0"], b"2.1")
            self.assertEqual(file.attrs["cancelled"], 0)
            self.assertTrue(file.attrs["generator"].startswith(b"samara "))
            self.assertAlmostEqual(file.attrs["body_radius"], (0.035 * 0.02)**0.5)
        self.assertEqual((values["a"], values["z(0)"], values["C_R"]), (0.035, 2.0, 1.21))
        self.assertEqual(as_json["values"]["density"], 1200)
        self.assertEqual((as_json["ground"], as_json["C_0"], as_json["cancelled"]), (-5, "2.1", False))

    def test_a_plate_in_water_has_the_constant_of_water(self):
        words = ["--set", "semi_chord=0.02", "--set", "semi_thickness=0.002", "--set", "density=1500", "--set", "nu=1e-6", *GUSTS,
                 "--realisations", 2, "--until", 0.2, "--frames", 2]
        in_water = run("simulate", "falling_plate_in_gusts", *words)
        k = 1.5 * 0.3**2
        epsilon = 0.43 * k**1.5 / 0.5
        Re = (20 / 3)**0.5 * k / (1.0e-6 * epsilon)**0.5
        by_hand = run("simulate", "falling_plate_in_gusts", *words, "--C0", repr(6.5 * (1 + 140 * Re**(-4 / 3))**-0.75))
        self.assertEqual(in_water.returncode, 0, in_water.stderr)
        rows = [[[float(word) for word in row] for row in list(csv.reader(io.StringIO(answer.stdout)))[1:]] for answer in (in_water, by_hand)]
        np.testing.assert_allclose(rows[0], rows[1], rtol=1e-9)

    def test_pictures_of_far_away_places_and_of_other_states_come_to_an_end(self):
        words = ["--realisations", 3, "--until", 0.1, "--frames", 3]
        far = cloud(*words, "--set", "x(0)=1e16", "--picture", FOLDER / "far.svg")
        self.assertEqual(far.returncode, 0, far.stderr)
        other = cloud(*words, *(f"--states={name}" for name in ("x", "ux", "wx")), "--picture", FOLDER / "other.svg")
        self.assertEqual(other.returncode, 0, other.stderr)
        for name, has_mean in (("far", True), ("other", False)):
            picture = xml.dom.minidom.parse(str(FOLDER / f"{name}.svg"))
            words = [text.firstChild.data for text in picture.getElementsByTagName("text") if text.firstChild]
            self.assertEqual("mean" in words, has_mean, name)
            paths = picture.getElementsByTagName("path")
            flown = [path for path in paths if path.getAttribute("stroke") == "#56b4e9" and path.getAttribute("fill") == "none"]
            self.assertEqual(len(flown), 3)
            self.assertLess(len(paths), 60)

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


class Wakes(Case):
    """Cards that fall through the wake of a plate."""

    @classmethod
    def setUpClass(cls):
        cls.wake, cls.still = FOLDER / "wake.h5", FOLDER / "laminar.h5"
        plan = ('[flow]\nshape = {{ kind = "rectangle", length = 1, thickness = 1 }}\nreynolds = {}\nturbulence = "{}"\n'
                'cells_per_length = 6\nextent = {{ before = 3, behind = 6, side = 3 }}\nend = "{}"\nmax_time = 2\n')
        for path, words in [(cls.wake, (20000, "k-epsilon", "mean")), (cls.still, (30, "none", "steady"))]:
            result = run("flow", write(f"{path.stem}.toml", plan.format(*words)), "-o", path)
            assert result.returncode == 4, result.stderr  # not settled, and written all the same

    def fly(self, *words, until=0.4):
        return run("simulate", *CARD[:-1], "--flow", self.wake, "--speed", "2 m/s", "--length", "0.5 m", "--set=z(0)=0.6", "--set=x(0)=0.8",
                   "--until", until, "--frames", 5, "--realisations", 64, *words)

    def test_the_mean_flow_carries_and_the_energy_scatters(self):
        path = FOLDER / "through.h5"
        result = self.fly("--seed", 3, "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("at 2 m/s and 0.5 m", result.stderr)
        with h5py.File(path) as file:
            self.assertGreater(file["mean"][-1, 0], 0.85)
            self.assertGreater(file["covariance"][-1, 0, 0], 1e-8)
        again = FOLDER / "again.h5"
        self.fly("--seed", 3, "-o", again)
        with h5py.File(path) as one, h5py.File(again) as other:
            np.testing.assert_array_equal(one["mean"][:], other["mean"][:])

    def test_the_place_of_the_flow_moves_all_of_it(self):
        near = self.fly("--json")
        far = run("simulate", *CARD[:-1], "--flow", self.wake, "--speed", 2, "--length", "50 cm", "--flow-place", "100 m, 0, 7",
                  "--set=z(0)=7.6", "--set=x(0)=100.8", "--until", 0.4, "--frames", 5, "--realisations", 64, "--json")
        one, other = (np.array([t["mean"] for t in json.loads(r.stdout)["times"]]) for r in (near, far))
        np.testing.assert_allclose(other - one, np.tile([100, 0, 7], (5, 1)), atol=1e-6)

    def test_a_body_that_leaves_the_grid_says_so(self):
        result = self.fly(until=3)
        self.assertRegex(result.stderr, r"\d+ left_flow")

    def test_beyond_the_grid_the_stream_goes_on_if_it_is_asked_for(self):
        ended, went_on = (json.loads(self.fly("--outside", what, "--json", until=3).stdout) for what in ("end", "stream"))
        self.assertEqual(json.loads(self.fly("--json", until=3).stdout), ended)
        self.assertGreater(ended["status"]["left_flow"], 0)
        self.assertEqual((went_on["status"]["left_flow"], went_on["times"][-1]["flying"]), (0, 64))
        self.assertIn("in the stream beyond its grid", went_on["air"])
        # The stream carries the cards on, at 2 m/s or so, and its own energy scatters them.
        before, after = went_on["times"][-2:]
        speed = (after["mean"][0] - before["mean"][0]) / (after["t"] - before["t"])
        self.assertAlmostEqual(speed, 2, delta=0.7)
        self.assertGreater(after["covariance"][0][0], before["covariance"][0][0])
        self.check_error(self.fly("--outside", "sea"), 2, "--outside is sea, expected end or stream")
        self.check_error(cloud("--realisations", 4, "--outside", "stream"), 2, "--outside", "are of --flow")

    def test_a_flow_that_was_not_finished_is_said_to_be_none(self):
        self.assertRegex(self.fly().stderr, r"warning: --flow: .*wake\.h5 was not finished: .* at max_time, 2 l/U")

    def test_a_flow_in_space_is_none_for_a_plate_in_a_plane(self):
        path = FOLDER / "space.h5"
        plan = write("space.toml", '''[flow]
dimensions = 3
shape = { kind = "box", length = 1, thickness = 1, width = 1 }
reynolds = 20000
cells_per_length = 4
extent = { before = 2, behind = 2, side = 2 }
max_time = 0.2
''')
        self.assertEqual(run("flow", plan, "-o", path).returncode, 4)
        plate = ["falling_plate_in_gusts", "--set=semi_chord=2cm", "--set=semi_thickness=0.2mm", "--set=density=1200"]
        result = run("simulate", *plate, "--flow", path, "--speed", 1, "--length", 1, "--realisations", 4)
        self.check_error(result, 2, "is a flow in space", "moves in a plane")

    def test_wrong_words_are_refused(self):
        for words, parts in [(("--flow", self.still, "--speed", 1, "--length", 1), ("laminar", "k-epsilon")),
                             (("--flow", self.wake), ("--speed",)),
                             (("--flow", self.wake, "--speed", 0, "--length", 1), ("--speed is 0", "more than 0")),
                             (("--flow", self.wake, "--speed", 1, "--length", 1, "--flow-place", "1, 2"), ("--flow-place", "x, y, z")),
                             (("--flow", self.wake, "--speed", 1, "--length", 1, *GUSTS), ("another fluid",))]:
            self.check_error(run("simulate", *CARD, "--realisations", 4, *words), 2, *parts)
        self.check_error(run("simulate", *CARD, "--realisations", 4, "--flow", FOLDER / "none.h5", "--speed", 1, "--length", 1), 3, "none.h5")


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
        self.refused([*ten, "-o", FOLDER / "cloud.txt"], "expected a name that ends in .csv, .h5, .glb or .usda")
        self.refused([*ten, "--keep", 3, "-o", FOLDER / "cloud.csv"], "trajectories go into a file that ends in .h5")
        self.refused([*ten, "--keep", 3], "trajectories go into a file that ends in .h5")
        self.refused([*ten, "--keep", -3, "-o", FOLDER / "cloud.h5"], "--keep is -3, expected a whole number from 0 on")
        self.refused([*ten, "--picture", FOLDER / "cloud.png"], "expected a name that ends in .svg")
        self.refused([*ten, "--first", 2**62], "first is 4611686018427387904; at most 4503599627370496 was expected")

    def test_wrong_words_are_named_before_the_checkpoint_of_another_call(self):
        kept = write("refused.h5.checkpoint", "of another call")
        ten = ["--realisations", 10, "-o", FOLDER / "refused.h5"]
        wrong = [(["--states", "speed"], 'has no state "speed"'), (["--ground", 3], "expected below the start"),
                 (["--first", 3, "--antithetic"], "an even number"), (["--set", "gust_x=1"], "gust_x was given a value")]
        for words, sentence in wrong:
            self.refused([*ten, *words], sentence)  # in the only line of stderr
        self.assertEqual(kept.read_text(), "of another call")
        kept.unlink()
        kept.mkdir()
        for words, sentence in wrong:
            self.refused([*ten, *words], sentence)
        self.check_error(cloud(*ten, "--until", 0.1), 3, "refused.h5.checkpoint", "is a folder")

    def test_no_file_of_another_kind_is_lost_to_a_cloud(self):
        for path in (book("line", LINE_PLAN), write("notes.h5", "mine")):
            before = path.read_bytes()
            self.refused(["--realisations", 10, "-o", path], "and no cloud: it would be overwritten")
            self.assertEqual(path.read_bytes(), before)

    def test_more_than_memory_holds(self):
        self.refused(["--realisations", 100000, "--keep", 100000, "--frames", 10001, "-o", FOLDER / "cloud.h5"], "which would take 104")
        self.refused(["--realisations", 10, "--frames", 2900000], "frames were expected")

    def test_flows_that_are_none(self):
        ten = ["--realisations", 10]
        self.refused(ten, "without a flow that differs between them: --turbulence, --flow or --wind was expected", CARD)
        for words, sentence in ((["swirling", "k=1"], "expected uniform or decaying"),
                                (["k=1"], "neither of epsilon and scale"),
                                (["k=1", "deviation=1", "epsilon=1"], "both of k and deviation"),
                                (["k=-1", "epsilon=1"], "k is -1 m^2/s^2, expected 0 or more"),
                                (["k=1", "epsilon=0"], "epsilon is 0 m^2/s^3, expected more than 0"),
                                (["k=nan", "epsilon=1"], "--turbulence: k is nan, expected a finite number"),
                                (["k=1", "epsilon=1", "k"], 'does not take "k" as well'),
                                (["k=1", "epsilon=1", "wind=2"], '--turbulence: unknown name "wind"')):
            self.refused([*ten, "--turbulence", *words], sentence, CARD)

    def test_words_of_another_kind_of_run(self):
        self.refused([], "--turbulence is of realisations: --realisations was expected")
        for words in (["--ground", 0], ["--seed", 3], ["--first", 3], ["--threads", 1], ["--keep", 3]):
            self.refused(words, f"{words[0]} is of realisations", CARD)
        self.refused(["--realisations", 10, "--forces"], "--forces is of single trajectories")
        self.refused(["--realisations", 10, "--integrator", "adaptive"], "--integrator is adaptive: realisations take steps of rk4")
        self.refused([*GUSTS, "--realisations", 10], "it cannot fly through gusts", ["immersed_body", *CARD[1:]])


if __name__ == "__main__":
    main()
