"""Usage: explorer_browser_test.py SAMARA ExplorerInBrowser SAMPLES

The page that `samara explore` writes, in a real browser (skipped, with exit code 77, without one). SAMPLES is the program
codebook_samples, which writes codebooks of all kinds. Where SAMARA_NODE_MODULES leads to axe-core (npm), it looks at the page, too.
"""

import csv
import itertools
import json
import os
import pathlib
import struct
import subprocess
import sys
import zlib

import h5py
import numpy as np

import browser
from explored_pages import CARD_PLAN, SAMPLES, explored, fallen
from glb_file import Glb, issues
from samara_case import COIN_PLAN, FOLDER, LONGEST, SAMARA, Case, book, main, run, write


def png_numbers(path):
    """The filtered bytes of a picture."""
    data, at, packed = path.read_bytes(), 8, b""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            size = struct.unpack(">II", data[at + 8:at + 16])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    return size, zlib.decompress(packed)


class ExplorerInBrowser(Case):
    @classmethod
    def setUpClass(cls):
        cls.browser = browser.Browser(longest=LONGEST)

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()

    def opened(self, page, hash=""):
        self.browser.requests.clear()
        self.browser.complaints.clear()
        self.browser.look(1200, 900)
        self.browser.open(page, hash)

    def check_quiet(self):
        """The page asked nobody, complained of nothing, and shows no error."""
        self.assertEqual([url for url in self.browser.requests if not url.startswith(("file:", "about:", "blob:"))], [])
        self.assertEqual(self.browser.complaints, [])
        self.assertEqual(self.browser.value("document.getElementById('errors').textContent"), "")

    def evaluated(self, number, points, by="null"):
        """What the page says at points of a codebook: points x outputs."""
        return np.array(self.browser.value(
            f"(() => {{ const book = new Codebook(explorer.state.data.books[{number}]);"
            f" return {json.dumps(points)}.map((x) => book.at(x, {by})).map((v) => v.map((u) => Number.isNaN(u) ? null : u)); }})()"), float)

    def test_values_of_all_kinds_of_codebooks_are_those_of_the_library(self):
        subprocess.run([SAMPLES, "reference", FOLDER], check=True)
        names = ["pieces", "trains", "kinds", "coin", "command", "mesh"]
        self.opened(explored(*(FOLDER / f"{name}.h5" for name in names), name="kinds"))
        for number, name in enumerate(names):
            rows = list(csv.reader((FOLDER / f"{name}.csv").read_text().splitlines()))
            count = self.browser.value(f"explorer.state.data.books[{number}].coordinates.length")
            table = np.array(rows[1:], float)
            values = self.evaluated(number, table[:, :count].tolist())
            scale = np.abs(table[:, count:]).max(axis=0)
            self.assertLess(np.max(np.abs(values - table[:, count:]) / scale), 1e-13, name)
            # The page shows each of them, with time or without.
            if number > 0:
                self.browser.value(f"(() => {{ const s = document.getElementById('codebook'); s.value = {number}; s.dispatchEvent(new Event('change')); }})()")
            self.assertEqual(self.browser.value("document.querySelectorAll('#curves canvas').length"), table.shape[1] - count)
            # A curve over any coordinate passes the same points.
            for along in range(count):
                same = np.array(self.browser.value(
                    f"(() => {{ const book = new Codebook(explorer.state.data.books[{number}]);"
                    f" return {json.dumps(table[:20, :count].tolist())}.map((x) => book.curve(book.prepare({along}, [x[{along}]]), x).map((c) => c[0])); }})()"))
                self.assertLess(np.max(np.abs(same - table[:20, count:]) / scale), 1e-13, f"{name} over {along}")
        self.check_quiet()

    def queried(self, path, names, point, times):
        settings = itertools.chain(*(("--set", f"{name}={value!r}") for name, value in zip(names[1:], point)))
        result = run("query", path, *settings, "--at", *(repr(t) for t in times), "--gradient", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)["outputs"]

    def compare(self, number, path, points, times, derivative_scale=None):
        """Values and derivatives against `samara query`, at all times for each of the points."""
        with h5py.File(path) as file:
            axes = file["pieces/0/axes"]
            names = sorted(axes, key=lambda name: axes[name].attrs["index"])
            lists = {name for name in names if axes[name].attrs["basis"] in (b"discrete", b"imported")}
        answers = [self.queried(path, names, point, times) for point in points]
        everywhere = [[t, *point] for point in points for t in times]
        for by in ["null", *range(len(names))]:
            if by != "null" and names[by] in lists:
                continue
            expected = np.array([[value for output in [answer[o] for answer in answers]
                                  for value in (output["values"] if by == "null" else output["gradient"][names[by]])]
                                 for o in range(len(answers[0]))], float).T
            found = self.evaluated(number, everywhere, by)
            scale = np.abs(expected).max(axis=0) + 1e-300
            self.assertLess(np.max(np.abs(found - expected) / scale), 1e-11 if by != "null" else 1e-13, f"{path} by {by}")

    def test_borders_corners_and_derivatives_are_those_of_samara_query(self):
        subprocess.run([SAMPLES, "reference", FOLDER], check=True)
        card, names = book("card", CARD_PLAN), ["pieces", "trains", "kinds"]
        self.opened(explored(*(FOLDER / f"{name}.h5" for name in names), card, name="borders"))
        for number, name in enumerate(["pieces", "trains"]):
            path = FOLDER / f"{name}.h5"
            with h5py.File(path) as file:
                ends = {axis: sorted({float(end) for piece in file["pieces"].values() for end in piece["axes"][axis].attrs["borders"]})
                        for axis in ["t", "C_D", "v(0)"]}
            self.compare(number, path, list(itertools.product(ends["C_D"], ends["v(0)"][1::2])), [*ends["t"], 0.123])
        random = np.random.default_rng(3)
        with h5py.File(FOLDER / "kinds.h5") as file:
            axes = sorted(file["pieces/0/axes"].values(), key=lambda axis: axis.attrs["index"])
            points = [[float(random.choice(axis[()])) if axis.attrs["basis"] == b"discrete" else
                       float(random.uniform(axis.attrs["lower"], axis.attrs["upper"])) for axis in axes[1:]] for _ in range(3)]
        self.compare(2, FOLDER / "kinds.h5", points, [0.0, 0.3, 0.5, 1.9])
        # The quaternion of the card is normalised, and derivatives go through that; slabs meet in time.
        with h5py.File(card) as file:
            borders = sorted({float(piece.attrs["lower"][0]) for piece in file["pieces"].values()})
        self.compare(3, card, [[0.25, 0.5], [0.37, 0.7], [0.301, 0.611]], [*borders, 0.1234, 0.25])
        attitude = self.browser.value("explorer.state.data.books[3].attitude")
        q = self.evaluated(3, [[0.2, 0.3, 0.6]])[0, attitude["places"]]
        self.assertAlmostEqual(np.linalg.norm(q), attitude["length"], delta=1e-14)
        self.check_quiet()

    def test_a_slider_moved_by_keys_changes_values_curves_address_and_the_line_to_copy(self):
        capture, fit = fallen()
        self.opened(explored(book("coin", COIN_PLAN), "--capture", capture, "--fit", fit, name="keys"))
        fitted = json.loads(fit.read_text())["coefficients"][0]["value"]
        self.assertEqual(self.browser.value("explorer.state.point[1]"), fitted)
        rms = json.loads(fit.read_text())["captures"][0]["residuals"][0]["rms"]
        self.assertLess(rms, 1.5e-4)
        self.assertAlmostEqual(self.browser.value("Number(document.querySelector('#curves [data-rms]').dataset.rms)"), rms, delta=1e-9)
        before = self.browser.value("document.querySelector('#curves canvas').toDataURL()")
        self.browser.value("document.getElementById('coordinate-1').focus()")
        self.browser.press("End")
        self.browser.until("explorer.state.point[1] === 1.6")
        self.browser.press("ArrowLeft")
        self.browser.until("location.hash.includes('p.C_D=1.598')")
        self.assertNotEqual(before, self.browser.value("document.querySelector('#curves canvas').toDataURL()"))
        self.assertGreater(self.browser.value("Number(document.querySelector('#curves [data-rms]').dataset.rms)"), 5e-4)
        # Who cannot see the curve is told of it when it comes to rest.
        end, last = self.browser.value("[explorer.curves.prepared.places[199], explorer.curves.values[0][199]]")
        self.browser.until(f"document.querySelector('#curves canvas').getAttribute('aria-label').includes(`, ${{kit.shown({last!r}, 4)}} at ${{kit.shown({end!r}, 4)}} `)")
        # Jumps to the worst point, and the line of the command gives what is shown there.
        self.browser.value("document.querySelector('#worst button[data-output=x]').click()")
        with h5py.File(book("coin", COIN_PLAN)) as file:
            worst = file["certificate/x"].attrs["worst"].tolist()
        self.browser.until(f"JSON.stringify(explorer.state.point) === JSON.stringify({json.dumps(worst)})")
        self.browser.until(f"document.getElementById('query').value.includes('--at {worst[0]!r}')")
        line = self.browser.value("document.getElementById('query').value")
        answer = subprocess.run(["bash", "-c", line.replace("samara", SAMARA, 1)], cwd=FOLDER, capture_output=True, text=True)
        row = next(csv.DictReader(answer.stdout.splitlines()))
        shown = float(self.browser.value("document.querySelector('#values tr[data-output=x] td[data-value]').dataset.value"))
        self.assertAlmostEqual(shown, float(row["x[m]"]), delta=1e-14)
        # The address brings the state back.
        self.browser.until(f"location.hash.includes('p.t={worst[0]!r}')")
        state = self.browser.value("location.hash")
        self.opened(FOLDER / "keys.html", state)
        self.assertEqual(self.browser.value("explorer.state.point"), worst)
        self.check_quiet()

    def choose(self, id, value):
        self.browser.value(f"(() => {{ const s = document.getElementById('{id}'); s.value = {value}; s.dispatchEvent(new Event('change')); }})()")

    def shown_rms(self):
        return self.browser.value("Number(document.querySelector('#curves [data-rms]').dataset.rms)")

    def test_residuals_are_those_of_the_codebook_that_is_chosen(self):
        capture, _ = fallen()
        second = book("finer", COIN_PLAN.replace("relative = 1e-3", "relative = 1e-7"))
        self.opened(explored(book("coin", COIN_PLAN), second, "--capture", capture, name="second"))
        pieces = self.browser.value("explorer.state.data.books.map((b) => JSON.stringify(b.pieces.map((p) => p.axes[0])))")
        self.assertNotEqual(*pieces)
        self.choose("codebook", 1)
        rows = list(csv.DictReader(capture.read_text().splitlines()))
        answer, = [o for o in self.queried(second, ["t", "C_D", "v(0)"], self.browser.value("explorer.state.point.slice(1)"),
                                           [float(row["t[s]"]) for row in rows]) if o["name"] == "x"]
        rest = np.array([float(row["x[m]"]) for row in rows]) - answer["values"]
        self.assertAlmostEqual(self.shown_rms(), float(np.sqrt(np.mean(rest ** 2))), delta=1e-12)
        self.check_quiet()

    def test_residuals_are_without_what_the_fit_found_of_clock_and_sensor(self):
        # Windows of a capture have values of their own, and names of their own.
        times = np.linspace(0.0, 0.4, 41)
        result = run("query", book("coin", COIN_PLAN), "--set", "C_D=1.25", "--set", "v(0)=0.1", "--at", *(repr(float(t)) for t in times))
        x = np.array([float(row["x[m]"]) for row in csv.DictReader(result.stdout.splitlines())])
        seen = 1.03 * x + 1e-4 * (-1.0) ** np.arange(41)
        capture = write("seen.csv", "t[s],x[m]\n" + "".join(f"{t - 0.01!r},{v!r}\n" for t, v in zip(times[2:].tolist(), seen[2:].tolist())))
        clock = write("clock.toml", 'delay = { range = ["0 ms", "20 ms"] }\ngain = { x = { range = [0.9, 1.1] } }\noffsets = []\n')
        for name, words in [("clock", ["--config", clock]), ("windows", ["--config", write("windows.toml", 'span = "0.2 s"\nstride = "0.1 s"\n')])]:
            fit = FOLDER / f"{name}.json"
            result = run("fit", book("coin", COIN_PLAN), capture, *words, "-o", fit)
            self.assertTrue(fit.exists(), result.stderr)
            captures = json.loads(fit.read_text())["captures"]
            self.assertEqual(len(captures) > 1, name == "windows")
            self.opened(explored(book("coin", COIN_PLAN), "--capture", capture, "--fit", fit, name=name))
            for number, own in enumerate(captures):
                self.choose("capture", number)
                self.assertEqual(self.browser.value(f"explorer.state.data.captures[{number}].id"), own["id"])
                self.assertAlmostEqual(self.shown_rms(), own["residuals"][0]["rms"], delta=1e-9)
            self.check_quiet()

    def test_angles_and_quaternions_are_shown_at_the_turn_next_to_the_curve(self):
        self.opened(explored(book("coin", COIN_PLAN), name="turns"))
        shifted = "Curves.prototype.shifted.call({state: {book: %s, measured: (o) => o}, atMeasured: () => %s}, %s, 0)"
        self.assertAlmostEqual(self.browser.value(shifted % ("{outputs: []}", "[[3.1]]", "{period: Math.PI, values: [-0.1]}"))[0], np.pi - 0.1, delta=1e-15)
        self.assertEqual(self.browser.value(shifted % ("{outputs: []}", "[[3.1]]", "{period: 0, values: [-0.1]}")), [-0.1])
        parts = "[{values: [-0.6, 0.6, null]}, {values: [0.8, -0.8, 0.8]}]"
        self.assertEqual(self.browser.value(shifted % (f"{{attitude: {{places: [0, 1]}}, outputs: {parts}}}", "[[0.6, 0.6, 0.6], [-0.8, -0.8, -0.8]]", parts + "[0]")),
                         [0.6, 0.6, None])

    def test_what_a_fit_knows_and_the_page_leaves_out_is_told_in_red(self):
        capture, fit = fallen()
        seen = json.loads(fit.read_text())
        seen["setup"]["averaged_frames"] = 5
        result = run("explore", book("coin", COIN_PLAN), "--capture", capture, "--fit", write("means.json", json.dumps(seen)), "-o", FOLDER / "means.html")
        self.assertIn("the fit has frames that are means of 5", result.stderr)
        self.opened(FOLDER / "means.html")
        self.assertEqual(self.browser.value("document.getElementById('left-out').className"), "bad")

    def test_the_keyboard_stays_where_it_is_when_the_form_is_built_anew(self):
        self.opened(explored(book("coin", COIN_PLAN), name="focus"))
        for id, after in [("slopes", "slopes"), ("keep", "keep"), ("drop", "keep")]:
            self.browser.value(f"document.getElementById('{id}').focus()")
            self.browser.press(" ")
            self.browser.until(f"document.activeElement.id === '{after}'")
        self.assertEqual(self.browser.value("[explorer.state.slopes, explorer.state.other]"), [True, None])
        # An address without a comparison shows none, whatever was there before.
        self.browser.value("document.getElementById('keep').click(); location.hash = '#p.C_D=1.3'")
        self.browser.until("explorer.state.point[1] === 1.3 && explorer.state.other === null")
        self.check_quiet()

    def test_what_lies_outside_the_box_is_refused_where_it_is_typed_and_in_the_address(self):
        self.opened(explored(book("coin", COIN_PLAN), name="outside"), "#p.C_D=7&p.v(0)=0.2&over=nonsense")
        self.assertEqual(self.browser.value("explorer.state.point"), [0, (0.8 + 1.6) / 2, 0.2])
        message = self.browser.value("(() => { const n = document.getElementById('coordinate-1-number'); n.value = '9';"
                                     " n.dispatchEvent(new Event('change')); return n.validationMessage; })()")
        self.assertEqual(message, "from 0.8 to 1.6 was expected")
        self.assertEqual(self.browser.value("explorer.state.point[1]"), (0.8 + 1.6) / 2)
        self.check_quiet()

    def test_two_points_are_compared_and_sensitivities_shown_on_demand(self):
        self.opened(explored(book("coin", COIN_PLAN), name="two"))
        count = "document.querySelectorAll('#curves canvas').length"
        self.assertEqual(self.browser.value(count), 2)
        self.browser.value("document.getElementById('keep').click(); document.getElementById('slopes').click()")
        self.assertEqual(self.browser.value(count), 4)
        self.assertEqual(self.browser.value("[...document.querySelectorAll('#curves canvas')].filter((c) => !c.getAttribute('aria-label')).length"), 0)
        self.browser.value("(() => { const s = document.getElementById('coordinate-1'); s.value = 0.9; s.dispatchEvent(new Event('input')); })()")
        self.browser.until("explorer.state.point[1] !== explorer.state.other[1]")
        self.browser.until("document.querySelectorAll('#values tr[data-output=v] td').length === 5 &&"
                           " location.hash.includes('b.C_D=1.2')")
        self.browser.value("document.getElementById('clock-number').value = 0.3;"
                           "document.getElementById('clock-number').dispatchEvent(new Event('change'))")
        self.browser.until("explorer.state.point[0] === 0.3 && document.querySelector('#values tr[data-output=v]').children[4].dataset.value > 0.01")
        self.check_quiet()

    def test_the_motion_plays_and_stands_still_in_steps_for_those_who_asked_for_less(self):
        page = explored(book("card", CARD_PLAN), name="playing")
        self.opened(page)
        self.browser.value("document.getElementById('play').click()")
        self.browser.until("explorer.state.point[0] > 0.02")
        self.browser.value("document.getElementById('play').click()")
        self.assertEqual(self.browser.value("document.getElementById('play').textContent"), "Play")
        self.browser.look(1200, 900, calm=True)
        begin = self.browser.value("explorer.state.point[0]")
        pictures = self.browser.value(
            "new Promise((done) => { const seen = new Set(); document.getElementById('play').click();"
            " const look = setInterval(() => seen.add(explorer.state.point[0]), 5);"
            " setTimeout(() => { clearInterval(look); document.getElementById('play').click(); done(seen.size); }, 800); })")
        self.assertLessEqual(pictures, 3)
        self.assertNotEqual(begin, self.browser.value("explorer.state.point[0]"))
        self.check_quiet()

    def test_a_list_is_played_from_value_to_value(self):
        if not (FOLDER / "kinds.h5").exists():
            subprocess.run([SAMPLES, "reference", FOLDER], check=True)
        self.opened(explored(FOLDER / "kinds.h5", name="list"))
        list = self.browser.value("explorer.state.book.coordinates.findIndex((c) => c.list && c.list.length > 1)")
        self.choose("over", list)
        values = self.browser.value("explorer.state.book.coordinates[explorer.state.along].list")
        self.browser.value("document.getElementById('speed').value = 1; document.getElementById('play').click()")
        for value in values[1:]:
            self.browser.until(f"explorer.state.point[{list}] === {value}")
        self.check_quiet()

    def test_what_is_saved_is_read_back(self):
        self.opened(explored(book("coin", COIN_PLAN), name="saved"), "#p.C_D=1.31&p.v(0)=0.25")
        table = FOLDER / "trajectory.csv"
        table.write_bytes(self.browser.saved("csv").read_bytes())
        answer = FOLDER / "back.json"
        config = write("scales.toml", 'loss = { kind = "none", scale = { x = "1 mm", v = "10 mm/s" } }\n')
        result = run("fit", book("coin", COIN_PLAN), table, "--config", config, "-o", answer)
        self.assertEqual(result.returncode, 0, result.stderr)
        coefficient, = json.loads(answer.read_text())["coefficients"]
        self.assertAlmostEqual(coefficient["value"], 1.31, delta=1e-5)
        (width, height), numbers = png_numbers(self.browser.saved("png"))
        self.assertGreater(min(width, height), 300)
        self.assertGreater(len(set(numbers)), 50)
        self.check_quiet()

    def test_an_open_surface_is_drawn_from_both_sides(self):
        leaf = write("leaf.obj", "v -3.5 0 0\nv 0 2 0\nv 3.5 0 0\nv 0 -2 0\nf 1 2 3 4\n")
        self.opened(explored(book("coin", COIN_PLAN), "--body", leaf, "--unit", "cm", name="leaf"))
        self.assertEqual(self.browser.value("""[40, -40].map((tilt) => {
            let fills = 0;
            const g = {beginPath() {}, lineTo() {}, closePath() {}, stroke() {}, fill() { ++fills; }}, view = new BodyView(null, {turn: 0, tilt, zoom: 1});
            view.drawMesh(g, {colour: "#336699", pose: {p: [0, 0, 0], q: [1, 0, 0, 0]}}, meshOf(explorer.state.book.body), 1, view.axes(), (v) => v,
                          (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2]);
            return fills;
        })"""), [2, 2])
        self.check_quiet()

    def test_the_saved_animation_follows_the_codebook(self):
        self.opened(explored(book("card", CARD_PLAN), name="animation"))
        path = FOLDER / "page.glb"
        path.write_bytes(self.browser.saved("glb").read_bytes())
        point = self.browser.value("explorer.state.point.slice(1)")
        times = np.linspace(0.0, 0.25, 301)
        columns = {output["name"]: np.array(output["values"])
                   for output in self.queried(book("card", CARD_PLAN), ["t", "C_D90", "C_R"], point, times.tolist())}
        glb = Glb(path)
        glb.check_against(self, times, np.stack([columns[n] for n in ["x", "y", "z"]], 1),
                          np.stack([columns[n] for n in ["qw", "qx", "qy", "qz"]], 1), size=0.07)
        self.assertIn(issues(path), [None, [0, 0, 0, 0]])
        # Time alone makes a motion.
        self.choose("over", 1)
        self.assertTrue(self.browser.value("document.getElementById('glb').hidden"))
        extras = glb.json["scenes"][0]["extras"]["parameters"]
        self.assertEqual([extras[name] for name in ["C_D90", "C_R", "C_T"]], [*point, 0.91])

    def test_the_page_and_the_command_write_the_same_animation(self):
        for name, plan in [("coin", COIN_PLAN), ("card", CARD_PLAN)]:
            self.opened(explored(book(name, plan), name=f"same_{name}"))
            names, point = self.browser.value("[explorer.state.book.coordinates.map((c) => c.name), explorer.state.point]")
            point = [round(value * 1.01, 3) for value in point]
            self.opened(FOLDER / f"same_{name}.html", "#" + "&".join(f"p.{n}={v!r}" for n, v in zip(names, point)))
            path = FOLDER / f"same_{name}.glb"
            result = run("query", book(name, plan), *(f"--set={n}={v!r}" for n, v in zip(names[1:], point[1:])), "-o", path)
            self.assertEqual(result.returncode, 0, result.stderr)
            files = [Glb(self.browser.saved("glb")), Glb(path)]
            extras = [file.json["scenes"][0].pop("extras") for file in files]
            self.assertEqual([pathlib.Path(extra.pop("codebook")).name for extra in extras], [f"{name}.h5"] * 2)
            self.assertEqual(extras[0].keys(), extras[1].keys())
            self.assertEqual(*(extra["model"] for extra in extras))
            self.assertEqual(*(list(sorted(extra["parameters"])) for extra in extras))
            for key, value in extras[0]["parameters"].items():
                self.assertAlmostEqual(value, extras[1]["parameters"][key], delta=1e-12 * max(1.0, abs(value)))
            for file in files:
                self.assertTrue(file.json["asset"].pop("generator").startswith("samara"))
            rows = [[file.accessor(k).astype(float) for k in range(len(file.json["accessors"]))] for file in files]
            for one, other in zip(*rows):
                np.testing.assert_allclose(one, other, atol=2e-6 * max(1e-2, np.abs(other).max()))
            # Ends that accessors state are of these numbers: Glb.accessor() has compared them.
            for file in files:
                for accessor in file.json["accessors"]:
                    accessor.pop("min", None), accessor.pop("max", None)
            self.assertEqual(files[0].json, files[1].json)
        self.check_quiet()

    def seen(self):
        return self.browser.value("[explorer.state.seen.turn, explorer.state.seen.tilt, explorer.state.seen.zoom]")

    def test_the_picture_of_the_body_is_turned_and_enlarged_by_keys_mouse_touch_and_fields(self):
        page = explored(book("card", CARD_PLAN), name="view")
        self.opened(page)
        self.assertEqual(self.seen(), [0, 0, 1])
        self.browser.value("document.getElementById('body').focus()")
        for key, code in [("ArrowRight", None), ("ArrowDown", 40), ("ArrowDown", 40), ("+", 187), ("+", 187)]:
            self.browser.press(key, code)
        self.assertEqual([round(v, 9) for v in self.seen()], [-5, 10, 2])
        self.browser.until("document.getElementById('body').getAttribute('aria-label').includes("
                           "'Seen 5 degrees from the left, 10 degrees from above, 2 times as large')")
        self.assertEqual(self.browser.value("['turn', 'tilt', 'zoom'].map((id) => Number(document.getElementById(id).value))"), [-5, 10, 1])
        # The address keeps it, and what cannot be a view is the front view.
        self.browser.until("location.hash.includes('view=-5%2C10%2C2')")
        state = self.browser.value("location.hash")
        self.opened(page, state)
        self.assertEqual(self.seen(), [-5, 10, 2])
        self.opened(page, "#view=1,x,2")
        self.assertEqual(self.seen(), [0, 0, 1])
        x, y = self.browser.value("(() => { const b = document.getElementById('body').getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")
        mouse = lambda kind, dx, dy, **more: self.browser.call("Input.dispatchMouseEvent", type=kind, x=x + dx, y=y + dy, **more)
        mouse("mousePressed", 0, 0, button="left", clickCount=1)
        mouse("mouseMoved", 50, 20, button="left", buttons=1)
        mouse("mouseReleased", 50, 20, button="left", clickCount=1)
        mouse("mouseMoved", 90, 20)
        self.assertEqual([round(v, 9) for v in self.seen()], [-30, 12, 1])
        mouse("mouseWheel", 0, 0, deltaX=0, deltaY=-200, modifiers=2)
        self.assertAlmostEqual(self.seen()[2], np.exp(0.4), delta=1e-6)
        touch = lambda kind, *places: self.browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x + at, "y": y, "id": n} for n, at in enumerate(places)])
        touch("touchStart", -20, 20)
        touch("touchMove", -40, 40)
        touch("touchEnd")
        self.assertAlmostEqual(self.seen()[2], 2 * np.exp(0.4), delta=1e-3)
        self.browser.value("document.getElementById('front').click()")
        self.assertEqual(self.seen(), [0, 0, 1])
        self.browser.value("(() => { const f = document.getElementById('zoom'); f.value = 3; f.dispatchEvent(new Event('input')); })()")
        self.assertEqual(self.seen(), [0, 0, 8])
        self.browser.until("document.getElementById('zoom').getAttribute('aria-valuetext') === '8 times'")
        self.check_quiet()

    def test_the_scale_below_the_body_is_true_however_it_is_looked_at(self):
        # A path of 0.6 m in the picture's own plane, in blue, inside one of 3 m: pixels of it, and of the scale with its label.
        self.opened(explored(book("coin", COIN_PLAN), name="scale"))
        measure = '''((seen) => {
          const canvas = document.createElement("canvas"), said = [];
          Object.assign(canvas.style, {width: "640px", height: "300px"});
          document.body.append(canvas);
          const g = canvas.getContext("2d");
          g.fillText = (text) => said.push(text);
          const at = (x) => ({p: [x, 0, 0], q: [1, 0, 0, 0]}), red = {path: [at(0), at(3)], pose: at(1.5), colour: "#ff0000"};
          new BodyView(canvas, seen).draw([{path: [at(1.2), at(1.8)], pose: at(1.5), colour: "#0000ff"}, red], plainPlateMesh, "m", {ink: "#00ff00"});
          const {data} = g.getImageData(0, 0, canvas.width, canvas.height), ends = (channel) => {
            let low = Infinity, high = -Infinity;
            for (let k = 0; k < data.length; k += 4)
              if (data[k + channel] > 90 && data[k + 3] > 90 && [0, 1, 2].every((c) => c === channel || data[k + c] < 0.7 * data[k + channel]))
                [low, high] = [Math.min(low, k / 4 % canvas.width), Math.max(high, k / 4 % canvas.width)];
            return high - low;
          };
          canvas.remove();
          return [said[0], ends(1), ends(2)];
        })'''.replace("plainPlateMesh", "plainPlate(0.02)")
        seen = set()
        for turn, zoom in [(0, 1), (60, 1), (0, 2), (0, 4), (-30, 3)]:
            label, bar, path = self.browser.value(f"{measure}({{turn: {turn}, tilt: 0, zoom: {zoom}}})")
            length = float(label.removesuffix(" m"))
            seen.add(length)
            # The line through a point of the path is a pixel and a half wide, as that of the scale.
            shown = 0.6 * np.cos(np.radians(turn)) / length * bar
            self.assertAlmostEqual(path, shown, delta=2.5 + 0.02 * shown, msg=f"{turn}, {zoom}: {label}")
            self.assertGreater(path, 40)
        self.assertGreater(len(seen), 1)
        self.check_quiet()

    def test_coins_fall_and_plates_turn_as_the_library_says(self):
        self.opened(explored(book("coin", COIN_PLAN), name="poses"), "#p.C_D=1.31&p.v(0)=0.25")
        path = FOLDER / "coin.glb"
        path.write_bytes(self.browser.saved("glb").read_bytes())
        times = np.linspace(0.0, 0.4, 101)
        answer, = [o for o in self.queried(book("coin", COIN_PLAN), ["t", "C_D", "v(0)"], [1.31, 0.25], times.tolist()) if o["name"] == "x"]
        depth, zero = np.array(answer["values"]), np.zeros(101)
        Glb(path).check_against(self, times, np.stack([zero, zero, -depth], 1), np.tile([1.0, 0.0, 0.0, 0.0], (101, 1)), size=0.02)
        # A plate: x and y as x and z of the world, theta from x to the chord, and its normal to the left of that.
        pose = self.browser.value("(() => { const {p, q} = poseOf({kind: 'plane', places: [2, 0, 1]}, [[2], [0.4], [1]], 0);"
                                  " return [p, turned(q, [1, 0, 0]), turned(q, [0, 0, 1])]; })()")
        np.testing.assert_allclose(pose, [[1, 0, 2], [np.cos(0.4), 0, np.sin(0.4)], [-np.sin(0.4), 0, np.cos(0.4)]], atol=1e-15)

    def test_a_jump_of_a_motion_stands_between_two_keys_and_a_gap_is_refused(self):
        self.opened(explored(book("coin", COIN_PLAN), name="jumps"))
        keys = ("denseKeys((times) => times.map((t) => ({p: [t, 0, t < 1.3 ? 0 : %s], q: [1, 0, 0, 0]})), 1, 1.5, 0.1)")
        times = np.array(self.browser.value(f"{keys % 0.01}.times"))
        self.assertLess(len(times), 200)
        self.assertTrue(np.all(np.diff((times - 1.0).astype(np.float32)) > 0))
        self.assertLess(np.min(np.diff(times)), 1e-6)
        message = self.browser.value(f"(() => {{ try {{ {keys % 'NaN'}; }} catch (e) {{ return e.message; }} }})()")
        self.assertIn("has no pose at 1.3", message)

    def test_an_error_without_bound_is_told_in_red_and_the_page_works(self):
        path = FOLDER / "unbounded.h5"
        path.write_bytes(book("coin", COIN_PLAN).read_bytes())
        with h5py.File(path, "r+") as file:
            for place in [file["certificate"], file["certificate/x"]]:
                for name in [n for n in place.attrs if n.startswith("max") and not n.endswith("norm_defect")]:
                    place.attrs[name] = np.inf
            file["certificate"].attrs["met"] = np.zeros((), file["certificate"].attrs["met"].dtype)
        self.opened(explored(path, name="unbounded"))
        shown = self.browser.value("[document.getElementById('certificate').className, document.getElementById('certificate').textContent,"
                                   " document.querySelector('#worst button').textContent]")
        self.assertRegex(" ".join(shown), "bad.*Certificate missed.*without bound.*Worst point of all: x, without bound")
        self.assertEqual(self.browser.value("document.querySelectorAll('#curves canvas').length"), 2)
        self.check_quiet()

    def test_certificates_that_are_missed_or_missing_are_told_in_red(self):
        missed = COIN_PLAN.replace('"v(0)" = [0.0, 0.4]', '"v(0)" = { range = [0.0, 0.4], nodes = 2 }')
        path = FOLDER / "missed.h5"
        run("build", write("missed.toml", missed), "-o", path)
        bare = FOLDER / "pieces.h5"
        if not bare.exists():
            subprocess.run([SAMPLES, "reference", FOLDER], check=True)
        self.opened(explored(path, bare, name="missed"))
        shown = "[document.getElementById('certificate').className, document.getElementById('certificate').textContent]"
        self.assertRegex(" ".join(self.browser.value(shown)), "bad.*Certificate missed")
        self.browser.value("(() => { const s = document.getElementById('codebook'); s.value = 1; s.dispatchEvent(new Event('change')); })()")
        self.assertRegex(" ".join(self.browser.value(shown)), "bad.*No certificate")
        self.assertFalse(self.browser.value("document.getElementById('build').hidden"))

    def test_it_is_drawn_in_the_dark_and_on_a_phone_without_scrolling_sideways(self):
        page = explored(book("card", CARD_PLAN), name="looks")
        for width, dark in [(1200, True), (390, False)]:
            self.browser.look(width, 800, dark=dark)
            self.browser.open(page, "#check")
            self.browser.until("document.documentElement.dataset.painted")
            self.assertEqual(self.browser.value("document.documentElement.dataset.painted"), "14")
            # Curves, and not axes alone: of the model's colour.
            drawn = self.browser.value(
                "(() => { const rgb = [1, 3, 5].map((at) => parseInt(kit.colours().model.slice(at, at + 2), 16));"
                " return [...document.querySelectorAll('canvas')].filter((c) => { const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
                " for (let k = 0; k < d.length; k += 4) if (d[k + 3] > 200 && rgb.every((v, i) => Math.abs(d[k + i] - v) < 24)) return true;"
                " return false; }).length; })()")
            self.assertGreaterEqual(drawn, 13)
            self.assertLessEqual(self.browser.value("document.documentElement.scrollWidth"), width)
            self.assertEqual(self.browser.value("getComputedStyle(document.body).backgroundColor"),
                             "rgb(20, 25, 31)" if dark else "rgb(255, 255, 255)")

    def test_axe_finds_nothing_that_shuts_people_out(self):
        axe = pathlib.Path(os.environ.get("SAMARA_NODE_MODULES", ""), "axe-core", "axe.min.js")
        if not axe.is_file():
            self.skipTest("SAMARA_NODE_MODULES does not lead to axe-core")
        capture, fit = fallen()
        page = explored(book("coin", COIN_PLAN), book("card", CARD_PLAN), "--capture", capture, name="axe")
        for width, dark in [(1200, False), (1200, True), (390, False)]:
            self.browser.look(width, 900, dark=dark)
            self.browser.open(page, "#slopes=1&b.C_D=1.3")
            self.browser.value(axe.read_text() + "; 1")
            found = self.browser.value("axe.run().then((r) => r.violations.map((v) => [v.id, v.nodes.map((n) => n.html)]))")
            self.assertEqual(found, [])


if __name__ == "__main__":
    if browser.PROGRAM is None:
        print("SKIPPED: none of chromium-headless-shell, chromium, google-chrome is installed")
        sys.exit(77)
    main()
