"""Usage: sweeps_test.py SAMARA [CLASS]

sweep and database, patterns and regime of sweeps: answers, files, and what they refuse.
"""

import json
import pathlib
import re
import shutil
import signal
import subprocess
import time

import h5py
import numpy

from samara_case import FOLDER, LINE_PLAN, LONGEST, SAMARA, Case, book, main, run, run_with_files_of_at_most, write

PLATES = """model = "falling_plate_nd"
[fixed]
beta = 0
[axes]
inertia_ratio = { from = 0.8, to = 2.4, count = 9 }
C_R = { from = 2.2, to = 3.2, count = 5 }
[releases]
tilt = [0.4, "40 deg"]
[run]
until = 120
step = 0.05
"""


def swept(name="plates", plan=PLATES):
    path = FOLDER / f"{name}.h5"
    if not path.exists():
        result = run("sweep", write(f"{name}.toml", plan), "-o", path)
        assert result.returncode == 0, result.stderr
    return path


CHAOS = """model = "falling_plate_nd"
[fixed]
beta = 0
inertia_ratio = 1.3
[axes]
C_T = { from = 0.8, to = 1.4 }
C_R = { from = 2, to = 4 }
A = { from = 1, to = 1.8 }
[sample]
count = 100
[releases]
tilt = [0.6]
[run]
until = 60
step = 0.05
keep = "trajectories"
"""

STEADY = """model = "immersed_body"
[fixed]
a = 0.035
b = 0.02
c = 1e-4
density = 400
C_D0 = 0.05
C_w = 2
[axes]
C_D90 = { from = 0.6, to = 2.7 }
[sample]
count = 2
[releases]
tilt = [0]
axis = [0.6]
[run]
until = 2
step = 1e-3
settle = 0.5
"""


