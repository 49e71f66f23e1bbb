"""Usage: many_questions_test.py SAMARA [CLASS]

Questions by the thousand: lists and ranges of times, tables of points.
"""

import json
import subprocess

from samara_case import COIN_PLAN, LINE_PLAN, SAMARA, Case, book, main, rows, run, write


class ManyQuestions(Case):
    def test_lists_and_ranges_of_times(self):
        line = book("line", LINE_PLAN)
        times = lambda *at: [float(row["t[1]"]) for row in rows(run("query", line, "--set", "k=4", "--at", *at).stdout)]
        self.assertEqual(times("0:0.1:0.5"), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])  # 3 times 0.1 is 0.30000000000000004
        self.assertEqual(times("0.1,0.2", "100 %"), [0.1, 0.2, 1.0])
        self.assertEqual(times("0:25:100 %"), [0.0, 0.25, 0.5, 0.75, 1.0])
        self.assertEqual(times("2:-1:0.5"), [2.0, 1.0])
        self.assertEqual(len(rows(run("query", line, "--set", "k=4", "--frames", "25").stdout)), 25)
        fall = run("simulate", "constant_rate", "--set", "k=4", "--until", "1", "--frames", "11").stdout
        self.assertEqual([row.split(",")[0] for row in fall.splitlines()[1:]], [f"{k / 10:g}" for k in range(11)])
        for bad, part in [("0:0:1", "no steps"), ("0:-1:5", "no steps"), ("0:1", "FROM:STEP:TO"), ("0:1e-9:10", "at most"), ("0,x", "x"), ("0,,1", "--at")]:
            self.check_error(run("query", line, "--set", "k=4", "--at", bad), 2, part)
        self.check_error(run("query", line, "--set", "k=4", "--at", "1", "--frames", "5"), 2, "--frames", "--at")

    def test_a_table_of_points_gives_what_one_call_each_gives(self):
        coin = book("coin", COIN_PLAN)
        points = write("points.csv", "v0[cm/s],t[ms],C_D\n10,100,1\n20,400,1.5\n0,0,0.8\n")
        many = rows(run("query", coin, "--points", points, "--gradient").stdout)
        self.assertEqual(len(many), 3)
        for row in many:
            one = rows(run("query", coin, "--set", f"C_D={row['C_D[1]']}", "--set", f"v0={row['v(0)[m/s]']}", "--at", row["t[s]"], "--gradient").stdout)[0]
            for name, value in one.items():
                self.assertAlmostEqual(float(row[name]), float(value), delta=1e-12 * max(1.0, abs(float(value))), msg=name)
        piped = subprocess.run([SAMARA, "query", coin, "--points", "-", "--gradient"], input=points.read_text(), capture_output=True, text=True)
        self.assertEqual(rows(piped.stdout), many)
        answer = json.loads(run("query", coin, "--points", points, "--json").stdout)
        self.assertEqual(answer["coordinates"]["t"], [0.1, 0.4, 0.0])
        self.assertEqual([len(output["values"]) for output in answer["outputs"]], [3, 3])

    def test_coordinates_stand_in_the_answer_as_they_were_asked(self):
        coin = book("coin", COIN_PLAN)
        asked = rows(run("query", coin, "--points", write("typed.csv", "C_D; v0[cm/s]; t\n+1.20; 10; 1e-1\n0.8; 20; 0.40\n")).stdout)
        self.assertEqual([(r["t[s]"], r["C_D[1]"], r["v(0)[m/s]"]) for r in asked], [("1e-1", "1.20", "0.1"), ("0.40", "0.8", "0.2")])
        # Not where they were moved into the box, or are no plain numbers.
        moved = rows(run("query", coin, "--points", write("far_typed.csv", "C_D,t,v0\n1.20,0.10,9.0\n"), "--clamp").stdout)[0]
        self.assertEqual((moved["t[s]"], moved["C_D[1]"], moved["v(0)[m/s]"]), ("0.10", "1.20", "0.4"))
        commas = rows(run("query", coin, "--points", write("commas.csv", "C_D;t\n1,20;0,10\n"), "--set", "v0=0").stdout)[0]
        self.assertEqual((commas["t[s]"], commas["C_D[1]"], commas["v(0)[m/s]"]), ("0.1", "1.2", "0"))

    def test_points_without_a_time_are_asked_at_all_times(self):
        line, points = book("line", LINE_PLAN), write("rates.csv", "k\n2\n5\n")
        asked = rows(run("query", line, "--points", points, "--at", "0:1:2").stdout)
        self.assertEqual([(float(r["k[1]"]), float(r["t[1]"])) for r in asked], [(k, t) for k in (2.0, 5.0) for t in (0.0, 1.0, 2.0)])
        for row in asked:
            one = rows(run("query", line, "--set", f"k={row['k[1]']}", "--at", row["t[1]"]).stdout)[0]
            self.assertAlmostEqual(float(row["u[1]"]), float(one["u[1]"]), places=9)

    def test_questions_that_memory_does_not_hold_are_refused(self):
        coin = book("coin", COIN_PLAN)
        for more in ("--gradient", "--json"):
            self.check_error(run("query", coin, "--set", "C_D=1", "--set", "v(0)=0", "--frames", 10000000, more), 2, "10000000 points are asked for at once")

    def test_bad_tables_of_points_name_the_line(self):
        line = book("line", LINE_PLAN)
        refuse = lambda text, code, *parts, more=(): self.check_error(run("query", line, "--points", write("bad_points.csv", text), *more), code, *parts)
        refuse("k,t\n4,1\n11,1\n", 5, "bad_points.csv:3", "k = 11", "[1, 10]")
        refuse("kk,t\n4,1\n", 3, "kk", 'did you mean "k"')
        refuse("k,k[1]\n4,1\n", 3, "two columns")
        refuse("k[m],t\n4,1\n", 3, "k is in m")
        refuse("k,t\n4,\n", 3, "bad_points.csv:2", "has no t")
        refuse("k,t\n4,x\n", 3, "bad_points.csv:2")
        refuse("k,t\n", 3, "has no rows")
        # What is wrong with the header is said first, and where it stands.
        refuse("# falls\nnote,k,t\nfast,4,1\n", 3, "bad_points.csv:2", 'the column "note" is no coordinate')
        refuse("# falls\nk[m],t\n4,x\n", 3, "bad_points.csv:2", "k is in m")
        refuse("t\n1\n", 2, "k is not set")
        refuse("k,t\n4,1\n", 2, "column of the time", more=("--at", "1"))
        refuse("k,t\n4,1\n", 2, "--set names", more=("--set", "k=3"))
        refuse("k,t\n4,1\n", 2, "--points", more=("--until", "30"))
        piped = subprocess.run([SAMARA, "query", line, "--points", "-"], input="k,t\n4,x\n", capture_output=True, text=True)
        self.check_error(piped, 3, "samara: stdin:2: ")
        clamped = run("query", line, "--points", write("far.csv", "k,t\n11,1\n4,1\n"), "--clamp")
        self.assertEqual(clamped.returncode, 0)
        self.assertEqual([float(r["k[1]"]) for r in rows(clamped.stdout)], [10.0, 4.0])


if __name__ == "__main__":
    main()
