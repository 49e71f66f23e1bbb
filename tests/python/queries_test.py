"""Answers of codebooks: those of the command, and the laws of broadcasting."""

import threading
import time
import tracemalloc

import numpy as np
import pytest

import samara
from conftest import answer

TIMES = np.linspace(0.0, 0.5, 7)


def points_of(coin, count, seed=0):
    lower, upper = (np.array([getattr(c, end) for c in coin.coordinates]) for end in ("lower", "upper"))
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def test_answers_and_gradients_are_those_of_the_command(coin, coin_path):
    told = answer("query", coin_path, "--set", "C_D=1.15", "--set", "v(0)=10 cm/s", "--gradient",
                  *(x for t in TIMES for x in ("--at", repr(float(t)))))
    values, slopes = coin.query({"C_D": 1.15, "v(0)": "10 cm/s"}, TIMES, gradient=True)
    points = np.column_stack([TIMES, np.full(7, 1.15), np.full(7, 0.1)])
    at_points, gradients = coin.at(points, gradient=True)
    for k, output in enumerate(told["outputs"]):
        scale = np.abs(output["values"]).max()
        np.testing.assert_allclose(values[:, k], output["values"], rtol=0, atol=1e-13 * scale)
        np.testing.assert_allclose(at_points[:, k], output["values"], rtol=0, atol=1e-13 * scale)
        for j, c in enumerate(coin.coordinates):
            expected = output["gradient"][c.name]
            tolerance = 1e-11 * np.abs(expected).max()
            np.testing.assert_allclose(gradients[:, k, j], expected, rtol=0, atol=tolerance)
            if j > 0:
                np.testing.assert_allclose(slopes[:, k, j - 1], expected, rtol=0, atol=tolerance)


def test_shapes_broadcast_as_those_of_numpy(coin):
    C, v = np.linspace(0.7, 1.9, 4)[:, None], np.linspace(-0.2, 0.6, 3)
    values, slopes = coin.query({"C_D": C, "v(0)": v}, TIMES, gradient=True)
    assert values.shape == (4, 3, 7, 2) and slopes.shape == (4, 3, 7, 2, 2)
    for i in range(4):
        for j in range(3):
            one, slope = coin.query({"C_D": C[i, 0], "v(0)": v[j]}, TIMES, gradient=True)
            assert one.shape == (7, 2)
            np.testing.assert_allclose(values[i, j], one, rtol=0, atol=1e-13)
            np.testing.assert_allclose(slopes[i, j], slope, rtol=0, atol=1e-13)
    array = np.stack(np.broadcast_arrays(C, v), -1)
    assert np.array_equal(coin.query(array, TIMES), coin.query({"C_D": C, "v(0)": v}, TIMES))
    assert coin.query({"C_D": 1.0, "v(0)": 0.0}, "100 ms").shape == (2,)
    assert coin.query({"C_D": C, "v(0)": v}, ["100 ms", "0.2 s"]).shape == (4, 3, 2, 2)
    assert coin.query({"C_D": np.empty((0, 5)), "v(0)": 0.0}, TIMES).shape == (0, 5, 7, 2)
    with pytest.raises(ValueError, match="do not broadcast"):
        coin.query({"C_D": np.ones(3), "v(0)": np.zeros(4)}, TIMES)


def test_points_of_any_leading_dimensions_agree_with_one_at_a_time(coin):
    points = points_of(coin, 24).reshape(2, 3, 4, 3)
    values, slopes, bends = coin.at(points, gradient=True, hessian=True)
    assert values.shape == (2, 3, 4, 2) and slopes.shape == (2, 3, 4, 2, 3) and bends.shape == (2, 3, 4, 2, 3, 3)
    np.testing.assert_allclose(coin.at(points), values, rtol=0, atol=1e-13)
    one, slope, bend = coin.at(points[1, 2, 3], gradient=True, hessian=True)
    assert np.array_equal(one, values[1, 2, 3]) and np.array_equal(slope, slopes[1, 2, 3])
    assert np.array_equal(bend, bends[1, 2, 3])
    assert np.array_equal(bends, bends.swapaxes(-1, -2))


def test_second_derivatives_are_differences_of_the_first(coin):
    point = np.array([0.31, 1.234, 0.123])
    _, _, bend = coin.at(point, gradient=True, hessian=True)
    for k, h in enumerate([1e-5, 1e-5, 1e-5]):
        step = np.eye(3)[k] * h
        _, above = coin.at(point + step, gradient=True)
        _, below = coin.at(point - step, gradient=True)
        # Central differences: their third derivative times h^2, and rounding over h.
        np.testing.assert_allclose(bend[:, :, k], (above - below) / (2 * h), rtol=0, atol=1e-5 * (1 + np.abs(bend).max()))


