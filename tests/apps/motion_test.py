"""Usage: motion_test.py SAMARA [CLASS]

sweep, patterns and regime: answers, files, and what they refuse.
"""

import json
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import time

import h5py
import numpy

from samara_case import FOLDER, LONGEST, SAMARA, Case, main, run, write

ROOT = pathlib.Path(__file__).resolve().parents[2]

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


class Databases(Case):
    def test_a_database_is_a_file_that_others_read(self):
        path = FOLDER / "motions.h5"
        result = run("database", swept("chaos", CHAOS), "-o", path, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        said = json.loads(result.stdout)
        with h5py.File(path) as file:
            self.assertEqual(file.attrs["format"], b"samara-motions")
            start, end, runs = (file[f"segments/{name}"][:] for name in ("start", "end", "run"))
            kinds = [file["kind_names"][int(k)].decode() for k in file["segments/kind"]]
            self.assertEqual(len(start), said["segments"])
            for kind in set(kinds):
                self.assertEqual(kinds.count(kind), said["kinds"][kind])
            follows = runs[1:] == runs[:-1]      # one after another in a run: the end of one is the start of the next
            numpy.testing.assert_array_equal(end[:-1][follows], start[1:][follows])
            state = [name.decode() for name in file["state_names"]]
            turn = (end - start)[:, state.index("theta")]
            numpy.testing.assert_array_equal([kind.startswith("turn") for kind in kinds], abs(turn) >= 0.6 * numpy.pi)
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

    def test_databases_that_cannot_be_made_are_refused(self):
        self.check_error(run("database", swept(), "-o", FOLDER / "no.h5"), 2,
                         "the sweep changes inertia_ratio, which is no coefficient of falling_plate_nd")
        self.check_error(run("database", write("sweep_text.h5", "no HDF5"), "-o", FOLDER / "no.h5"), 3, "sweep_text.h5")
        self.check_error(run("database", swept("chaos", CHAOS), "-o", FOLDER / "chaos.h5"), 2, "chaos.h5")
        self.assertFalse((FOLDER / "no.h5").exists())


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
        for release in answer["releases"]:
            self.assertEqual(sum(release["counts"].values()), 45)
            self.assertEqual(sum(region["points"] for region in release["regions"]), 45)
            self.assertEqual(len(release["clusters"]), 3)
            self.assertEqual(len({cluster["falls"] for cluster in release["clusters"]}), 1)
            ours, _, source = [cluster["adjusted_rand"] for cluster in release["clusters"]]
            self.assertGreater(ours, source)

    def test_an_interrupted_sweep_goes_on_where_it_stopped(self):
        plan = write("long.toml", PLATES.replace("count = 9", "count = 1500").replace("until = 120", "until = 900"))
        path = FOLDER / "long.h5"
        process = subprocess.Popen([SAMARA, "sweep", plan, "-o", path], stderr=subprocess.PIPE, text=True)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=LONGEST)
        self.assertEqual(process.returncode, 130, errors)
        self.assertIn("cancelled after", errors)
        self.assertFalse(path.exists())
        part = FOLDER / "long.h5.part"
        if part.exists():
            self.assertIn("is kept: the same line goes on from there", errors)
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

    def test_sweeps_and_patterns_that_cannot_be_meant_are_refused(self):
        self.check_error(run("sweep", write("bad.toml", PLATES.replace("C_R", "C_Q")), "-o", FOLDER / "bad.h5"), 3,
                         "bad.toml:6", "C_Q", "did you mean")
        self.check_error(run("sweep", write("bad.toml", PLATES), "-o", FOLDER / "bad.toml"), 2, "bad.toml")
        self.check_error(run("sweep", write("good.toml", PLATES), "-o", FOLDER / "new.h5", "--resume"), 2,
                         "there is no", "to go on from")
        note = write("note.txt", "words")
        self.check_error(run("sweep", FOLDER / "good.toml", "-o", note), 2, "is a file, and no sweep")
        self.check_error(run("patterns", swept(), "--clusters", "0"), 2, "--clusters is 0")
        self.check_error(run("patterns", FOLDER / "missing.csv"), 3, "missing.csv")
        self.check_error(run("patterns", swept(), swept()), 2, "is a sweep, which was expected alone")
        half = FOLDER / "half.h5"
        half.write_bytes(swept().read_bytes()[:3000])
        self.check_error(run("patterns", half), 3, "half.h5", "HDF5")


