"""Fields of space by the command: built by a plan, asked, exported, and what cannot be done with them."""

import csv
import io
import json
import math
import pathlib
import shutil
import xml.etree.ElementTree

import h5py

from samara_case import FOLDER, Case, book, main, run, write

ROD_PLAN = """model = "heat_rod"
[fixed]
capacity = 3.6e6
length = "20 cm"
[box]
conductivity = [15.0, 60.0]
left = [0.0, 100.0]
amplitude = [-50.0, 50.0]
[time]
end = "10 min"
[tolerance]
relative = 1e-3
"""
AT = ["--set", "conductivity=40", "--set", "left=30", "--set", "amplitude=-20"]
X = ["--set", "x=5 cm"]


def rod():
    return book("rod", ROD_PLAN)


def exact(t, x, k=40.0, left=30.0, amplitude=-20.0, capacity=3.6e6, length=0.2):
    """Sines; the first terms left out are below 1e-7 from t = 1 s on."""
    tau = k * t / (capacity * length * length)
    s = x / length
    sines = sum(32 / (n * math.pi) ** 3 * math.sin(n * math.pi * s) * math.exp(-((n * math.pi) ** 2) * tau)
                for n in range(1, 400, 2))
    return left * (1 - s) + amplitude * sines


def arrays(path):
    """The data arrays of a .vtu file, by name."""
    root = xml.etree.ElementTree.parse(path).getroot()
    assert root.attrib["type"] == "UnstructuredGrid"
    piece = root.find("UnstructuredGrid/Piece")
    found = {"counts": (int(piece.attrib["NumberOfPoints"]), int(piece.attrib["NumberOfCells"]))}
    for array in piece.iter("DataArray"):
        found[array.attrib.get("Name", "points")] = [float(word) for word in array.text.split()]
    return found


