"""Builds from plans and functions: what the command builds, progress, and what a user's function raises."""

import concurrent.futures
import math
import tomllib

import numpy as np
import pytest

import samara
from conftest import COIN
from models_test import exact, model
from samara._errors import in_words_of_python


def test_a_plan_gives_the_codebook_of_the_command(coin):
    path = COIN / "plan.toml"
    for plan in (path, tomllib.loads(path.read_text())):
        book = samara.build(plan, progress=False)
        assert book.certificate.met and book.message.startswith("certified")
        assert book.certificate.max_error == coin.certificate.max_error
        points = np.array([[0.1, 0.7, 0.0], [0.5, 1.9, -0.4]])
        assert np.array_equal(book.at(points), coin.at(points))


def test_a_bad_plan_is_an_input_error_with_its_place():
    for change, text in [({"box": {"C_d": [0.6, 2.0]}}, "C_D"), ({"tolerance": {"relative": -1.0}}, "relative"),
                         ({"colour": "red"}, "colour"), ({"title": "\ud800"}, "\"title\" is '.ud800'"),
                         ({"box": {"C_D": [0.6, math.nan]}}, "nan")]:
        with pytest.raises(ValueError, match=text) as raised:
            samara.build({**tomllib.loads((COIN / "plan.toml").read_text()), **change}, progress=False)
        assert isinstance(raised.value, samara.Error)
    with pytest.raises(OSError, match="missing.toml"):
        samara.build("missing.toml")
    with pytest.raises(samara.ArgumentError, match="object"):
        samara.build({"model": object()})


def test_progress_is_told_and_can_end_a_build():
    stages = []
    samara.build(COIN / "plan.toml", progress=lambda stage, fraction: stages.append((stage, fraction)))
    assert stages and all(0.0 <= fraction <= 1.0 for _, fraction in stages)
    for no in (False, np.bool_(False)):
        with pytest.raises(samara.NoResultError, match="first slab"):
            samara.build(COIN / "plan.toml", progress=lambda stage, fraction: no)
        book = samara.build(COIN / "plan.toml", progress=lambda stage, fraction: no if stage == "slab 5" else None)
        assert not book.certificate.met and "cancelled" in book.message
    with pytest.raises(samara.NoResultError):
        samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], progress=lambda stage, fraction: False)
    for wrong in ("yes", 1, None):
        with pytest.raises(samara.ArgumentError, match="progress is"):
            samara.build(COIN / "plan.toml", progress=wrong)

    def bad(stage, fraction):
        raise LookupError("of the report")

    with pytest.raises(LookupError, match="of the report"):
        samara.build(COIN / "plan.toml", progress=bad)


def test_errors_name_arguments_where_the_library_names_options_and_leave_what_they_quote():
    said = "solver --config a.toml failed"
    plan = {"command": {"run": ["sh", "-c", f"cat >/dev/null; echo '{said}' >&2; exit 3"], "inputs": {"x": "1"}, "outputs": {"u": "1"}},
            "box": {"x": [0.0, 1.0]}, "tolerance": {"relative": 1e-3}}
    with pytest.raises(samara.Error, match=f'it said "{said}"') as raised:
        samara.build(plan, progress=False)
    assert raised.value.args == (str(raised.value),) and said in repr(raised.value)
    with pytest.raises(samara.ArgumentError) as raised:
        samara.fit("vertical_fall", [COIN / "coin.toml"])
    assert "needs config with a [box]" in str(raised.value) and raised.value.args == (str(raised.value),)
    assert in_words_of_python('--sidecar "a --config b": or --left-out-span, --fresh') == 'sidecar "a --config b": or left_out_span, resume=False'


@pytest.mark.parametrize("kind", ["pgd", "sampling"])
def test_the_codebook_of_a_model_in_python_follows_the_exact_solution(kind):
    plan = {"box": {"stiffness": [4.0, 9.0], "damping": [0.0, 0.5]}, "time": {"end": 2.0}, "tolerance": {"relative": 1e-4},
            "builder": {"kind": kind}}
    book = samara.build(plan, model(), progress=False, certificate_points=40)
    assert book.certificate.verdict == "met at 40 points" and book.model["name"] == "oscillator"
    times = np.linspace(0, 2, 21)
    k, c = np.random.default_rng(1).uniform([4.0, 0.0], [9.0, 0.5], (30, 2)).T
    values = book.query({"stiffness": k, "damping": c}, times, outputs=["place"])[..., 0]
    # The range of the place is 2 m.
    np.testing.assert_allclose(values, exact(times, k[:, None], c[:, None]), rtol=0, atol=4e-4)