class Patterns(Case):
    def track(self, name, rows):
        return write(name, "t[s],x[m],y[m],z[m]\n" + "\n".join(",".join(f"{v:.6f}" for v in row) for row in rows) + "\n")

    def test_captures_are_labelled_window_by_window_and_beside_a_person(self):
        t = numpy.arange(0, 10, 0.02)
        swing = self.track("swing.csv", numpy.c_[t, 0.1 * numpy.sin(6 * t), 0 * t, -0.4 * t + 0.01 * numpy.cos(12 * t)])
        helix = self.track("round.csv", numpy.c_[t, 0.1 * numpy.cos(6 * t), 0.1 * numpy.sin(6 * t), -0.4 * t])
        labels = write("labels.csv", "capture,first_frame,last_frame,label\nswing,0,400,zigzag\nround,0,400,spiral\nround,50,400,zigzag\n")
        text = run("patterns", swing, helix, "--length", "5 cm", "--labels", labels)
        self.assertEqual(text.returncode, 0, text.stderr)
        self.assertIn("agreement 0.667", text.stdout)
        answer = json.loads(run("patterns", swing, helix, "--length", "5 cm", "--json").stdout)
        self.assertEqual([c["windows"][-1]["pattern"] for c in answer["captures"]], ["zigzag", "spiral"])
        self.check_error(run("patterns", swing, "--labels", labels), 2, "labels name the capture \"round\"")
        self.check_error(run("patterns", swing, "--class", "a=zigzag"), 2, "--labels was expected")
        self.check_error(run("patterns", swing, "--length", "5 kg"), 2, "--length")
        short = self.track("short.csv", numpy.c_[t, t, t, t][:9])
        self.check_error(run("patterns", short), 2, "has 9 frames that were seen, expected at least 12")


class Regimes(Case):
    def test_a_body_is_placed_in_the_measured_diagram(self):
        disc = ["immersed_body", "--set", "a=1 cm", "--set", "b=1 cm", "--set", "c=0.75 mm", "--set", "density=2700",
                "--set", "fluid_density=1000", "--set", "nu=1e-6"]
        answer = json.loads(run("regime", *disc, "--json").stdout)
        self.assertAlmostEqual(answer["I_disc"], 0.009940195505498954)
        self.assertAlmostEqual(answer["Re"], 3163.26, places=2)
        self.assertEqual((answer["regime"], answer["beyond"]), ("chaotic", "periodic"))
        text = run("regime", *disc).stdout
        for part in ("I*, disc    0.00994", "I*, ellipse 0.2025", "regime      chaotic", "beyond      periodic"):
            self.assertIn(part, text)
        self.assertIn("a guess", run("regime", *disc[:-1], "nu=1e-3").stderr)
        self.check_error(run("regime", "falling_plate_nd"), 2, "does not say length")


class PatternsPage(Case):
    def test_the_lines_of_the_page_run(self):
        page = (ROOT / "docs" / "patterns.md").read_text()
        shutil.copytree(ROOT / "examples" / "falling_card", FOLDER / "examples" / "falling_card", dirs_exist_ok=True)
        lines = [line for line in page.splitlines() if line.startswith("samara ") and "$SAMARA_DATA" not in line]
        self.assertGreaterEqual(len(lines), 4)
        for line in lines:
            result = subprocess.run([SAMARA, *shlex.split(line)[1:]], cwd=FOLDER, capture_output=True, text=True, timeout=LONGEST)
            self.assertEqual(result.returncode, 0, f"{line}: {result.stderr}")


if __name__ == "__main__":
    main()