def test_outputs_are_given_in_the_order_wanted_and_coordinates_can_be_held(coin):
    all_values = coin.query({"C_D": 1.0, "v(0)": 0.0}, TIMES)
    names = [o.name for o in coin.outputs]
    turned = coin.query({"C_D": 1.0, "v(0)": 0.0}, TIMES, outputs=names[::-1])
    np.testing.assert_allclose(turned, all_values[:, ::-1], rtol=0, atol=1e-13)
    assert np.array_equal(coin.query({"C_D": 1.0, "v(0)": 0.0}, TIMES, outputs="x"),
                          coin.query({"C_D": 1.0, "v(0)": 0.0}, TIMES, outputs=["x"]))
    assert np.array_equal(coin.at([0.1, 1.0, 0.0], outputs="v"), coin.at([0.1, 1.0, 0.0], outputs=["v"]))
    with pytest.raises(samara.ArgumentError, match="outputs are 3"):
        coin.at([0.1, 1.0, 0.0], outputs=3)
    held = coin.at(np.array([[1.0, 0.0]]), fixed={"t": "500 ms"}, outputs=["x"])
    np.testing.assert_allclose(held[0, 0], all_values[-1, names.index("x")], rtol=1e-12)


def test_frames_are_read_by_the_names_of_their_columns(coin):
    pandas = pytest.importorskip("pandas")
    points = points_of(coin, 5)
    frame = pandas.DataFrame(points, columns=[c.name for c in coin.coordinates])
    turned = frame[frame.columns[::-1]]
    assert np.array_equal(coin.at(turned), coin.at(points))
    assert np.array_equal(coin.at(turned.iloc[2]), coin.at(points[2]))
    assert np.array_equal(coin.at(turned[["v(0)", "C_D"]], fixed={"t": 0.1}), coin.at(points[:, 1:], fixed={"t": 0.1}))
    assert np.array_equal(coin.query(turned[["v(0)", "C_D"]], TIMES), coin.query(points[:, 1:], TIMES))
    for wrong, text in [(turned, '"t" is unknown'), (turned[["C_D"]], r"v\(0\) is not given"),
                        (turned[["C_D", "v(0)", "C_D"]], "more than once")]:
        with pytest.raises(samara.ArgumentError, match=text):
            coin.query(wrong, TIMES)


def test_masked_values_are_refused(coin):
    points = points_of(coin, 5)
    hidden = np.ma.array(points, mask=points == points[1, 1])
    assert np.array_equal(coin.at(np.ma.array(points)), coin.at(points))
    for ask in (lambda: coin.at(hidden), lambda: coin.query(hidden[:, 1:], TIMES),
                lambda: coin.query({"C_D": hidden[:, 1], "v(0)": 0}, TIMES)):
        with pytest.raises(samara.ArgumentError, match="1 of .* values are masked, expected none"):
            ask()


def test_answers_go_into_arrays_of_the_caller(coin):
    points = points_of(coin, 1000)
    room = np.empty((1000, 2))
    assert coin.at(points, out=room) is room
    assert np.array_equal(room, coin.at(points))
    q = points[:, 1:]
    expected = coin.query(q, TIMES)
    for room in (np.empty((1000, 7, 2)), np.empty_like(expected)):
        assert coin.query(q, TIMES, out=room) is room
        assert np.array_equal(room, expected)
    room = np.empty((1000, 2))
    assert coin.query(q, 0.3, out=room) is room and np.array_equal(room, coin.query(q, 0.3))
    with pytest.raises(samara.ArgumentError, match=r"out has the shape \(1000, 2, 7\), expected \(1000, 7, 2\)"):
        coin.query(q, TIMES, out=np.empty((1000, 2, 7)))
    with pytest.raises(samara.ArgumentError, match=r"shape \(4, 1\), expected \(7, 1\)"):
        coin.query(q[0], TIMES, outputs=["x"], out=np.empty((4, 1)))
    with pytest.raises(samara.ArgumentError, match=r"shape \(2, 1\), expected \(2,\)"):
        coin.query(q[0], 0.3, out=np.empty((2, 1)))
    for outputs in (["x"], ["x", "v"]):
        with pytest.raises(samara.ArgumentError, match="out is of the type float32"):
            coin.query(q, TIMES, outputs=outputs, out=np.empty((1000, 7, len(outputs)), np.float32))
        sealed = np.empty((1000, 7, len(outputs)))
        sealed.setflags(write=False)
        with pytest.raises(samara.ArgumentError, match="out is read-only"):
            coin.query(q, TIMES, outputs=outputs, out=sealed)
    before = np.full_like(expected, np.nan)
    address = before.ctypes.data
    assert coin.query(q, TIMES, out=before).ctypes.data == address  # no other memory
    for wrong in (np.empty((999, 2)), np.empty((1000, 2), np.float32), np.empty((2, 1000)).T):
        with pytest.raises(ValueError, match="out"):
            coin.at(points, out=wrong)
    frozen = np.empty((1000, 2))
    frozen.setflags(write=False)
    with pytest.raises(ValueError, match="read-only"):
        coin.at(points, out=frozen)


