"""Codebooks as objects: what they say of themselves, their numbers, slices, pickles; what they leave in memory."""

import dataclasses
import gc
import multiprocessing
import pathlib
import pickle
import types

import numpy as np
import pytest

import samara
from conftest import answer, command

GOLDEN = pathlib.Path(__file__).parent.parent / "codebooks" / "golden"
TIMES = np.linspace(0.0, 0.5, 5)


def resident():
    """Bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def test_a_codebook_says_what_the_command_says_of_it(coin, coin_path):
    told = answer("info", coin_path)
    assert [vars(c) for c in coin.coordinates] == told["coordinates"]
    assert [vars(o) for o in coin.outputs] == told["outputs"]
    assert coin.model == told["model"]
    assert vars(coin.build) == told["build"]
    assert coin.provenance == told["provenance"]
    certificate = told["certificate"]
    for key, value in vars(coin.certificate).items():
        if key == "outputs":
            assert [vars(o) for o in value.values()] == certificate["outputs"]
        else:
            assert value == certificate[key], key
    assert coin.certificate.met and coin.certificate.outputs["v"].p95 < 1e-4


def test_a_notebook_shows_axes_ranks_and_the_certificate_in_green_or_red(coin):
    page = coin._repr_html_()
    for text in ("C_D", "v(0)", "chebyshev", "certificate met", "#1a7f37"):
        assert text in page, text
    assert "C_D 0.6..2" in repr(coin)
    missed = samara.separate(lambda x: np.abs(x[:, 0] - 0.3), {"a": (0, 1)}, ["u"], 1e-8, max_calls=200)
    assert not missed.certificate.met and "#cf222e" in missed._repr_html_() and "MISSED" in missed._repr_html_()


def test_a_notebook_says_how_many_points_of_a_certificate_failed(coin):
    certificate = dataclasses.replace(coin.certificate, met=False, failed_points=3)
    told = types.SimpleNamespace(**{name: getattr(coin, name) for name in ("coordinates", "title", "model")}, certificate=certificate)
    assert "of which 3 failed" in samara._html.codebook(told, coin._book.outlines())
    told.certificate = dataclasses.replace(coin.certificate, met=False, verdict="not converged")
    assert "certificate NOT CONVERGED</b>: largest error" in samara._html.codebook(told, coin._book.outlines())
    assert "failed" not in coin._repr_html_()


def test_factors_evaluate_to_the_answers_and_cannot_be_written(coin):
    pieces = coin.to_numpy()
    for piece in pieces:
        for group in piece.groups:
            nodes = [a.nodes for a in piece.axes]
            index = [len(n) // 2 for n in nodes]
            point = np.array([n[i] for n, i in zip(nodes, index)])
            if group.kind == "train":
                product = group.cores[0][0]
                for core, i in zip(group.cores[1:], index):
                    product = product @ core[:, i]
                values = product[:, 0]
            else:
                values = group.weights @ np.prod([f[i] for f, i in zip(group.factors, index)], axis=0)
            np.testing.assert_allclose(values, coin.at(point, outputs=group.outputs), rtol=1e-11, atol=1e-13)
            for view in (*group.cores, *group.factors):
                with pytest.raises(ValueError):
                    view[...] = 0.0


def test_a_view_keeps_its_codebook(coin_path):
    book = samara.Codebook.open(coin_path)
    group = book.to_numpy()[0].groups[0]
    view = (*group.cores, *group.factors)[0]
    expected = view.copy()
    del book, group
    gc.collect()
    samara.Codebook.open(coin_path)
    assert np.array_equal(view, expected)


def test_a_coordinate_counted_from_a_front_is_said_with_the_numbers():
    book = samara.Codebook.open(GOLDEN / "codebook_0.7.h5")
    [piece] = book.to_numpy()
    front = piece.front
    assert front.coordinate == "C" and front.others == (("k", 2), ("h", 3))
    for at in (0, 2, 4):
        t, s, k, m, h = (axis.nodes[at % len(axis.nodes)] for axis in piece.axes)
        place = np.polynomial.chebyshev.chebval2d(2 * k - 1, h / 2, front.place.reshape(3, 2).T)
        C = 2 + (s - 2 + place) / (1 + place * (s - 2))
        np.testing.assert_allclose(book.at(np.array([t, C, k, m, h])), [(1 + t) * s + k**2 + m, s**2 * h], rtol=0, atol=1e-12)
    assert book.slice(C=1.5, k=0.2, h=0.1).to_numpy()[0].front is None
    with pytest.raises(samara.ArgumentError, match='counts from a front that moves with "k"'):
        book.slice(C=1.5)


def test_a_slice_answers_as_the_whole_with_the_coordinate_held(coin):
    part = coin.slice(C_D=1.1)
    assert [c.name for c in part.coordinates] == ["t", "v(0)"] and part.certificate is None
    assert part.model["fixed"]["C_D"] == 1.1
    v = np.linspace(-0.3, 0.7, 9)
    np.testing.assert_allclose(part.query({"v(0)": v}, TIMES), coin.query({"C_D": 1.1, "v(0)": v}, TIMES), rtol=0, atol=1e-13)
    for held, kind in [({"C_D": 9.0}, samara.OutsideBoxError), ({"t": 0.1}, samara.ArgumentError),
                       ({"C_D": 1.0, "v(0)": 0.0}, samara.ArgumentError), ({"C_X": 1.0}, samara.ArgumentError)]:
        with pytest.raises(kind):
            coin.slice(**held)


def test_sobol_indices_are_those_of_the_command(coin, coin_path):
    told = answer("stats", coin_path)
    s = coin.sobol()
    assert list(s.inputs) == told["inputs"]
    np.testing.assert_array_equal(s.times, told["times"])
    for output in told["outputs"]:
        name = output["name"]
        np.testing.assert_array_equal(s.mean[name], output["mean"])
        np.testing.assert_array_equal(s.deviation[name], output["deviation"])
        for k, parameter in enumerate(s.inputs):
            np.testing.assert_array_equal(s.total[name][:, k], np.array(output["total"][parameter], float))
            np.testing.assert_array_equal(s.first_order[name][:, k], np.array(output["first_order"][parameter], float))


def test_statistics_of_distributions_are_those_of_the_command(coin, coin_path):
    told = answer("stats", coin_path, "--set", "C_D=normal(1.2, 0.05)", "--set", "v(0)=0.1..0.2", "--quantiles", "0.1", "0.9",
                  "--group", "C_D,v(0)")
    s = coin.sobol({"C_D": ("normal", 1.2, 0.05), "v(0)": ("uniform", "10 cm/s", 0.2)}, quantiles=[0.1, 0.9], groups=[["C_D", "v(0)"]])
    for output in told["outputs"]:
        np.testing.assert_array_equal(s.mean[output["name"]], output["mean"])
        np.testing.assert_array_equal(s.quantiles[output["name"]].T, output["quantiles"])
        np.testing.assert_array_equal(s.group_closed[output["name"]][:, 0], np.array(output["groups"][0]["closed"], float))
    held = coin.sobol(fixed={"v(0)": "10 cm/s"})
    assert held.inputs == ("C_D",)
    one = coin.sobol(groups="C_D", quantiles=0.5)
    assert one.groups == coin.sobol(groups=["C_D"]).groups == (("C_D",),)
    np.testing.assert_array_equal(one.quantiles["v"], coin.sobol(quantiles=[0.5]).quantiles["v"])
    for wrong in [3, [3]]:
        with pytest.raises(samara.ArgumentError, match="are 3, expected"):
            coin.sobol(groups=wrong)
    for wrong in [{"C_D": 1.1}, {"foo": 1}, {"C_D": ("gauss", 1, 1)}, {"C_D": ("normal", 1)}, {"C_X": ("normal", 1, 1)},
                  {"C_D": "normal(1, 1)"}, {"C_D": ("normal", float("nan"), 1)}]:
        with pytest.raises(samara.ArgumentError):
            coin.sobol(wrong)


def test_a_name_that_is_no_coordinate_is_said_before_what_its_unit_would_be(coin):
    for call, name in [(lambda: coin.slice(v0="10 cm/s"), "v0"),
                       (lambda: coin.at([[1.1, 0.0]], fixed={"T": "500 ms"}), "T"),
                       (lambda: coin.sobol({"v0": ("normal", "10 cm/s", "1 cm/s")}), "v0"),
                       (lambda: coin.sobol(fixed={"v0": "10 cm/s"}), "v0")]:
        with pytest.raises(samara.ArgumentError, match=f'^coordinate "{name}" is unknown; '):
            call()


def test_a_deviation_is_a_difference_of_temperatures():
    oven = samara.separate(lambda x: x[:, :1] * x[:, 1:], {"a": (250, 700), "b": (0, 1)}, {"u": "K"}, tolerance=1e-6, units={"a": "K"})
    s = oven.sobol({"a": ("normal", "300 degC", "20 K")}, fixed={"b": 1})
    np.testing.assert_allclose((s.mean["u"][0], s.deviation["u"][0]), (573.15, 20), rtol=1e-3)
    for deviation in ("20 degC", np.array("20 degC"), ["20 degC"]):
        with pytest.raises(samara.ArgumentError, match="a: .*difference of temperatures"):
            oven.sobol({"a": ("normal", "300 degC", deviation)}, fixed={"b": 1})


def ask(book):
    return book.query({"C_D": 1.2, "v(0)": 0.1}, TIMES)


def test_pickles_cross_to_processes_that_were_spawned(coin):
    assert pickle.loads(pickle.dumps(coin)).certificate == coin.certificate
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        for values in pool.map(ask, [coin, coin]):
            assert np.array_equal(values, ask(coin))


def test_a_saved_codebook_is_the_same(coin, tmp_path):
    path = tmp_path / "copy.h5"
    coin.save(path)
    copy = samara.Codebook.open(path)
    assert copy.certificate == coin.certificate and np.array_equal(ask(copy), ask(coin))
    with pytest.raises(OSError, match="cannot write .*none/copy.h5") as raised:
        coin.save(tmp_path / "none" / "copy.h5")
    assert isinstance(raised.value, samara.InputError)


def test_a_codebook_is_not_saved_by_a_name_of_another_format(coin, tmp_path):
    with pytest.raises(samara.ArgumentError, match=r"coin\.csv.*HDF5 is written; a name that ends in \.h5 was expected"):
        coin.save(tmp_path / "coin.csv")
    assert not list(tmp_path.iterdir())
    coin.save(tmp_path / "coin.book")


def test_bad_files_are_os_errors_with_the_sentence_of_the_command(tmp_path):
    broken = tmp_path / "broken.h5"
    broken.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(10))
    foreign = tmp_path / "foreign.h5"
    foreign.write_text("no codebook")
    for path in (broken, foreign, tmp_path / "missing.h5", tmp_path):
        with pytest.raises(OSError) as raised:
            samara.Codebook.open(path)
        assert isinstance(raised.value, samara.InputError)
        assert str(raised.value) in command("info", path, codes=(3,)).stderr


def test_a_thousand_opened_codebooks_leave_no_memory_behind(coin_path):
    def use():
        book = samara.Codebook.open(coin_path)
        ask(book)
        book.to_numpy()
        book._repr_html_()

    def outside():
        try:
            samara.Codebook.open("/nowhere.h5")
        except OSError:
            pass

    for _ in range(200):
        use()
        outside()
    gc.collect()
    before = resident()
    for _ in range(1000):
        use()
        outside()
    gc.collect()
    assert resident() - before < 4 << 20, f"{(resident() - before) / 1e6:.1f} MB more"
