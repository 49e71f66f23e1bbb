"""Records, patterns and regimes of motions, beside the command and plain formulas."""

import json
import re
import threading
import time

import numpy as np
import pytest

import samara
from conftest import LEAF, MEADOW, PLATES, answer, helix


def test_a_number_that_makes_no_sense_is_refused_by_its_name(tmp_path):
    t = np.arange(0, 10, 0.02)
    track = {"drop": {"t[s]": t, **{f"{c}[m]": v for c, v in zip("xyz", helix(t).T)}}}
    record, = samara.records(track)
    (tmp_path / "wind.toml").write_text(MEADOW)
    wind, air, times = samara.Wind(tmp_path / "wind.toml"), samara.Turbulence(0.3, 0.2), [0.0, 0.05]

    def realised(air=air, **more):
        return samara.realise("immersed_body_in_gusts", LEAF, times, air, **{"realisations": 4, **more})

    for call, text in [
        (lambda: samara.records(track, length=-1), "length is -1 m, expected a finite number from 0 on"),
        (lambda: samara.patterns(track, length=np.nan), "length is nan m"),
        (lambda: samara.patterns([record], length="5 cm"), "length and sidecar are of captures"),
        (lambda: samara.records(track, sidecar="a.toml"), 'sidecar "a.toml" says what .* every capture given is in memory'),
        (lambda: samara.records("b.toml", sidecar="a.toml"), "every capture given is a sidecar itself; a table file was expected"),
        (lambda: samara.records("b.csv", sidecar=3), "sidecar is of the type int, expected a file"),
        (lambda: realised(checkpoint=3), "checkpoint is of the type int, expected a file"),
        (lambda: samara.agreement([("drop", 0, 499, "spiral")], track, length="-5 cm"), "length is -0.05 m"),
        (lambda: samara.agreement([("drop", 0, 499, "spiral")], track, thresholds={"wobble": None}), "wobble is None"),
        (lambda: samara.pattern_thresholds(wobble="high"), "wobble: .*high"),
        (lambda: samara.Record(t, helix(t), length=np.inf), "length is inf m"),
        (lambda: samara.Record(t, helix(t), position_noise=-1), "position_noise is -1 m"),
        (lambda: samara.Record(t, helix(t), angle_noise="x"), "angle_noise: "),
        (lambda: samara.Record(t, helix(t), left_out=-1), "left_out is -1, expected a whole number"),
        (lambda: record.features(settle=1), "settle is 1, expected a share from 0 to below 1"),
        (lambda: record.label(settle=None), "settle is None"),
        (lambda: record.windows(swings=None), "swings is None"),
        (lambda: record.windows(overlap="half"), "overlap: .*half"),
        (lambda: wind.velocity(0.0, [0, 0, 2], body_length=0), "body_length is 0 m, expected a finite number above 0"),
        (lambda: wind.velocity(np.nan, [0, 0, 2]), "times: a number is nan, expected finite ones"),
        (lambda: wind.velocity(0.0, [0, np.inf, 2]), "positions: a number is inf"),
        (lambda: wind.velocity(0.0, [0, 0, 2], seed=None), "seed is None, expected a whole number from 0 on"),
        (lambda: wind.series([[0, 0, 10]], 0, 10), "step is 0 s"),
        (lambda: realised(realisations=None), "realisations is None"),
        (lambda: realised(step=0), "step is 0 s"),
        (lambda: realised(body_radius=-1), "body_radius is -1 m"),
        (lambda: realised(relative_error="x"), "relative_error: "),
        (lambda: realised(C_0=-1), "C_0 is -1"),
        (lambda: realised(antithetic=1), "antithetic is 1, expected True or False"),
        (lambda: realised(rotation="no"), "rotation is 'no', expected True or False"),
        (lambda: realised(samara.Turbulence(-1, 0.2)), r"k is -1 m\^2/s\^2"),
        (lambda: realised(samara.Turbulence(0.3, 0.2, (np.nan, 0, 0))), "stream: a number is nan"),
        (lambda: realised(samara.Turbulence(0.3, 0.2, decays="no")), "decays is 'no'"),
        (lambda: samara.k_means(helix(t), None), "clusters is None"),
        (lambda: samara.simulate("vertical_fall", {}, times, relative_tolerance=None), "relative_tolerance is None"),
        (lambda: samara.simulate("vertical_fall", {}, times, stiff="no"), "stiff is 'no'"),
        (lambda: samara.Model(lambda t, x, p: x, {"x": samara.State("x", initial=np.nan)}, {}), "initial of x: a number is nan"),
    ]:
        with pytest.raises(samara.ArgumentError, match=text):
            call()


def test_sentences_of_records_name_arguments_in_place_of_options(tmp_path):
    sidecar = tmp_path / "side.toml"
    sidecar.write_text('[columns]\nt = { quantity = "t", unit = "s" }\n')
    for call in (lambda: samara.records(sidecar), lambda: samara.patterns(sidecar), lambda: samara.agreement([("a", 0, 9, "steady")], sidecar)):
        with pytest.raises(samara.InputError, match="the sidecar by sidecar, or lay it beside"):
            call()