def test_an_answer_may_be_written_over_its_points(coin, product):
    def written(ask, points, answer_of=lambda a: a):
        """Into the same memory, and a point further."""
        expected = ask(points).copy()
        room = np.empty((len(points) + 1, 2))
        for to in (room[:-1], room[1:]):
            room[:-1] = points
            ask(room[:-1], out=answer_of(to))
            assert np.array_equal(answer_of(to), expected)

    points = np.random.default_rng(0).uniform([-1, 0], [2, 1], (1000, 2))
    written(product.at, points)
    written(product.query, points)
    q = points_of(coin, 1000)[:, 1:]
    written(lambda q, **more: coin.query(q, [0.3], **more), q, lambda a: a[:, None])


def test_precision_and_threads_change_answers_by_rounding_only(coin):
    points = points_of(coin, 20000)
    exact = coin.at(points, threads=1)
    assert np.array_equal(exact, coin.at(points, threads=2))
    single = coin.at(points, precision="single")
    assert 0 < np.abs(single - exact).max() < 1e-5
    assert np.abs(coin.at(points, precision="auto") - exact).max() < 1e-5
    for ask in (lambda **more: coin.at(points, **more), lambda **more: coin.query(points[:, 1:], TIMES, **more)):
        for wrong in ("half", None):
            with pytest.raises(samara.ArgumentError, match=f"precision is .?{wrong}.?, expected"):
                ask(precision=wrong)
        for wrong in (1.5, "two", -1, True):
            with pytest.raises(samara.ArgumentError, match="threads is .*, expected a whole number from 0 on"):
                ask(threads=wrong)
        with pytest.raises(samara.ArgumentError, match="threads is 2147483648, expected a whole number from 0 to 2147483647"):
            ask(threads=2**31)
        assert np.array_equal(ask(threads=np.int64(2)), ask())
    for more in ({"draws": 1.5}, {"seed": 1.5}):
        with pytest.raises(samara.ArgumentError, match="expected a whole number"):
            coin.sobol(**more)


def test_a_point_outside_the_box_is_a_value_error_that_names_it(coin):
    with pytest.raises(samara.OutsideBoxError, match="C_D = 7") as raised:
        coin.query({"C_D": 7.0, "v(0)": 0.0}, TIMES)
    assert isinstance(raised.value, ValueError) and isinstance(raised.value, samara.Error)
    with pytest.raises(ValueError):
        coin.query({"C_D": 1.0, "v(0)": 0.0}, [0.1, 0.7])
    for parameters, times, text in [
        ({"C_D": 1.0}, TIMES, r"v\(0\) is not given"),
        ({"C_d": 1.0, "v(0)": 0.0}, TIMES, "did you mean \"C_D\""),
        ({"C_D": 1.0, "v(0)": "3 kg"}, TIMES, "kg"),
        ({"C_D": 1.0, "v(0)": np.nan}, TIMES, "finite|nan"),
        ({"C_D": None, "v(0)": 0.0}, TIMES, "C_D is None, expected a number"),
        ({"C_D": 10**400, "v(0)": 0.0}, TIMES, "C_D is beyond the largest number"),
        ({"C_D": 1.0, "v(0)": 0.0}, None, "times are not given"),
        ({"C_D": 1.0, "v(0)": 1j}, TIMES, "complex"),
        (np.ones((4, 2)) * 1j, TIMES, "complex"),
        (np.ones((4, 3)), TIMES, r"expected \(\.\., 2\)"),
    ]:
        with pytest.raises(samara.ArgumentError, match=text):
            coin.query(parameters, times)
    with pytest.raises(samara.ArgumentError, match="labels"):
        coin.query({"C_D": 1.0, "v(0)": 0.0}, TIMES, labels="polars")


def test_a_codebook_without_time_answers_without_times(product):
    np.testing.assert_allclose(product.query({"a": "150 cm", "b": 0.5}), [0.75, 2.5], rtol=1e-12)
    values, slopes = product.query({"a": [0.0, 1.0], "b": 0.5}, gradient=True)
    np.testing.assert_allclose(slopes[1], [[0.5, 1.0], [1.0, 0.0]], atol=1e-10)
    for room in (np.empty((2, 2)), np.empty((2, 2)).T):
        assert product.query({"a": [0.0, 1.0], "b": 0.5}, out=room) is room and np.array_equal(room, values)
    with pytest.raises(ValueError, match="no time"):
        product.query({"a": 1.0, "b": 0.5}, [0.1])


