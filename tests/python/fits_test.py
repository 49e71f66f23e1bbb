"""Fits: the numbers of the command, captures in memory, models in Python, and what was minimised."""

import concurrent.futures
import csv
import json
import tomllib

import numpy as np
import pytest

import samara
from conftest import COIN, command
from models_test import exact, model


@pytest.fixture(scope="module")
def result(coin):
    return samara.fit(coin, [COIN / "coin.toml"], COIN / "fit.toml", profiles=True)


def without_times(told):
    """What does not depend on the machine."""
    if not isinstance(told, dict):
        return told
    return {k: without_times(v) for k, v in told.items() if k not in ("seconds", "evaluations")}


def test_a_fit_is_that_of_the_command(coin_path, result, tmp_path):
    told = json.loads(command("fit", coin_path, COIN / "coin.toml", "--config", COIN / "fit.toml", "--profiles", "--json").stdout)
    assert without_times(result.raw) == without_times(told)
    assert result.is_usable and result.status == "converged"
    C = result["C_D"]
    assert (C.value, C.standard_error, C.verdict) == tuple(
        told["coefficients"][0][k] for k in ("value", "standard_error", "verdict"))
    assert list(C.interval) == told["profiles"][0]["interval"]
    np.testing.assert_array_equal(result.covariance, told["covariance"])
    assert len(result.captures) == 10 and set(result.captures[0].own) == {"v(0)", "offset of x"}
    config = tomllib.loads((COIN / "fit.toml").read_text())
    assert without_times(samara.fit(coin_path, COIN / "coin.toml", config, profiles=True).raw) == without_times(told)


def test_a_fit_of_a_codebook_without_a_certificate_says_so(coin, result):
    told = "the codebook has no certificate that meets its tolerance"
    sliced = samara.fit(coin.slice(**{"v(0)": 0.1}), COIN / "coin.toml", COIN / "fit.toml")
    assert told in sliced.warnings and told in str(sliced) and told not in result.warnings


def test_the_report_and_words_are_those_of_the_command(coin_path, result, tmp_path):
    command("fit", coin_path, COIN / "coin.toml", "--config", COIN / "fit.toml", "--profiles", "--report", tmp_path / "a.html")
    result.report(tmp_path / "b.html")
    a, b = ((tmp_path / name).read_text() for name in ("a.html", "b.html"))
    assert len(a) == pytest.approx(len(b), abs=100) and b.startswith(a[:200])
    with pytest.raises(samara.InputError, match="/nowhere/fit.html"):
        result.report("/nowhere/fit.html")
    (tmp_path / "coin.toml").write_text("mine")
    with pytest.raises(samara.ArgumentError, match='coin.toml", expected a name that ends in .html'):
        result.report(tmp_path / "coin.toml")
    assert (tmp_path / "coin.toml").read_text() == "mine"
    # The old page is replaced, not overwritten: whoever reads it meanwhile has it to the end.
    (tmp_path / "read.html").hardlink_to(tmp_path / "a.html")
    result.report(tmp_path / "a.html")
    assert (tmp_path / "read.html").read_text() == a and (tmp_path / "a.html").stat().st_ino != (tmp_path / "read.html").stat().st_ino
    assert "C_D" in str(result) and "converged" in repr(result) and "C_D" in result._repr_html_()


def test_half_the_sum_of_squares_is_the_cost_and_its_gradient_vanishes(result):
    q = result.answer
    r, J = result.residuals(q), result.jacobian(q)
    assert len(q) == len(result.unknowns) == 1 + 2 * 10 and J.shape == (len(r), len(q))
    assert 0.5 * r @ r == pytest.approx(result.raw["cost"], rel=1e-12)
    size = np.linalg.norm(J, axis=0) * np.linalg.norm(r)
    lower, upper = result.bounds
    assert np.all(np.abs(J.T @ r)[(q > lower) & (q < upper)] < 1e-5 * size[(q > lower) & (q < upper)])
    away = q * 1.02
    J = result.jacobian(away)
    for k in range(len(q)):
        step = np.zeros(len(q))
        step[k] = 1e-6
        slope = (result.residuals(away + step) - result.residuals(away - step)) / 2e-6
        # Second derivatives jump where the loss bends.
        np.testing.assert_allclose(J[:, k], slope, rtol=0, atol=1e-4 * np.abs(J[:, k]).max())


