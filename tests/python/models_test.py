"""Models of Samara and of the user, and their trajectories."""

import io

import numpy as np
import pytest

import samara
from conftest import COIN, answer, command

TIMES = np.linspace(0.0, 2.0, 11)
COIN_VALUES = {"area": "4.71435e-4 m^2", "thickness": "2.55 mm", "density": "6338.6 kg/m^3", "C_D": 1.2, "v(0)": "10 cm/s"}


def oscillator(t, x, p):
    """A damped oscillator."""
    place, speed = x
    stiffness, damping = p
    return speed, -stiffness * place - damping * speed


def oscillator_jacobian(t, x, p):
    place, speed = x
    stiffness, damping = p
    return ((0, 1), (-stiffness, -damping)), ((0, 0), (-place, -speed))


def model(**more):
    return samara.Model(
        oscillator,
        states={"place": samara.State("place", "m", initial=1.0), "speed": "m/s"},
        parameters={"stiffness": "1/s^2", "damping": samara.Parameter("damping", "1/s", default=0.0)},
        **more,
    )


def exact(t, k, c):
    """From 1 m at rest."""
    w = np.sqrt(k - c * c / 4)
    return np.exp(-c * t / 2) * (np.cos(w * t) + c / (2 * w) * np.sin(w * t))


def test_models_say_what_the_command_says():
    told = {m["name"]: m for m in answer("models")["models"]}
    assert set(samara.models()) == set(told)
    fall = samara.models("vertical_fall")
    for key in ("title", "equations", "frames", "source", "validity", "time_unit"):
        assert getattr(fall, key) == told["vertical_fall"][key]
    rod = samara.models("heat_rod")
    assert rod.states[0].unit == "K" and rod.title == told["heat_rod"]["title"]
    assert samara.models()["heat_rod"] == rod
    for p, expected in zip(fall.parameters, told["vertical_fall"]["parameters"], strict=True):
        assert {k: v for k, v in vars(p).items()} == {k: expected[k] for k in vars(p)}
    with pytest.raises(samara.ArgumentError, match="vertical_fall"):
        samara.models("vertical_fal")


def test_a_trajectory_is_that_of_the_command():
    table = command("simulate", "vertical_fall", *(x for n, v in COIN_VALUES.items() for x in ("--set", f"{n}={v}")),
                    "--until", "0.5 s", "--frames", "6").stdout
    expected = np.loadtxt(io.StringIO(table), delimiter=",", skiprows=1)
    result = samara.simulate("vertical_fall", COIN_VALUES, np.linspace(0, 0.5, 6))
    assert result.done and result.sensitivities is None
    np.testing.assert_allclose(result.values, expected[:, 1:], rtol=0, atol=1e-14)
    assert np.array_equal(result["x"], result.values[:, result.states.index("x")])
    for kind in (KeyError, samara.ArgumentError):
        with pytest.raises(kind, match='output "w" is unknown'):
            result["w"]
    assert tuple(result) == result.outputs and "x" in result and "w" not in result


def test_sensitivities_are_those_of_neighbouring_trajectories():
    times = np.linspace(0, 0.5, 6)
    result = samara.simulate("vertical_fall", COIN_VALUES, times, ["C_D", "v(0)"])
    assert samara.simulate("vertical_fall", COIN_VALUES, times, "C_D").parameters == ("C_D",)
    assert result.sensitivities.shape == (6, 2, 2) and result.parameters == ("C_D", "v(0)")
    h = 1e-4
    for k, (name, value) in enumerate([("C_D", 1.2), ("v(0)", 0.1)]):
        both = samara.simulate("vertical_fall", {**COIN_VALUES, name: np.array([value - h, value + h])}, times).values
        np.testing.assert_allclose(result.sensitivities[..., k], (both[1] - both[0]) / (2 * h), rtol=0, atol=1e-7)