def test_labelled_answers_of_pandas_hold_the_same_numbers(coin):
    pytest.importorskip("pandas")
    C = np.array([0.8, 1.1, 1.6])
    values, slopes = coin.query({"C_D": C, "v(0)": 0.0}, TIMES, gradient=True)
    frame = coin.query({"C_D": C, "v(0)": 0.0}, TIMES, gradient=True, labels="pandas")
    assert list(frame.columns[:3]) == ["C_D", "v(0)", "t"] and len(frame) == 21
    for k, o in enumerate(coin.outputs):
        assert np.array_equal(frame[o.name], values[..., k].ravel())
        assert np.array_equal(frame[f"d{o.name}/dC_D"], slopes[..., k, 0].ravel())
    assert frame.attrs["units"]["v(0)"] == "m/s"


def test_labelled_answers_of_xarray_hold_the_same_numbers(coin):
    pytest.importorskip("xarray")
    C = np.array([0.8, 1.1, 1.6])
    values, slopes = coin.query({"C_D": C, "v(0)": 0.0}, TIMES, gradient=True)
    data = coin.query({"C_D": C, "v(0)": 0.0}, TIMES, gradient=True, labels="xarray")
    for k, o in enumerate(coin.outputs):
        assert data[o.name].dims == ("sample", "time") and data[o.name].attrs["units"] == o.unit
        assert np.array_equal(data[o.name], values[..., k])
        assert np.array_equal(data[f"d{o.name}"].sel(parameter="C_D"), slopes[..., k, 0])


def test_a_dataset_has_each_name_once():
    def still(x):
        return np.repeat(x, 2, 1)

    def moving(x, t):
        return np.repeat(x[:, None], len(t), 1)

    for parameter, function, outputs, end, more, name in [
        ("a", still, ["x", "dx"], None, {"gradient": True}, "dx"),
        ("parameter", still, ["x", "y"], None, {"gradient": True}, "parameter"),
        ("time", moving, ["x"], 1, {"times": [0.5]}, "time"),
    ]:
        book = samara.separate(function, {parameter: (0, 1)}, outputs, end=end, certificate_points=20)
        with pytest.raises(samara.ArgumentError, match=f'the Dataset of this answer has "{name}" more than once'):
            book.query({parameter: 0.5}, labels="xarray", **more)


def test_nothing_but_the_answer_is_allocated(coin):
    points = points_of(coin, 200_000)
    q = points[:2000, 1:].copy()
    times = np.linspace(0, 0.5, 200)
    for ask in (lambda: coin.at(points), lambda: coin.query(q, times), lambda: coin.query(q, times, gradient=True)):
        ask()
        tracemalloc.start()
        answer = ask()
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        size = sum(a.nbytes for a in answer) if isinstance(answer, tuple) else answer.nbytes
        assert size <= peak < size + 100_000


def test_eight_threads_at_once_get_the_answers_of_one(coin):
    points = [points_of(coin, 300, seed) for seed in range(8)]
    expected = [(coin.at(p), coin.query(p[:, 1:], TIMES + 0.001 * k * (TIMES < 0.4), gradient=True))
                for k, p in enumerate(points)]
    wrong = []

    def ask(k):
        for _ in range(30):
            values, slopes = coin.query(points[k][:, 1:], TIMES + 0.001 * k * (TIMES < 0.4), gradient=True)
            if not (np.array_equal(coin.at(points[k]), expected[k][0]) and np.array_equal(values, expected[k][1][0])
                    and np.array_equal(slopes, expected[k][1][1])):
                wrong.append(k)

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(8)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not wrong


@pytest.mark.parametrize("what", ["a batch is answered", "times are prepared"])
def test_other_threads_go_on_while(what, coin):
    points = points_of(coin, 400_000)
    times = np.linspace(0, 0.5, 1_000_000)
    rounds, done = [0], threading.Event()

    def count():
        while not done.is_set():
            rounds[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    time.sleep(0.01)
    before = rounds[0]
    begin = time.perf_counter()
    if what == "a batch is answered":
        coin.at(points, threads=1)
    else:
        coin.query(np.empty((0, 2)), times)
    elapsed = time.perf_counter() - begin
    during = rounds[0] - before
    done.set()
    thread.join()
    # A thread that waited for the lock would come to a handful of rounds.
    assert during > 100, f"{during} rounds in {elapsed:.3f} s"
