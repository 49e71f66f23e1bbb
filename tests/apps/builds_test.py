"""Usage: builds_test.py SAMARA [CLASS]

Builds that miss, are killed, or find no room.
"""

import json
import pathlib
import signal
import subprocess
import time
import unittest

from plans import plate_plan
from samara_case import COIN_PLAN, FOLDER, LINE_PLAN, LONGEST, PATIENCE, SAMARA, Case, main, run, run_with_files_of_at_most, write


PLATE_PLAN = plate_plan(3, 3.0)


class Builds(Case):
    def test_a_build_that_misses_its_tolerance_is_written_marked_and_exits_with_4(self):
        plan = COIN_PLAN.replace('"v(0)" = [0.0, 0.4]', '"v(0)" = { range = [0.0, 0.4], nodes = 2 }')
        path = FOLDER / "missed.h5"
        result = run("build", write("missed.toml", plan), "-o", path)
        self.assertEqual(result.returncode, 4)
        self.assertIn("missed", result.stderr)
        query = run("query", path, "--set", "C_D=1", "--set", "v(0)=0.1")
        self.assertEqual(query.returncode, 0)
        self.assertIn("missed its tolerance", query.stderr)
        self.assertTrue(run("info", path).stdout.startswith("MISSED ITS TOLERANCE"))
        self.assertIn("missed its tolerance", run("stats", path).stderr)
        self.assertEqual(run("validate", path).returncode, 4)
        self.assertIn("at most 100 % of the box errs by more", run("validate", path, "--points", "1").stdout)

    def test_a_builder_that_did_not_converge_is_not_said_to_have_missed_what_no_point_misses(self):
        write("relay.toml", 'name = "relay"\n[states]\nx = { initial = 1 }\nv = {}\n[parameters]\nk = {}\nmu = {}\n'
                            '[rates]\nx = "v"\nv = "-k*x - mu*sign(v)"\n')
        plan = write("relay_plan.toml", 'model = "relay.toml"\n[box]\nk = [1, 4]\nmu = [0, 0.2]\n[time]\nend = 3\n'
                                        '[tolerance]\nrelative = 1e-2\n[builder]\nkind = "sampling"\nmax_calls = 250\n')
        path = FOLDER / "relay.h5"
        ended = 'no point errs by more than was asked, but the builder ended with "max_calls"'
        built = run("build", plan, "-o", path)
        for result in (built, run("validate", path, "--seed", "7")):
            self.assertEqual(result.returncode, 4, result.stderr)
            self.assertTrue(result.stdout.startswith("certificate: NOT CONVERGED"), result.stdout)
            self.assertIn(ended, result.stdout)
        self.assertIn("the build did not converge", built.stderr)
        info = run("info", path).stdout
        self.assertTrue(info.startswith("NOT CONVERGED"), info)
        self.assertIn(ended, info)
        self.assertIn("did not converge", run("stats", path).stderr)

    def test_a_build_whose_model_gives_no_result_leaves_nothing_and_the_mended_plan_is_built(self):
        model = 'name = "drain"\n[states]\nh = { initial = 1 }\n[parameters]\nk = {}\n[rates]\nh = "-k*sqrt(h)"\n'
        write("drain.toml", model)
        plan = write("drained.toml", 'model = "drain.toml"\n[box]\nk = [0.5, 1.5]\n[time]\nend = 2\n[tolerance]\nrelative = 1e-3\n')
        path = FOLDER / "drained.h5"
        self.check_error(run("build", plan, "-o", path), 4, "no trajectory at k = ")
        self.assertFalse(pathlib.Path(f"{path}.checkpoint").exists())
        write("drain.toml", model.replace("sqrt(h)", "sqrt(max(h, 0))"))
        self.assertIn(run("build", plan, "-o", path).returncode, (0, 4))
        self.assertTrue(path.exists())

    def check_killed_builds_resume(self, plan, name):
        whole, killed = FOLDER / f"whole_{name}.h5", FOLDER / f"killed_{name}.h5"
        self.assertEqual(run("build", plan, "-o", whole).returncode, 0)
        process = subprocess.Popen([SAMARA, "build", plan, "-o", killed], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        checkpoint = pathlib.Path(f"{killed}.checkpoint")
        while process.poll() is None and not checkpoint.exists():
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertFalse(killed.exists())
        self.assertTrue(checkpoint.exists())
        again = run("build", plan, "-o", killed)
        self.assertEqual(again.returncode, 0)
        self.assertIn(f"going on from {checkpoint}", again.stderr)
        self.assertFalse(checkpoint.exists())
        left, right = (json.loads(run("info", p, "--json").stdout) for p in (whole, killed))
        for info in (left, right):
            del info["provenance"]
        left.pop("bytes"), right.pop("bytes")
        self.assertEqual(left, right)
        return whole, killed

    def test_a_killed_build_leaves_no_file_and_resumes_to_the_same_codebook(self):
        for strategy in ("slabs", "cross"):
            with self.subTest(strategy):
                plan = write("kill.toml", COIN_PLAN.replace("1e-3", "1e-4") + f'strategy = "{strategy}"\n')
                whole, killed = self.check_killed_builds_resume(plan, strategy)
                at = ["--set", "C_D=1.1", "--set", "v(0)=0.13", "--gradient"]
                self.assertEqual(run("query", whole, *at).stdout, run("query", killed, *at).stdout)

    def test_a_plate_that_turns_is_built_in_slabs_and_certified(self):
        path = FOLDER / "plate.h5"
        result = run("build", write("plate.toml", PLATE_PLAN), "-o", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        info = json.loads(run("info", path, "--json").stdout)
        self.assertEqual(info["build"]["strategy"], "slabs")
        self.assertRegex(" ".join(run("info", path).stdout.split()), r" \d+ march(es)?, .* evaluations in all; a sweep over its grid, \d+ trajectories, would take about ")
        self.assertTrue(info["certificate"]["met"])
        at = ["--set", "C_T=1.1", "--set", "C_R=2.7", "--set", "A=1.3"]
        self.assertEqual(run("query", path, *at, "--at", "0", "1.7", "3").returncode, 0)

    def test_a_checkpoint_that_is_none_is_refused_and_nothing_is_written(self):
        path = FOLDER / "slabs.h5"
        pathlib.Path(f"{path}.checkpoint").write_text("")
        result = run("build", write("slabs.toml", PLATE_PLAN), "-o", path, "--resume")
        self.check_error(result, 3, f"{path}.checkpoint", "--fresh begins anew")
        self.assertFalse(path.exists())
        self.assertEqual(run("build", FOLDER / "slabs.toml", "-o", path, "--fresh").returncode, 0)
        self.assertFalse(pathlib.Path(f"{path}.checkpoint").exists())

    def test_fresh_removes_a_damaged_checkpoint_and_no_other_file(self):
        path = FOLDER / "anew.h5"
        plan, kept = write("line.toml", LINE_PLAN), pathlib.Path(f"{path}.checkpoint")
        kept.write_text("t,z\n0,1\n")
        for words in ([], ["--fresh"]):
            self.check_error(run("build", plan, "-o", path, *words), 3, f"{kept}: this is no checkpoint of a build or a cloud, and would be lost")
            self.assertEqual(kept.read_text(), "t,z\n0,1\n")
        kept.write_text("samara journal 1\nand what is left of it")
        self.check_error(run("build", plan, "-o", path), 3, "--fresh begins anew, and removes it")
        self.assertEqual(run("build", plan, "-o", path, "--fresh").returncode, 0)
        self.assertFalse(kept.exists())

    def test_a_checkpoint_of_another_plan_is_not_eaten(self):
        path = FOLDER / "two_plans.h5"
        process = subprocess.Popen([SAMARA, "build", write("slabs.toml", PLATE_PLAN), "-o", path], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        checkpoint = pathlib.Path(f"{path}.checkpoint")
        while process.poll() is None and not checkpoint.exists():
            time.sleep(0.001)
        process.kill()
        process.wait()
        before = checkpoint.read_bytes()
        result = run("build", write("line.toml", LINE_PLAN), "-o", path)
        self.check_error(result, 3, "belongs to another plan", "--fresh begins anew")
        self.assertEqual(checkpoint.read_bytes(), before)
        self.assertEqual(run("build", FOLDER / "slabs.toml", "-o", path).returncode, 0)

    def test_an_interrupted_build_keeps_its_checkpoint_and_the_same_line_goes_on(self):
        plan = write("slabs.toml", PLATE_PLAN)
        whole, path = FOLDER / "whole_interrupted.h5", FOLDER / "interrupted.h5"
        self.assertEqual(run("build", plan, "-o", whole).returncode, 0)
        for kind in (signal.SIGINT, signal.SIGTERM):
            checkpoint = pathlib.Path(f"{path}.checkpoint")
            for _ in range(30):  # on a busy machine the build may be done before it is interrupted
                process = subprocess.Popen([SAMARA, "build", plan, "-o", path], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                while process.poll() is None and not checkpoint.exists():
                    time.sleep(0.001)
                process.send_signal(kind)
                _, words = process.communicate(timeout=LONGEST)
                if process.returncode != 0:
                    break
                path.unlink()
            self.assertEqual(process.returncode, 130, words)
            self.assertIn(f"interrupted; {checkpoint} is kept: the same line goes on from there", words)
            self.assertFalse(path.exists())
            self.assertFalse(pathlib.Path(f"{path}.lock").exists())
            self.assertEqual(run("build", plan, "-o", path).returncode, 0)
            left, right = (json.loads(run("info", p, "--json").stdout) for p in (whole, path))
            for info in (left, right):
                del info["provenance"], info["bytes"]
            self.assertEqual(left, right)
            path.unlink()

    def test_two_builds_of_one_output_at_once_are_refused(self):
        path = FOLDER / "twice.h5"
        process = subprocess.Popen([SAMARA, "build", write("slabs.toml", PLATE_PLAN), "-o", path], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        lock = pathlib.Path(f"{path}.lock")
        while process.poll() is None and not (lock.exists() and lock.read_text()):
            time.sleep(0.001)
        result = run("build", FOLDER / "slabs.toml", "-o", path)
        self.check_error(result, 2, f"process {process.pid} builds", "twice.h5.lock")
        self.assertEqual(process.wait(timeout=LONGEST), 0)
        self.assertFalse(lock.exists())
        lock.write_text("1")  # of a build that was killed
        self.assertEqual(run("build", FOLDER / "slabs.toml", "-o", path).returncode, 0)

    def test_what_is_no_codebook_is_not_replaced_without_force(self):
        plan = write("line.toml", LINE_PLAN)
        thesis = FOLDER / "thesis.tex"
        thesis.write_text("years of work")
        self.check_error(run("build", plan, "-o", thesis), 2, "thesis.tex", "no codebook", "--force replaces it")
        self.assertEqual(thesis.read_text(), "years of work")
        self.assertEqual(run("build", plan, "-o", thesis, "--force").returncode, 0)
        self.assertEqual(run("build", plan, "-o", thesis).returncode, 0)  # it is one now

    def test_a_name_with_room_for_no_checkpoint_is_built_without(self):
        for length in (244, 255):
            target = FOLDER / ("n" * (length - 3) + ".h5")
            result = run("build", write("coin.toml", COIN_PLAN), "-o", target)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertTrue(run("info", target).stdout)
            self.assertEqual("no checkpoint: cannot write" in result.stderr, length == 255, result.stderr)
        self.check_error(run("build", FOLDER / "coin.toml", "-o", FOLDER / ("n" * 256)), 2, "File name too long")
        self.check_error(run("query", "n" * 300, "--set", "k=1"), 3, "n" * 300)
        self.check_error(run("fit", "n" * 300, "x.csv"), 2, "n" * 300)

    def test_an_output_that_is_a_link_stays_one(self):
        link, target = FOLDER / "link_to_new.h5", FOLDER / "behind.h5"
        link.symlink_to("behind.h5")
        for _ in range(2):  # the file is not there yet, and is
            self.assertEqual(run("build", write("line.toml", LINE_PLAN), "-o", link).returncode, 0)
            self.assertTrue(link.is_symlink())
            self.assertFalse(target.is_symlink())
            self.assertEqual(run("query", target, "--set", "k=4").returncode, 0)

    def test_a_full_disk_is_one_sentence_about_the_checkpoint_and_one_about_the_codebook(self):
        target = FOLDER / "full.h5"
        result = run_with_files_of_at_most(1000, "build", write("full.toml", COIN_PLAN), "-o", target)
        self.assertEqual(result.returncode, 2, result.stderr)
        warning, *_, error = result.stderr.strip().splitlines()
        self.assertIn("samara: warning: no checkpoint: cannot write", warning)
        self.assertIn(f'samara: cannot write "{target}": File too large', error)
        self.assertEqual(len(result.stderr.strip().splitlines()), 2, result.stderr)
        self.assertFalse(target.exists())

    @unittest.skipIf(PATIENCE > 1, "a slow build stores checkpoints on the way, which are larger than the codebook")
    def test_a_build_whose_file_cannot_be_written_at_the_end_keeps_its_checkpoint(self):
        target = FOLDER / "kept.h5"
        plan = write("kept.toml", COIN_PLAN.replace("1e-3", "1e-4"))
        checkpoint = pathlib.Path(f"{target}.checkpoint")
        self.assertEqual(run("build", plan, "-o", target).returncode, 0)
        # The checkpoints, without certificate, fit where the codebook does not.
        size = target.stat().st_size - 100
        for _ in range(3):  # a build that is held up stores checkpoints on the way, too
            checkpoint.unlink(missing_ok=True)
            result = run_with_files_of_at_most(size, "build", plan, "-o", target)
            if "no checkpoint" not in result.stderr:
                break
        self.assertEqual(result.returncode, 2)
        self.assertNotIn("no checkpoint", result.stderr)
        self.assertTrue(checkpoint.exists())
        self.assertEqual(run("build", plan, "-o", target, "--resume").returncode, 0)
        self.assertFalse(checkpoint.exists())
        self.check_error(run("build", plan, "-o", target, "--resume"), 2, "--resume: there is no", "kept.h5.checkpoint")


if __name__ == "__main__":
    main()