def test_the_posterior_is_highest_at_the_answer_and_falls_as_its_gradient_says(result):
    q = result.answer
    best, gradient = result.log_posterior(q, gradient=True)
    assert best == pytest.approx(result.log_posterior(q), rel=1e-12)
    J = result.jacobian(q)
    deviations = 1 / np.linalg.norm(J, axis=0)
    rng = np.random.default_rng(0)
    for _ in range(10):
        direction = rng.normal(size=len(q)) * deviations
        assert result.log_posterior(q + 0.3 * direction) < best
        here, slope = result.log_posterior(q + 0.3 * direction, gradient=True)
        h = 1e-5
        difference = (result.log_posterior(q + (0.3 + h) * direction) - result.log_posterior(q + (0.3 - h) * direction)) / (2 * h)
        assert slope @ direction == pytest.approx(difference, rel=1e-4, abs=1e-4)
    outside = q.copy()
    outside[0] = 5.0
    assert result.log_posterior(outside) == -np.inf


def test_eight_threads_at_once_get_the_residuals_of_one(result):
    points = [result.answer * (1 + 0.001 * k) for k in range(8)]
    expected = [(result.residuals(q), result.jacobian(q)) for q in points]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for _ in range(5):
            for (r, J), a, b in zip(expected, pool.map(result.residuals, points), pool.map(result.jacobian, points)):
                assert np.array_equal(r, a) and np.array_equal(J, b)


def test_points_of_a_wrong_size_are_refused(result):
    with pytest.raises(samara.ArgumentError, match="21|unknown"):
        result.residuals([1.0])
    with pytest.raises(samara.ArgumentError, match="C_D"):
        result.residuals(np.full(21, np.nan))
    for ask in (result.residuals, result.jacobian, result.log_posterior):
        with pytest.raises(samara.ArgumentError, match="complex"):
            ask(result.answer * (1 + 0j))


def test_whether_there_is_a_gradient_is_true_or_false(result):
    with pytest.raises(samara.ArgumentError, match="gradient is 'yes', expected True or False"):
        result.log_posterior(result.answer, "yes")


def test_an_interval_is_as_open_as_its_profile():
    t = np.linspace(0, 1, 21)
    own = samara.Model(lambda t, x, p: (-p[0] * x[0],), {"x": samara.State("x", "m", initial=1.0)}, {"k": "1/s"}, name="fade")
    for noise, is_open in [(0.2, (True, False)), (3.0, (True, True)), (0.001, (False, False))]:
        x = np.exp(-0.02 * t) + noise * np.random.default_rng(1).normal(size=21)
        fitted = samara.fit(own, {"t[s]": t, "x[m]": x}, {"box": {"k": [0.0, 2.0]}, "loss": {"kind": "none"}, "starts": 1},
                            profiles=True)
        interval = fitted["k"].interval
        assert tuple(map(np.isinf, interval)) == is_open, interval
        for end, found in zip(interval, fitted.profiles["k"]["interval"]):
            assert np.isinf(end) if found is None else end == found
        assert interval[0] < fitted["k"].value < interval[1]


def test_scipy_finds_the_coefficients_of_the_fit(result):
    optimize = pytest.importorskip("scipy.optimize")
    found = optimize.least_squares(result.residuals, result.middle, result.jacobian, result.bounds, x_scale="jac",
                                   xtol=1e-12, ftol=1e-12, gtol=1e-12)
    C = result["C_D"]
    assert abs(found.x[0] - C.value) < 0.01 * C.standard_error


