"""Usage: answers_test.py SAMARA [CLASS]

Answers of the command: on stdout, exit code 0.
"""

import csv
import json
import math
import pathlib

from samara_case import COIN_PLAN, FOLDER, LINE_PLAN, Case, book, main, run, write


class Answers(Case):
    def test_windows_of_a_codebook_are_composed_to_longer_times(self):
        coin = ["density=6339", "area=4.714e-4", "thickness=2.55e-3"]
        plan = write("window.toml", "model = 'vertical_fall'\n[fixed]\n" + "\n".join(coin) +
                     "\n[box]\nC_D = [0.8, 1.6]\n'v(0)' = [0.0, 0.5]\n[time]\nend = 0.05\n[tolerance]\nrelative = 1e-5\nassurance = 0.925\n")
        window = FOLDER / "window.h5"
        self.assertEqual(run("build", plan, "-o", window).returncode, 0)
        call = ["query", window, "--set", "C_D=1.2", "--until", "1 s"]
        rows = run(*call, "--set", "v(0)=0.2").stdout.splitlines()
        truth = run("simulate", "vertical_fall", *[part for value in coin for part in ("--set", value)],
                    "--set", "C_D=1.2", "--set", "v(0)=0.2", "--until", "1", "--frames", "11").stdout.splitlines()
        self.assertEqual(rows[0], "t[s],C_D[1],v(0)[m/s],v[m/s],x[m]")
        self.assertEqual(len(rows), 12)
        for row, other in zip(rows[1:], truth[1:]):
            self.assertAlmostEqual(float(row.split(",")[4]), float(other.split(",")[2]), delta=1e-4)
        answer = json.loads(run(*call, "--set", "v(0)=0.2", "--json").stdout)
        self.assertEqual([output["name"] for output in answer["outputs"]], ["v", "x"])
        self.assertNotIn("certificate_met", answer)  # it is of one window
        # Of less drag the terminal speed, 0.58 m/s, is outside the box.
        far = run("query", window, "--set", "C_D=0.8", "--set", "v(0)=0.49", "--until", "2")
        self.assertEqual(far.returncode, 5)
        self.assertRegex(far.stderr, r"left the box at t = [0-9.]+: v = 0\.5\d* m/s is outside \[0, 0\.5\]; values after t = [0-9.]+ are empty")
        self.assertTrue(far.stdout.splitlines()[-1].endswith(",,"))
        told = run("query", window, "--set", "C_D=0.8", "--set", "v(0)=0.49", "--until", "2", "--json")  # compared with its schema
        self.assertIsNone(json.loads(told.stdout)["outputs"][0]["values"][-1])
        self.check_error(run(*call, "--set", "v(0)=0.7"), 5, "left the box at t = 0: v = 0.7")
        self.check_error(run(*call, "--set", "v(0)=0.2", "--gradient"), 2, "none of --at, --gradient and --clamp")
        self.check_error(run("query", window, "--set", "C_D=1.2", "--set", "v(0)=0.2", "--until", "0"), 2, "more than 0")

    def test_models_lists_every_model_and_explains_one(self):
        self.assertIn("vertical_fall", run("models").stdout)
        text = run("models", "vertical_fall").stdout
        for part in ["C_D", "kg/m^3", "8/3", "source"]:
            self.assertIn(part, text)
        models = json.loads(run("models", "--json").stdout)
        self.assertEqual(models["schema"], "samara-models/1")
        self.assertIn("quadratic_drag_fall", [m["name"] for m in models["models"]])

    def test_models_says_what_a_force_is_made_of(self):
        text = run("models", "falling_plate").stdout
        for part in ["affine in:", "C_T, C_R, A, B, mu1, mu2", "symmetries:", "translation of x", "force term",
                     "gravity and buoyancy", "(m + m11) vx' = "]:
            self.assertIn(part, text)
        self.assertLessEqual(max(len(line) for line in text.splitlines()), 110)
        model, = json.loads(run("models", "falling_plate", "--json").stdout)["models"]
        self.assertEqual(model["affine_in"], ["C_T", "C_R", "A", "B", "mu1", "mu2"])
        self.assertEqual(model["force_units"], {"force": "N/m", "torque": "N", "power": "W/m"})
        self.assertEqual([term["name"] for term in model["force_terms"]],
                         ["inertia", "translational lift", "rotational lift", "drag", "dissipation",
                          "gravity and buoyancy"])

    def test_every_model_is_explained_within_the_width_of_a_page(self):
        for line in run("models").stdout.splitlines():
            name = line.split()[0]
            text = run("models", name).stdout
            self.assertIn("source:", text)
            self.assertLessEqual(max(len(row) for row in text.splitlines()), 120, name)

    def test_simulate_runs_the_reference_plate(self):
        # The model sheet's state of I* = 1.1 at t = 5, thin plate.
        result = run("simulate", "falling_plate_nd", "--set", "beta=0", "--set", "w(0)=0.001", "--set",
                     "theta(0)=0.7853981633974483", "--until", "5", "--frames", "2")
        header, _, last = csv.reader(result.stdout.splitlines())
        self.assertEqual(header, ["t[1]", "vx[1]", "vy[1]", "w[1]", "theta[1]", "x[1]", "y[1]"])
        state = [0.755521995, -0.371934127, -0.058302197, -1.602042954, -2.633326975, -1.65421933]
        for value, expected in zip(last[1:], state):
            self.assertAlmostEqual(float(value), expected, delta=1e-6)

    def test_simulate_breaks_the_force_down_by_term(self):
        arguments = ["--set", "semi_chord=7 mm", "--set", "semi_thickness=0.5 mm", "--set", "density=2.7 g/cm^3"]
        result = run("simulate", "falling_plate", *arguments, "--until", "1", "--frames", "2001", "--forces")
        rows = list(csv.DictReader(result.stdout.splitlines()))
        powers = [name for name in rows[0] if name.endswith(".power[W/m]")]
        self.assertEqual(len(powers), 6)
        for name in ["drag.Fx[N/m]", "drag.Fy[N/m]", "dissipation.T[N]", "kinetic_energy[J/m]"]:
            self.assertIn(name, rows[0])
        # The energy gained is the work of all terms, by the trapezoidal rule: a part in 1e4 at this spacing.
        work = sum(float(row[name]) for row in rows for name in powers)
        work -= 0.5 * sum(float(row[name]) for row in (rows[0], rows[-1]) for name in powers)
        gain = float(rows[-1]["kinetic_energy[J/m]"]) - float(rows[0]["kinetic_energy[J/m]"])
        self.assertAlmostEqual(work * 1.0 / 2000, gain, delta=1e-4 * abs(gain))
        # Without the flag nothing but the states.
        plain = run("simulate", "falling_plate", *arguments, "--until", "1", "--frames", "2").stdout
        self.assertEqual(len(plain.splitlines()[0].split(",")), 7)

    def test_simulate_by_any_integrator_gives_the_same_fall(self):
        fall = ["simulate", "falling_plate_nd", "--set", "theta(0)=0.4", "--until", "2", "--frames", "3"]
        last = {}
        for integrator in [[], ["--integrator", "adaptive"], ["--integrator", "rk4", "--step", "0.005"]]:
            result = run(*fall, *integrator)
            self.assertEqual(result.returncode, 0)
            last[str(integrator)] = [float(v) for v in result.stdout.splitlines()[-1].split(",")]
        reference, *others = last.values()
        for other in others:
            for a, b in zip(reference, other):
                self.assertAlmostEqual(a, b, delta=1e-7)

    def test_simulate_refuses_steps_that_do_not_suit_the_integrator(self):
        fall = ["simulate", "constant_rate", "--set", "k=2"]
        self.check_error(run(*fall, "--integrator", "rk4"), 2, "--step was expected")
        self.check_error(run(*fall, "--step", "0.1"), 2, "no --step was expected")
        self.check_error(run(*fall, "--integrator", "rk4", "--step", "0"), 2, "--step")
        self.check_error(run(*fall, "--integrator", "rkmk", "--step", "0.1"), 2, "quaternion")

    def test_every_model_is_explained_on_few_pages(self):
        for model in json.loads(run("models", "--json").stdout)["models"]:
            lines = run("models", model["name"]).stdout.splitlines()
            self.assertLess(len(lines), 160, model["name"])
            self.assertLess(max(map(len, lines)), 125, model["name"])

    def test_simulate_prints_the_exact_fall(self):
        result = run("simulate", "quadratic_drag_fall", "--set", "C_D=1", "--until", "0.5", "--frames", "6")
        rows = list(csv.reader(result.stdout.splitlines()))
        self.assertEqual(rows[0], ["t[s]", "u[m/s]"])
        speed = math.sqrt(2 * 0.1 * 9.81 / (1.23 * 0.5))
        for t, u in rows[1:]:
            self.assertAlmostEqual(float(u), -speed * math.tanh(9.81 * float(t) / speed), delta=1e-8)

    def test_a_density_that_looks_like_grams_per_cubic_centimetre_is_warned_of(self):
        call = ["simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7e-4", "--set", "thickness=2.5e-3",
                "--until", "0.1"]
        result = run(*call, "--set", "density=6.3")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("warning: the solid has a density of 6.3 kg/m^3", result.stderr)
        self.assertEqual(run(*call, "--set", "density=6.3 g/cm^3").stderr, "")

    def test_values_may_carry_units(self):
        arguments = ["simulate", "vertical_fall", "--set", "C_D=1", "--set", "density=6.3 g/cm^3", "--set", "area=4.7 cm^2",
                     "--set", "thickness=2.5 mm", "--until", "100 ms", "--frames", "2"]
        plain = ["simulate", "vertical_fall", "--set", "C_D=1", "--set", "density=6300", "--set", "area=4.7e-4",
                 "--set", "thickness=2.5e-3", "--until", "0.1", "--frames", "2"]
        left, right = (list(csv.reader(run(*a).stdout.splitlines())) for a in (arguments, plain))
        self.assertEqual(left[0], right[0])
        for a, b in zip(left[2], right[2]):
            self.assertAlmostEqual(float(a), float(b), delta=1e-14)

    def test_query_gives_values_and_derivatives(self):
        path = book("line", LINE_PLAN)
        result = run("query", path, "--set", "k=4", "--at", "7", "2", "--gradient")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        rows = list(csv.reader(result.stdout.splitlines()))
        self.assertEqual(rows[0], ["t[1]", "k[1]", "u[1]", "du/dt[1]", "du/dk[1]"])
        # u = (10 / k - 1) t, so du/dt = 1.5 and du/dk = -10 t / k^2.
        for row, t in zip(rows[1:], [7.0, 2.0]):
            for got, exact in zip(map(float, row), [t, 4.0, 1.5 * t, 1.5, -10.0 * t / 16.0]):
                self.assertAlmostEqual(got, exact, delta=1e-6)

    def test_query_as_json_is_one_object_with_a_schema(self):
        path = book("line", LINE_PLAN)
        answer = json.loads(run("query", path, "--set", "k=4", "--json", "--gradient").stdout)
        self.assertEqual(answer["schema"], "samara-query/1")
        self.assertEqual(len(answer["outputs"][0]["values"]), 11)
        self.assertEqual(set(answer["outputs"][0]["gradient"]), {"t", "k"})
        self.assertTrue(answer["certificate_met"])

    def test_clamp_takes_the_nearest_point_and_says_so(self):
        path = book("line", LINE_PLAN)
        clamped = run("query", path, "--set", "k=11", "--at", "3", "--clamp")
        self.assertEqual(clamped.returncode, 0)
        self.assertIn("k was moved", clamped.stderr)
        self.assertEqual(clamped.stdout, run("query", path, "--set", "k=10", "--at", "3").stdout)

    def test_answers_go_to_a_file_when_asked(self):
        path = book("line", LINE_PLAN)
        target = FOLDER / "answer.csv"
        result = run("query", path, "--set", "k=4", "-o", target)
        self.assertEqual(result.stdout, "")
        self.assertEqual(target.read_text(), run("query", path, "--set", "k=4").stdout)

    def test_info_shows_axes_certificate_and_provenance(self):
        path = book("line", LINE_PLAN)
        text = run("info", path).stdout
        for part in ["constant_rate", "chebyshev", "certificate: met", "made by samara"]:
            self.assertIn(part, text)
        info = json.loads(run("info", path, "--json").stdout)
        self.assertEqual(info["schema"], "samara-info/1")
        self.assertIsNone(info["certificate"]["norm_defect"])  # there is no attitude
        self.assertTrue(info["certificate"]["met"])
        self.assertGreaterEqual(info["certificate"]["points"], 2000)

    def test_a_codebook_with_a_front_answers_and_says_what_it_cannot(self):
        path = pathlib.Path(__file__).parent.parent / "codebooks" / "golden" / "codebook_0.7.h5"
        self.assertIn("C is counted from a front that moves with k and h", run("info", path).stdout)
        info = json.loads(run("info", path, "--json").stdout)
        self.assertEqual(info["front"], {"coordinate": "C", "others": ["k", "h"]})
        C, k, h = 1.3, 0.8, -1.5
        K, H = 2 * k - 1, h / 2
        front = 0.1 + 0.2 * K - 0.3 * H + 0.15 * K * (2 * H * H - 1)
        s = 2 + (C - 2 - front) / (1 - front * (C - 2))
        answer = json.loads(run("query", path, "--set", f"C={C}", "--set", f"k={k}", "--set", f"h={h}", "--set", "m=0.5", "--at", 1, "--json").stdout)
        self.assertAlmostEqual(answer["outputs"][0]["values"][0], 2 * s + k * k + 0.5, places=12)
        self.assertIn("counted from a front", run("stats", path).stderr)
        self.check_error(run("export", path, "--to", "flat", "-o", FOLDER / "front.flat"), 2, '"C" is counted from a front')
        self.check_error(run("explore", path, "-o", FOLDER / "front.html"), 2, '"C" is counted from a front')

    def test_stats_are_those_of_the_function_over_the_box(self):
        # u = (10/k - 1) t over k in [1, 10]: mean t (10 ln 10/9 - 1), variance t^2 (10 - (10 ln 10/9)^2); k is all there is.
        stats = json.loads(run("stats", book("line", LINE_PLAN), "--json").stdout)
        self.assertEqual(stats["schema"], "samara-stats/1")
        self.assertEqual(stats["inputs"], ["k"])
        output = stats["outputs"][0]
        mean = 10 * math.log(10) / 9
        for t, found, deviation, total in zip(stats["times"], output["mean"], output["deviation"], output["total"]["k"]):
            self.assertAlmostEqual(found, t * (mean - 1), delta=1e-6)
            self.assertAlmostEqual(deviation, t * math.sqrt(10 - mean**2), delta=1e-6)
            if t > 1e-6:
                self.assertAlmostEqual(total, 1.0, delta=1e-9)

    def test_stats_take_distributions_of_inputs(self):
        # u = (10/k - 1) t: falling in k, so that its quantiles are those of k, from the other end.
        plan = book("line", LINE_PLAN)
        stats = json.loads(run("stats", plan, "--json", "--set", "k=lognormal(3, 0.1)", "--quantiles", "0.1", "0.5").stdout)
        output = stats["outputs"][0]
        for t, tenth, half, mean in zip(stats["times"], *output["quantiles"], output["mean"]):
            self.assertAlmostEqual(half, t * (10 / 3 - 1), delta=0.01 * t + 1e-9)
            self.assertAlmostEqual(tenth, t * (10 / (3 * math.exp(0.1 * 1.2815515655)) - 1), delta=0.01 * t + 1e-9)
            self.assertAlmostEqual(mean, t * (10 / 3 * math.exp(0.005) - 1), delta=1e-5)
        part = json.loads(run("stats", plan, "--json", "--set", "k=2..4").stdout)["outputs"][0]["mean"]
        for t, mean in zip(stats["times"], part):
            self.assertAlmostEqual(mean, t * (5 * math.log(2) - 1), delta=1e-6)
        for wrong, sentence in [("k=5", "no free parameter"), ("k=normal(3)", "normal(1.1, 0.05)"), ("k=gauss(3, 1)", "gauss"),
                                ("k=normal(30, 1)", "outside the codebook's box"), ("q=3", "unknown name"),
                                ("k=4..2", "below the largest"), ("k=normal(3, 1e-17)", "below rounding")]:
            self.check_error(run("stats", plan, "--set", wrong), 2, sentence)
        for wrong, sentence in [(["0", "1"], "a quantile is asked for at 0, expected a share above 0 and below 1"), (["0.5", "1"], "asked for at 1,"),
                                (["0.5", "0.1", "0.50"], "the quantile at 0.5 is asked for twice"), (["nan"], "nan")]:
            self.check_error(run("stats", plan, "--quantiles", *wrong), 2, sentence)
        self.check_error(run("stats", plan, "--group", "k"), 2, "--group \"k\"", "a single input")

    def test_a_unit_behind_a_range_holds_for_both_of_its_ends(self):
        of_both, behind = (run("stats", book("coin", COIN_PLAN), "--json", "--set", f"v(0)={text}") for text in ("1 cm/s..30 cm/s", "1..30 cm/s"))
        self.assertEqual(behind.returncode, 0, behind.stderr)
        self.assertEqual(behind.stdout, of_both.stdout)

    def test_stats_take_the_covariance_of_a_fit(self):
        coin = book("coin", COIN_PLAN)
        fall = run("simulate", "vertical_fall", "--set", "C_D=1.2", "--set", "area=4.7144e-4", "--set", "thickness=2.55e-3",
                   "--set", "density=6338.5", "--set", "v(0)=0.15", "--until", "0.35", "--frames", "22").stdout.splitlines()
        files = []
        for k in range(4):
            rows = [row.split(",") for row in fall[1:]]
            moved = [f"{r[0]},{float(r[2]) + 2e-4 * math.sin(7 * i + 3 * k)}" for i, r in enumerate(rows)]
            files.append(write(f"fall{k}.csv", "\n".join(["t[s],x[m]", *moved]) + "\n"))
        fitted = run("fit", coin, *files, "-o", FOLDER / "falls.json")
        self.assertEqual(fitted.returncode, 0, fitted.stderr)
        answer = json.loads((FOLDER / "falls.json").read_text())
        coefficient = next(c for c in answer["coefficients"] if c["name"] == "C_D")
        said = run("stats", coin, "--fit", FOLDER / "falls.json", "--set", "v(0)=0.15", "--json", "--quantiles", "0.5")
        self.assertEqual(said.returncode, 0, said.stderr)
        stats = json.loads(said.stdout)
        self.assertEqual(stats["inputs"], ["C_D"])
        point = run("query", coin, "--set", f"C_D={coefficient['value']}", "--set", "v(0)=0.15", "--at", "0.4", "--gradient", "--json")
        x = next(o for o in json.loads(point.stdout)["outputs"] if o["name"] == "x")
        found = next(o for o in stats["outputs"] if o["name"] == "x")
        expected = abs(x["gradient"]["C_D"][0]) * coefficient["standard_error"]
        self.assertAlmostEqual(found["deviation"][-1] / expected, 1, delta=0.05)
        self.assertAlmostEqual(found["quantiles"][0][-1], x["values"][0], delta=0.1 * expected)
        answer["covariance"] = []
        self.check_error(run("stats", coin, "--fit", write("bare.json", json.dumps(answer))), 3, "bare.json", "covariance")
        self.check_error(run("stats", coin, "--fit", write("none.json", "{}")), 3, "none.json")

    def test_indices_are_left_out_where_an_output_varies_less_than_its_error(self):
        # x(0) is fixed, so that x varies with t^2; what a coarse codebook says of early times is its own error.
        coarse, fine = book("coin", COIN_PLAN), book("coin6", COIN_PLAN.replace("relative = 1e-3", "relative = 1e-6"))
        said = run("stats", coarse, "--json")
        rough, sharp = json.loads(said.stdout), json.loads(run("stats", fine, "--json").stdout)
        compared = left_out = 0
        for a, b in zip(rough["outputs"], sharp["outputs"]):
            for name in rough["inputs"]:
                known = [(t, i) for t, i in zip(sharp["times"], b["first_order"][name]) if i is not None]
                for t, index in zip(rough["times"], a["first_order"][name]):
                    if index is None:
                        left_out += 1
                        continue
                    near_t, near = min(known, key=lambda pair: abs(pair[0] - t))
                    if abs(near_t - t) > 5e-3:
                        continue
                    compared += 1
                    self.assertAlmostEqual(index, near, delta=0.05, msg=f"{a['name']}, {name}, t = {t}")
        self.assertGreater(compared, 10)
        self.assertGreater(left_out, 0)
        self.assertIn("Sobol' indices of x are left out at", said.stderr)

    def test_validate_certifies_again_on_other_points(self):
        path = book("line", LINE_PLAN)
        a = json.loads(run("validate", path, "--points", "500", "--seed", "3", "--json").stdout)["certificate"]
        b = json.loads(run("validate", path, "--points", "500", "--seed", "4", "--json").stdout)["certificate"]
        self.assertTrue(a["met"] and b["met"])
        self.assertEqual(a["points"], 500)
        self.assertNotEqual(a["outputs"][0]["worst"], b["outputs"][0]["worst"])


if __name__ == "__main__":
    main()
