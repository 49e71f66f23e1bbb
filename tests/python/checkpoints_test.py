"""Checkpoints of builds from functions: who takes one up, and by what a function is known again."""

import functools
import os
import subprocess
import sys
import textwrap
import threading
import types
import warnings

import numpy as np
import pytest

import samara
from conftest import COIN, interrupted
from models_test import model, oscillator, oscillator_jacobian
from samara._building import _fingerprint
from samara._identity import identity


INTERRUPTED = """
    import os, signal, sys, threading, time
    import samara
    calls = [0]
    def slow(x):
        calls[0] += 1
        time.sleep(0.02)
        return (1 / (1 + 25 * (x[:, 0] + 0.3 * x[:, 1]) ** 2))
    def stop():
        while calls[0] < 20:
            time.sleep(0.005)
        os.kill(os.getpid(), signal.SIGINT)
    if sys.argv[2] == "stop":
        threading.Thread(target=stop, daemon=True).start()
    try:
        book = samara.separate(slow, {"a": (-1, 1), "b": (-1, 1)}, ["u"], tolerance=1e-6, certificate_points=50,
                               checkpoint=sys.argv[1])
        print("done", calls[0], book.certificate.met)
    except KeyboardInterrupt:
        print("interrupted", calls[0])
"""


def test_ctrl_c_ends_a_build_and_its_checkpoint_is_taken_up(tmp_path):
    script = tmp_path / "build.py"
    script.write_text(textwrap.dedent(INTERRUPTED))
    checkpoint = tmp_path / "build.checkpoint"

    def run(mode, path):
        return subprocess.run([sys.executable, script, path, mode], capture_output=True, text=True, timeout=240).stdout.split()

    stopped = run("stop", checkpoint)
    assert stopped[0] == "interrupted"
    assert checkpoint.exists()
    resumed = run("go", checkpoint)
    whole = run("go", tmp_path / "other.checkpoint")
    assert resumed[0] == whole[0] == "done" and resumed[2] == whole[2] == "True"
    assert int(resumed[1]) < int(whole[1])
    assert not checkpoint.exists()


class Scaled:
    def __init__(self, by):
        self.by = by

    def __call__(self, x):
        return self.by / (1 + 25 * x[:, 0] ** 2)


FACTOR = 1.0


def by_a_global(x):
    return FACTOR / (1 + 25 * x[:, 0] ** 2)


def functions_of(by):
    """The same function, with a number that stands in another place each time."""
    def closure(x):
        return by / (1 + 25 * x[:, 0] ** 2)

    def default(x, by=by):
        return by / (1 + 25 * x[:, 0] ** 2)

    def keyword(x, *, by=by):
        return by / (1 + 25 * x[:, 0] ** 2)

    return {"closure": closure, "default": default, "keyword": keyword, "object": Scaled(by), "method": Scaled(by).__call__,
            "partial": functools.partial(keyword, by=by), "global": by_a_global}


@pytest.mark.parametrize("kind", list(functions_of(1.0)))
def test_a_checkpoint_is_taken_up_by_the_same_function_only(kind, tmp_path, monkeypatch):
    checkpoint = tmp_path / "build.checkpoint"

    def separated(by, stopped=False):
        monkeypatch.setattr(sys.modules[__name__], "FACTOR", by)
        told = []

        def progress(stage, fraction):
            told.append(stage)
            return not (stopped and checkpoint.exists())

        book = samara.separate(functions_of(by)[kind], {"a": (-1, 1)}, ["u"], 1e-6, checkpoint=checkpoint,
                               progress=progress, certificate_points=20)
        return book.at([[0.0]])[0, 0]

    def stop():
        try:
            separated(1.0, True)
        except samara.NoResultError:
            pass
        assert checkpoint.exists()

    stop()
    with pytest.raises(samara.InputError, match="another .*; resume=False begins anew"):
        separated(2.0)
    assert separated(1.0) == pytest.approx(1.0, abs=1e-5)


def test_a_checkpoint_of_what_cannot_be_told_is_not_taken_up(tmp_path):
    checkpoint, lock = tmp_path / "build.checkpoint", threading.Lock()

    def locked(x):
        with lock:
            return 1 / (1 + 25 * x[:, 0] ** 2)

    checkpoint.touch()  # of whoever
    with pytest.warns(UserWarning, match="cannot be told, for its lock cannot be pickled"):
        book = samara.separate(locked, {"a": (-1, 1)}, ["u"], 1e-4, checkpoint=checkpoint, certificate_points=20)
    assert book.certificate.met
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        samara.separate(locked, {"a": (-1, 1)}, ["u"], 1e-4, checkpoint=checkpoint, certificate_points=20)


def test_a_checkpoint_that_cannot_be_written_is_warned_of(tmp_path):
    with pytest.warns(UserWarning, match="no checkpoint: .*none/build.checkpoint"):
        book = samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], checkpoint=tmp_path / "none" / "build.checkpoint",
                               certificate_points=20)
    assert book.certificate.met


def test_a_checkpoint_that_is_no_file_is_refused_by_name():
    plan = {"model": "vertical_fall"}
    for call in [lambda **more: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], **more), lambda **more: samara.build(plan, **more),
                 lambda **more: samara.sweep(plan, **more)]:
        with pytest.raises(samara.ArgumentError, match="checkpoint is of the type int, expected a file"):
            call(checkpoint=3)


