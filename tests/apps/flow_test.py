"""Flows by the command: solved from a plan, told, drawn, exported, and what is refused."""

import json
import os
import re
import struct
import xml.etree.ElementTree
import zlib

import h5py
import numpy

from samara_case import FOLDER, LINE_PLAN, Case, book, main, run, write

PLAN = """title = "small"
[flow]
shape = { kind = "ellipse", length = 1, thickness = 1 }
reynolds = 30
turbulence = "none"
cells_per_length = 6
extent = { before = 3, behind = 6, side = 3 }
end = "steady"
max_time = 80
"""


def flow():
    path = FOLDER / "wake.h5"
    if not path.exists():
        result = run("flow", write("wake.toml", PLAN), "-o", path)
        assert result.returncode == 0, result.stderr
        assert "flow, steady" in result.stdout
    return path


def pixels(path):
    """Of a PNG of 8 bits with no filters: height x width x 3."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        content = data[at + 8:at + 8 + length]
        checksum, = struct.unpack(">I", data[at + 8 + length:at + 12 + length])
        assert checksum == zlib.crc32(kind + content)
        if kind == b"IHDR":
            size = struct.unpack(">II", content[:8])
        if kind == b"IDAT":
            packed += content
        at += 12 + length
    rows = numpy.frombuffer(zlib.decompress(packed), dtype=numpy.uint8).reshape(size[1], 1 + 3 * size[0])
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(size[1], size[0], 3)


class Flows(Case):
    def test_a_plan_becomes_a_file_that_h5py_reads(self):
        with h5py.File(flow()) as file:
            self.assertEqual(file.attrs["format"], b"samara-flow")
            u, x, y = file["centre/u"][:], file["axes/x"][:], file["axes/y"][:]
            faces = file["fields/u"][:]
            self.assertEqual(u.shape, (len(y), len(x)))
            self.assertLess(numpy.abs(u - 0.5 * (faces[:, 1:] + faces[:, :-1])).max(), 1e-14)
            # What flows in flows out, and the body's shadow is slow.
            self.assertAlmostEqual(faces[:, 0].sum(), faces[:, -1].sum(), delta=1e-4)
            behind = u[len(y) // 2, numpy.searchsorted(x, 0.8)]
            self.assertLess(behind, 0.3)
            self.assertEqual(file["centre/u"].dims[1][0].name, "/axes/x")
            drag = file["loads"].attrs["C_D"]
            self.assertAlmostEqual(file["loads/drag"][-1], drag, delta=1e-3)
            # 1.75 without borders; the sides are near.
            self.assertAlmostEqual(drag, 2.1, delta=0.35)

    def test_info_tells_it_to_people_and_programs(self):
        words = run("info", flow())
        self.assertIn("flow, steady", words.stdout)
        self.assertNotIn("(95 %)", words.stdout)  # no mean of periods
        told = json.loads(run("info", flow(), "--json").stdout)
        self.assertEqual(told["schema"], "samara-flow-info/1")
        self.assertEqual(told["status"], "steady")
        self.assertLess(told["checks"]["force_disagreement"], 1e-10)
        said = float(re.search(r"C_D ([0-9.]+)", words.stdout)[1])
        self.assertAlmostEqual(said, told["C_D"], delta=1e-3)

    def test_a_picture_shows_the_body_the_colours_and_the_lines(self):
        path = FOLDER / "speed.png"
        result = run("picture", flow(), "--field", "speed", "--scale", "8", "--no-streamlines", "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        plain = pixels(path)
        self.assertEqual(run("picture", flow(), "--field", "speed", "--scale", "8", "-o", path).returncode, 0)
        lines = pixels(path)
        height, width = 36 * 8, 54 * 8
        # The body's centre lies 3 lengths of 6 cells behind the left border and in the middle.
        row, column = 14 + 28 + height // 2, 14 + 18 * 8
        self.assertEqual(plain[row, column].tolist(), [110, 110, 110])
        grey = (plain[42:42 + height, 14:14 + width] == 110).all(axis=2).sum()
        self.assertAlmostEqual(grey / 64 / 36, numpy.pi / 4, delta=0.12)
        self.assertGreater((lines != plain).any(axis=2).sum(), 5000)
        # The bar: yellow at its top, dark violet at its end.
        bar = 14 + width + 20 + 12
        for row, colour in [(43, [253, 231, 37]), (41 + height, [68, 1, 84])]:
            self.assertLess(numpy.abs(plain[row, bar].astype(int) - colour).max(), 5)
        self.check_error(run("picture", flow(), "--field", "kk", "-o", path), 2, 'no field "kk"', 'did you mean "k"')

    def test_paraview_is_given_where_the_numbers_are(self):
        path = FOLDER / "wake.xdmf"
        self.assertEqual(run("export", flow(), "--to", "paraview", "-o", path).returncode, 0)
        root = xml.etree.ElementTree.parse(path).getroot()
        with h5py.File(flow()) as file:
            for item in root.iter("DataItem"):
                if item.attrib["Format"] != "HDF":
                    continue
                name, dataset = item.text.split(":")
                self.assertEqual(name, "wake.h5")
                self.assertEqual(" ".join(map(str, file[dataset].shape)), item.attrib["Dimensions"])
        self.check_error(run("export", flow(), "--to", "paraview", "-o", FOLDER / "wake.vtu"), 2, "expected a name in .xdmf")

    def test_a_body_moves_on_the_path_of_its_plan(self):
        moving = PLAN.replace('end = "steady"\nmax_time = 80\n', "max_time = 1.5\n").replace("before = 3, behind = 6", "before = 3, behind = 3")
        motion = '[motion]\nx = "-0.5*sin(2*pi*t)"\nangle = "t"\nstream = 0\nperiod = 0.25\n'
        path = FOLDER / "moving.h5"
        result = run("flow", write("moving.toml", moving + motion), "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("the body moves; fields are those of t = 1.5", result.stdout)
        self.assertFalse((FOLDER / "moving.h5.checkpoint").exists())
        with h5py.File(path) as file:
            t, x, drag = file["loads/t"][:], file["loads/x"][:], file["loads/drag"][:]
            self.assertEqual(t[-1], 1.5)
            self.assertLess(numpy.abs(x + 0.5 * numpy.sin(2 * numpy.pi * t)).max(), 1e-12)
            self.assertLess(numpy.abs(file["loads/angle"][:] - t).max(), 1e-12)
            # The body's grey is where the path ends: at the middle again.
            open_cells, places = file["body/open"][:], file["axes/x"][:]
            self.assertAlmostEqual(((1 - open_cells).sum(axis=0) * places).sum() / (1 - open_cells).sum(), x[-1], delta=0.03)
            # Drag and inertia hold it back.
            velocity = -numpy.pi * numpy.cos(2 * numpy.pi * t)
            self.assertLess((drag * velocity).sum(), 0)
        told = json.loads(run("info", path, "--json").stdout)
        self.assertTrue(told["moving"])
        self.assertLess(told["checks"]["force_disagreement"], 1e-10)
        self.check_error(run("flow", write("far.toml", moving + motion.replace("-0.5", "3")), "-o", FOLDER / "far.h5"), 3, "far.toml:9: motion: ", "of a border at t = ")
        self.assertFalse((FOLDER / "far.h5").exists())
        for line, *words in [('x = "-0.5*sn(t)"', "x", "sn"), ("", "motion: has no path"), ('x = "t"\nperiod = 2', "period", "is 2", "at most max_time, 1.5"), ('x = "t"\nstream = -1', "stream", "is -1"), ('x = "t"\nstream = 1e59', "bad.toml:11", "stream", "is 1e+59, expected its speed in U, from 0 to 1000"),
                             ('x = "t"\nperiod = 0', "period", "is 0"), ('x = "t"\nz = "t"', "z"), ('x = "1 [m]"', "without a unit")]:
            self.check_error(run("flow", write("bad.toml", moving + "[motion]\n" + line), "-o", FOLDER / "bad.h5"), 3, *words)
        self.check_error(run("flow", write("bad.toml", moving.replace("max_time", 'end = "mean"\nmax_time') + motion), "-o", FOLDER / "bad.h5"), 3, "end")

    def test_a_mean_that_is_not_reached_is_marked_and_has_exit_code_4(self):
        plan = write("short.toml", PLAN.replace("max_time = 80", "max_time = 1"))
        result = run("flow", plan, "-o", FOLDER / "short.h5")
        self.assertEqual(result.returncode, 4)
        self.assertIn("short.h5 is written and marked: the flow still changes by", result.stderr)
        told = run("info", FOLDER / "short.h5").stdout
        self.assertIn("flow, max_time", told)
        self.assertIn("of unknown error", told)
        # What took hours is kept, also from a plan that is refused, and a longer run goes on from it.
        kept = FOLDER / "short.h5.checkpoint"
        self.check_error(run("flow", plan, "-o", FOLDER / "short.h5"), 2, "a max_time after that was expected")
        bad = write("bad_short.toml", PLAN.replace("side = 3", "side = 1.5"))
        self.assertEqual(run("flow", bad, "-o", FOLDER / "short.h5", "--fresh").returncode, 3)
        leaving = write("leaving.toml", PLAN.replace('end = "steady"', 'end = "time"') + '[motion]\nx = "4*t"\n')
        self.check_error(run("flow", leaving, "-o", FOLDER / "short.h5", "--fresh"), 3, "of a border at t = ")
        other = write("other_short.toml", PLAN.replace("thickness = 1", "thickness = 0.9"))
        self.check_error(run("flow", other, "-o", FOLDER / "short.h5"), 3, "checkpoint of another case", "--fresh")
        self.assertTrue(kept.exists())
        longer = write("longer.toml", PLAN)
        self.assertEqual(run("flow", longer, "-o", FOLDER / "short.h5").returncode, 0)
        self.assertFalse(kept.exists())
        with h5py.File(FOLDER / "short.h5") as one, h5py.File(flow()) as whole:
            self.assertTrue((one["fields/u"][:] == whole["fields/u"][:]).all())

    def test_a_flow_that_diverges_leaves_its_last_state_and_no_file(self):
        path = FOLDER / "diverging.h5"
        self.assertEqual(run("flow", write("diverging.toml", PLAN.replace("max_time = 80", "max_time = 1")), "-o", path).returncode, 4)
        path.unlink()
        # A state as no step leaves it: the next one is not finite.
        with h5py.File(f"{path}.checkpoint", "r+", libver="latest") as file:
            file["p"][len(file["p"]) // 3] = 1e308
        result = run("flow", write("diverging.toml", PLAN), "-o", path)
        self.check_error(result, 4, "the flow diverged: a value is not finite", "l/U, step", "cell (", "no file is written",
                         "diverging.h5.checkpoint keeps the state of at most a minute before")
        self.assertFalse(path.exists())
        self.assertTrue((FOLDER / "diverging.h5.checkpoint").exists())

    def test_the_model_of_high_reynolds_numbers_warns_where_they_are_low(self):
        slow = PLAN.replace('"none"', '"k-epsilon"').replace("reynolds = 30", "reynolds = 900").replace("max_time = 80", "max_time = 0.2")
        result = run("flow", write("slow.toml", slow), "-o", FOLDER / "slow.h5")
        self.assertIn('k-epsilon is a model of high Reynolds numbers, and this is 900: expected turbulence = "none"', result.stderr)
        fast = run("flow", write("fast.toml", slow.replace("= 900", "= 1100")), "-o", FOLDER / "slow.h5", "--fresh")
        self.assertNotIn("high Reynolds numbers", fast.stderr)

    def test_a_mean_of_no_period_has_no_error(self):
        plan = write("mean.toml", PLAN.replace('"steady"', '"mean"').replace("max_time = 80", "max_time = 1"))
        result = run("flow", plan, "-o", FOLDER / "mean.h5")
        self.assertEqual(result.returncode, 4)
        self.assertIn("0 whole periods were averaged, expected at least 5; the fields are those of one instant", result.stderr)
        self.assertNotIn("nan", result.stdout + result.stderr)
        self.assertIn("Strouhal number unknown", result.stdout)
        told = json.loads(run("info", FOLDER / "mean.h5", "--json").stdout)
        with h5py.File(FOLDER / "mean.h5") as file:
            for name in ["C_D_half_width", "C_D_rms", "C_L_rms", "strouhal"]:
                self.assertIsNone(told[name])
                self.assertNotIn(name, file["loads"].attrs)
        self.assertEqual(run("picture", FOLDER / "mean.h5", "--field", "u", "-o", FOLDER / "mean.png").returncode, 0)

    def test_a_mesh_in_space_stands_in_the_flow(self):
        # A box of 2 x 1 x 1: the longest extent becomes a body length.
        corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 2)]
        sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        text = "".join("v {} {} {}\n".format(*corner) for corner in corners)
        for a, b, c, d in sides:
            text += f"f {a + 1} {b + 1} {c + 1}\nf {a + 1} {c + 1} {d + 1}\n"
        write("box.obj", text)
        plan = write("space.toml", '''[flow]
dimensions = 3
shape = { kind = "mesh", file = "box.obj", thickness = 0.5 }
reynolds = 50
turbulence = "none"
cells_per_length = 8
extent = { before = 1.5, behind = 2, side = 1.5 }
max_time = 0.2
''')
        path = FOLDER / "space.h5"
        result = run("flow", plan, "-o", path)
        self.assertEqual(result.returncode, 4, result.stderr)
        with h5py.File(path) as file:
            self.assertEqual(file["centre/w"].shape, (24, 24, 28))
            self.assertEqual(file["centre/w"].dims[0][0].name, "/axes/z")
            closed = 1 - file["body/open"][:]
            self.assertAlmostEqual(closed.sum() / 8**3, 0.25, delta=1e-9)
            self.assertGreater(file["loads"].attrs["C_D"], 0)
        self.assertEqual(run("picture", path, "--field", "u", "-o", FOLDER / "space.png").returncode, 0)

    def test_a_box_makes_a_codebook_whose_answers_are_those_of_flows(self):
        small = PLAN.replace("before = 3, behind = 6, side = 3", "before = 2, behind = 3, side = 2").replace(
            "cells_per_length = 6", "cells_per_length = 4").replace("max_time = 80", "max_time = 300")
        plan = write("book.toml", small + '''[box]
log10_reynolds = [1.45, 1.65]
[book]
certificate_points = 3
[tolerance]
relative = 0.05
''')
        path = FOLDER / "book.h5"
        result = run("flow", plan, "-o", path, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        built = json.loads(result.stdout)
        self.assertEqual((built["schema"], built["met"]), ("samara-flow-book/1", True))
        self.assertEqual(set(built["discretisation"]), {output["name"] for output in built["certificate"]["outputs"]})
        # What the grid is worth stands in the file, apart from the certificate.
        said = json.loads(run("info", path, "--json").stdout)["build"]["message"]
        self.assertIn(f"C_D by {built['discretisation']['C_D']:.3g}", said)
        asked = run("query", path, "--set", "log10_reynolds=1.55").stdout.splitlines()
        drag = float(dict(zip(asked[0].split(","), asked[1].split(",")))["C_D[1]"])
        single = FOLDER / "single.h5"
        self.assertEqual(run("flow", write("single.toml", small.replace("reynolds = 30", f"reynolds = {10**1.55}")), "-o",
                             single).returncode, 0)
        told = json.loads(run("info", single, "--json").stdout)
        self.assertAlmostEqual(drag, told["C_D"], delta=0.03)

    def test_a_book_that_is_refused_leaves_the_flows_of_another_alone(self):
        flat = PLAN.replace("thickness = 1 }", "thickness = 0.4 }").replace("side = 3", "side = 1.5")
        kept = FOLDER / "kept.h5.checkpoint"
        for kind in ["energy", "fields"]:
            # The body fits into the stream at both ends of the box, and is too wide between them.
            box = f'[box]\nangle_of_attack = ["30 deg", "150 deg"]\n[book]\nkind = "{kind}"\ncertificate_points = 2\n'
            kept.write_text("flows")
            result = run("flow", write("wide.toml", flat + box), "-o", FOLDER / "kept.h5", "--fresh")
            self.check_error(result, 3, "wide.toml:10: box: ", "33 % of the stream's width", "a side of at least 2 body lengths")
            self.assertEqual(kept.read_text(), "flows")
            kept.unlink()
            self.check_error(run("flow", write("box.toml", PLAN + box), "-o", FOLDER / "kept.h5", "--resume"), 2,
                             "--resume: there is no", "kept.h5.checkpoint to go on from")

    def test_a_steady_flow_that_ends_before_its_first_check_says_so(self):
        brief = PLAN.replace('"ellipse"', '"rectangle"').replace("cells_per_length = 6", "cells_per_length = 4").replace("max_time = 80", "max_time = 1")
        result = run("flow", write("brief.toml", brief), "-o", FOLDER / "brief.h5")
        self.assertEqual(result.returncode, 4)
        self.assertIn("max_time, 1 l/U, was reached after ", result.stderr)
        self.assertIn("whether the flow still changes is looked at after 20", result.stderr)
        self.assertNotIn("changes by 0", result.stderr)

    def test_a_file_that_is_no_checkpoint_is_refused_before_the_first_flow_and_left_alone(self):
        short = PLAN.replace("max_time = 80", "max_time = 0.5")
        box = '[box]\nlog10_reynolds = [1.45, 1.65]\n'
        alone, books, path = write("alone.toml", short), write("boxed.toml", PLAN + box), FOLDER / "door.h5"
        kept, finer = FOLDER / "door.h5.checkpoint", FOLDER / "door.h5.checkpoint.finer"
        for plan, file, of in [(alone, kept, ("a flow", "a flow or a book of flows")), (books, kept, ("a build or a cloud", "a flow or a book of flows")),
                               (books, finer, ("a build or a cloud",) * 2)]:
            file.write_text("t,z\n0,1\n")
            for kind, words in zip(of, ([], ["--fresh"])):
                self.check_error(run("flow", plan, "-o", path, *words), 3, f"{file}: this is no checkpoint of {kind}, and would be lost")
                self.assertEqual(file.read_text(), "t,z\n0,1\n")
            file.unlink()
        # A flow does not go on from the flows of a book, nor a book from a flow; --fresh removes either, also damaged.
        kept.write_text("samara journal 1\n")
        self.check_error(run("flow", alone, "-o", path), 3, "this is no checkpoint of a flow")
        self.assertEqual(run("flow", alone, "-o", path, "--fresh").returncode, 4)
        path.unlink()
        self.check_error(run("flow", books, "-o", path), 3, "this is no checkpoint of a build")
        kept.write_bytes(kept.read_bytes()[:kept.stat().st_size // 2])
        self.check_error(run("flow", alone, "-o", path), 3, "door.h5.checkpoint")
        self.assertEqual(run("flow", alone, "-o", path, "--fresh").returncode, 4)

    def test_a_name_with_room_for_no_checkpoint_is_a_warning(self):
        path = FOLDER / ("n" * 247 + ".h5")
        result = run("flow", write("named.toml", PLAN.replace("max_time = 80", "max_time = 0.5")), "-o", path)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn("samara: warning: no checkpoint: cannot write", result.stderr)
        self.assertNotIn("is kept", result.stderr)
        self.assertTrue(run("info", path).stdout)

    def test_a_book_of_fields_is_asked_drawn_and_exported_at_an_angle(self):
        small = PLAN.replace("before = 3, behind = 6, side = 3", "before = 1.5, behind = 2, side = 1.5").replace(
            "cells_per_length = 6", "cells_per_length = 4").replace("thickness = 1 }", "thickness = 0.5 }")
        plan = write("fields.toml", small + '''[box]
angle_of_attack = ["0 deg", "30 deg"]
[book]
kind = "fields"
certificate_points = 2
[tolerance]
relative = 0.05
''')
        path = FOLDER / "fields.h5"
        result = run("flow", plan, "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("root mean square over the places", result.stdout)
        self.assertIn("what 95 % of the places at a point keep below; the largest anywhere", result.stdout)
        self.assertFalse(os.path.exists(str(path) + ".checkpoint"))
        self.assertIn("mesh: 168 nodes", run("info", path).stdout)
        angle = "angle_of_attack=30 deg"
        single = FOLDER / "turned.h5"
        turned = small.replace("reynolds = 30", 'reynolds = 30\nangle_of_attack = "30 deg"')
        self.assertEqual(run("flow", write("turned.toml", turned), "-o", single).returncode, 0)
        with h5py.File(single) as file:
            u, x, y = file["centre/u"][:], file["axes/x"][:], file["axes/y"][:]
        asked = run("query", path, "--set", f"x={x[9]}", "--set", f"y={y[7]}", "--set", angle).stdout.splitlines()
        said = dict(zip(asked[0].split(","), map(float, asked[1].split(","))))
        # The end of the box is a node.
        self.assertAlmostEqual(said["u[1]"], u[7, 9], delta=0.01)
        for made in ["fields.png", "fields.vtu"]:
            verb = ["picture", path, "--field", "u"] if made.endswith("png") else ["export", path, "--to", "paraview"]
            self.assertEqual(run(*verb, "--set", angle, "-o", FOLDER / made).returncode, 0)
        self.check_error(run("picture", path, "-o", FOLDER / "no.png"), 2, "needs a value of angle_of_attack, from 0 to 0.523599")
        self.check_error(run("picture", single, "--set", angle, "-o", FOLDER / "no.png"), 2, "--set", "is one flow")
        self.check_error(run("picture", path, "--set", "angle_of_attack=2", "-o", FOLDER / "no.png"), 5, "angle_of_attack")

    def test_a_book_of_turbulent_fields_over_angle_and_reynolds_number_is_flown_in(self):
        plan = write("turbulent.toml", '''[flow]
shape = { kind = "ellipse", length = 1, thickness = 0.5 }
reynolds = 2e4
cells_per_length = 4
extent = { before = 2, behind = 3, side = 2.5 }
max_time = 600
[box]
angle_of_attack = ["60 deg", "90 deg"]
log10_reynolds = [4, 5]
[book]
kind = "fields"
certificate_points = 2
max_calls = 40
[tolerance]
relative = 0.15
''')
        path = FOLDER / "turbulent.h5"
        result = run("flow", plan, "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("certificate: met", result.stdout)
        self.assertIn("log10_epsilon", result.stdout)
        flown = run("simulate", "sphere_flight_in_gusts", "--flow", path, "--flow-set", "angle_of_attack=75 deg", "--flow-set",
                    "log10_reynolds=4.5", "--speed", 2, "--length", "0.5 m", "--set=x(0)=0.6", "--until", 0.1, "--realisations", 4)
        self.assertEqual(flown.returncode, 0, flown.stderr)

    def test_what_cannot_be_a_flow_is_refused_in_a_sentence(self):
        out = FOLDER / "never.h5"
        for change, code, parts in [
            (("reynolds = 30", "reynolds = -1"), 3, ["bad.toml:4", "[flow] reynolds: is -1"]),
            (("reynolds = 30", "reynolds = nan"), 3, ["bad.toml:4", "reynolds"]),
            (("thickness = 1 }", "thickness = 0.1 }"), 3, ["bad.toml:2: flow: ", "0.1 thin", "cells_per_length at least 20"]),
            (("side = 3", "side = 1.5"), 3, ["bad.toml:2: flow: ", "33 % of the stream's width"]),
            (("before = 3", "before = 1"), 3, ["bad.toml:2: flow: ", "within 0.5 of a border, expected at least 0.6667, four cells"]),
            (("before = 3", "before = 1e59"), 3, ["bad.toml:7: [flow.extent] before: is 1e+59, expected more than 0.5 and at most 1000 body lengths"]),
            (("side = 3", "side = 0.5"), 3, ["bad.toml:7: [flow.extent] side: is 0.5, expected more than 0.5"]),
            (("cells_per_length = 6", "cells_per_length = 900"), 3, ["bad.toml:2: flow: ", "expected at most max_memory, 2 GB"]),
            (('"ellipse"', '"elipse"'), 3, ["elipse", "ellipse"]),
            (('"ellipse", length = 1, thickness', '"plate", baffle = true, thickness'), 3, ["thickness", "stands beside baffle = true"]),
            (('end = "steady"\nmax_time = 80\n', 'end = "time"\nmax_time = 80\n[motion]\nx = "0"\nperiod = 1e-6\n'), 3,
             ["[motion] period", "is 1e-06, expected at least 0.1667 l/U"]),
            (("end = ", "ende = "), 3, ["ende", "end"]),
            (("end = ", "intensity = 0\nend = "), 3, ["bad.toml:8", "intensity", "is 0"]),
            (("end = ", "intensity = -0.1\nend = "), 3, ["intensity", "is -0.1"]),
            (("end = ", "intensity = 1.5\nend = "), 3, ["intensity", "is 1.5, expected at most 1"]),
            (("end = ", "intensity = nan\nend = "), 3, ["intensity"]),
            (('end = "steady"\nmax_time = 80\n', "max_time = 80\n[box]\nlog10_reynolds = [3, 4]\n[tolerance]\nrelative = 0.02\n"), 3,
             ["relative", "is 0.02, expected at least 0.03", "three times"]),
        ]:
            with self.subTest(change=change):
                self.check_error(run("flow", write("bad.toml", PLAN.replace(*change)), "-o", out), code, *parts)
                self.assertFalse(out.exists())

    def test_a_damaged_flow_file_is_refused(self):
        damaged = FOLDER / "damaged.h5"
        data = bytearray(flow().read_bytes())
        data[len(data) // 2] ^= 0xFF
        damaged.write_bytes(data)
        result = run("picture", damaged, "--field", "u", "-o", FOLDER / "damaged.png")
        self.check_error(result, 3, "damaged.h5")

    def test_values_that_no_flow_has_are_refused(self):
        changed = FOLDER / "changed.h5"
        for name, value, sentence in [
            ("centre/k_resolved", -0.1, "-0.1 in cell (4, 3, 0), expected none below 0"),
            ("centre/u", numpy.nan, "expected finite numbers, found nan"),
            ("centre/p", numpy.inf, "expected finite numbers, found inf"),
            ("body/open", numpy.nan, "expected finite numbers, found nan"),
            ("body/open", 1.5, "1.5 in cell (4, 3, 0), expected shares"),
            ("centre/epsilon", 0.0, "0 in cell (4, 3, 0), expected positive ones"),
        ]:
            with self.subTest(name=name, value=value):
                changed.write_bytes(flow().read_bytes())
                with h5py.File(changed, "r+", libver="latest") as file:
                    if name not in file:
                        file[name] = numpy.ones_like(file["centre/k"][:])
                        file[name].attrs["unit"] = file["centre/k"].attrs["unit"]
                    file[name][3, 4] = value
                self.check_error(run("info", changed), 3, "changed.h5", name, sentence)

        changed.write_bytes(flow().read_bytes())
        with h5py.File(changed, "r+", libver="latest") as file:
            file["grid"].attrs["cells"] = numpy.array([54.0 * 36, 1, 1])
        self.check_error(run("info", changed), 3, "has 1 cells along y, expected at least 2")
        changed.write_bytes(flow().read_bytes())
        with h5py.File(changed, "r+", libver="latest") as file:
            file["loads"].attrs["C_D"] = numpy.nan
        self.check_error(run("info", changed), 3, "changed.h5", "/loads", "C_D is nan, expected a finite number")

    def test_no_other_file_is_lost_to_a_flow(self):
        other = write("other", "mine")
        self.check_error(run("flow", write("again.toml", PLAN), "-o", other), 2, "is a file, and neither a flow nor a codebook")
        self.assertEqual(other.read_text(), "mine")
        self.assertFalse(os.path.exists(str(other) + ".checkpoint"))
        line = book("line", LINE_PLAN)
        kept = line.read_bytes()
        self.check_error(run("flow", FOLDER / "again.toml", "-o", line), 2, "is a codebook, and a flow would be written")
        self.assertEqual(line.read_bytes(), kept)
        kept = flow().read_bytes()
        boxed = write("boxed.toml", PLAN + "[box]\nlog10_reynolds = [1.4, 1.6]\n")
        self.check_error(run("flow", boxed, "-o", flow()), 2, "is a flow, and a codebook would be written: it would be lost")
        self.assertEqual(flow().read_bytes(), kept)


if __name__ == "__main__":
    main()