def test_tables_in_memory_are_fitted_as_their_files(coin, tmp_path):
    rng = np.random.default_rng(5)
    t = np.linspace(0, 0.4, 25)
    tables = {}
    for k, v in enumerate([0.0, 0.1, 0.2]):
        x = 0.02 * k + coin.query({"C_D": 1.3, "v(0)": v}, t, outputs=["x"])[:, 0] + 1e-4 * rng.normal(size=25)
        x[:k] = np.nan
        tables[f"drop{k}"] = {"t[ms]": 1000 * t, "x[mm]": 1000 * x}
        with open(tmp_path / f"drop{k}.csv", "w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(tables[f"drop{k}"])
            rows.writerows((repr(float(a)), "" if np.isnan(b) else repr(float(b))) for a, b in zip(*tables[f"drop{k}"].values()))
    config = {"outputs": ["x"], "loss": {"kind": "huber", "scale": "1 mm"}}
    memory = samara.fit(coin, tables, config)
    files = samara.fit(coin, sorted(tmp_path.glob("*.csv")), config)
    assert memory["C_D"].value == pytest.approx(files["C_D"].value, rel=1e-9)
    assert memory["C_D"].standard_error == pytest.approx(files["C_D"].standard_error, rel=1e-6)
    assert [c.id for c in memory.captures] == ["drop0", "drop1", "drop2"]
    assert memory["C_D"].value == pytest.approx(1.3, abs=0.02)


def test_a_value_that_is_masked_or_missing_was_not_seen_and_times_may_be_differences(coin):
    t = np.linspace(0, 0.4, 25)
    x = coin.query({"C_D": 1.3, "v(0)": 0.1}, t, outputs=["x"])[:, 0]
    gone = np.arange(25) % 5 == 2
    seen = {"t[s]": t, "x[m]": np.where(gone, np.nan, x)}

    def fitted(columns):
        return samara.fit(coin, {"drop [1]": columns}, {"outputs": ["x"]})

    expected = fitted(seen)
    assert expected["C_D"].value == pytest.approx(1.3, rel=1e-6) and expected.captures[0].id == "drop [1]"
    wrong = np.where(gone, 7.0, x)
    for values in (np.ma.array(wrong, mask=gone), np.ma.array(wrong.astype(object), mask=gone), np.where(gone, None, x),
                   np.where(gone, "nan", x.astype("U30"))):
        assert fitted({**seen, "x[m]": values})["C_D"].value == expected["C_D"].value
    for head in ("t[s]", "t[ms]"):
        differences = (1e9 * t).round().astype("timedelta64[ns]")
        assert fitted({head: differences, "x[m]": seen["x[m]"]})["C_D"].value == pytest.approx(expected["C_D"].value, rel=1e-6)
    for column, values, text in [
        ("t[s]", np.datetime64("2026-01-01") + differences, r"of the type datetime64\[ns\], expected numbers"),
        ("x[m]", differences, r"of the type timedelta64\[ns\], expected numbers"),
        ("x[m]", gone, "of the type bool"),
        ("x[m]", x + 0j, "of the type complex128"),
        ("x[m]", ["high"] * 25, "has the value 'high', expected numbers"),
        ("t[s]", np.ma.array(t, mask=gone), "or one is missing"),
    ]:
        with pytest.raises(samara.ArgumentError, match=rf"(?=.*drop \[1\]).*{text}"):
            fitted({**seen, column: values})
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"t[s]": pandas.to_timedelta(t, "s"), "x[m]": pandas.array(wrong, "Float64")})
    frame.loc[gone, "x[m]"] = pandas.NA
    assert fitted(frame)["C_D"].value == pytest.approx(expected["C_D"].value, rel=1e-6)


def test_a_column_of_a_capture_has_one_dimension(coin):
    columns = {"t[s]": np.linspace(0, 0.4, 5), "x[m]": np.linspace(0, 0.4, 5)}
    for head in columns:
        for shaped in (lambda a: a[None], lambda a: a[:, None], lambda a: np.stack([a, a * np.nan]), lambda a: a[1]):
            with pytest.raises(samara.ArgumentError, match=r'".*" of capture 1 has the shape .*, expected \(frames,\)'):
                samara.fit(coin, {**columns, head: shaped(columns[head])})


def test_frames_are_captures_and_coefficients_become_one(coin):
    pandas = pytest.importorskip("pandas")
    t = np.linspace(0, 0.4, 25)
    x = coin.query({"C_D": [1.3, 1.3], "v(0)": [0.0, 0.1]}, t, outputs=["x"])[..., 0]
    frames = [pandas.DataFrame({"t[s]": t, "x[m]": row, "drop": str(k)}) for k, row in enumerate(x)]
    fitted = samara.fit(coin, frames, {"outputs": ["x"], "cluster_by": ["drop"]})
    table = fitted.coefficients
    assert table.loc["C_D", "value"] == pytest.approx(1.3, rel=1e-6)
    assert fitted.raw["clusters"] == 2
    assert list(table.index) == ["C_D"]
    row, one = table.loc["C_D"], fitted["C_D"]
    assert (row.unit, row.verdict, row.determined) == (one.unit, one.verdict, one.determined)
    assert (row.interval_lower, row.interval_upper) == one.interval and row.standard_error == one.standard_error


def test_a_model_in_python_is_fitted():
    t = np.linspace(0, 2, 41)
    tables = {f"run{k}": {"t[s]": t, "place[m]": exact(t, 7.0, 0.3) + 1e-4 * np.random.default_rng(k).normal(size=41)}
              for k in range(3)}
    fitted = samara.fit(model(), tables, {"box": {"stiffness": [4.0, 10.0], "damping": [0.0, 1.0]}, "outputs": ["place"],
                                          "loss": {"kind": "none"}, "starts": 1})
    assert fitted.is_usable, str(fitted)
    assert fitted["stiffness"].value == pytest.approx(7.0, abs=2e-3)
    assert fitted["damping"].value == pytest.approx(0.3, abs=2e-3)
    r = fitted.residuals(fitted.answer)
    assert 0.5 * r @ r == pytest.approx(fitted.raw["cost"], rel=1e-9)