def test_a_sidecar_is_of_the_tables_among_captures(tmp_path):
    rows = "".join(f"{0.02 * k},{0.1 * k},0,{-0.2 * k}\n" for k in range(20))
    units = {"t": "s", "x": "cm", "y": "cm", "z": "cm"}
    columns = "[columns]\n" + "".join(f'{name} = {{ quantity = "{name}", unit = "{unit}" }}\n' for name, unit in units.items())
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text("t,x,y,z\n" + rows)
    (tmp_path / "of_a.toml").write_text('file = "a.csv"\n' + columns.replace("cm", "mm"))
    (tmp_path / "side.toml").write_text(columns)
    a, b = samara.records([tmp_path / "of_a.toml", tmp_path / "b.csv"], sidecar=tmp_path / "side.toml")
    np.testing.assert_allclose([a.positions[-1, 0], b.positions[-1, 0]], [0.0019, 0.019])


def test_records_of_captures_are_labelled_as_the_command_labels_them(tmp_path):
    t = np.arange(0, 10, 0.02)
    columns = {"t[s]": t, **{f"{c}[m]": v for c, v in zip("xyz", helix(t).T)}}
    path = tmp_path / "round.csv"
    path.write_text(",".join(columns) + "\n" + "\n".join(",".join(f"{v:.9g}" for v in row) for row in zip(*columns.values())) + "\n")
    record, = samara.records({"round": columns}, length="5 cm")
    assert record.positions.shape == (500, 3) and record.normals is None and record.name == "round"
    assert record.label().pattern == "spiral"
    told = answer("patterns", path, "--length", "5 cm")["captures"][0]["windows"]
    windows = samara.patterns(path, length=0.05).sequences[0]
    assert [(w["pattern"], round(w["margin"], 9)) for w in told] == [(label.pattern, round(label.margin, 9)) for *_, label in windows]
    features = record.features()
    assert abs(features["wobble"]) < 0.01 and abs(features["fall"] - 0.4) < 1e-3
    # By hand, and with an attitude: a plate that stays level descends steadily.
    level = samara.Record(t, np.c_[0 * t, 0 * t, -t], normals=np.tile([0.0, 0.0, 1.0], (500, 1)), length=0.05)
    assert level.label().pattern == "steady"
    # At the threshold itself a tilt is none any more.
    assert level.label(thresholds={"steady_lengths": 1000.0}).pattern != "steady"
    with pytest.raises(samara.ArgumentError, match=r"positions have the shape \(500,\), expected \(500, 3\)"):
        samara.Record(t, t)
    with pytest.raises(samara.ArgumentError, match="did you mean"):
        record.label(thresholds={"steady_tlit": 1.0})
    assert samara.pattern_thresholds(veers=3.0)["veers"] == 3.0 and samara.pattern_thresholds()["veers"] == 2.5