def test_trajectories_broadcast():
    C, v = np.array([[0.8], [1.6]]), np.array([0.0, 0.2, 0.4])
    all_of_them = samara.simulate("vertical_fall", {**COIN_VALUES, "C_D": C, "v(0)": v}, [0.0, 0.3], ["C_D"])
    assert all_of_them.values.shape == (2, 3, 2, 2) and all_of_them.sensitivities.shape == (2, 3, 2, 2, 1)
    for i in range(2):
        for j in range(3):
            one = samara.simulate("vertical_fall", {**COIN_VALUES, "C_D": C[i, 0], "v(0)": v[j]}, [0.0, 0.3], ["C_D"])
            # Other coordinates are under the control of the error: to its tolerance.
            np.testing.assert_allclose(all_of_them.values[i, j], one.values, rtol=0, atol=1e-9)
            np.testing.assert_allclose(all_of_them.sensitivities[i, j], one.sensitivities, rtol=0, atol=1e-7)


@pytest.mark.parametrize("jacobian", [None, oscillator_jacobian])
def test_a_model_in_python_integrates_to_the_exact_solution(jacobian):
    own = model(jacobian=jacobian)
    result = samara.simulate(own, {"stiffness": 9.0, "damping": np.array([0.0, 0.5])}, TIMES, ["stiffness"])
    for k, c in enumerate([0.0, 0.5]):
        np.testing.assert_allclose(result["place"][k], exact(TIMES, 9.0, c), rtol=0, atol=1e-8)
        slope = (exact(TIMES, 9.0 + 1e-5, c) - exact(TIMES, 9.0 - 1e-5, c)) / 2e-5
        np.testing.assert_allclose(result.sensitivities[k, :, 0, 0], slope, rtol=0, atol=1e-7)


def test_complex_steps_and_a_jacobian_give_the_same_derivatives():
    x, p = np.array([0.3, -1.2]), np.array([9.0, 0.4])
    stepped, given = model()._derivatives(0.0, x, p), model(jacobian=oscillator_jacobian)._derivatives(0.0, x, p)
    for a, b in zip(stepped, given):
        np.testing.assert_allclose(a, b, rtol=1e-15, atol=0)
    xs, ps = np.random.default_rng(0).normal(size=(2, 2, 5))
    t = np.zeros(5)
    np.testing.assert_allclose(model()._jacobians(t, xs, ps), model(jacobian=oscillator_jacobian)._jacobians(t, xs, ps),
                               rtol=1e-15, atol=0)


def test_what_a_users_function_raises_comes_back_with_its_traceback():
    def broken(t, x, p):
        raise KeyError("mine")

    own = samara.Model(broken, {"x": "1"}, {"k": "1"})
    with pytest.raises(KeyError, match="mine") as raised:
        samara.simulate(own, {"k": np.linspace(0, 1, 20)}, [0.0, 1.0])
    assert raised.traceback[-1].name == "broken"

    def short(t, x, p):
        return (x[0],)

    with pytest.raises(samara.ArgumentError, match="1 rates, expected 2"):
        samara.simulate(samara.Model(short, {"a": "1", "b": "1"}, {"k": "1"}), {"k": 1.0}, [0.0, 1.0])

    for masked in (lambda t, x, p: (np.ma.masked_where(x[0] > 0, x[0]),), lambda t, x, p: np.ma.masked_where(x > 0, x)):
        own = samara.Model(masked, {"a": samara.State("a", initial=1.0)}, {"k": "1"})
        with pytest.raises(samara.ArgumentError, match="the function's answer: 1 of 1 values are masked"):
            samara.simulate(own, {"k": 1.0}, [0.0, 1.0])

    def real_only(t, x, p):
        return (np.arctan2(x[0], p[0]),)

    with pytest.raises(TypeError, match="jacobian"):
        samara.simulate(samara.Model(real_only, {"a": "1"}, {"k": "1"}), {"k": 1.0}, [0.0, 1.0], True)