def test_an_exception_of_a_model_comes_back_from_a_build():
    calls = [0]

    def broken(t, x, p):
        calls[0] += 1
        if calls[0] > 20:
            raise ZeroDivisionError("deep inside")
        return (-p[0] * x[0],)

    own = samara.Model(broken, {"x": samara.State("x", initial=1.0)}, {"k": "1/s"})
    with pytest.raises(ZeroDivisionError, match="deep inside") as raised:
        samara.build({"box": {"k": [1.0, 2.0]}, "time": {"end": 1.0}, "tolerance": {"relative": 1e-3}}, own, progress=False)
    assert raised.traceback[-1].name == "broken"


def test_a_plan_file_with_a_model_of_ones_own_is_refused_with_its_place(tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text("[box]\nstiffness = [4, 9]\n[time]\nend = 1\n[tolerance]\nrelative = -1\n")
    with pytest.raises(samara.InputError, match="plan.toml:6"):
        samara.build(plan, model())
    plan.write_bytes(b"title = '\xff\xfe'\n")
    with pytest.raises(samara.InputError, match="plan.toml"):
        samara.build(plan, model())
    with pytest.raises(samara.InputError, match="none.toml"):
        samara.build(tmp_path / "none.toml", model())
    for wrong in [lambda: samara.build(3), lambda: samara.build(plan, "vertical_fall"), lambda: samara.build({}, model=3),
                  lambda: samara.build(plan, model(), certificate_points=1.5), lambda: samara.build(plan, model(), resume="no")]:
        with pytest.raises(samara.ArgumentError, match="expected"):
            wrong()


def test_what_looks_like_a_mistake_of_units_in_a_body_is_warned_of():
    plan = {"model": "kirchhoff_body", "body": {"shape": "disc", "size": [12.0, 2.0], "density": 700.0, "fluid_density": 1.2},
            "time": {"end": 0.1}, "tolerance": {"relative": 1e-2}, "box": {"qx(0)": [0.0, 0.1]}}
    with pytest.warns(UserWarning, match="24 m long: were its sizes given in mm or cm"):
        samara.build(plan, progress=False, certificate_points=5)


def borehole(x):
    rw, r, Tu, Hu, Tl, Hl, L, Kw = x.T
    log = np.log(r / rw)
    return 2 * np.pi * Tu * (Hu - Hl) / (log * (1 + 2 * L * Tu / (log * rw**2 * Kw) + Tu / Tl))


BOREHOLE = {"rw": (0.05, 0.15), "r": (100, 50000), "Tu": (63070, 115600), "Hu": (990, 1110), "Tl": (63.1, 116),
            "Hl": (700, 820), "L": (1120, 1680), "Kw": (9855, 12045)}


def test_the_borehole_function_of_eight_inputs_is_separated_with_few_calls():
    book = samara.separate(borehole, BOREHOLE, {"flow": "m^3/s"}, tolerance=1e-6)
    assert book.certificate.met and book.build.evaluations < 4000
    lower, upper = np.array(list(BOREHOLE.values())).T
    x = np.random.default_rng(3).uniform(lower, upper, (2000, 8))
    exact_values = borehole(x)
    assert np.abs(book.at(x)[:, 0] - exact_values).max() < 2e-6 * np.ptp(exact_values)


def decay(x, t):
    return np.exp(-x[:, :1] * t)[..., None]


def one_decay(x, t):
    return np.exp(-x[0] * t)[:, None]


@pytest.mark.parametrize("vectorised", [True, False])
@pytest.mark.parametrize("workers", [0, 2])
def test_functions_of_time_and_executors_give_the_same(vectorised, workers):
    pool = concurrent.futures.ThreadPoolExecutor(workers) if workers else None
    book = samara.separate(decay if vectorised else one_decay, {"rate": ("1 1/s", "3 1/s")}, ["u"], 1e-5, vectorised, pool,
                           units={"rate": "1/s"}, end="2 s", certificate_points=100)
    times = np.linspace(0, 2, 9)
    np.testing.assert_allclose(book.query({"rate": [1.0, 2.2]}, times)[..., 0], np.exp(-np.outer([1.0, 2.2], times)),
                               rtol=0, atol=2e-5)


def test_floors_of_outputs_may_be_a_series():
    pandas = pytest.importorskip("pandas")
    floors = {"u": 2.0}

    def separated(absolute):
        return samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], absolute=absolute, certificate_points=20)

    assert separated(pandas.Series(floors)).certificate == separated(floors).certificate


