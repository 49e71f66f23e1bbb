"""Usage: body_test.py SAMARA [CLASS]

Bodies: what their shape or mesh says of mass, inertia and added mass.
"""

import json
import math

from samara_case import FOLDER, Case, main, run, write

CUBE = """v 0 0 0
v 20 0 0
v 20 20 0
v 0 20 0
v 0 0 20
v 20 0 20
v 20 20 20
v 0 20 20
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
f 4 1 5
f 4 5 8
"""
# Without symmetries, for which some outputs would be no more than round-off.
BLOCK = CUBE.replace("v 20 20 20", "v 23 25 27")


def body(*arguments):
    result = run("body", *arguments, "--json")
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


class Bodies(Case):
    def test_a_sphere_drags_half_of_what_it_displaces(self):
        for extra in ([], ["--added-mass", "panels"]):
            answer = body("ellipsoid", "--size", "1 cm", "1 cm", "1 cm", "--density", "2700", "--fluid", "998", *extra)
            volume = 4 / 3 * math.pi * 1e-6
            self.assertAlmostEqual(answer["mass"] / (2700 * volume), 1, delta=1e-12)
            for k in range(3):
                self.assertAlmostEqual(answer["added_mass"][k][k] / (0.5 * 998 * volume), 1, delta=0.03 if extra else 1e-12)
                self.assertAlmostEqual(answer["inertia"][k] / (0.4 * 2700 * volume * 1e-4), 1, delta=1e-12)

    def test_numbers_of_a_disc_and_a_plate(self):
        disc = body("disc", "--size", "12.25 mm", "2.55 mm", "--density", "6338.6", "--fluid", "998.2", "--viscosity", "1.002 mPa s")
        self.assertAlmostEqual(disc["mass"], 6338.6 * math.pi * 0.01225**2 * 2.55e-3, delta=1e-9)
        expected = math.pi * 6338.6 * 2.55e-3 / (64 * 998.2 * 0.0245)
        self.assertAlmostEqual(disc["scaling_numbers"]["inertia_ratio_of_disc"] / expected, 1, delta=1e-9)
        speed = math.sqrt((6338.6 / 998.2 - 1) * 9.81 * 2.55e-3)
        self.assertAlmostEqual(disc["scaling_numbers"]["fall_reynolds_number"] / (speed * 0.0245 * 998.2 / 1.002e-3), 1, delta=1e-9)
        plate = body("plate", "--size", "0.2", "0.1", "0.01", "--density", "1200", "--fluid", "1000")
        self.assertAlmostEqual(plate["inertia"][2] / (1200 * 2e-4 * (0.04 + 0.01) / 12), 1, delta=1e-12)

    def test_the_fluid_that_a_cube_drags_does_not_depend_on_its_direction(self):
        # 0.638 of its volume: the limit of finer meshes. A beam of square section drags as much either way across.
        cube = body("plate", "--size", "1", "1", "1", "--density", "1200", "--fluid", "1000", "--added-mass", "panels")
        for k in range(3):
            self.assertAlmostEqual(cube["added_mass"][k][k] / 638, 1, delta=0.005)
        beam = body("plate", "--size", "1", "0.1", "0.1", "--density", "1200", "--fluid", "1000", "--added-mass", "panels")
        self.assertAlmostEqual(beam["added_mass"][1][1] / beam["added_mass"][2][2], 1, delta=0.02)

    def test_a_mesh_is_weighed_in_its_unit_and_its_lines_make_a_plan(self):
        mesh = write("cube.obj", CUBE)
        answer = body(mesh, "--unit", "mm", "--density", "500", "--fluid", "1000")
        self.assertAlmostEqual(answer["mass"], 500 * 8e-6, delta=1e-12)
        for part, expected in zip(answer["centre_of_mass"], [0.01] * 3):
            self.assertAlmostEqual(part, expected, delta=1e-12)
        self.assertEqual(answer["added_mass_by"], "panels")
        self.assertEqual(body(mesh, "--unit", "mm", "--density", "500", "--fluid", "1000", "--added-mass", "ellipsoid")["added_mass_by"], "ellipsoid")
        mesh = write("block.obj", BLOCK)
        lines = run("body", mesh, "--unit", "mm", "--density", "500", "--fluid", "1000", "--toml").stdout
        self.assertTrue(lines.startswith('model = "kirchhoff_body"\n'))
        plan = lines + '[box]\n"ux(0)" = [0.1, 0.2]\n[time]\nend = "0.1 s"\n'
        self.assertEqual(run("build", write("cube.toml", plan), "-o", FOLDER / "cube.h5").returncode, 0)

    def test_the_few_triangles_of_a_mesh_are_divided_into_panels(self):
        given = ["--density", "2000", "--fluid", "1000"]
        mesh = write("box.obj", CUBE)
        result = run("body", mesh, "--unit", "mm", *given)
        self.assertIn("added mass by 2000 panels, into which the 12 triangles were divided", result.stderr)
        answer, plate = body(mesh, "--unit", "mm", *given), body("plate", "--size", "2 cm", "2 cm", "2 cm", *given, "--added-mass", "panels")
        for k in range(6):  # of twelve panels it was half of it, and nothing of the turns
            self.assertAlmostEqual(answer["added_mass"][k][k] / plate["added_mass"][k][k], 1, delta=0.02 if k < 3 else 0.06)

    def test_a_plan_and_a_simulation_take_the_body_itself(self):
        mesh = write("block.obj", BLOCK)
        given = ["--unit", "mm", "--density", "500", "--fluid", "1000"]
        lines = run("body", mesh, *given, "--toml").stdout
        rest = '[box]\n"ux(0)" = [0.1, 0.2]\n[time]\nend = "0.1 s"\n'
        table = '[body]\nmesh = "block.obj"\nunit = "mm"\ndensity = 500\nfluid_density = "1 g/cm^3"\n'
        answers = []
        for name, plan in (("by_lines", lines + rest), ("by_body", 'model = "kirchhoff_body"\n' + table + rest)):
            book = FOLDER / f"{name}.h5"
            result = run("build", write(f"{name}.toml", plan), "-o", book)
            self.assertEqual(result.returncode, 0, result.stderr)
            answers.append(run("query", book, "--set", "ux(0)=0.15").stdout)
        self.assertEqual(*answers)
        settings = [part for line in lines.splitlines() if " = " in line and "model" not in line
                    for part in ("--set", line.replace(" = ", "="))]
        by_numbers = run("simulate", "kirchhoff_body", *settings, "--set", "ux(0)=0.1").stdout
        self.assertEqual(run("simulate", "kirchhoff_body", "--body", mesh, *given, "--set", "ux(0)=0.1").stdout, by_numbers)
        self.assertNotEqual(run("simulate", "kirchhoff_body", "--body", mesh, *given, "--set", "ux(0)=0.1", "--set", "mass=1").stdout,
                            by_numbers)
        self.check_error(run("simulate", "vertical_fall", "--body", mesh, *given), 2, 'for the model "kirchhoff_body"')
        self.check_error(run("simulate", "kirchhoff_body", "--body", mesh, "--unit", "mm", "--fluid", "1"), 2, "--density")
        self.check_error(run("simulate", "kirchhoff_body", "--density", "500"), 2, "--body was expected")
        for wrong, code, sentence in [(table.replace("block.obj", "none.obj"), 3, "none.obj"),
                                      (table + "size = [1, 2, 3]\n", 3, "size: is of a shape only"),
                                      (table + 'shape = "disc"\n', 3, "one of the two"),
                                      (table.replace("= 500", "= -500"), 3, "-500"),
                                      (table.replace('"mm"', '"kg"'), 3, "kg")]:
            plan = write("wrong.toml", 'model = "kirchhoff_body"\n' + wrong + rest)
            self.check_error(run("build", plan, "-o", FOLDER / "wrong.h5"), code, "wrong.toml" if "none" not in wrong else "none.obj", sentence)
        plan = write("wrong.toml", 'model = "vertical_fall"\n' + table + '[box]\nC_D = [1, 2]\n[time]\nend = 1\n')
        self.check_error(run("build", plan, "-o", FOLDER / "wrong.h5"), 3, '"kirchhoff_body"')

    def test_words_without_an_option(self):
        words = run("body", "plate", "--size", "20 cm", "10 cm", "1 cm", "--density", "1200", "--fluid", "1000").stdout
        self.assertIn("mass            0.24 kg", words)
        self.assertIn("inertia_ratio_of_plate", words)

    def test_bad_bodies(self):
        given = ["--density", "500", "--fluid", "1000"]
        self.check_error(run("body", "disc", "--size", "1 cm", *given), 2, "1 lengths for the shape \"disc\", expected 2: radius and thickness")
        self.check_error(run("body", "plate", "--size", "1", "2", "0", *given), 2, "0")
        self.check_error(run("body", "plate", "--size", "1 kg", "2", "1", *given), 2, "1 kg")
        self.check_error(run("body", "plate", "--size", "1", "2", "1", "--density", "nan", "--fluid", "1"), 2, "nan")
        self.check_error(run("body", "plate", "--size", "1", "2", "1", "--unit", "mm", *given), 2, "a plate has a unit")
        self.check_error(run("body", "disc", "--size", "1 cm", "1 mm", "--added-mass", "panels", *given), 2, "added mass by panels needs a mesh")
        mesh = write("open.obj", CUBE.replace("f 1 3 2\n", ""))
        self.check_error(run("body", mesh, *given), 2, "needs a unit")
        self.check_error(run("body", mesh, "--unit", "mm", *given), 3, "open.obj", "not closed")
        self.check_error(run("body", mesh, "--unit", "kg", *given), 2, "kg")
        self.check_error(run("body", mesh, "--unit", "mm", "--size", "1", *given), 2, "a mesh has a size of its own")
        self.check_error(run("body", mesh, "--unit", "mm", "--added-mass", "guess", *given), 2, "guess")
        for shape in ("sphere", "n" * 300):
            self.check_error(run("body", shape, "--size", "1", *given), 2, f'"{shape}" is no shape (ellipsoid, disc, plate) and no file')
        self.check_error(run("body", "disc", "--size", "1 cm", "1 mm", "--toml", "--viscosity", "1e-3", *given), 2, "--viscosity")
        for wrong in ("-1 mPa s", "0"):
            self.check_error(run("body", "disc", "--size", "1 cm", "1 mm", "--viscosity", wrong, *given), 2, f"--viscosity is {wrong}, expected more than 0")
        self.check_error(run("body", "missing.stl", "--unit", "mm", *given), 3, "missing.stl")


if __name__ == "__main__":
    main()