def test_what_a_model_raises_comes_back_from_its_fit_and_its_residuals():
    limit = [np.inf]

    def fragile(t, x, p):
        if np.any(np.real(p[0]) > limit[0]):
            raise ZeroDivisionError("too stiff")
        return (-p[0] * x[0],)

    own = samara.Model(fragile, {"x": samara.State("x", "m", initial=1.0)}, {"k": "1/s"})
    t = np.linspace(0, 1, 11)
    table = {"t[s]": t, "x[m]": np.exp(-2 * t)}
    config = {"box": {"k": [1.0, 4.0]}, "loss": {"kind": "none"}, "starts": 1}
    fitted = samara.fit(own, table, config)
    assert fitted["k"].value == pytest.approx(2.0, rel=1e-6)
    limit[0] = 3.0
    for call in (lambda: fitted.residuals([3.5]), lambda: fitted.jacobian([3.5]), lambda: fitted.log_posterior([3.5], True)):
        with pytest.raises(ZeroDivisionError, match="too stiff"):
            call()
    assert np.isfinite(fitted.residuals([2.5])).all()

    def asked(k):
        try:
            return bool(np.isfinite(fitted.log_posterior([k])))
        except ZeroDivisionError:
            return "raised"

    # Each caller gets what its own call raised, and no other's.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert list(pool.map(asked, [3.5, 2.5] * 100)) == ["raised", True] * 100
    limit[0] = 0.5
    with pytest.raises(ZeroDivisionError, match="too stiff"):
        samara.fit(own, table, config)


def test_a_fit_whose_output_is_no_number_says_so_where_its_coefficients_are_asked_for(result, tmp_path):
    model = tmp_path / "rooted.toml"
    model.write_text('name = "rooted"\ntitle = "Its output is no number"\nsource = "none"\n[states]\nx = { initial = 1 }\n'
                     '[parameters]\nk = { unit = "1/s" }\n[rates]\nx = "-k*x"\n[outputs]\ny = "sqrt(x - 2)"\n')
    t = np.linspace(0, 1, 21)
    failed = samara.fit(model, {"t[s]": t, "y[1]": np.exp(-t)}, {"box": {"k": [1.0, 4.0]}, "outputs": ["y"], "loss": {"kind": "none"}})
    assert failed.status == "failed"
    with pytest.raises(samara.NoResultError, match='"k", for the fit has the status "failed": none of .* starts succeeded; the first: '
                       'the output "y" at 0 s of capture ".*" is not a finite number'):
        failed["k"]
    for kind in (KeyError, samara.ArgumentError):
        with pytest.raises(kind) as raised:
            result["C_T"]
        assert str(raised.value) == 'coefficient "C_T" is unknown; did you mean "C_D"?'


def test_a_fit_is_iterated_by_its_coefficients_and_one_without_any_knows_no_name(result):
    assert list(result) == ["C_D"] and "C_D" in result and "C_T" not in result
    t = np.linspace(0, 1, 11)
    own = samara.Model(lambda t, x, p: (-p[0] * x[0],), {"x": "m"}, {"k": "1/s"}, name="fade")
    fitted = samara.fit(own, {"t[s]": t, "x[m]": 3 * np.exp(-t)},
                        {"outputs": ["x"], "box": {"x(0)": [0.1, 5.0]}, "fixed": {"k": 1.0}, "loss": {"kind": "none"}})
    assert fitted.status == "converged" and list(fitted) == []
    with pytest.raises(samara.UnknownNameError, match='^coefficient "k" is unknown; known: none$'):
        fitted["k"]


