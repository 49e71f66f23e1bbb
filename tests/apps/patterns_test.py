"""Usage: patterns_test.py SAMARA [CLASS]

patterns of captures, and regime: answers, pages, and what they refuse.
"""

import json

import numpy

from samara_case import FOLDER, Case, main, run, write


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
        self.assertEqual(answer["schema"], "samara-patterns/1")
        self.assertEqual([c["windows"][-1]["pattern"] for c in answer["captures"]], ["zigzag", "spiral"])
        self.check_error(run("patterns", swing, "--labels", labels), 3, f"{labels}:3: labels name the capture \"round\"")
        self.check_error(run("patterns", swing, "--class", "a=zigzag"), 2, "--labels was expected")
        self.check_error(run("patterns", swing, "--length", "5 kg"), 2, "--length")
        self.check_error(run("patterns", swing, "--clusters", "3"), 2, "--clusters is of sweeps")
        # Thresholds are those of the call, and stand beside every answer.
        self.assertEqual(answer["thresholds"]["veers"], 2.5)
        asked = json.loads(run("patterns", swing, "--length", "5 cm", "--threshold", "steady_sway=2", "--json").stdout)
        self.assertEqual(asked["captures"][0]["windows"][-1]["pattern"], "steady")
        self.assertEqual(asked["thresholds"]["steady_sway"], 2)
        self.assertIn("steady_sway 2", run("patterns", swing, "--threshold", "steady_sway=2").stdout)
        self.check_error(run("patterns", swing, "--threshold", "steady_swa=2"), 2, "--threshold", "did you mean \"steady_sway\"")
        self.check_error(run("patterns", swing, "--threshold", "veers=-2"), 2, "--threshold", "veers is -2")
        self.check_error(run("patterns", swing, "--threshold", "veers=2", "--threshold", "veers=3"), 2, '--threshold: "veers" is set twice')
        self.check_error(run("patterns", swing, "--set", "a=1"), 2, "--body was expected")
        # One with a gap says so, and the others are answered.
        far = self.track("far.csv", numpy.c_[t, 0.1 * numpy.sin(6 * t), 0 * t, -0.4 * t][(t < 5) | (t > 5.3)])
        both = json.loads(run("patterns", far, swing, "--length", "5 cm", "--report", FOLDER / "both.html", "--json").stdout)["captures"]
        self.assertEqual([[w["pattern"] for w in c["windows"]] for c in both], [["unresolved"], ["zigzag"]])
        self.assertIn("no frames from 4.98 to 5.32 s", both[0]["windows"][0]["why"])
        short = self.track("short.csv", numpy.c_[t, t, t, t][:9])
        self.check_error(run("patterns", short), 3, str(short), "has 9 frames that were seen, expected at least 12")


    def test_the_page_of_captures_cannot_be_made_to_run_what_stands_in_files(self):
        hostile = "<img src=x onerror=alert(1)>&</script>\"'"
        t = numpy.arange(0, 6, 0.02)
        rows = "\n".join(f"{a:.6f},{0.1 * numpy.sin(6 * a):.6f},0,{-0.4 * a:.6f},{{}}" for a in t)
        quoted = '"' + hostile.replace('"', '""') + '"'
        write("two.csv", "t[s],x[m],y[m],z[m],drop\n" + rows.replace("{}", quoted) + "\n" + rows.replace("{}", "b") + "\n")
        sidecar = write("two.toml", 'file = "two.csv"\ngroup_by = ["drop"]\n[columns]\n' + "".join(
            f'"{c}[{u}]" = {{ quantity = "{c}", unit = "{u}" }}\n' for c, u in [("t", "s"), ("x", "m"), ("y", "m"), ("z", "m")]))
        body = ["--body", "immersed_body", "--set", "a=2.5 cm", "--set", "b=2.5 cm", "--set", "c=0.2 mm", "--set", "density=1000"]
        text, data = self.pattern_page(sidecar, *body)
        self.assertNotIn("<img", text)
        self.assertIn(hostile, data["captures"][0]["id"])
        self.assertEqual(len(data["diagram"]["bodies"]), 1)
        self.assertEqual(data["falls"]["groups"], [0, 1])
        told = json.loads(run("regime", "immersed_body", *body[2:], "--json").stdout)
        self.assertEqual(data["diagram"]["bodies"][0]["I_disc"], told["I_disc"])
        self.check_error(run("patterns", sidecar, "--sidecar", sidecar), 2, "every capture given is a sidecar itself; a table file was expected")
        # The body says its length: excursions count in it, as with --length.
        swing = next(f["values"] for f in data["falls"]["features"] if f["name"] == "excursion")
        self.assertLess(abs(swing[0] - 2), 0.1)
        self.check_error(run("patterns", sidecar, "--report", sidecar), 2, "which it would overwrite")


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


if __name__ == "__main__":
    main()
