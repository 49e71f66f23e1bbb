"""Usage: docs_lines_test.py SAMARA [CLASS]

The lines of docs/fits.md run as they stand, and say what the page says they do.
"""

import pathlib
import re
import shlex
import shutil
import subprocess

from samara_case import FOLDER, LONGEST, SAMARA, Case, main

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "fits.md").read_text()


class FitsPage(Case):
    def test_the_lines_run(self):
        for example in ("coin", "tumbling_card", "changing_lift"):
            shutil.copytree(ROOT / "examples" / example, FOLDER / "examples" / example)
        (FOLDER / "ratio.toml").write_text(re.search(r"`ratio.toml`\n\n```toml\n(.*?)```", PAGE, re.S).group(1))
        lines = [line for line in PAGE.splitlines() if line.startswith("samara ") and "$SAMARA_DATA" not in line]
        self.assertEqual(len(lines), 12)
        results = [subprocess.run([SAMARA, *shlex.split(line)[1:]], cwd=FOLDER, capture_output=True, text=True, timeout=LONGEST)
                   for line in lines]
        self.assertEqual([r.returncode for r in results], [0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0], results[-1].stderr)
        self.assertRegex(results[1].stdout, r"C_D +1\.169.*0\.88 to 1\.49 \(95 %\)")
        self.assertIn("10 of 10 residual series are not independent", results[1].stdout)
        rows = [dict(re.findall(r"^(A|C_R|C_T|mu1) +([0-9.]+) ", text, re.M)) for text in (PAGE, results[2].stdout)]
        self.assertEqual(sorted(rows[0]), ["A", "C_R", "C_T", "mu1"])
        for name, value in rows[0].items():
            self.assertAlmostEqual(float(rows[1][name]) / float(value), 1.0, places=3)
        self.assertRegex(results[4].stdout, r"0\.68 +2\.6\d+ \+- 0\.02")
        self.assertEqual(len((FOLDER / "replay.csv").read_text().splitlines()), 146)
        phrase, = re.findall(r"^determined by the captures: .*$", PAGE, re.M)
        self.assertIn(phrase, results[9].stdout)
        self.assertRegex(results[10].stdout, r"0\.1 s ahead \[m\] +model +0\.021.*\n.*straight line +0\.0071")
        for line in ("C_D                     1.169 -                 0.095        0.075   78.7 %", "0.4667                 82.2 %"):
            self.assertIn(line, PAGE)
            self.assertIn(line, results[11].stdout)
        self.assertIn("<!DOCTYPE html>", (FOLDER / "fit.html").read_text())


if __name__ == "__main__":
    main()