def test_what_the_function_raises_or_gets_wrong_comes_back():
    def bad(x):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine") as raised:
        samara.separate(bad, {"a": (0, 1)}, ["u"])
    assert raised.traceback[-1].name == "bad"
    with pytest.raises(samara.ArgumentError, match=r"the shape \(3,\)"):
        samara.separate(lambda x: np.zeros(3), {"a": (0, 1)}, ["u", "v"])
    with pytest.raises(ValueError):
        samara.separate(lambda x: x, {"a": (1, 0)}, ["u"])
    for call, text in [
        (lambda: samara.separate(lambda x: x * 1j, {"a": (0, 1)}, ["u"]), "complex"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], units={"b": "m"}), 'coordinate "b" is unknown'),
        (lambda: samara.separate(lambda x: x, {"a": 3}, ["u"]), "a has the bounds 3, expected a pair"),
        (lambda: samara.separate(lambda x: x, {"a": (None, 1)}, ["u"]), "a is None"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, [1]), r"outputs are \[1\]"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], certificate_points=1.5), "certificate_points is 1.5"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], certificate_points=-1), "is -1, expected .* from 1 on"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], certificate_points=0), "is 0, expected .* from 1 on"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u", "u"]), 'outputs have "u" more than once'),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], pool=3), "pool is of the type int, expected an executor"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], resume="no"), "resume is 'no', expected True or False"),
        (lambda: samara.separate(3, {"a": (0, 1)}, ["u"]), "the function is of the type int"),
        (lambda: samara.separate(lambda x: x, {"a": (0, -1)}, ["u"]), "a has the bounds 0 and -1, expected finite ones, the lower"),
        (lambda: samara.separate(lambda x: x, {"a": (0, math.inf)}, ["u"]), "a has the bounds 0 and inf"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], -1), "tolerance is -1, expected more than 0 and less than 1"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], None), "tolerance is None"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], end=0), "end is 0 s, expected a finite number above 0"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], absolute={"u": -1}), "absolute of u is -1, expected .* from 0 on"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], absolute={"w": 1}), 'output "w" is unknown'),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], absolute=0), "absolute are given as int"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], seed=None), "seed is None, expected a whole number"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], max_calls=-1), "max_calls is -1, expected a whole number"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], title=3), "title is 3, expected a text"),
        (lambda: samara.separate(lambda x: x, {"a": (0, 1)}, ["u"], vectorised="no"), "vectorised is 'no', expected True or False"),
    ]:
        with pytest.raises(samara.ArgumentError, match=text):
            call()
    one = samara.separate(lambda x: x, {"a": (0, 1)}, "uv", certificate_points=20)
    assert [o.name for o in one.outputs] == ["uv"]
    assert one.query({"a": 0.5}, outputs="uv").shape == (1,)


@pytest.mark.parametrize("vectorised", [True, False])
def test_masked_answers_of_a_function_are_refused(vectorised):
    def masked(x):
        return np.ma.masked_where(x[..., 0] > 0.5, x[..., 0])

    with pytest.raises(samara.ArgumentError, match="the function's answer: .* values are masked, expected none"):
        samara.separate(masked, {"a": (0, 1)}, ["u"], vectorised=vectorised)


def test_a_process_takes_calls_where_it_can(tmp_path):
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        book = samara.separate(math_product, {"a": (0, 1), "b": (0, 1)}, ["u"], 1e-4, False, pool, certificate_points=30)
    np.testing.assert_allclose(book.query({"a": 0.5, "b": 0.5}), [0.25], atol=1e-4)


def math_product(x):
    return x[0] * x[1]