def test_functions_that_forget_derivatives_of_complex_numbers_are_found():
    def drag(t, x, p):
        return (-p[0] * np.abs(x[0]) * x[0],)

    def smooth(t, x, p):
        return (-p[0] * np.sqrt(x[0] * x[0]) * x[0],)

    def of(function):
        return samara.Model(function, {"v": samara.State("v", "m/s", initial=1.0)}, {"k": "1/m"})

    times = [0.0, 0.5, 1.0]
    np.testing.assert_allclose(samara.simulate(of(drag), {"k": 2.0}, times)["v"], 1 / (1 + 2 * np.array(times)), rtol=1e-8)
    with pytest.raises(samara.ArgumentError, match='rate of "v" by "v".*complex'):
        samara.simulate(of(drag), {"k": 2.0}, times, True)
    result = samara.simulate(of(smooth), {"k": 2.0}, times, True)
    np.testing.assert_allclose(result.sensitivities[:, 0, 0], -np.array(times) / (1 + 2 * np.array(times)) ** 2, atol=1e-8)
    with pytest.raises(samara.ArgumentError, match="complex"):
        of(drag)._jacobians(np.zeros(3), np.array([[1.0, 0.5, 0.2]]), np.full((1, 3), 2.0))


def one_state(rate, jacobian=None):
    return samara.Model(lambda t, x, p: (rate(x[0], p[0]),), {"x": "m"}, {"p": "1"}, jacobian)


@pytest.mark.parametrize("rate, x, p", [
    (lambda x, p: -x * 1e-6 / p, 2.0, 1.5e-5),
    (lambda x, p: -x * 1e-6 / p, 2.0, 3e-7),
    (lambda x, p: np.sqrt(x) * p, 2e-6, 1.0),
    (lambda x, p: np.cos(3e5 * p) * x, 1.0, 1.0),
    (lambda x, p: (1e8 + p * x) - 1e8, 1.0, 1.0),
    (lambda x, p: (1e8 + p * x) - 1e8, 1.0, 1e-3),
    (lambda x, p: p * np.sqrt(x), 0.0, 1.0),
    (lambda x, p: p * np.log(x), 1e-7, 2.0),
])
def test_models_of_small_numbers_fast_oscillations_and_cancellation_are_not_refused(rate, x, p):
    with np.errstate(all="ignore"):
        _, by_state, by_parameter = one_state(rate)._derivatives(0.0, np.array([x]), np.array([p]))
        h = 1e-30
        assert by_parameter[0, 0] == np.imag(rate(x, p + h * 1j)) / h


def test_the_domain_of_a_function_is_not_left_to_check_its_derivatives():
    def rate(x, nu):
        if np.any(np.real(nu) <= 0) or np.any(np.real(x) < 0):
            raise ValueError("outside")
        return -x / nu

    for x in (0.0, 3.0):
        _, by_state, _ = one_state(rate)._derivatives(0.0, np.array([x]), np.array([1e-6]))
        assert by_state[0, 0] == pytest.approx(-1e6, rel=1e-12)


def test_what_forgets_derivatives_is_found_at_small_numbers_too():
    for x, p in [(2e-7, 1.0), (3.0, 1e-6), (2e9, 1.0)]:
        with pytest.raises(samara.ArgumentError, match="complex steps"):
            one_state(lambda x, p: -p * np.abs(x) * x)._derivatives(0.0, np.array([x]), np.array([p]))


def test_a_jacobian_is_held_against_its_shape_and_against_differences():
    B = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])

    def rates(t, x, p):
        return B[0, 0] * p[0] + B[0, 1] * p[1] + B[0, 2] * p[2] - x[0], B[1, 0] * p[0] + B[1, 1] * p[1] + B[1, 2] * p[2]

    def of(by_states, by_parameters):
        return samara.Model(rates, {"a": "1", "b": "1"}, {"u": "1/s", "v": "1/s", "w": "1/s"},
                            jacobian=lambda t, x, p: (by_states, by_parameters))

    x, p, states = np.array([0.5, 2.0]), np.array([1.0, 2.0, 3.0]), [[-1, 0], [0, 0]]
    np.testing.assert_array_equal(of(states, B)._derivatives(0.0, x, p)[2], B)
    with pytest.raises(samara.ArgumentError, match=r"shape \(3, 2\).*expected \(2, 3\)"):
        of(states, B.T)._derivatives(0.0, x, p)
    with pytest.raises(samara.ArgumentError, match='"a" by "v" is 2.5 by jacobian'):
        of(states, B + [[0, 0.5, 0], [0, 0, 0]])._derivatives(0.0, x, p)
    # Where the rate does not depend on it at all.
    with pytest.raises(samara.ArgumentError, match='"b" by "a" is 1 by jacobian'):
        of([[-1, 0], [1, 0]], B)._derivatives(0.0, x, p)
    many = np.tile(x[:, None], 3), np.tile(p[:, None], 3)
    with pytest.raises(samara.ArgumentError, match="by jacobian"):
        of([[-1, 0], [1, 0]], B)._jacobians(np.zeros(3), *many)
    with pytest.raises(samara.ArgumentError, match="2 rows of 2"):
        of([[-1, 0, 0], [0, 0, 0]], B)._jacobians(np.zeros(3), *many)
    none = samara.Model(lambda t, x, p: (-x[0],), {"x": "1"}, {}, jacobian=lambda t, x, p: ([[-1.0]], []))
    assert none._derivatives(0.0, np.ones(1), np.empty(0))[2].shape == (1, 0)