class Fields(Case):
    def test_a_point_of_place_time_and_parameters_has_its_temperature(self):
        result = run("query", rod(), *AT, *X, "--at", "1", "1 min", "10 min")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = list(csv.DictReader(io.StringIO(result.stdout)))
        self.assertEqual(list(rows[0])[:3], ["t[s]", "x[m]", "conductivity[W/(m K)]"])
        for row in rows:
            self.assertAlmostEqual(float(row["u[K]"]), exact(float(row["t[s]"]), 0.05), delta=1e-3 * 150)

    def test_derivatives_by_place_and_parameters_are_there(self):
        result = run("query", rod(), *AT, *X, "--at", "60", "--gradient", "--json")
        gradient = json.loads(result.stdout)["outputs"][0]["gradient"]
        step = 1e-4
        slope = (exact(60, 0.05 + step) - exact(60, 0.05 - step)) / (2 * step)
        self.assertAlmostEqual(gradient["x"][0], slope, delta=0.01 * abs(slope) + 1.0)
        self.assertAlmostEqual(gradient["left"][0], 0.75, delta=2e-3)

    def test_info_and_statistics_of_a_field(self):
        result = run("info", rod())
        self.assertIn("model heat_rod: heat conduction in a rod", result.stdout)
        self.assertRegex(result.stdout, r"x +m +space +legendre")
        self.assertRegex(result.stdout, r"points x \d+ times x \d+ places")
        self.assertIn("against the exact solution", result.stdout)
        statistics = json.loads(run("stats", rod(), "--json").stdout)
        self.assertEqual(statistics["inputs"], ["x", "conductivity", "left", "amplitude"])
        mean = statistics["outputs"][0]["mean"]
        # Left and amplitude are 50 and 0 in the mean, and the line from left to 0 half of left over the rod.
        self.assertAlmostEqual(mean[0], 25.0, delta=0.1)

    def test_a_field_is_certified_again_against_its_exact_solution(self):
        result = run("validate", rod(), "--points", 100, "--seed", 5, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        certificate = json.loads(result.stdout)["certificate"]
        self.assertTrue(certificate["met"])
        self.assertGreater(certificate["places"], 20)
        self.assertLess(certificate["max_error"], 1e-3)

    def test_one_time_is_exported_as_a_line_with_its_temperatures(self):
        result = run("export", rod(), "--to", "paraview", *AT, "--at", "1 min", "-o", FOLDER / "rod.vtu")
        self.assertEqual((result.returncode, result.stdout), (0, ""), result.stderr)
        found = arrays(FOLDER / "rod.vtu")
        nodes, lines = found["counts"]
        self.assertEqual(lines, nodes - 1)
        self.assertEqual(found["types"], [3] * lines)
        self.assertEqual(found["connectivity"][:4], [0, 1, 1, 2])
        self.assertEqual(found["offsets"][-1], 2 * lines)
        places = found["points"][::3]
        self.assertEqual((places[0], places[-1]), (0.0, 0.2))
        self.assertEqual(len(found["u[K]"]), nodes)
        for x, u in zip(places, found["u[K]"]):
            self.assertAlmostEqual(u, exact(60, x), delta=1e-3 * 150)

    def test_several_times_are_exported_as_a_series(self):
        result = run("export", rod(), "--to", "paraview", *AT, "--at", 1, 60, "-o", FOLDER / "series.pvd")
        self.assertEqual(result.returncode, 0, result.stderr)
        steps = xml.etree.ElementTree.parse(FOLDER / "series.pvd").getroot().findall("Collection/DataSet")
        self.assertEqual([float(step.attrib["timestep"]) for step in steps], [1.0, 60.0])
        for step in steps:
            found = arrays(FOLDER / step.attrib["file"])
            middle = len(found["u[K]"]) // 2
            self.assertAlmostEqual(found["u[K]"][middle], exact(float(step.attrib["timestep"]), found["points"][3 * middle]),
                                   delta=1e-3 * 150)

    def test_without_times_there_are_eleven(self):
        run("export", rod(), "--to", "paraview", *AT, "-o", FOLDER / "all.pvd")
        steps = xml.etree.ElementTree.parse(FOLDER / "all.pvd").getroot().findall("Collection/DataSet")
        self.assertEqual(len(steps), 11)
        self.assertEqual(float(steps[-1].attrib["timestep"]), 600.0)

    def test_a_thermocouple_at_one_place_tells_the_conductivity(self):
        write("couple.csv", "t,T\n" + "".join(f"{t},{exact(t, 0.07)}\n" for t in range(5, 300, 5)))
        couple = write("couple.toml", 'file = "couple.csv"\n[columns]\nt = { quantity = "t", unit = "s" }\n'
                       'T = { quantity = "u", unit = "K" }\n')
        config = write("couple_fit.toml", 'outputs = ["u"]\nnoise = "estimated"\n[fixed]\nx = "7 cm"\nleft = 30\n')
        result = run("fit", rod(), couple, "--config", config, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        found = {c["name"]: c["value"] for c in json.loads(result.stdout)["coefficients"]}
        # The codebook errs by 1e-3 of 150 K at most, and the temperature changes by 20 K with the conductivity.
        self.assertAlmostEqual(found["conductivity"], 40.0, delta=0.5)
        self.assertAlmostEqual(found["amplitude"], -20.0, delta=0.3)

    def test_the_models_name_the_rod(self):
        self.assertIn("heat_rod", run("models").stdout)
        text = run("models", "heat_rod").stdout
        for word in ["capacity du/dt", "Carslaw", "place, from 0 to length", "W/(m K)", "temperature"]:
            self.assertIn(word, text)
        kinds = {model["name"]: model["kind"] for model in json.loads(run("models", "--json").stdout)["models"]}
        self.assertEqual((kinds["heat_rod"], kinds["vertical_fall"]), ("field", "trajectories"))


class MeshFields(Case):
    """u = k + x + 2 y on the unit square of two triangles, k in [0, 1]: the golden file."""

    BOOK = pathlib.Path(__file__).parent.parent / "codebooks" / "golden" / "codebook_0.6.h5"

    def test_a_point_of_the_mesh_has_its_value_and_derivatives(self):
        result = run("query", self.BOOK, "--set", "x=0.8", "--set", "y=70 cm", "--set", "k=0.3", "--gradient")
        self.assertEqual(result.returncode, 0, result.stderr)
        row = next(csv.DictReader(io.StringIO(result.stdout)))
        self.assertEqual(list(row)[:4], ["x[m]", "y[m]", "k[K]", "u[K]"])
        for name, expected in {"u[K]": 2.5, "du/dx[K/m]": 1, "du/dy[K/m]": 2, "du/dk[1]": 1}.items():
            self.assertAlmostEqual(float(row[name]), expected, places=12)

    def test_points_of_the_mesh_are_asked_for_by_a_table(self):
        table = write("places.csv", "x[cm],y,k\n80,0.7,0.3\n20,0.1,0.5\n")
        result = run("query", self.BOOK, "--points", table, "--gradient")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = list(csv.DictReader(io.StringIO(result.stdout)))
        self.assertEqual([round(float(row["u[K]"]), 12) for row in rows], [2.5, 0.9])
        self.assertEqual([round(float(row["du/dy[K/m]"]), 12) for row in rows], [2, 2])

    def test_a_place_of_a_table_in_no_cell_is_told_with_its_line(self):
        book = FOLDER / "notch.h5"
        shutil.copy(self.BOOK, book)
        with h5py.File(book, "r+") as file:
            file["mesh/points"][3] = [0.7, 0.7]  # the corner was at 1, 1
        table = write("notch.csv", "x,y,k\n0.2,0.1,0.5\n0.9,0.8,0.5\n")
        self.check_error(run("query", book, "--points", table), 5, "notch.csv:3: the point (0.9, 0.8) is in no cell")

    def test_a_node_is_asked_for_by_its_number(self):
        result = json.loads(run("query", self.BOOK, "--set", "node=3", "--set", "k=0.3", "--json").stdout)
        self.assertEqual(result["coordinates"], {"node": 3.0, "k": 0.3})
        self.assertAlmostEqual(result["outputs"][0]["values"][0], 3.3, places=12)

    def test_a_mesh_is_exported_with_its_triangles(self):
        out = FOLDER / "mesh.vtu"
        self.assertEqual(run("export", self.BOOK, "--to", "paraview", "--set", "k=0.5", "-o", out).returncode, 0)
        found = arrays(out)
        self.assertEqual(found["counts"], (4, 2))
        self.assertEqual(found["types"], [5, 5])
        self.assertEqual(found["connectivity"], [0, 1, 2, 3, 2, 1])
        points = [found["points"][3 * i : 3 * i + 3] for i in range(4)]
        for (x, y, z), u in zip(points, found["u[K]"]):
            self.assertEqual(z, 0)
            self.assertAlmostEqual(u, 0.5 + x + 2 * y, places=12)

    def test_statistics_weigh_nodes_by_their_areas(self):
        # Over the square x + 2 y has the mean 3/2 and the variance 5/12, k over its interval 1/2 and 1/12. Nodes that
        # count alike would have the same mean, but a variance of 5/4.
        output = json.loads(run("stats", self.BOOK, "--json").stdout)["outputs"][0]
        self.assertAlmostEqual(output["mean"][0], 2.0, places=12)
        self.assertAlmostEqual(output["deviation"][0], math.sqrt(5 / 12 + 1 / 12), places=12)

    def test_info_tells_of_the_mesh(self):
        self.assertIn("mesh: 4 nodes in x, y m, 2 cells", run("info", self.BOOK).stdout)
        self.assertEqual(json.loads(run("info", self.BOOK, "--json").stdout)["mesh"]["nodes"], 4)

    def test_what_a_mesh_does_not_answer_is_said(self):
        k = ["--set", "k=0.3"]
        self.check_error(run("query", self.BOOK, "--set", "node=1.5", *k), 5, "values of a discrete axis")
        self.check_error(run("query", self.BOOK, "--set", "x=0.8", *k), 2, "y is not set")
        self.check_error(run("query", self.BOOK, "--set", "x=1.8", "--set", "y=0", *k), 5, "x = 1.8 m is outside")
        self.check_error(run("export", self.BOOK, "--to", "paraview", *k, "-o", FOLDER / "m.pvd"), 2, "has none")
        self.check_error(run("validate", self.BOOK), 3, "no exact solution is known of here")


class BadFields(Case):
    def test_a_rod_is_not_simulated_nor_checked(self):
        self.check_error(run("simulate", "heat_rod"), 2, "field of space", "samara build")
        self.check_error(run("models", "heat_rod", "--check"), 2, "heat_rod", "is a field")

    def test_a_rod_is_not_fitted_by_integration(self):
        write("short.csv", "t,T\n1,20\n2,21\n3,22\n")
        couple = write("short_couple.toml", 'file = "short.csv"\n[columns]\nt = { quantity = "t", unit = "s" }\n'
                       'T = { quantity = "u", unit = "K" }\n')
        config = write("short_fit.toml", 'outputs = ["u"]\nnoise = "estimated"\n[fixed]\nx = 0.07\n')
        result = run("fit", rod(), couple, "--config", config, "--reference")
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertIn("field of space", result.stderr.strip().splitlines()[-1])

    def test_a_rod_has_no_windows(self):
        self.check_error(run("query", rod(), *AT, *X, "--until", "1 h"), 2, "field of space", "no trajectories")

    def test_a_codebook_without_space_is_not_drawn(self):
        line = book("line", 'model = "constant_rate"\n[box]\nk = [1.0, 10.0]\n[time]\nend = 10.0\n')
        self.check_error(run("export", line, "--to", "paraview", "--set", "k=2", "-o", FOLDER / "x.vtu"), 2,
                         "has no coordinate of space")

    def test_exports_that_cannot_be(self):
        out = ["-o", FOLDER / "bad.vtu"]
        self.check_error(run("export", rod(), "--to", "paraview", *AT, *out), 2, "holds one time, but there are 11")
        self.check_error(run("export", rod(), "--to", "paraview", *AT, "--at", 1, "-o", FOLDER / "bad.txt"), 2,
                         "expected a name in .vtu")
        self.check_error(run("export", rod(), "--to", "paraview", *AT[:4], "--at", 1, *out), 2, "amplitude is not set")
        self.check_error(run("export", rod(), "--to", "paraview", *AT, "--at", 1e4, *out), 5, "t = 10000 s is outside")
        self.check_error(run("export", rod(), "--to", "excel", *AT, "--at", 1, *out), 2, "excel")
        self.assertFalse((FOLDER / "bad.vtu").exists())
        # Of a series of which one time is outside, nothing is written.
        series = run("export", rod(), "--to", "paraview", *AT, "--at", 1, 1e4, "-o", FOLDER / "bad.pvd")
        self.check_error(series, 5, "t = 10000 s is outside")
        self.assertEqual(list(FOLDER.glob("bad*")), [])

    def test_a_point_beside_the_rod_is_outside(self):
        self.check_error(run("query", rod(), *AT, "--set", "x=0.3"), 5, "x = 0.3 m is outside")

    def test_a_plan_without_a_length_is_told(self):
        plan = write("short.toml", ROD_PLAN.replace('length = "20 cm"\n', ""))
        self.check_error(run("build", plan, "-o", FOLDER / "short.h5"), 3, 'needs "length"')


if __name__ == "__main__":
    main()
