"""Usage: explorer_test.py SAMARA Explorer SAMPLES

The page that `samara explore` writes, as a file. SAMPLES is the program codebook_samples, which writes codebooks of all kinds.
"""

import itertools
import json
import os
import re
import subprocess

from explored_pages import CARD_PLAN, HOSTILE, SAMPLES, explored, fallen
from samara_case import COIN_PLAN, FOLDER, Case, book, main, run, write


def fine_box():
    """A closed box as OBJ, two sides of it in 50 x 50 squares."""
    corners = "".join(f"v {x} {y} {z}\n" for x in range(2) for y in range(51) for z in range(51))
    number = lambda x, y, z: 1 + (x * 51 + y) * 51 + z
    faces = []
    for x in (0, 1):
        for y, z in itertools.product(range(50), range(50)):
            square = [number(x, y, z), number(x, y + 1, z), number(x, y + 1, z + 1), number(x, y, z + 1)]
            faces.append(square if x else square[::-1])
    for k in range(50):
        faces += [[number(0, k, 0), number(0, k + 1, 0), number(1, k + 1, 0), number(1, k, 0)],
                  [number(0, k, 50), number(1, k, 50), number(1, k + 1, 50), number(0, k + 1, 50)],
                  [number(0, 0, k), number(1, 0, k), number(1, 0, k + 1), number(0, 0, k + 1)],
                  [number(0, 50, k), number(0, 50, k + 1), number(1, 50, k + 1), number(1, 50, k)]]
    return corners + "".join("f {} {} {}\nf {} {} {}\n".format(a, b, c, a, c, d) for a, b, c, d in faces)


def explored_data(page):
    return json.loads(re.search('id="explored">(.*?)</script>', page).group(1))