def test_other_threads_go_on_while_clusters_are_found():
    points = np.random.default_rng(4).random((50_000, 4))
    rounds, done = [0], threading.Event()

    def count():
        while not done.is_set():
            rounds[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    time.sleep(0.01)
    before = rounds[0]
    samara.k_means(points, 4, restarts=1)
    during = rounds[0] - before
    done.set()
    thread.join()
    assert during > 100


def test_clusters_and_agreement_are_those_of_plain_formulas(tmp_path):
    random = np.random.default_rng(2)
    centres = np.array([[0.0, 0.0], [5.0, 0.0], [0.0, 6.0]])
    truth = np.repeat([0, 1, 2], [60, 40, 20])
    points = centres[truth] + 0.3 * random.standard_normal((120, 2))
    for found in [samara.k_means(points, 3, seed=5), samara.gaussian_mixture(points, 3)]:
        assert found.converged and samara.adjusted_rand(truth, found.assignment) == 1.0
        np.testing.assert_array_equal(found.assignment, truth)  # the largest first
        np.testing.assert_allclose(found.centres, [points[truth == k].mean(0) for k in range(3)], atol=1e-6)
    spread = sum(((points[truth == k] - points[truth == k].mean(0)) ** 2).sum() for k in range(3))
    assert abs(samara.k_means(points, 3).objective - spread) < 1e-9
    # Hubert and Arabie: pairs that both put together, beyond what chance does.
    assert abs(samara.adjusted_rand(list("aabbcc"), [1, 1, 2, 2, 2, 3]) - (2 - 3 * 4 / 15) / ((3 + 4) / 2 - 3 * 4 / 15)) < 1e-12
    with pytest.raises(samara.ArgumentError, match=r"points have the shape \(120,\)"):
        samara.k_means(points[:, 0], 3)
    with pytest.raises(samara.ArgumentError):
        samara.k_means(points[:2], 3)
    swept = samara.sweep(PLATES, progress=False)
    falls, kinds = swept.clusters(3, ["tilt", "flips"], release=1)
    assert (falls % 2 == 1).all() and len(kinds.assignment) == len(falls) and kinds.centres.shape == (3, 2)
    for more, text in [({"features": ["titl"]}, "did you mean"), ({"count": 0}, "count is 0, expected a whole number from 1 on"),
                       ({"release": 2}, "no release 2, expected 0 to 1"), ({"mixture": "no"}, "mixture is 'no'")]:
        with pytest.raises(samara.ArgumentError, match=text):
            swept.clusters(**{"count": 3, **more})


def test_a_persons_labels_are_compared_as_the_command_compares_them(tmp_path):
    t = np.arange(0, 12, 0.02)
    swings = np.stack([0.1 * np.sin(6 * t), 0 * t, -0.4 * t], 1)
    tables = {name: {"t[s]": t, **{f"{c}[m]": v for c, v in zip("xyz", path.T)}} for name, path in [("a", helix(t)), ("b", swings)]}
    files = []
    for name, columns in tables.items():
        files.append(tmp_path / f"{name}.csv")
        files[-1].write_text(",".join(columns) + "\n" + "\n".join(",".join(f"{v!r}" for v in row) for row in zip(*(c.tolist() for c in columns.values()))) + "\n")
    rows = [("a", 0, 500, "round"), ("b", 0, 400, "swing"), ("b", 100, 599, "round")]
    classes = {"round": ["spiral", "helix"], "swing": "zigzag"}
    both = samara.agreement(rows, tables, classes, length="5 cm")
    assert both.words == ["round", "swing", "other"] and both.confusion.tolist() == [[1, 1, 0], [0, 1, 0], [0, 0, 0]]
    assert abs(both.share - 2 / 3) < 1e-15 and abs(both.balanced - 0.75) < 1e-15
    assert abs(both.kappa - (2 / 3 - 4 / 9) / (1 - 4 / 9)) < 1e-12
    assert [segment[4] for segment in both.segments] == ["spiral", "zigzag", "zigzag"]
    labels = tmp_path / "labels.csv"
    labels.write_text("capture,first_frame,last_frame,label\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n")
    told = answer("patterns", *files, "--length", "5 cm", "--labels", labels, "--class", "round=spiral+helix", "--class", "swing=zigzag")["labels"]
    same = samara.agreement(labels, files, classes, length="5 cm")
    assert told["kappa"] == same.kappa and told["confusion"] == same.confusion.tolist() and told["words"] == same.words
    with pytest.raises(samara.ArgumentError, match='is "swings", which stands for nothing; did you mean "swing"'):
        samara.agreement([("a", 0, 500, "swings")], tables, classes)
    with pytest.raises(samara.ArgumentError, match="label 0 goes from frame 9 to 3"):
        samara.agreement([("a", 9, 3, "swing")], tables, classes)
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(rows, columns=["capture", "first_frame", "last_frame", "label"])
    assert samara.agreement(frame, tables, classes, length=0.05).frame["pattern"].tolist() == ["spiral", "zigzag", "zigzag"]


def test_patterns_are_frames(tmp_path):
    pytest.importorskip("pandas")
    t = np.arange(0, 12, 0.02)
    swings = np.stack([0.1 * np.sin(6 * t), 0 * t, -0.4 * t], 1)
    tables = {name: {"t[s]": t, **{f"{c}[m]": v for c, v in zip("xyz", path.T)}} for name, path in [("a", helix(t)), ("b", swings)]}
    found = samara.patterns(tables, length="5 cm")
    assert list(found.windows["record"]) == ["a", "b"] and list(found.windows["pattern"]) == ["spiral", "zigzag"]
    assert list(found.features["pattern"]) == ["spiral", "zigzag"] and len(found.features.columns) == 2 + len(samara.FEATURES)
    assert list(found.records[0].frame.columns) == ["t", "x", "y", "z"]
    # Each seen once, never one after the other: nothing is known of what follows.
    assert len(found.transitions) == 0
    found.report(tmp_path / "page.html")
    assert "Patterns of captures" in (tmp_path / "page.html").read_text()
    assert "does not say which body falls" in (tmp_path / "page.html").read_text()
    disc = samara.regime("immersed_body", {"a": "1 cm", "b": "1 cm", "c": "0.75 mm", "density": 2700, "fluid_density": 1000, "nu": 1e-6})
    found.report(tmp_path / "page.html", body=disc)
    data = json.loads(re.search(r'id="patterns">(.*?)</script>', (tmp_path / "page.html").read_text(), re.S)[1])
    shown, = data["diagram"]["bodies"]
    assert (shown["Re"], shown["I_disc"], shown["regime"]) == (disc.Re, disc.I_disc, "chaotic")
    with pytest.raises(samara.ArgumentError, match="expected a samara.Regime"):
        found.report(tmp_path / "page.html", body="immersed_body")


def test_a_regime_is_that_of_the_command():
    values = {"a": "1 cm", "b": "1 cm", "c": "0.75 mm", "density": 2700, "fluid_density": 1000, "nu": 1e-6}
    told = answer("regime", "immersed_body", *(x for n, v in values.items() for x in ("--set", f"{n}={v}")))
    found = samara.regime("immersed_body", values)
    assert {k: v for k, v in told.items() if k != "schema"} == vars(found)
    with pytest.raises(samara.ArgumentError, match="does not say length"):
        samara.regime("falling_plate_nd", {})
