"""Usage: follows_test.py SAMARA [CLASS]

Motions followed frame by frame from the command.
"""

import csv
import json

from samara_case import FOLDER, Case, main, run, write

COIN = ["--set", "area=4.7144e-4", "--set", "thickness=2.55e-3", "--set", "density=6338.5", "--set", "fluid_density=998.2"]
CONFIG = """step = "2 ms"
loss = { scale = "1 mm" }
[fixed]
area = "4.7144e-4 m^2"
thickness = "2.55 mm"
density = "6338.5 kg/m^3"
fluid_density = "998.2 kg/m^3"
"x(0)" = "0 m"
[box]
C_D = [0.6, 2.0]
"v(0)" = ["-0.1 m/s", "0.5 m/s"]
"""


class Follows(Case):
    def fall(self, name, speed, change=lambda k, x: x):
        """A capture of a coin, 0.5 mm off where and now."""
        path = FOLDER / name
        result = run("simulate", "vertical_fall", "--set", "C_D=1.2", *COIN, "--set", f"v(0)={speed}", "--until", "0.4", "--frames", "41")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = list(csv.reader(result.stdout.splitlines()))
        column = rows[0].index("x[m]")
        lines = ["t[s],x[m]"]
        for k, row in enumerate(rows[1:]):
            lines.append(f"{row[0]},{change(k, float(row[column]) + 5e-4 * ((7 * k + round(40 * speed)) % 5 - 2) / 1.4)}")
        return write(path.name, "\n".join(lines) + "\n")

    def fitted(self):
        path = FOLDER / "fit.json"
        if not path.exists():
            result = run("fit", "vertical_fall", self.fall("a.csv", 0.1), self.fall("b.csv", 0.2), "--config", write("fit.toml", CONFIG), "-o", path)
            self.assertEqual(result.returncode, 0, result.stderr)
        return path

    def followed(self, track, *arguments):
        result = run("follow", "vertical_fall", self.fitted(), track, *arguments, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        answer = json.loads(result.stdout)
        self.assertEqual(answer["schema"], "samara-follow/1")
        return answer

    def test_state_and_drag_are_found_with_errors_and_the_next_tenth_of_a_second_is_in_its_band(self):
        answer = self.followed(self.fall("c.csv", 0.15), "--ahead", "0.1 s")
        names = [c["name"] for c in answer["columns"]]
        drag = answer["values"][-1][names.index("C_D")]
        self.assertLess(abs(drag - 1.2), 4 * answer["errors"][-1][names.index("C_D")])
        x = [row[1] for row in csv.reader((FOLDER / "c.csv").read_text().splitlines())][1:]
        inside = 0
        for k in range(15, 31):
            low, high = answer["forecast_lower"][k][0], answer["forecast_upper"][k][0]
            self.assertLess(low, answer["forecast"][k][0])
            inside += low <= float(x[k + 10]) <= high
        self.assertGreaterEqual(inside, 12)
        self.assertIn("taken as exact", answer["warnings"][0])

    def test_frames_after_the_origin_change_no_digit_of_what_was_said_before(self):
        one = self.followed(self.fall("c.csv", 0.15), "--ahead", "0.1 s", "--velocity-noise", "0.1")
        other = self.followed(self.fall("c.csv", 0.15, lambda k, x: x + (0.02 if k > 20 else 0.0)), "--ahead", "0.1 s", "--velocity-noise", "0.1")
        for key in ("values", "errors", "forecast", "forecast_lower", "forecast_upper"):
            self.assertEqual(one[key][:21], other[key][:21], key)
        self.assertNotEqual(one["values"][25], other["values"][25])

    def test_noise_is_chosen_on_captures_to_train(self):
        answer = self.followed(self.fall("c.csv", 0.15), "--train", FOLDER / "a.csv", FOLDER / "b.csv")
        self.assertTrue(answer["noise"]["chosen"])
        self.assertIsNotNone(answer["noise"]["score"])

    def test_what_is_given_is_held_where_the_rest_is_chosen_and_no_noise_is_told_of_that_the_model_lacks(self):
        arguments = [self.fall("c.csv", 0.15), "--train", FOLDER / "a.csv", FOLDER / "b.csv", "--velocity-noise", "0.1", "--drift", "0"]
        noise = self.followed(*arguments)["noise"]
        self.assertEqual([noise[key] for key in ("velocity", "drift", "rate")], [0.1, 0, 0])
        text = " ".join(run("follow", "vertical_fall", self.fitted(), *arguments).stdout.split())
        self.assertIn("of velocities 0.1 m/s (given) per root of a second;", text)
        self.assertIn("drift by 0 (given)", text)
        self.assertNotIn("of rates", text)

    def test_the_table_has_a_row_a_frame_and_empty_cells_before_the_start(self):
        target = FOLDER / "followed.csv"
        result = run("follow", "vertical_fall", self.fitted(), self.fall("c.csv", 0.15), "--ahead", "50 ms", "--start-frames", "5", "-o", target)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("C_D", result.stdout)
        rows = list(csv.DictReader(target.read_text().splitlines()))
        self.assertEqual(len(rows), 41)
        self.assertEqual(rows[3]["C_D[1]"], "")
        self.assertNotEqual(rows[3]["smoothed C_D[1]"], "")
        self.assertNotEqual(rows[4]["C_D[1]"], "")
        self.assertNotEqual(rows[40]["ahead 95 % x[m]"], "")

    def test_a_track_without_a_start_is_said_to_be_none(self):
        result = run("follow", "vertical_fall", self.fitted(), self.fall("c.csv", 0.15), "--start-frames", "100")
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("no start was found", result.stderr)

    def test_a_motion_lost_before_its_last_frame_is_marked_as_missed(self):
        jumping = self.fall("jumping.csv", 0.15, lambda k, x: x + (0.3 * (-1) ** k if k > 30 else 0.0))
        result = run("follow", "vertical_fall", self.fitted(), jumping)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("the motion was lost after", " ".join(result.stderr.split()))
        self.assertIn("at 0.4 s", result.stderr)

    def test_many_frames_far_off_bring_a_warning_one_loss_that_was_found_again_does_not(self):
        def sentences(name, change):
            return " ".join(self.followed(self.fall(name, 0.15, change))["warnings"])

        moved = sentences("moved.csv", lambda k, x: x + (0.3 if k > 20 else 0.0))
        self.assertNotIn("lie farther", moved)
        wild = sentences("wild.csv", lambda k, x: x + (0.05 if k > 10 and k % 5 == 0 else 0.0))
        self.assertRegex(wild, r"\d+ of 33 frames lie farther from the forecast than errors allow")

    def test_what_cannot_be_followed_is_refused_in_a_sentence(self):
        track, fit = self.fall("c.csv", 0.15), self.fitted()
        self.check_error(run("follow", "falling_plate", fit, track), 3, 'a fit of the model "vertical_fall"')
        self.check_error(run("follow", "vertical_fall", fit, track, "--ahead", "-1"), 2, "--ahead is -1")
        self.check_error(run("follow", "vertical_fall", fit, track, "--ahead", "1e9"), 2, "1000000000 s ahead", "a longer step or less ahead")
        self.check_error(run("follow", "vertical_fall", fit, track, "--step", "1e-12", "--train", FOLDER / "a.csv"), 2, "steps of 1e-12 s", "a longer step")
        self.check_error(run("follow", "vertical_fall", fit, track, "--noise", "y=1"), 2, 'no output "y"')
        for more in ((), ("--train", FOLDER / "a.csv")):
            self.check_error(run("follow", "vertical_fall", fit, track, "--rate-noise", "3", *more), 2, "--rate-noise", "3 rad/s", "no state in rad/s")
        self.check_error(run("follow", "vertical_fall", track, track), 3, "the JSON of a fit")
        self.check_error(run("follow", "vertical_fall", fit, track, "--train", FOLDER / "a.csv", track), 3, "is the track that is followed")
        self.check_error(run("follow", "vertical_fall", fit, write("other.csv", "t[s],y[m]\n0,0\n0.1,0\n0.2,0\n")), 3, "other.csv", "measures nothing")
        write("early.csv", "t[s],x[m]\n-0.1,0\n0,0\n0.1,0.1\n0.2,0.2\n")
        early = write("early.toml", 'file = "early.csv"\nstart = "as given"\n')
        self.check_error(run("follow", "vertical_fall", fit, early), 3, "early.csv: ", "a frame is -0.1 s; a finite time from 0 on")
        self.check_error(run("follow", "vertical_fall", fit, track, "--train", early), 3, "early.csv: ", "a frame is -0.1 s")
        held = json.loads(fit.read_text())
        held["fixed"]["delay"] = 0.02
        self.check_error(run("follow", "vertical_fall", write("held.json", json.dumps(held)), track), 3, "held.json: ", 'holds "delay" at 0.02')
        pixels = write("pixels.csv", track.read_text().replace("x[m]", "x[px]", 1))
        self.assertIn("x[px]", pixels.read_text())
        self.check_error(run("follow", "vertical_fall", fit, pixels), 3, 'measures "x" in px; m was expected')
        self.check_error(run("follow", "vertical_fall", fit, track, "--train", pixels), 3, 'measures "x" in px; m was expected')


if __name__ == "__main__":
    main()