class Explorer(Case):
    def beside(self, fit, *shown):
        """What the page has of captures beside a fit, and what was told."""
        page = FOLDER / "beside.html"
        options = itertools.chain.from_iterable(("--capture", path) for path in shown)
        result = run("explore", book("coin", COIN_PLAN), *options, "--fit", fit, "-o", page)
        self.assertEqual(result.returncode, 0, result.stderr)
        return explored_data(page.read_text())["captures"], result.stderr

    def test_the_page_is_complete_in_itself_and_forbids_the_network(self):
        text = explored(book("coin", COIN_PLAN)).read_text()
        self.assertEqual(re.findall(r"(?:src|href)\s*=\s*[\"'](?!#)", text), [])
        self.assertIn("default-src 'none'", text)
        self.assertIn("Permission is hereby granted", text)

    def test_what_stands_in_files_cannot_become_markup(self):
        plan = COIN_PLAN.replace("model", f"title = '''{HOSTILE}'''\nmodel", 1)
        path = FOLDER / "<img src=x onerror=alert(1)>.h5"
        path.write_bytes(book("hostile", plan).read_bytes())
        text = explored(path, "--capture", write("<img src=y>.csv", "t[s],x[m]\n0,0\n0.1,0.05\n0.2,0.2\n")).read_text()
        self.assertNotIn("<img", text)
        self.assertEqual(text.count("</script>"), 4)

    def test_bad_calls_are_told_in_one_sentence(self):
        path = book("coin", COIN_PLAN)
        page = FOLDER / "refused.html"
        self.check_error(run("explore", path, "-o", path), 2, "which it would overwrite")
        self.check_error(run("explore", path, "--outputs", "y", "-o", page), 2, 'no codebook has an output "y"')
        self.check_error(run("explore", path, "--times", "1", "-o", page), 2, "number of times is 1")
        self.check_error(run("explore", path, "--body", "disc", "-o", page), 2, "its radius and its thickness")
        self.check_error(run("explore", path, "--size", "1 cm", "-o", page), 2, "--body was expected")
        self.check_error(run("explore", path, "--body", "leaf.stl", "-o", page), 2, "--unit")
        self.check_error(run("explore", path, "--body", write("fine.obj", fine_box()), "--unit", "mm", "-o", page), 2, "more than the 5000 that a page draws")
        self.check_error(run("explore", FOLDER / "none.h5", "-o", page), 3, "none.h5")
        damaged = FOLDER / "damaged.h5"
        damaged.write_bytes(path.read_bytes()[:-2000])
        self.check_error(run("explore", damaged, "-o", page), 3, "damaged.h5")
        _, fit = fallen()
        other = book("line", COIN_PLAN.replace("vertical_fall", "constant_rate").split("[fixed]")[0] +
                     "[box]\nk = [1.0, 10.0]\n[time]\nend = 10.0\n[tolerance]\nrelative = 1e-9\n")
        self.check_error(run("explore", other, "--fit", fit, "-o", page), 2, 'of the model "vertical_fall"')
        self.assertFalse(page.exists())

    def test_factors_beyond_20_megabytes_are_refused_with_their_size_unless_outputs_are_chosen(self):
        # Stored numbers that deflate to nothing: 2 outputs with 1.5 million numbers each.
        path = FOLDER / "large.h5"
        subprocess.run([SAMPLES, "large", path], check=True)
        result = run("explore", path, "-o", FOLDER / "large.html")
        self.assertEqual((result.returncode, (FOLDER / "large.html").exists()), (2, False))
        self.assertIn("the factors have 24.0 MB, more than the 20 MB that a page takes: fewer outputs (--outputs)", result.stderr)
        explored(path, "--outputs", "u", name="large")

    def test_a_picture_of_the_middle_of_the_box_takes_a_value_of_a_list(self):
        subprocess.run([SAMPLES, "reference", FOLDER], check=True)
        result = run("plot", FOLDER / "kinds.h5", "-o", FOLDER / "kinds.svg")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_a_body_that_is_not_drawn_is_told(self):
        path = book("coin", COIN_PLAN)
        result = run("explore", path, "--outputs", "v", "--body", "disc", "--size", "1", "0.1", "-o", FOLDER / "still.html")
        self.assertIn("coin.h5 moves no body with the outputs of the page", result.stderr)

    def test_one_number_of_a_quaternion_brings_the_others_and_a_free_shape_is_named(self):
        text = explored(book("card", CARD_PLAN), "--outputs", "qw", name="quaternion").read_text()
        data = explored_data(text)["books"][0]
        self.assertEqual([output["name"] for output in data["outputs"]], ["qw", "qx", "qy", "qz"])
        self.assertEqual(data["attitude"]["places"], [0, 1, 2, 3])
        free = COIN_PLAN.replace('thickness = "2.55 mm"\n', "").replace("C_D = [0.8, 1.6]", 'C_D = [1.1, 1.2]\nthickness = ["2.5 mm", "2.6 mm"]')
        text = explored(book("free", free), name="free").read_text()
        data = explored_data(text)["books"][0]
        self.assertEqual(data["body"]["changes"], ["thickness"])

    def test_bytes_that_are_no_text_do_not_stop_the_page(self):
        path = FOLDER / os.fsdecode(b"caf\xe9.h5")
        path.write_bytes(book("coin", COIN_PLAN).read_bytes())
        self.assertIn("caf\ufffd.h5", explored(path, name="bytes").read_text())

    def test_a_channel_that_is_no_output_is_left_out_with_a_warning(self):
        capture = write("more.csv", "t[s],x[m],height[m]\n0,0,1\n0.1,0.01,1\n0.2,0.05,1\n")
        result = run("explore", book("coin", COIN_PLAN), "--capture", capture, "-o", FOLDER / "more.html")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("height in m is no output of the codebook", result.stderr)

    def test_captures_of_one_name_are_those_of_the_fit_by_their_files(self):
        capture, _ = fallen()
        copies = []
        for folder in ("first", "second", "third"):
            (FOLDER / folder).mkdir()
            copies.append(FOLDER / folder / "drop.csv")
            copies[-1].write_bytes(capture.read_bytes())
        fit = FOLDER / "of_two.json"
        self.assertEqual(run("fit", book("coin", COIN_PLAN), *copies[:2], "-o", fit).returncode, 0)
        shown = (copies[1], FOLDER / "first" / ".." / "first" / "drop.csv", copies[2])
        captures, told = self.beside(fit, *shown)
        self.assertEqual([c["placeInFit"] for c in captures], [1, 0, None])
        self.assertEqual([c["label"] for c in captures], [f"drop, {path}" for path in shown])
        self.assertEqual(told.count("the fit has several of that name"), 1, told)
        # The fit was made in a folder further in.
        written = json.loads(fit.read_text())
        for capture in written["captures"]:
            capture["file"] = os.path.relpath(capture["file"], FOLDER)
        captures, told = self.beside(write("further_in.json", json.dumps(written)), copies[1])
        self.assertEqual([(c["placeInFit"], c["label"]) for c in captures], [(1, "drop")])
        self.assertNotIn("several of that name", told)

    def test_parts_of_a_motion_between_gaps_are_those_of_the_fit(self):
        capture, _ = fallen()
        lines = capture.read_text().splitlines(keepends=True)
        parts = write("parts.csv", "".join(lines[:9] + lines[14:]))
        write("parts.toml", 'file = "parts.csv"\n[clean]\nlongest_gap = "50 ms"\n')
        fit = FOLDER / "parts.json"
        self.assertEqual(run("fit", book("coin", COIN_PLAN), parts, "-o", fit).returncode, 0)
        self.assertEqual([c["id"] for c in json.loads(fit.read_text())["captures"]], ["parts#1", "parts#2"])
        captures, _ = self.beside(fit, parts)
        self.assertEqual([c["placeInFit"] for c in captures], [0, 1])


if __name__ == "__main__":
    main()
