"""Usage: animation_test.py SAMARA CLASS

The animations that `samara query` and `samara simulate` write, read back by nothing but their specifications and compared
with the CSV of the same call. The official validator (npm: gltf-validator) is asked where SAMARA_NODE_MODULES leads to it.
"""

import csv
import math
import re

import h5py
import numpy as np

from glb_file import Glb, issues, y_up
from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write

CARD = ["--set", "a=0.035", "--set", "b=0.02", "--set", "c=1e-4", "--set", "density=1200", "--set", "C_D0=0.05",
        "--set", "C_D90=0.61", "--set", "C_T=2.71", "--set", "C_R=0.91", "--set", "C_w=2", "--set", "speed_floor=1e-3",
        "--set", "wy(0)=25", "--set", "wz(0)=5", "--until", "1.5"]
PLATE = ["--set", "inertia_ratio=3", "--set", "w(0)=2", "--set", "vx(0)=0.3", "--until", "20"]


def columns(*arguments):
    """The CSV of a call: times, and columns by name."""
    result = run(*arguments)
    assert result.returncode == 0, result.stderr
    rows = list(csv.reader(result.stdout.splitlines()))
    table = np.array(rows[1:], float)
    return table[:, 0], {re.sub(r"\[.*", "", name): table[:, k] for k, name in enumerate(rows[0])}


def written(*arguments, name="motion.glb"):
    path = FOLDER / name
    result = run(*arguments, "-o", path)
    assert result.returncode == 0, result.stderr
    assert result.stdout == ""
    return path


def planar(values):
    """Poses of a plate in its plane, as the documentation of models says: y up, theta from x to the chord."""
    half = 0.5 * values["theta"]
    zero = np.zeros_like(half)
    return (np.stack([values["x"], zero, values["y"]], 1), np.stack([np.cos(half), zero, -np.sin(half), zero], 1))


def spatial(values):
    return (np.stack([values[n] for n in ["x", "y", "z"]], 1), np.stack([values[n] for n in ["qw", "qx", "qy", "qz"]], 1))