def test_what_is_wrong_is_said_with_the_sentence_of_the_library(coin):
    for call, kind, text in [
        (lambda: samara.fit(coin, ["missing.csv"]), OSError, "missing.csv"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], {"outputs": ["y"]}), ValueError, "y"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], {"colour": 1}), ValueError, "colour"),
        (lambda: samara.fit(coin, {"t[s]": [0.0, 0.0, 0.1], "x[m]": [0.0, 1.0, 2.0]}), ValueError, "increase"),
        (lambda: samara.fit(coin, {"x[m]": [0.0, 1.0, 2.0]}), ValueError, "times"),
        (lambda: samara.fit(coin, {"t[s]": [0.0, 1.0], "x[m]": [np.inf, 1.0]}), ValueError, "infinite"),
        (lambda: samara.fit(coin, {"t[s]": [0.0, 1.0, 2.0], "x[m]": [1.0, 1.0]}), ValueError, r"shape \(2,\)"),
        (lambda: samara.fit(coin, {"t[m]": [0.0, 0.1], "x[m]": [0.0, 0.1]}), ValueError,
         r'"t\[m\]" of capture 1: "1 m" has the dimension m, expected s'),
        (lambda: samara.fit(coin, {"t[frame]": [0.0, 0.1], "x[m]": [0.0, 0.1]}), ValueError, "frame"),
        (lambda: samara.fit(coin, {"t[1]": [0.0, 0.1], "x[m]": [0.0, 0.1]}), ValueError, r"t\[1\]"),
        (lambda: samara.fit(coin, {"t[%]": [0.0, 0.1], "x[m]": [0.0, 0.1]}), ValueError, r"t\[%\]"),
        (lambda: samara.fit(coin, {"t[s]": [0.0, 0.1], "x[m]": [0.0, 0.1], "x[cm]": [0.0, 10.0]}), ValueError, 'two columns of "x"'),
        (lambda: samara.fit(coin, {"t[s]": [0.0, 0.1], "t[ms]": [0.0, 10.0], "x[m]": [0.0, 0.1]}), ValueError, 'two columns of "t"'),
        (lambda: samara.fit(coin, None), samara.ArgumentError, "captures are of the type NoneType"),
        (lambda: samara.fit(None, [COIN / "coin.toml"]), samara.ArgumentError, "source is of the type NoneType"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], 3), samara.ArgumentError, "config is of the type int"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], progress="yes"), samara.ArgumentError, "progress is 'yes'"),
        (lambda: samara.fit("vertical_fall", [COIN / "coin.toml"]), ValueError, "box"),
        (lambda: samara.fit(coin, []), ValueError, "CAPTURE"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], span=0), samara.ArgumentError, "^span is 0 s"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], left_out="test.toml"), samara.ArgumentError, "^left_out needs ahead"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], left_out=[{"t[s]": [0.0]}]), samara.ArgumentError,
         "left_out has one of the type dict, expected files"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], left_out=3), samara.ArgumentError, "left_out has one of the type int"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], sidecar=3), samara.ArgumentError, "sidecar is of the type int, expected a file"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], coefficients=3), samara.ArgumentError, "coefficients is of the type int"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], reference="yes"), samara.ArgumentError, "reference is 'yes', expected True"),
        (lambda: samara.fit(coin, [COIN / "coin.toml"], profiles="no"), samara.ArgumentError, "profiles is 'no', expected True"),
    ]:
        with pytest.raises(kind, match=text) as raised:
            call()
        assert isinstance(raised.value, samara.Error)


def test_captures_left_out_are_predicted_as_by_the_command(coin, coin_path):
    told = json.loads(command("fit", coin_path, COIN / "train.toml", "--config", COIN / "fit.toml", "--left-out", COIN / "test.toml",
                              "--left-out-span", "0.25 s", "--ahead", "0.1 s", "--json").stdout)
    fitted = samara.fit(coin, COIN / "train.toml", COIN / "fit.toml", left_out=[COIN / "test.toml"], left_out_span="0.25 s",
                        ahead="100 ms")
    assert told["predictions"] and without_times(fitted.raw) == without_times(told)


def test_a_series_of_coefficients_is_that_of_the_command(tmp_path):
    folder = COIN.parent / "changing_lift"
    told = json.loads(command("fit", "falling_plate", folder / "plate.csv", "--config", folder / "series.toml",
                              "--series", tmp_path / "series.h5", "--json", codes=(0, 4)).stdout)
    fitted = samara.fit("falling_plate", folder / "plate.csv", folder / "series.toml")
    assert without_times(fitted.series) == without_times(told)
    book, saved = fitted.series_codebook(), samara.Codebook.open(tmp_path / "series.h5")
    times = np.linspace(book.coordinates[0].lower, book.coordinates[0].upper, 9)[:, None]
    assert np.array_equal(book.at(times), saved.at(times))
    with pytest.raises(samara.ArgumentError, match="series"):
        fitted.residuals([0.0])


def test_a_fit_plots_itself(result):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = result.plot()
    assert len(axes.ravel()[0].lines) == 20