class Databases(Case):
    def test_a_database_is_a_file_that_others_read(self):
        path = FOLDER / "motions.h5"
        result = run("database", swept("chaos", CHAOS), "-o", path, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        said = json.loads(result.stdout)
        self.assertEqual(said["schema"], "samara-motions/1")
        worth = said["chain"]["held_out"]
        self.assertEqual([value is None for value in worth["chi_square"]], [freedom == 0 for freedom in worth["degrees_of_freedom"]])
        with h5py.File(path) as file:
            self.assertEqual(file.attrs["format"], b"samara-motions")
            start, end, runs = (file[f"segments/{name}"][:] for name in ("start", "end", "run"))
            steady = file["segments/is_steady"][:].astype(bool)
            kinds = [file["kind_names"][int(k)].decode() for k in file["segments/kind"][:][~steady]]
            self.assertEqual(len(start), said["segments"])
            self.assertEqual(steady.sum(), said["steady"])
            for kind in set(kinds):
                self.assertEqual(kinds.count(kind), said["kinds"][kind])
            follows = runs[1:] == runs[:-1]      # one after another in a run: the end of one is the start of the next
            numpy.testing.assert_array_equal(end[:-1][follows], start[1:][follows])
            state = [name.decode() for name in file["state_names"]]
            turn = (end - start)[:, state.index("theta")]
            numpy.testing.assert_array_equal([kind.startswith("turn") for kind in kinds], abs(turn[~steady]) >= 0.6 * numpy.pi)
            fall = file["segments/displacement"][:, 2]
            for k in range(0, len(start), 9):       # its frames end where it does, to what a plate moves in two frames
                frame = int(file["run_first"][int(runs[k])])
                first, last = (file["frames"][frame + int(file[f"segments/{end}"][k])] for end in ("first", "last"))
                self.assertLess(abs((last - first)[state.index("y")] - fall[k]), 1.5)
            self.assertEqual(file["edges"].attrs["threshold"], said["threshold"])
            curve = file["threshold_curve"][:]
            self.assertGreater(curve[:, 1].max(), 0.7)
            self.assertEqual((file["component"][:] == 0).sum(), said["kept"])
            self.assertEqual(file["chain/counts"].shape, (4 ** int(file["chain"].attrs["order"]), 4))

    def test_of_few_runs_it_is_said_that_they_tell_nothing_of_a_chain(self):
        few = swept("few", CHAOS.replace("count = 100", "count = 30"))
        result = run("database", few, "-o", FOLDER / "few_motions.h5")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("run lengths too few to tell   two events on", result.stdout)
        self.assertNotIn("nan", result.stdout)
        said = json.loads(run("database", few, "-o", FOLDER / "few_motions.h5", "--json").stdout)
        of_few = said["chain"]["held_out"]
        self.assertEqual((of_few["chi_square"], of_few["degrees_of_freedom"], of_few["largest_95"]), ([None] * 4, [0] * 4, None))

    def test_databases_that_cannot_be_made_are_refused(self):
        self.check_error(run("database", swept(), "-o", FOLDER / "no.h5"), 3,
                         "plates.h5: the sweep changes inertia_ratio, which is no coefficient of falling_plate_nd")
        self.check_error(run("database", swept("steady", STEADY), "-o", FOLDER / "no.h5"), 3,
                         "steady.h5: all falls of the sweep are steady: there are no events to cut them at")
        self.check_error(run("database", write("sweep_text.h5", "no HDF5"), "-o", FOLDER / "no.h5"), 3, "sweep_text.h5")
        self.check_error(run("database", swept("chaos", CHAOS), "-o", FOLDER / "chaos.h5"), 2, "chaos.h5")
        self.assertFalse((FOLDER / "no.h5").exists())

    def test_no_file_of_another_kind_is_lost_to_a_database(self):
        for path in [book("line", LINE_PLAN), swept(), write("notes", "mine")]:
            before = pathlib.Path(path).read_bytes()
            self.check_error(run("database", swept("chaos", CHAOS), "-o", path), 2, str(path), "no database of motions")
            self.assertEqual(pathlib.Path(path).read_bytes(), before)

    def test_an_interrupted_database_is_none(self):
        many = swept("many", CHAOS.replace("count = 100", "count = 10000").replace('keep = "trajectories"\n', ""))
        path = FOLDER / "many_motions.h5"
        for _ in range(30):  # on a busy machine it may be done before it is interrupted
            process = subprocess.Popen([SAMARA, "database", many, "-o", path, "--verbose"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            begun = process.stderr.readline()
            process.send_signal(signal.SIGINT)
            errors = process.stderr.read()
            process.wait(timeout=LONGEST)
            if process.returncode != 0:
                break
            path.unlink()
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("integrating", begun)
        self.assertIn("cancelled before the motions were cut", errors)
        self.assertFalse(path.exists())


class Sweeps(Case):
    def test_a_sweep_is_a_file_that_others_read(self):
        with h5py.File(swept()) as file:
            self.assertEqual(file.attrs["format"], b"samara-sweep")
            names = [name.decode() for name in file["feature_names"]]
            labels = [file["label_names"][int(k)].decode() for k in file["labels"]]
            features = file["features"][:]
            self.assertEqual(features.shape, (90, len(names)))
            self.assertEqual([name.decode() for name in file["point_names"]], ["inertia_ratio", "C_R"])
            self.assertEqual(file["points"].shape, (45, 2))
            numpy.testing.assert_allclose(file["axes/inertia_ratio"][:], numpy.linspace(0.8, 2.4, 9))
            flips = features[:, names.index("flips")]
            for label, flip in zip(labels, flips):
                self.assertEqual(label in ("steady", "zigzag"), flip < 1.5)
            self.assertEqual(json.loads(file.attrs["thresholds"])["steady_tilt"], 0.2)
            self.assertIn(b"inertia_ratio", file["plan"][0])

    def test_patterns_of_a_sweep_are_counted_mapped_and_clustered(self):
        text = run("patterns", swept()).stdout
        self.assertEqual(len(re.findall(r"^release ", text, re.M)), 3)
        self.assertIn("adjusted Rand index", text)
        answer = json.loads(run("patterns", swept(), "--json").stdout)
        self.assertEqual(answer["schema"], "samara-sweep/1")
        for release in answer["releases"]:
            self.assertEqual(sum(release["counts"].values()), 45)
            self.assertEqual(sum(region["points"] for region in release["regions"]), 45)
            self.assertEqual(len(release["clusters"]), 3)
            self.assertEqual(len({cluster["falls"] for cluster in release["clusters"]}), 1)
            ours, _, source = [cluster["adjusted_rand"] for cluster in release["clusters"]]
            self.assertGreater(ours, source)

    def test_the_page_of_a_sweep_holds_its_map_its_features_and_what_follows_what(self):
        path = swept("kept", PLATES.replace("until = 120", "until = 200\nkeep = \"trajectories\""))
        _, data = self.pattern_page(path)
        with h5py.File(path) as file:
            labels = file["labels"][:].astype(int).reshape(45, 2)
            features = file["features"][:]
            points = file["points"][:]
            names = [name.decode() for name in file["feature_names"]]
        scaled = (points - points.min(0)) / numpy.ptp(points, 0)
        distance = numpy.linalg.norm(scaled[:, None] - scaled, axis=2)
        for k, release in enumerate(data["box"]["releases"]):
            for n, cell in enumerate(release["cells"]):
                order = numpy.argsort(distance[n], kind="stable")
                if distance[n][order[7]] - distance[n][order[6]] < 1e-9:
                    continue  # which is the seventh is a matter of rounding
                counts = numpy.bincount(labels[order[:7], k], minlength=8)
                # Colour and sureness are of the same pattern, the most frequent one around.
                self.assertEqual(counts[ord(cell.lower()) - ord("a")], counts.max())
                self.assertEqual(cell.isupper(), counts.max() / 7 >= 0.7)
            # Sure and not: both are there, and where a whole neighbourhood agrees the map is sure.
            self.assertGreater(len({cell.islower() for cell in release["cells"]}), 1)
        self.assertEqual(data["falls"]["patterns"], list(labels.ravel()))
        tilt, = [feature for feature in data["falls"]["features"] if feature["name"] == "tilt"]
        numpy.testing.assert_allclose(tilt["values"], features[:, names.index("tilt")], rtol=1e-5)
        self.assertIn("does not say length", data["diagram"]["missing"])
        self.assertEqual(data["thresholds"]["steady_tilt"], 0.2)
        self.assertEqual(data["chain"]["falls"], 90)
        for step in data["chain"]["steps"]:
            self.assertTrue(step["interval"][0] <= step["probability"] <= step["interval"][1])
        self.assertIsNone(self.pattern_page(swept())[1]["chain"])
        self.check_error(run("patterns", path, "--report", path), 2, "which it would overwrite")
        self.check_error(run("patterns", path, "--threshold", "veers=2"), 2, "are of captures")

    def test_drawn_points_are_shown_by_slices_and_bodies_by_their_place_with_shares(self):
        plan = '''model = "falling_plate"
[fixed]
semi_thickness = "1 mm"
[axes]
semi_chord = { from = "3 mm", to = "14 mm" }
density = { from = 1500, to = 9000 }
[sample]
count = 40
[releases]
tilt = ["10 deg", "60 deg", "80 deg"]
[run]
until = 1
step = "1 ms"
'''
        path = swept("drawn", plan)
        _, data = self.pattern_page(path)
        self.assertIsNone(data["box"]["axes"])
        slices = [part for release in data["box"]["releases"] for part in release["slices"]]
        self.assertEqual([(part["x"], part["y"], len(part["map"])) for part in slices], [(0, 1, 1024)] * 3)
        bodies = data["diagram"]["bodies"]
        self.assertEqual(len(bodies), 40)
        with h5py.File(path) as file:
            points, labels = file["points"][:], file["labels"][:].astype(int).reshape(40, 3)
            names = [name.decode() for name in file["label_names"]]
        for body, (chord, density), three in zip(bodies, points, labels):
            body_alone = json.loads(run("regime", "falling_plate", "--set", f"semi_chord={chord!r}", "--set", "semi_thickness=1 mm",
                                        "--set", f"density={density!r}", "--json").stdout) if body is bodies[0] else None
            if body_alone:
                self.assertAlmostEqual(body["Re"], body_alone["Re"], delta=1e-9 * body["Re"])
                self.assertEqual(body["regime"], body_alone["regime"])
            numpy.testing.assert_allclose(body["shares"], numpy.bincount(three, minlength=8) / 3, atol=1e-6)
        # The same shares from the command: those of the seven nearest points.
        scaled = (points - [3e-3, 1500]) / [11e-3, 7500]
        nearest = numpy.argsort(((scaled - scaled[5]) ** 2).sum(1))[:7]
        there = ["--set", f"semi_chord={points[5, 0]!r}", "--set", f"density={points[5, 1]!r}", "--set", "semi_thickness=1 mm"]
        answer = json.loads(run("regime", "falling_plate", *there, "--sweep", path, "--json").stdout)["sweep"]
        self.assertEqual(answer["falls"], 21)
        for k, name in enumerate(names):
            share = answer["shares"][name]
            self.assertAlmostEqual(share["share"], (labels[nearest] == k).mean())
            self.assertTrue(share["interval"][0] <= share["share"] <= share["interval"][1])
            self.assertGreater(share["interval"][1] - share["interval"][0], 0.05)
        told = json.loads(run("patterns", path, "--json").stdout)
        self.assertAlmostEqual(told["points_of_one_pattern"], (labels == labels[:, :1]).all(1).mean())
        self.check_error(run("regime", "falling_plate", *there[:2], "--set", "density=9500", *there[4:], "--sweep", path), 2, "density is 9500",
                         "inside the box")
        self.check_error(run("regime", "immersed_body", "--set", "a=1 cm", "--set", "b=1 cm", "--set", "c=0.01 mm", "--set", "density=1000",
                             "--sweep", path), 2, "is of the model \"falling_plate\"")
        # What the sweep held fixed is asked for, too, and what follows from it.
        self.check_error(run("regime", "falling_plate", *there[:4], "--set", "semi_thickness=2 mm", "--sweep", path), 2,
                         "semi_thickness of the body is 0.002, expected 0.001, at which the sweep held it")
        self.check_error(run("regime", "falling_plate", *there, "--set", "x(0)=1", "--sweep", path), 2, "x(0) of the body is 1, expected 0")

    def test_an_interrupted_sweep_goes_on_where_it_stopped(self):
        plan = write("long.toml", PLATES.replace("count = 9", "count = 15000").replace("until = 120", "until = 60"))
        path = FOLDER / "long.h5"
        # Some chunks of a few tenths of a second, of a hundred; sanitizers and busy machines are slower.
        for wait in (2.5, 10, 40):
            process = subprocess.Popen([SAMARA, "sweep", plan, "-o", path], stderr=subprocess.PIPE, text=True)
            time.sleep(wait)
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=LONGEST)
            self.assertEqual(process.returncode, 130, errors)
            self.assertIn("cancelled after", errors)
            self.assertFalse(path.exists())
            if "before there was anything to keep" not in errors:
                break
        part = FOLDER / "long.h5.part"
        self.assertIn("is kept: the same line goes on from there", errors)
        with h5py.File(part) as file:
            self.assertEqual(len(file["labels"]) % 1024, 0)
        self.check_error(run("patterns", part, "--labels", plan), 2, "are of captures")
        other = write("other.toml", PLATES)
        self.check_error(run("sweep", other, "-o", path), 3, "belongs to another plan")

    def test_clusters_of_different_features_are_of_the_same_falls(self):
        # Damped plates descend steadily: without swings their recurrence is not known, but d and e are.
        damped = PLATES.replace("C_R = { from = 2.2, to = 3.2, count = 5 }", "mu1 = { from = 0.2, to = 4, count = 5 }")
        answer = json.loads(run("patterns", swept("damped", damped), "--json").stdout)
        with h5py.File(FOLDER / "damped.h5") as file:
            names = [name.decode() for name in file["feature_names"]]
            recurrence = file["features"][:, names.index("recurrence")].reshape(45, 2)
        self.assertTrue(numpy.isnan(recurrence).any())
        for k, release in enumerate(answer["releases"]):
            known = numpy.isfinite(recurrence[:, k]).sum()
            self.assertEqual([cluster["falls"] for cluster in release["clusters"]], [known] * 3)

    def test_points_are_drawn_from_and_clamped_to_the_part_of_a_pattern(self):
        path = swept()
        table = run("patterns", path, "--draw", "zigzag", "--count", "40", "--seed", "3").stdout.splitlines()
        self.assertEqual((table[0], len(table)), ("inertia_ratio[1],C_R[1]", 41))
        answer = json.loads(run("patterns", path, "--draw", "zigzag", "--count", "40", "--seed", "3", "--json").stdout)
        self.assertEqual(self.check_schema(answer), "samara-pattern-points")
        self.assertEqual((answer["wanted"], answer["seed"]), ("zigzag", 3))
        points = numpy.array([point["values"] for point in answer["points"]])
        numpy.testing.assert_allclose(points, [[float(v) for v in line.split(",")] for line in table[1:]], rtol=1e-12)
        with h5py.File(path) as file:
            falls, box = file["points"][:], numpy.array([file["lower"][:], file["upper"][:]])
            labels = numpy.array([file["label_names"][int(k)].decode() for k in file["labels"]]).reshape(45, -1)
        releases = labels.shape[1]
        scaled = lambda x: (x - box[0]) / (box[1] - box[0])
        distance = lambda x, of: numpy.linalg.norm(scaled(falls[of]) - scaled(x), axis=1).min()
        # Each is nearer to a fall of the pattern than to any of another.
        for point in points:
            self.assertTrue(numpy.all((point >= box[0]) & (point <= box[1])))
            self.assertLessEqual(distance(point, labels[:, 0] == "zigzag"), distance(point, labels[:, 0] != "zigzag") + 1e-12)
        self.assertGreater(len(numpy.unique(points[:, 0])), 20)
        other = json.loads(run("patterns", path, "--draw", "zigzag", "--seed", "4", "--json").stdout)
        self.assertNotEqual(other["points"][0]["values"], answer["points"][0]["values"])
        for name in numpy.unique(labels[:, 1]):
            words = ["--clamp", name, "--set", "inertia_ratio=2.4", "--set", "C_R=2.9", "--release", "1"]
            moved, = json.loads(run("patterns", path, *words, "--json").stdout)["points"]
            at = numpy.array(moved["values"])
            self.assertTrue(moved["pattern"] == name or distance(at, labels[:, 1] == name) < 1e-12)
            self.assertLessEqual(numpy.linalg.norm(scaled(at) - scaled(numpy.array([2.4, 2.9]))),
                                 distance(numpy.array([2.4, 2.9]), labels[:, 1] == name) + 1e-12)
        self.check_error(run("patterns", path, "--draw", "helix"), 2, "helix is 0 of 45 points of the box; there are")
        self.check_error(run("patterns", path, "--draw", "zigzga"), 2, "zigzag")
        self.check_error(run("patterns", path, "--draw", "zigzag", "--count", "0"), 2, "--count is 0")
        self.check_error(run("patterns", path, "--draw", "zigzag", "--release", str(releases)), 2, f"there is no release {releases}")
        self.check_error(run("patterns", path, "--clamp", "zigzag", "--set", "C_R=2"), 2, "--clamp has no value of inertia_ratio")
        self.check_error(run("patterns", path, "--clamp", "zigzag", "--draw", "zigzag"), 2, "one of them was expected")
        self.check_error(run("patterns", path, "--seed", "1"), 2, "--draw was expected")
        self.check_error(run("patterns", path, "--release", "1"), 2, "--draw or --clamp was expected")
        self.check_error(run("patterns", path, "--draw", "zigzag", "--set", "C_R=2"), 2, "--set is of the point that --clamp moves")
        self.check_error(run("patterns", path, "--draw", "zigzag", "--report", FOLDER / "no.html"), 2, "--report is of the whole sweep")
        self.check_error(run("patterns", path, "--draw", "zigzag", "--clusters", "3"), 2, "--clusters is of the whole sweep")

    def test_a_sweep_interrupted_while_it_is_refined_goes_on_without_its_falls_again(self):
        plan = write("finer.toml", PLATES.replace("until = 120", "until = 400") + "[refine]\nrounds = 6\n")
        path, part = FOLDER / "finer.h5", FOLDER / "finer.h5.part"
        process = subprocess.Popen([SAMARA, "sweep", plan, "-o", path], stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + 20
        while not part.exists() and process.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=LONGEST)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("is kept: the same line goes on from there", errors)
        with h5py.File(part) as file:
            self.assertEqual(len(file["labels"]), 90)

    def test_a_sweep_whose_file_cannot_be_written_keeps_its_checkpoint(self):
        plan = write("room.toml", PLATES + "[refine]\nrounds = 1\n")
        path, whole, part = FOLDER / "room.h5", FOLDER / "whole_room.h5", FOLDER / "room.h5.part"
        self.assertEqual(run("sweep", plan, "-o", whole).returncode, 0)
        # The falls of the plan fit where those of the round do not.
        result = run_with_files_of_at_most(whole.stat().st_size - 100, "sweep", plan, "-o", path)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("File too large", result.stderr)
        self.assertTrue(part.exists())
        result = run("sweep", plan, "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse(part.exists())
        with h5py.File(path) as one, h5py.File(whole) as other:
            for name in ["points", "labels", "features"]:
                numpy.testing.assert_array_equal(one[name][:], other[name][:])

    def test_a_file_that_is_no_checkpoint_is_left_alone_by_a_sweep(self):
        plan, path, part = write("door.toml", PLATES), FOLDER / "door.h5", FOLDER / "door.h5.part"
        finished = swept().read_bytes()
        for other in (b"t,z\n0,1\n", finished):
            part.write_bytes(other)
            for words in ([], ["--fresh"]):
                self.check_error(run("sweep", plan, "-o", path, *words), 3, f"{part}: this is no checkpoint of a sweep, and would be lost")
                self.assertEqual(part.read_bytes(), other)
        part.write_bytes(b"")
        self.assertEqual(run("sweep", plan, "-o", path, "--fresh").returncode, 0)
        self.assertFalse(part.exists())

    def test_a_sweep_whose_name_has_room_for_no_checkpoint_is_refined_without(self):
        path = FOLDER / ("n" * 248 + ".h5")
        result = run("sweep", write("named.toml", PLATES.replace("until = 120", "until = 20") + "[refine]\nrounds = 2\n"), "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr.count("no checkpoint: cannot write"), 1, result.stderr)

    def test_sweeps_and_patterns_that_cannot_be_meant_are_refused(self):
        self.check_error(run("sweep", write("bad.toml", PLATES.replace("C_R", "C_Q")), "-o", FOLDER / "bad.h5"), 3,
                         "bad.toml:6", "C_Q", "did you mean")
        self.check_error(run("sweep", write("bad.toml", PLATES), "-o", FOLDER / "bad.toml"), 2, "bad.toml")
        self.check_error(run("sweep", write("good.toml", PLATES), "-o", FOLDER / "new.h5", "--resume"), 2,
                         "there is no", "to go on from")
        note = write("note", "words")
        self.check_error(run("sweep", FOLDER / "good.toml", "-o", note), 2, "is a file, and no sweep")
        self.check_error(run("patterns", swept(), "--clusters", "0"), 2, "--clusters is 0")
        self.check_error(run("patterns", FOLDER / "missing.csv"), 3, "missing.csv")
        self.check_error(run("patterns", swept(), swept()), 2, "is a sweep, which was expected alone")
        half = FOLDER / "half.h5"
        half.write_bytes(swept().read_bytes()[:3000])
        self.check_error(run("patterns", half), 3, "half.h5", "HDF5")
        shutil.copy(swept(), half)
        with h5py.File(half, "a") as file:
            del file["model_text"]
            file.create_dataset("model_text", (0,), "S8")
        self.check_error(run("patterns", half), 3, "/model_text", "is not one text")
        shutil.copy(swept(), half)
        with h5py.File(half, "a") as file:
            del file["labels"]
            file["labels"] = 1.0
        self.check_error(run("patterns", half), 3, "/labels", "has 0 dimensions, expected 1")


if __name__ == "__main__":
    main()