def test_a_wrong_jacobian_is_refused_where_it_is_taken_and_costs_a_build_without_it_nothing():
    wrong = samara.Model(lambda t, x, p: (x[1], -p[0] * x[0]), {"x": "m", "v": "m/s"}, {"k": "1/s^2"},
                         jacobian=lambda t, x, p: ([[0.0, 1.0], [1.0, 0.0]], [[0.0], [1.0]]))
    plan = {"box": {"k": [0.8, 1.2], "x(0)": [0.1, 1.0]}, "time": {"end": 1.0}, "tolerance": {"relative": 1e-3}}
    assert samara.build(plan, wrong, progress=False, certificate_points=20).certificate.met
    with pytest.raises(samara.ArgumentError, match="by jacobian"):
        samara.build({**plan, "builder": {"kind": "pgd", "strategy": "enrichment"}}, wrong, progress=False)
    with pytest.raises(samara.ArgumentError, match="by jacobian"):
        samara.simulate(wrong, {"k": 1.0, "x(0)": 0.5}, np.linspace(0.0, 1.0, 3), sensitivities=["k"])


def test_what_a_model_derives_from_its_states_is_integrated_with_them(tmp_path):
    (tmp_path / "pendulum.toml").write_text("""name = "pendulum"
[states]
angle = { unit = "rad", initial = 0.5 }
spin = { unit = "rad/s" }
[parameters]
length = { unit = "m", above = 0 }
[rates]
angle = "spin"
spin = "-9.81 [m/s^2]/length*sin(angle)"
[outputs]
tip = { value = "length*sin(angle)", unit = "m" }
share = "cos(angle)"
""")
    file = tmp_path / "pendulum.toml"
    assert [(o.name, o.unit) for o in samara.models(file).outputs] == [("tip", "m"), ("share", "1")]
    table = command("simulate", file, "--set", "length=1.1", "--until", "2", "--frames", "11").stdout
    assert table.splitlines()[0] == "t[s],angle[rad],spin[rad/s],tip[m],share[1]"
    expected = np.loadtxt(io.StringIO(table), delimiter=",", skiprows=1)
    plain = samara.simulate(file, {"length": 1.1}, TIMES)
    assert plain.states == ("angle", "spin") and plain.outputs == ("angle", "spin", "tip", "share")
    np.testing.assert_allclose(plain.values, expected[:, 1:], rtol=0, atol=1e-14)
    lengths = np.array([1.1 - 1e-5, 1.1, 1.1 + 1e-5])
    all_three = samara.simulate(file, {"length": lengths}, TIMES, ["length"])
    assert all_three.sensitivities.shape == (3, 11, 4, 1)
    np.testing.assert_allclose(all_three["tip"], lengths[:, None] * np.sin(all_three["angle"]), rtol=1e-14)
    difference = (all_three.values[2] - all_three.values[0]) / 2e-5
    np.testing.assert_allclose(all_three.sensitivities[1, :, :, 0], difference, rtol=0, atol=1e-4)
    assert not np.allclose(all_three.sensitivities[1, :, 2, 0], 0)