def test_warnings_are_told_when_they_happen_so_an_interruption_loses_none(tmp_path):
    def separated(**more):
        return samara.separate(lambda x: 1 / (1 + 25 * x[:, 0] ** 2), {"a": (-1, 1)}, ["u"], 1e-6, certificate_points=20, **more)

    def built(**more):
        return samara.build(COIN / "plan.toml", certificate_points=20, **more)

    for call in (separated, built):
        told = interrupted(call, tmp_path)
        assert [warning.filename for warning in told] == [__file__]


def test_the_identity_of_a_function_is_alike_in_all_runs_and_that_of_a_model_is_all_of_it():
    code = textwrap.dedent("""
        from samara._identity import identity
        import numpy as np
        words = {"a", "b", "c"}
        def f(x, of=np.arange(3)):
            return x in {"one", "two", "three", "four"} and words
        print(identity(f))
    """)
    told = {subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": str(seed)}, capture_output=True,
                           text=True).stdout for seed in range(4)}
    assert len(told) == 1 and "unknown" not in told.pop()

    def comment(**more):
        own = model(**more)
        return _fingerprint(own.rhs, "x.checkpoint", True, own.jacobian, repr(own.states), repr(own.parameters))

    def other_start():
        own = samara.Model(oscillator, {"place": samara.State("place", "m", initial=2.0), "speed": "m/s"},
                           {"stiffness": "1/s^2", "damping": samara.Parameter("damping", "1/s", default=0.0)})
        return _fingerprint(own.rhs, "x.checkpoint", True, own.jacobian, repr(own.states), repr(own.parameters))

    assert comment() == comment()
    assert len({comment(), comment(jacobian=oscillator_jacobian), other_start()}) == 3


def test_the_identity_of_what_a_class_computes_is_another_with_each_of_its_members(monkeypatch):
    code = textwrap.dedent("""
        class Law:
            exponent = {exponent}
            def drag(self, x):
                return {drag} * x
            @property
            def lift(self):
                return {lift}
            @staticmethod
            def mass():
                return {mass}
            @classmethod
            def torque(cls, x):
                return {torque} * x
        class Fall(Law):
            def __call__(self, x):
                return x**self.exponent + self.drag(x) + self.lift + self.mass() + self.torque(x)
        def fall(x):
            return Fall()(x)
    """)
    members = dict.fromkeys(("exponent", "drag", "lift", "mass", "torque"), 1.0)

    def told(**changed):
        law = types.ModuleType("law_of_a_test")
        monkeypatch.setitem(sys.modules, law.__name__, law)
        exec(code.format(**{**members, **changed}), law.__dict__)
        both = identity(law.Fall()), identity(law.fall)
        assert [why for _, why in both] == ["", ""]
        return [digest for digest, _ in both]

    assert told() == told()
    for digests in zip(told(), *(told(**{name: 2.0}) for name in members)):
        assert len(set(digests)) == 1 + len(members)


def test_the_identity_of_a_function_is_another_with_all_that_it_computes_with(tmp_path, monkeypatch):
    helper = "def drag(x): return {} * x\n"
    code = textwrap.dedent("""
        import functools
        import numpy as np
        import helper_of_a_test
        from helper_of_a_test import drag
        from installed_of_a_test import drag as installed
        class Law:
            table, kinds, curve, held = [{0}], {{"a": [{0}]}}, np.array([{0}]), functools.lru_cache(lambda x: {0} * x)
            def __init__(self, f=None):
                self.f = f
            def __call__(self, x):
                return self.f(x)
        def g(x):
            return {0} * x
        def by_class(x):
            return Law.{1}
        def with_attribute(x):
            return x
        with_attribute.c = {0}
        @functools.wraps(g)
        def wrapped(*x):
            return x
        def by_name(x):
            return drag(x)
        def by_installed(x):
            return installed(x)
        def by_module(x):
            return helper_of_a_test.drag(x)
        kept, vectorised, by_object = functools.lru_cache(g), np.vectorize(g), Law(g)
        within = Law([Law(lambda x: {0} * x)])
        dispatched = functools.singledispatch(g)
    """)

    def told(name, own=1.0, other=1.0, member="table"):
        for module, text, folder in [("helper_of_a_test", helper.format(other), tmp_path),
                                     ("installed_of_a_test", helper.format(other), tmp_path / "site-packages"),
                                     ("law_of_a_test", code.format(own, member), tmp_path)]:
            loaded = types.ModuleType(module)
            loaded.__file__ = str(folder / f"{module}.py")
            monkeypatch.setitem(sys.modules, module, loaded)
            exec(text, loaded.__dict__)
        return identity(getattr(loaded, name))

    for name in ("with_attribute", "wrapped", "kept", "vectorised", "by_object", "within"):
        assert told(name) == told(name) != told(name, own=2.0) and told(name)[1] == "", name
    for name in ("table", "kinds", "curve", "held"):
        assert told("by_class", member=name) == told("by_class", member=name) != told("by_class", own=2.0, member=name)
    for name in ("by_name", "by_module"):
        assert told(name) == told(name) != told(name, other=2.0) and told(name)[1] == "", name
    assert told("by_installed") == told("by_installed", other=2.0)
    assert told("dispatched")[0] == "unknown"  # by what it keeps of its calls
    function = np.vectorize(lambda x: x, otypes=[float])
    before = identity(function)
    function(np.ones(3))
    assert identity(function) == before
