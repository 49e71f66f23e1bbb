"""Usage: wind_test.py SAMARA [CLASS]

Winds from files: a body in one realisation and in many, series at points, and what is refused.
"""

import csv
import io
import math
import pathlib
import re
import shlex
import shutil
import subprocess

from samara_case import FOLDER, LONGEST, SAMARA, Case, main, run, write

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEAF = [word for text in ("a=3.5 cm", "b=2 cm", "c=0.1 mm", "density=700", "C_D90=1.81", "C_D0=0.05", "C_T=0.31", "C_R=0.31",
                          "C_w=2", "z(0)=2 m") for word in ("--set", text)]
MEADOW = '[mean]\nspeed = "4 m/s"\nroughness = "3 cm"\n[turbulence]\nheight = "2 m"\n[series]\nspectrum = "kaimal"\n'


def table(text):
    rows = list(csv.reader(io.StringIO(text)))
    return {name.split("[")[0]: [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}


class Wind(Case):
    def simulate(self, wind, *more, model="immersed_body"):
        result = run("simulate", model, *LEAF, "--wind", wind, *more)
        self.assertEqual(result.returncode, 0, result.stderr)
        return table(result.stdout)

    def test_a_uniform_wind_carries_the_fall_along(self):
        wind = write("uniform.toml", '[mean]\nprofile = "uniform"\nspeed = "3 m/s"\ntowards = "90 deg"\n')
        times = ["--until", "0.5", "--frames", "6"]
        still = table(run("simulate", "immersed_body", *LEAF, *times).stdout)
        carried = self.simulate(wind, *times, "--set", "uy(0)=3")
        for k, t in enumerate(still["t"]):
            self.assertAlmostEqual(carried["y"][k], still["y"][k] + 3.0 * t, delta=1e-8)
            self.assertAlmostEqual(carried["z"][k], still["z"][k], delta=1e-8)

    def test_a_seed_gives_one_path_and_another_seed_another(self):
        wind = write("meadow.toml", MEADOW)
        times = ["--until", "0.6", "--frames", "4"]
        self.assertEqual(self.simulate(wind, *times), self.simulate(wind, *times, "--seed", 1))
        self.assertNotEqual(self.simulate(wind, *times)["x"], self.simulate(wind, *times, "--seed", 2)["x"])
        self.assertGreater(self.simulate(wind, *times)["x"][-1], 0.5)

    def test_a_short_gust_late_in_a_steady_fall_is_not_leapt_over(self):
        # A body that falls straight down takes long steps. A gust of 10 ms carries it half its speed times its length.
        ball = [word for text in ("a=3.5 cm", "b=3.5 cm", "c=3 cm", "density=700", "C_D90=1.81", "C_D0=1.8", "C_T=0.31", "C_R=0.31",
                                  "C_w=2") for word in ("--set", text)]
        ends = {}
        for kind in ("cvodes", "adaptive"):
            for seconds in ("1 s", "10 ms"):
                gust = write("gust.toml", '[mean]\nprofile = "uniform"\nspeed = 0\n[[gusts]]\nvelocity = [0, "3 m/s", 0]\n'
                             f'start = "5.0003 s"\nduration = "{seconds}"\n')
                result = run("simulate", "immersed_body", *ball, "--wind", gust, "--until", 10, "--frames", 2, "--integrator", kind)
                self.assertEqual(result.returncode, 0, result.stderr)
                ends[kind, seconds] = table(result.stdout)["y"][-1]
        self.assertGreater(ends["cvodes", "10 ms"], 0.008)
        self.assertLess(ends["cvodes", "10 ms"], 0.016)
        # The estimate of the adaptive steps' error does not see what depends on time alone (adaptive.h).
        for seconds in ("1 s", "10 ms"):
            self.assertAlmostEqual(ends["adaptive", seconds] / ends["cvodes", seconds], 1.0, delta=1e-3)
        self.assertIn("a gust lasts 0.01 s and steps are of 0.01 s; --step 0.001", run(
            "simulate", "immersed_body", *ball, "--wind", gust, "--until", 6, "--frames", 2, "--integrator", "rk4", "--step", "10 ms").stderr)
        flown = run("simulate", "immersed_body_in_gusts", *ball, "--wind", gust, "--until", 0.1, "--frames", 2, "--realisations", 2,
                    "--step", "5 ms")
        self.assertIn("a gust lasts 0.01 s", flown.stderr)

    def test_a_wind_may_be_a_pipe(self):
        wind = write("gusty.toml", MEADOW + '[[gusts]]\nvelocity = [0, "3 m/s", 0]\nstart = "50 ms"\nduration = "10 ms"\n')
        times = ["--until", 0.1, "--frames", 3]
        for call in (["immersed_body", *LEAF, *times], ["immersed_body", *LEAF, *times, "--integrator", "rk4", "--step", "2 ms"],
                     ["immersed_body_in_gusts", *LEAF, *times, "--realisations", 3, "--step", "2 ms"]):
            named = run("simulate", *call, "--wind", wind)
            piped = subprocess.run([SAMARA, "simulate", *map(str, call), "--wind", "/dev/stdin"], input=wind.read_text(),
                                   capture_output=True, text=True, timeout=LONGEST)
            self.assertEqual(piped.returncode, 0, piped.stderr)
            self.assertEqual(piped.stdout, named.stdout)
            self.assertEqual("a gust lasts 0.01 s" in piped.stderr, "--step" in call)

    def test_a_realisation_converges_to_the_path_of_the_reference_integrator(self):
        wind = write("meadow.toml", MEADOW)
        times = ["--wind", wind, "--seed", 7, "--until", "0.4", "--frames", 3]
        path = table(run("simulate", "immersed_body", *LEAF, *times).stdout)
        errors = []
        for step in ("1e-3", "5e-4", "2.5e-4"):
            one = run("simulate", "immersed_body_in_gusts", *LEAF, *times, "--realisations", 1, "--body-radius", 0, "--step", step)
            self.assertEqual(one.returncode, 0, one.stderr)
            cloud = table(re.sub(r",(?=[,\n])", ",nan", one.stdout))
            errors.append(math.dist([cloud[f"{x}.mean"][-1] for x in "xyz"], [path[x][-1] for x in "xyz"]))
        self.assertLess(errors[0], 5e-5)
        for coarse, fine in zip(errors, errors[1:]):
            self.assertGreater(coarse / fine, 3.0)  # the ramp over a step is of second order

    def test_many_realisations_land_downwind_and_scatter(self):
        wind = write("meadow.toml", MEADOW)
        call = ["simulate", "immersed_body_in_gusts", *LEAF, "--wind", wind, "--until", "3", "--ground", "0", "--step", "2 ms"]
        result = run(*call, "--realisations", 64, "--frames", 4)
        self.assertEqual(result.returncode, 0, result.stderr)
        landed, mean, error = re.search(r"(\d+) landed.* x = ([0-9.]+) \+- ([0-9.]+) m", result.stderr).groups()
        self.assertGreater(int(landed), 32)
        # A fall of some 1.5 s in a wind of 2 to 3 m/s.
        self.assertGreater(float(mean), 2.5)
        self.assertLess(float(mean), 6.0)
        self.assertLess(float(error), 0.5)
        again = run(*call, "--realisations", 64, "--frames", 4, "--threads", 1)
        self.assertEqual(again.stdout, result.stdout)

    def test_fluid_seen_in_the_surface_layer_lands_where_the_field_does(self):
        call = ["simulate", "immersed_body_in_gusts", *LEAF, "--until", "6", "--ground", "0", "--frames", 2, "--step", "2 ms", "--realisations", 256]
        field = run(*call, "--wind", write("meadow.toml", MEADOW))
        seen = run(*call, "--wind", write("seen.toml", MEADOW.replace('height = "2 m"', 'kind = "seen"')), "--C0", 3)
        self.assertEqual(seen.returncode, 0, seen.stderr)
        x = [float(re.search(r" x = ([0-9.]+) \+- ([0-9.]+) m", text.stderr)[1]) for text in (field, seen)]
        # Two models of the same energy: the same within a quarter, not the same.
        self.assertLess(abs(x[1] / x[0] - 1.0), 0.25)
        # Without any turbulence all would land at one place: it scatters them, most where eddies hold together in space.
        for direction, least in (("x", 1.0), ("y", 0.3)):
            of_field, of_seen = [float(re.search(rf" {direction} = \S+ \+- \S+ m \(deviation (\S+) m\)", text.stderr)[1])
                                 for text in (field, seen)]
            self.assertGreater(of_seen, least)
            self.assertLess(of_seen, of_field)

    def test_series_have_the_deviation_of_their_spectrum(self):
        wind, output = write("meadow.toml", MEADOW), FOLDER / "series.csv"
        result = run("wind", wind, "--at", "0, 0, 2 m", "--at", "0, 50 cm, 2", "--until", "1 h", "--step", "0.1 s", "-o", output)
        self.assertEqual(result.returncode, 0, result.stderr)
        series = table(output.read_text())
        self.assertEqual(len(series["t"]), 36000)
        for point in (1, 2):
            along = series[f"along_{point}"]
            mean = sum(along) / len(along)
            deviation = math.sqrt(sum((u - mean) ** 2 for u in along) / len(along))
            said = re.search(rf"^{point} +along +([0-9.]+) +([0-9.]+) +([0-9.]+)$", result.stdout, re.M)
            self.assertAlmostEqual(float(said[1]), mean, delta=1e-3)
            self.assertAlmostEqual(float(said[2]), deviation, delta=1e-3)
            # An hour at 2.9 m/s passes some thousand lengths of 8 m: 3 % of a deviation.
            self.assertAlmostEqual(deviation / float(said[3]), 1.0, delta=0.12)

    def test_a_file_is_explained(self):
        result = run("wind", write("meadow.toml", MEADOW))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("u_star 0.2754 m/s", result.stdout)
        self.assertRegex(result.stdout, r"200 modes, sigma 0\.4767 m/s, L 3\.277 m")
        small = run("wind", write("small.toml", MEADOW.replace('"2 m"', '"2 m"\nlongest = "5 cm"')))
        self.assertIn("waves from 0.025 m (for a body of that length) to 0.05 m", small.stdout)


class BadWinds(Case):
    def check_file(self, text, *parts):
        self.check_error(run("wind", write("bad.toml", text)), 3, "bad.toml", *parts)

    def test_profiles(self):
        mean = '[mean]\nspeed = "4 m/s"\n'
        self.check_file(mean + 'height = "2 m"\nroughness = "2 m"\n', "[mean] roughness", "2 m, expected more than")
        self.check_file(mean + 'roughness = "0 m"\n', "[mean] roughness", "is 0 m; more than 0 was expected")
        self.check_file(mean + 'roughness = "-3 cm"\n', "is -0.03 m; more than 0 was expected")
        self.check_file(mean + "roughness = nan\n", "[mean] roughness", "nan")
        self.check_file(mean + 'height = "3 s"\n', "[mean] height")
        self.check_file('[mean]\nspeed = "-4 m/s"\n', "[mean] speed", "is -4 m/s, expected at least 0")
        self.check_file(mean + 'roughnes = "3 cm"\n', "roughnes", "roughness")
        self.check_file(mean + 'profile = "logaritmic"\n', "logarithmic")
        self.check_file(mean + 'profile = "power"\nroughness = "3 cm"\n', "roughness")
        self.check_file(mean + 'profile = "power"\nexponent = 0\n', "[mean] exponent")
        self.check_file("[turbulence]\n", "mean")

    def test_turbulence_gusts_and_series(self):
        mean = '[mean]\nspeed = "4 m/s"\n'
        uniform = mean + 'profile = "uniform"\n'
        self.check_file(mean + "[turbulence]\nmodes = 0\n", "[turbulence] modes", "is 0, expected 1 to 100000")
        self.check_file(mean + '[turbulence]\nheight = "2 cm"\n', "[turbulence] height", "0.02 m")
        self.check_file(mean + '[turbulence]\nheight = "2 cm"\nsigma = 1\nlength = 3\n', "[turbulence] height", "0.02 m")
        self.check_file(mean + "[turbulence]\nsigma = inf\n", "[turbulence] sigma")
        self.check_file(mean + '[turbulence]\nshortest = "2 m"\nlongest = "1 m"\n', "[turbulence] longest")
        self.check_file(uniform + "[turbulence]\n", '"sigma" is missing')
        self.check_file(uniform + '[turbulence]\nsigma = "1 m/s"\n', '"length" is missing')
        self.check_file(mean + "[[gusts]]\nvelocity = [1, 0]\nduration = 1\n", "velocity", "has 2 numbers, expected 3")
        self.check_file(mean + "[[gusts]]\nvelocity = [1, 0, 0]\nduration = 0\n", "duration", "is 0 s; more than 0 was expected")
        self.check_file(mean + "[[gusts]]\nvelocity = [1, 0, nan]\nduration = 1\n", "velocity")
        self.check_file(mean + "[[gusts]]\nvelocity = [1, 0, 0]\nduration = 1\ntravel = [0, 0, 0]\n", "travel", "everywhere at once")
        self.check_file(mean + '[[gusts]]\nvelocity = [1, 0, 0]\nduration = 1\nshape = "cosine"\n', "one_minus_cosine")
        self.check_file(mean + "[turbulence]\nratios = [1, 0]\n", "[turbulence] ratios")
        self.check_file(mean + '[turbulence]\nkind = "seen"\nmodes = 3\n', "modes")
        self.check_file(uniform + '[turbulence]\nkind = "seen"\n', "logarithmic")
        self.check_file(mean + '[turbulence]\nkind = "seen"\n[[gusts]]\nvelocity = [1, 0, 0]\nduration = 1\n', "[[gusts]]")
        self.check_file(mean + "[series]\n", "sigma")
        self.check_file(mean + '[series]\nspectrum = "kaimal"\nsigma = 1\n', "sigma")
        self.check_file(uniform + '[series]\nspectrum = "kaimal"\n', "spectrum", "logarithmic")

    def test_calls(self):
        wind = write("meadow.toml", MEADOW)
        self.check_error(run("simulate", "falling_plate", "--wind", wind), 2, "immersed_body", "falling_plate")
        self.check_error(run("simulate", "immersed_body_in_gusts", *LEAF, "--wind", wind), 2, '"immersed_body", or with --realisations')
        ball = ["--set", "z(0)=1", "--wind", wind, "--realisations", 2, "--until", 0.1]
        self.check_error(run("simulate", "sphere_flight_in_gusts", *ball, "--body-radius", "2 cm"), 2, "is no flat one")
        self.assertEqual(run("simulate", "sphere_flight_in_gusts", *ball).returncode, 0)
        self.check_error(run("simulate", "immersed_body", *LEAF, "--wind", wind, "--seed", -1), 2, "--seed", "-1")
        calm = write("calm.toml", '[mean]\nspeed = "4 m/s"\n')
        self.check_error(run("simulate", "immersed_body", *LEAF, "--until", 0.1, "--frames", 2, "--wind", calm, "--seed", 5), 2,
                         f"--seed draws turbulence, and {calm} holds none")
        self.check_error(run("simulate", "immersed_body", *LEAF, "--wind", FOLDER / "none.toml"), 3, "does not exist")
        self.check_error(run("wind", wind, "--at", "0, 0", "-o", FOLDER / "s.csv"), 2, "--at", "3 were expected")
        self.check_error(run("wind", wind, "--at", "0, 0, -1", "-o", FOLDER / "s.csv"), 2, "height of point 1")
        self.check_error(run("wind", wind, "--at", "0, 0, 0.02", "-o", FOLDER / "s.csv"), 2, "mean wind at point 1")
        self.check_error(run("wind", wind, "--at", "0, 0, 2", "--step", "0", "-o", FOLDER / "s.csv"), 2, "--step is 0")
        self.check_error(run("wind", wind, "--at", "0, 0, 2", "--until", "0.1", "-o", FOLDER / "s.csv"), 2, "expected 4 to 6666666 steps at 1 point")
        two = ["--at", "0, 0, 2", "--at", "0, 1, 2", "--step", "1 ms", "-o", FOLDER / "s.csv"]
        self.check_error(run("wind", wind, *two, "--until", "3334 s"), 2, "3.334e+06 steps of 0.001 s; expected 4 to 3333333 steps at 2 points")
        self.check_error(run("wind", write("still.toml", '[mean]\nspeed = "4 m/s"\n'), "--at", "0, 0, 2", "-o", FOLDER / "s.csv"), 3,
                         "holds no [series]")
        seen = write("seen.toml", MEADOW.replace('height = "2 m"', 'kind = "seen"'))
        self.check_error(run("simulate", "immersed_body", *LEAF, "--wind", seen), 3, "--realisations was expected")
        self.check_error(run("simulate", "immersed_body_in_gusts", *LEAF, "--wind", wind, "--realisations", 10, "--C0", 3), 2, "--C0")
        both = ["--realisations", 10, "--wind", wind, "--turbulence", "uniform"]
        self.check_error(run("simulate", "immersed_body_in_gusts", *LEAF, *both), 2, "--turbulence", "--wind")


if __name__ == "__main__":
    main()