def test_what_a_model_derives_is_asked_of_its_codebook(tmp_path):
    book = samara.build({
        "equations": {
            "name": "pendulum",
            "states": {"angle": {"unit": "rad", "initial": 0.5}, "spin": {"unit": "rad/s"}},
            "parameters": {"length": {"unit": "m", "above": 0}},
            "rates": {"angle": "spin", "spin": "-9.81 [m/s^2]/length*sin(angle)"},
            "outputs": {"tip": {"value": "length*sin(angle)", "unit": "m"}},
        },
        "box": {"length": [0.8, 1.4]}, "time": {"end": 2}, "tolerance": {"relative": 1e-5}}, progress=False)
    assert [(o.name, o.unit) for o in book.derived] == [("tip", "m")]
    lengths, times = np.array([[0.9, 1.0, 1.3], [0.8, 1.1, 1.2]]), np.linspace(0, 2, 9)
    values, slopes = book.query({"length": lengths}, times, outputs=["tip", "angle"], gradient=True)
    assert values.shape == (2, 3, 9, 2) and slopes.shape == (2, 3, 9, 2, 1)
    stored, stored_slopes = book.query({"length": lengths}, times, outputs="angle", gradient=True)
    np.testing.assert_allclose(values[..., 1], stored[..., 0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(values[..., 0], lengths[..., None] * np.sin(stored[..., 0]), rtol=0, atol=1e-13)
    expected = np.sin(stored[..., 0]) + lengths[..., None] * np.cos(stored[..., 0]) * stored_slopes[..., 0, 0]
    np.testing.assert_allclose(slopes[..., 0, 0], expected, rtol=0, atol=1e-12)
    out = np.empty((9, 1))
    assert book.query({"length": 1.1}, times, outputs=["tip"], out=out) is out
    np.testing.assert_array_equal(out, book.query({"length": 1.1}, times, outputs=["tip"]))
    for room in (np.empty((2, 9)).T, book.query({"length": 1.1}, times, outputs=["angle", "spin"])):
        # The times of one of stored outputs run fastest in memory.
        assert book.query({"length": 1.1}, times, outputs=["tip", "angle"], out=room) is room
        np.testing.assert_array_equal(room, book.query({"length": 1.1}, times, outputs=["tip", "angle"]))
    one = book.query({"length": 1.1}, times[3], outputs="tip")
    assert one.shape == (1,) and one[0] == out[3, 0]
    pandas = pytest.importorskip("pandas")
    table = book.query({"length": [1.0, 1.1]}, times, outputs=["tip"], labels="pandas")
    assert isinstance(table, pandas.DataFrame) and len(table) == 18 and "tip" in table.columns
    with pytest.raises(samara.ArgumentError, match="hessian"):
        book.at([1.0, 1.1], outputs=["tip"], hessian=True)
    with pytest.raises(samara.ArgumentError, match="tpi"):
        book.query({"length": 1.1}, times, outputs=["tpi"])


def test_wrong_calls_are_value_errors():
    for call, text in [
        (lambda: samara.simulate("vertical_fall", {"C_d": 1.0}, [0.0, 1.0]), "C_D"),
        (lambda: samara.simulate("vertical_fall", COIN_VALUES, [1.0, 0.5]), "times"),
        (lambda: samara.simulate("vertical_fall", COIN_VALUES, [0.0, np.nan]), "nan|finite"),
        (lambda: samara.simulate("vertical_fall", COIN_VALUES, [0.0, 0.1], ["mass"]), "mass"),
        (lambda: samara.Model(oscillator, {}, {}), "no state"),
        (lambda: samara.models(samara.Model(oscillator, {"a": "cm"}, {})), '"cm", expected one of the SI, such as "m"'),
        (lambda: samara.models(samara.Model(oscillator, {"a": "smoot"}, {})), "smoot"),
        (lambda: samara.Model(oscillator, {"a": samara.State("b")}, {}), '"b" under the name "a"'),
        (lambda: samara.Model(oscillator, {"t": "s"}, {}), '"t" .* is that of the time'),
        (lambda: samara.Model(oscillator, {"x": "m"}, {"t": "s"}), '"t" .* is that of the time'),
        (lambda: samara.Model(oscillator, {"x": "m"}, {"x": "m"}), '"x" .* is given twice'),
        (lambda: samara.Model(None, {"x": "m"}, {}), "rhs is of the type NoneType"),
        (lambda: samara.Model(oscillator, {"x": "m"}, {}, 3), "jacobian is of the type int"),
        (lambda: samara.Model(oscillator, ["x"], {}), "states are given as list"),
        (lambda: samara.Model(oscillator, {"x": "m"}, ["k"]), "parameters are given as list"),
        (lambda: samara.Model(oscillator, {"x": 1.0}, {}), "x is 1.0, expected its unit"),
        (lambda: samara.Model(oscillator, {"x": samara.State("x", 5)}, {}), "unit of x is 5, expected a text"),
        (lambda: samara.Model(oscillator, {5: "m"}, {}), "name of 5 is 5, expected a text"),
        (lambda: samara.Model(oscillator, {"x": samara.State("x", initial=[1, 1])}, {}), "initial of x has 2 values"),
        (lambda: samara.Model(oscillator, {"x": samara.State("x", initial=None)}, {}), "initial of x is None"),
        (lambda: samara.Model(oscillator, {"x": samara.State("x", "m", scale=-1)}, {}), "scale of x is -1 m, exp"),
        (lambda: samara.Model(oscillator, {"x": "m"}, {"k": samara.Parameter("k", lower="0 m")}), "lower of k: .*m"),
        (lambda: samara.Model(oscillator, {"x": "m"}, {"k": samara.Parameter("k", upper=np.nan)}), "upper of k: .*nan"),
        (lambda: samara.Model(oscillator, {"x": "m"}, {}, title=3), "title is 3, expected a text"),
        (lambda: samara.simulate(model(), {"stiffness": 1.0}, TIMES, ["damping"]),
         '^"damping" of sensitivities is not given, expected among the parameters$'),
        (lambda: samara.simulate("vertical_fall", {"C_D": None}, [0.0, 1.0]), "C_D is None"),
        (lambda: samara.simulate(model(name="heat_rod"), {"stiffness": 1.0}, [0.0, 1.0]), '"heat_rod" is that of a model'),
        (lambda: samara.simulate("heat_rod", {}, [0.0, 1.0]), "field of space"),
        (lambda: samara.simulate(model(name="vertical_fall"), {"stiffness": 1.0}, [0.0, 1.0]), "vertical_fall"),
    ]:
        with pytest.raises(samara.ArgumentError, match=text):
            call()


def test_numbers_of_states_and_parameters_may_have_units():
    stiffness = samara.Parameter("stiffness", "1/s^2", 1, lower="1 1/min^2", upper=np.inf)
    own = samara.Model(oscillator, {"place": samara.State("place", "m", "10 cm"), "speed": "m/s"},
                       {"stiffness": stiffness, "damping": "1/s"})
    assert own.states[0].initial == 0.1 and own.parameters[0].lower == 1 / 3600
    place = samara.simulate(own, {"damping": 0.0}, TIMES)["place"]
    np.testing.assert_allclose(place, 0.1 * np.cos(TIMES), rtol=0, atol=1e-9)


def test_a_solution_that_ends_is_an_outcome():
    def explosion(t, x, p):
        return (p[0] * x[0] ** 2,)

    own = samara.Model(explosion, {"x": samara.State("x", initial=1.0)}, {"k": "1"})
    result = samara.simulate(own, {"k": np.array([0.5, 2.0])}, [0.0, 0.4, 1.0])
    assert not result.done and result.problems[0] == "" and result.problems[1] != ""
    np.testing.assert_allclose(result["x"][0], 1 / (1 - 0.5 * result.times), rtol=1e-8)
    assert np.isnan(result["x"][1, -1])


def test_models_of_files_are_taken(tmp_path):
    file = COIN.parent / "own_model" / "predator_prey.toml"
    assert {s.name for s in samara.models(file).states} == {"prey", "predator"}