class Animations(Case):
    def test_a_turning_card_in_space_is_followed_between_keys(self):
        times, values = columns("simulate", "immersed_body", *CARD, "--frames", "1501")
        glb = Glb(written("simulate", "immersed_body", *CARD))
        glb.check_against(self, times, *spatial(values), size=0.07)
        # It turns several times, so that too few keys would show.
        self.assertGreater(len(glb.channel("rotation")[0]), 300)
        corners, triangles = glb.mesh()
        self.assertEqual(triangles.max() + 1, len(corners))
        np.testing.assert_allclose(np.abs(corners).max(axis=0), [0.035, 1e-4, 0.02], rtol=1e-2)
        extras = glb.json["scenes"][0]["extras"]
        self.assertEqual((extras["model"], extras["parameters"]["C_T"], extras["integrator"]), ("immersed_body", 2.71, "cvodes"))

    def test_a_tumbling_plate_turns_from_x_to_y_which_is_up(self):
        times, values = columns("simulate", "falling_plate_nd", *PLATE, "--frames", "1001")
        self.assertGreater(np.ptp(values["theta"]), 3.5)
        glb = Glb(written("simulate", "falling_plate_nd", *PLATE))
        glb.check_against(self, times, *planar(values), size=2.8)
        place, turn = glb.pose(5.0)
        k = np.argmin(np.abs(times - 5.0))
        np.testing.assert_allclose(place[:2], [values["x"][k], values["y"][k]], atol=3e-3)
        # About the axis that points to the viewer, counter-clockwise.
        self.assertAlmostEqual(abs(turn[3]), abs(np.cos(0.5 * values["theta"][k])), delta=5e-3)
        self.assertAlmostEqual(turn[2] / turn[3], np.tan(0.5 * values["theta"][k]), delta=5e-2)

    def test_a_codebook_gives_the_motion_at_its_parameters(self):
        point = ["--set", "C_D=1.3", "--set", "v(0)=0.2"]
        times, values = columns("query", book("coin", COIN_PLAN), *point, "--at", *(f"{0.4 * k / 40!r}" for k in range(41)))
        glb = Glb(written("query", book("coin", COIN_PLAN), *point))
        depth = values["x"]
        zero = np.zeros_like(depth)
        glb.check_against(self, times, np.stack([zero, zero, -depth], 1), np.tile([1.0, 0, 0, 0], (len(times), 1)), size=0.0245)
        corners, _ = glb.mesh()
        # A disc of the area and thickness that the plan fixes, y up.
        np.testing.assert_allclose(np.abs(corners).max(axis=0), [0.01225, 2.55e-3 / 2, 0.01225], rtol=1e-3)
        extras = glb.json["scenes"][0]["extras"]["parameters"]
        self.assertEqual((extras["C_D"], extras["v(0)"]), (1.3, 0.2))
        self.assertAlmostEqual(extras["thickness"], 2.55e-3, delta=1e-12)
        part = Glb(written("query", book("coin", COIN_PLAN), *point, "--at", "0.1", "--at", "0.3", name="part.glb"))
        self.assertAlmostEqual(part.channel("translation")[0][-1], 0.2, delta=1e-7)

    def test_flights_through_random_air_are_nodes_with_their_seed(self):
        card = ["immersed_body_in_gusts", *CARD[:-4], "--set", "z(0)=2", "--until", "0.5", "--turbulence", "uniform", "deviation=0.3", "scale=0.5"]
        flights = [*card, "--realisations", "5", "--seed", "11", "--frames", "501", "--ground", "1.9"]
        glb = Glb(written("simulate", *flights, "--keep", "3", name="flights.glb"))
        self.assertEqual([node["name"] for node in glb.json["nodes"]], ["realisation 0", "realisation 1", "realisation 2"])
        extras = glb.json["scenes"][0]["extras"]
        self.assertEqual((extras["seed"], extras["parameters"]["C_T"], extras["model"]), ("11", 2.71, "immersed_body_in_gusts"))
        self.assertIn("uniform turbulence", extras["air"])
        self.assertIn(issues(FOLDER / "flights.glb"), [None, [0, 0, 0, 0]])
        kept = written("simulate", *flights, "--keep", "3", name="flights.h5")
        with h5py.File(kept) as file:
            names = [name.decode() for name in file["kept_states"]]
            paths, times = file["kept"][:], file["t"][:]
        self.assertEqual(paths.shape[:2], (3, 501), names)
        for node, path in enumerate(paths):
            # Each frame up to the landing, which is one key more; positions are the first three states.
            seen = np.isfinite(path).all(1)
            self.assertLess(seen.sum(), 501)
            channel = glb.channel("translation", node)
            self.assertEqual(len(channel[0]), seen.sum() + 1)
            np.testing.assert_allclose(channel[1][:-1], y_up(path[seen][:, :3]), atol=1e-6)
            np.testing.assert_allclose(channel[0][:-1], times[seen], atol=1e-6)
        # All of them, unless fewer are asked for; and frames that are too few are told of.
        result = run("simulate", *card, "--realisations", "4", "--frames", "6", "-o", FOLDER / "few.glb")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"players draw bodies up to .* degrees .* times as many --frames would do")
        self.assertEqual(len(Glb(FOLDER / "few.glb").json["nodes"]), 4)
        self.check_error(run("simulate", *card, "--realisations", "4", "--keep", "0", "-o", FOLDER / "none.glb"), 2, "--keep is 0")

    def test_each_flight_that_lands_ends_at_its_landing(self):
        card = ["immersed_body_in_gusts", *CARD[:-2], "--set", "z(0)=0.1"]
        plate = ["falling_plate_in_gusts", "--set", "semi_chord=1 cm", "--set", "semi_thickness=0.2 mm", "--set", "density=2700",
                 "--set", "fluid_density=1.2", "--set", "nu=1.5e-5", "--set", "w(0)=20", "--set", "y(0)=0.1"]
        air = ["--until", "0.6", "--turbulence", "uniform", "deviation=0.1", "scale=0.5", "--seed", "3", "--realisations", "4", "--first", "2",
               "--ground", "0", "--step", "0.1 ms", "--keep", "4"]
        for model, poses in [(card, spatial), (plate, planar)]:
            glb = Glb(written("simulate", *model, *air, "--frames", "61", name="landing.glb"))
            # Frames of every step say how bodies stand when they land.
            with h5py.File(written("simulate", *model, *air, "--frames", "6001", name="landing.h5")) as file:
                names = [name.decode() for name in file["kept_states"]]
                paths, landings = file["kept"][:], file["landings"][:]
            np.testing.assert_array_equal(landings[:, 0], [2, 3, 4, 5])
            for node, (path, (_, t, *place)) in enumerate(zip(paths, landings)):
                times, places = glb.channel("translation", node)
                self.assertAlmostEqual(times[-1], t, delta=1e-6)
                np.testing.assert_allclose(places[-1], y_up(np.array(place)), atol=1e-6)
                self.assertEqual(len(times), math.floor(t / 0.01) + 2)
                # A hundredth of a second before, bodies stand up to 13 degrees otherwise.
                last = path[np.isfinite(path).all(1)][-1]
                _, turns = poses({name: last[k:k + 1] for k, name in enumerate(names)})
                expected = np.append(y_up(turns[0, 1:]), turns[0, 0])
                self.assertLess(math.degrees(2 * math.acos(min(1.0, abs(glb.channel("rotation", node)[1][-1] @ expected)))), 2)

    def test_a_motion_that_was_moved_into_the_box_is_told(self):
        moved = run("query", book("coin", COIN_PLAN), "--set", "C_D=7", "--set", "v(0)=0.2", "--clamp", "-o", FOLDER / "moved.glb")
        self.assertEqual(moved.returncode, 0, moved.stderr)
        self.assertIn("C_D was moved to the border of the box", moved.stderr)
        self.assertEqual(Glb(FOLDER / "moved.glb").json["scenes"][0]["extras"]["parameters"]["C_D"], 1.6)

    def test_what_was_drawn_at_random_stands_beside_the_parameters(self):
        wind = write("wind.toml", '[mean]\nspeed = "1 m/s"\nroughness = "3 cm"\n[turbulence]\nsigma = "0.2 m/s"\nlength = "5 m"\n')
        glb = Glb(written("simulate", "immersed_body", *CARD[:-1], "0.2", "--set", "z(0)=2", "--wind", wind, "--seed", "9"))
        extras = glb.json["scenes"][0]["extras"]
        self.assertEqual((extras["seed"], extras["wind"], extras["parameters"]["z(0)"]), ("9", str(wind), 2))
        self.assertEqual(glb.json["nodes"][0]["extras"], {"start": 0})
        text = written("query", book("coin", COIN_PLAN), "--set", "C_D=1.3", "--set", "v(0)=0.2", "--at", "0.1", "--at", "0.3", name="late.usda").read_text()
        self.assertIn("double start = 0.1", text)
        self.assertRegex(text, r'double "C_D" = 1\.3\n')

    def test_a_mesh_of_ones_own_is_drawn(self):
        mesh = write("wedge.obj", "v 0 0 0\nv 30 0 0\nv 0 20 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
        glb = Glb(written("simulate", "immersed_body", *CARD, "--body", mesh, "--unit", "mm"))
        corners, triangles = glb.mesh()
        np.testing.assert_allclose(sorted(map(tuple, corners.round(6))), sorted([(0, 0, 0), (0.03, 0, 0), (0, 0, -0.02), (0, 0.01, 0)]), atol=1e-6)
        self.assertEqual(len(triangles), 4)
        corners, _ = Glb(written("simulate", "immersed_body", *CARD, "--body", "plate", "--size", "3 cm", "2 cm", "1 mm")).mesh()
        np.testing.assert_allclose(corners.max(axis=0), [0.015, 5e-4, 0.01], rtol=1e-6)

    def test_an_open_surface_is_drawn_from_both_sides_and_gives_no_mass(self):
        leaf = write("leaf.obj", "v -3.5 0 0\nv 0 2 0\nv 3.5 0 0\nv 0 -2 0\nf 1 2 3 4\n")
        glb = Glb(written("simulate", "immersed_body", *CARD, "--body", leaf, "--unit", "cm"))
        corners, triangles = glb.mesh()
        np.testing.assert_allclose(np.abs(corners).max(axis=0), [0.035, 0, 0.02], atol=1e-6)
        self.assertEqual((len(triangles), glb.json["materials"][0]["doubleSided"]), (2, True))
        self.check_error(run("simulate", "kirchhoff_body", "--body", leaf, "--unit", "cm", "--density", "700", "--fluid", "1.2", "--until", "1",
                             "-o", FOLDER / "heavy.glb"), 3, "leaf.obj", "not closed")

    def test_the_scene_as_text_has_the_same_keys(self):
        glb = Glb(written("simulate", "falling_plate_nd", *PLATE))
        text = written("simulate", "falling_plate_nd", *PLATE, name="motion.usda").read_text()
        self.assertTrue(text.startswith("#usda 1.0\n"))
        self.assertIn('upAxis = "Z"', text)
        samples = {}
        for name in ["translate", "orient"]:
            block = re.search(rf"xformOp:{name}.timeSamples = {{\n(.*?)\n        }}", text, re.S).group(1)
            samples[name] = np.array([[float(v) for v in re.findall(r"-?[\d.]+(?:e[-+]?\d+)?", line)] for line in block.splitlines()])
        times, places = glb.channel("translation")
        np.testing.assert_allclose(samples["translate"][:, 0] / 24.0, times, atol=1e-5)
        np.testing.assert_allclose(samples["translate"][:, [1, 3, 2]] * [1, 1, -1], places, atol=1e-5)
        np.testing.assert_allclose(samples["orient"][:, [2, 4, 3, 1]] * [1, 1, -1, 1], glb.channel("rotation")[1], atol=1e-6)
        self.assertEqual(text.count("{"), text.count("}"))
        counts = len(re.search(r"faceVertexCounts = \[(.*?)\]", text).group(1).split(","))
        self.assertEqual(counts, len(glb.mesh()[1]))

    def test_what_moves_no_body_or_shows_none_is_refused_in_one_sentence(self):
        motion = FOLDER / "refused.glb"
        self.check_error(run("simulate", "constant_rate", "--set", "k=2", "-o", motion), 2, "does not move a body")
        self.check_error(run("query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v(0)=0", "--json", "-o", motion), 2, "holds a motion")
        self.check_error(run("query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v(0)=0", "--at", "0.1", "-o", motion), 2, "two times")
        self.check_error(run("query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v(0)=0", "--body", "disc"), 2, ".glb or .usda was expected")
        self.check_error(run("query", book("coin", COIN_PLAN), "--set", "C_D=7", "--set", "v(0)=0", "-o", motion), 5, "C_D")
        self.check_error(run("simulate", "immersed_body", *CARD, "--forces", "-o", motion), 2, "--forces")
        self.check_error(run("simulate", "immersed_body", *CARD, "--body", "ball", "-o", motion), 2, "--unit")
        self.assertFalse(motion.exists())
        for name in ("refused.gltf", "refused.fbx", "refused.usd", "refused.USDZ"):
            for call in (["simulate", "immersed_body", *CARD], ["query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v(0)=0"]):
                self.check_error(run(*call, "-o", FOLDER / name), 2, name, "expected a name that ends in .glb or .usda")
            self.assertFalse((FOLDER / name).exists())

    def test_an_ending_in_capitals_is_the_same_format(self):
        self.assertEqual(written("simulate", "immersed_body", *CARD, name="loud.GLB").read_bytes()[:4], b"glTF")
        self.assertEqual(written("query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v(0)=0", name="loud.USDA").read_bytes()[:5], b"#usda")

    def test_the_official_validator_finds_nothing(self):
        paths = [written("simulate", "immersed_body", *CARD),
                 written("query", book("coin", COIN_PLAN), "--set", "C_D=1", "--set", "v(0)=0", name="coin.glb")]
        for path in paths:
            found = issues(path)
            if found is None:
                self.skipTest("SAMARA_NODE_MODULES does not lead to gltf-validator")
            self.assertEqual(found, [0, 0, 0, 0])


if __name__ == "__main__":
    main()
