"""Patterns, sweeps, winds, flows and clouds, beside the command and plain formulas."""

import concurrent.futures
import json
import os
import re

import h5py
import numpy as np
import pytest

import samara
from conftest import answer, command, interrupted

PLATES = {
    "model": "falling_plate_nd",
    "fixed": {"beta": 0},
    "axes": {"inertia_ratio": {"from": 0.8, "to": 2.4, "count": 9}, "C_R": [2.2, 2.7, 3.2]},
    "releases": {"tilt": [0.4, "40 deg"]},
    "run": {"until": 120, "step": 0.05},
}
LEAF = {"a": "3.5 cm", "b": "2 cm", "c": "0.1 mm", "density": 800, "C_D0": 0.05, "C_w": 2, "C_D90": 1.9, "C_T": 1.2, "C_R": 1.0,
        "z(0)": 1.0}
MEADOW = '[mean]\nspeed = "4 m/s"\nroughness = "3 cm"\n[turbulence]\nsigma = "0.8 m/s"\nlength = "5 m"\nmodes = 20\n'


def helix(t):
    return np.stack([0.1 * np.cos(6 * t), 0.1 * np.sin(6 * t), -0.4 * t], 1)


def test_a_sweep_is_that_of_the_command(tmp_path):
    swept = samara.sweep(PLATES, progress=False)
    assert swept.complete and swept.points.shape == (27, 2) and swept.features.shape == (54, len(samara.FEATURES))
    swept.save(tmp_path / "mine.h5")
    (tmp_path / "plan.toml").write_text(swept.plan)
    command("sweep", tmp_path / "plan.toml", "-o", tmp_path / "theirs.h5")
    with h5py.File(tmp_path / "theirs.h5") as file:
        np.testing.assert_array_equal(swept.features, file["features"][:])
        names = [name.decode() for name in file["label_names"]]
        assert list(swept.labels) == [names[int(k)] for k in file["labels"]]
        assert tuple(names) == samara.PATTERNS
    with pytest.raises(samara.InputError, match="cannot write .*none/mine.h5"):
        swept.save(tmp_path / "none" / "mine.h5")
    again = samara.Sweep.open(tmp_path / "mine.h5")
    np.testing.assert_array_equal(again.features, swept.features)
    assert list(again.labels) == list(swept.labels) and again.releases == swept.releases
    with pytest.raises(samara.InputError, match="C_Q"):
        samara.sweep({**PLATES, "axes": {"C_Q": [1.0]}}, progress=False)
    with pytest.raises(samara.ArgumentError, match="keeps no trajectories"):
        swept.trajectories()


def test_a_sweep_is_a_frame_and_a_map_and_a_page(tmp_path):
    swept = samara.sweep({**PLATES, "run": {"until": 120, "step": 0.05, "keep": "trajectories"}}, progress=False)
    shares = swept.shares()
    for k, name in enumerate(samara.PATTERNS):
        np.testing.assert_allclose(shares[:, k], (swept.labels.reshape(27, 2) == name).mean(1))
    pattern, probability, distance = swept.at(swept.points.reshape(9, 3, 2), release=1)
    assert pattern.shape == probability.shape == distance.shape == (9, 3)
    # At a fall whose neighbourhood is sure the map says what the fall does.
    assert all(p == label for p, label, sure in zip(pattern.ravel(), swept.labels[1::2], probability.ravel()) if sure == 1)
    times, states, names = swept.trajectories()
    assert states.shape == (54, len(times), len(names))
    np.testing.assert_allclose(states[1, 0, names.index("theta")], np.radians(40))
    with pytest.raises(samara.InputError, match="/nowhere/page.html"):
        swept.report("/nowhere/page.html")
    with pytest.raises(samara.ArgumentError, match='sweep.h5", expected a name that ends in .html'):
        swept.report(tmp_path / "sweep.h5")
    swept.report(tmp_path / "page.html")
    assert "default-src 'none'" in (tmp_path / "page.html").read_text()
    with pytest.raises(samara.ArgumentError, match="inside the box"):
        swept.at([9.0, 2.5])
    pytest.importorskip("pandas")
    frame = swept.frame
    # By name, in whatever order.
    by_name = frame[["C_R", "inertia_ratio"]][::2]
    for found, expected in zip(swept.at(by_name), swept.at(swept.points)):
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(swept.clamp("zigzag", by_name), swept.clamp("zigzag", swept.points))
    with pytest.raises(samara.ArgumentError, match='"tilt" is unknown'):
        swept.at(frame[["C_R", "inertia_ratio", "tilt"]])
    for of_one, of_list in zip(swept.clusters(2, "drift"), swept.clusters(2, ["drift"])):
        np.testing.assert_equal(vars(of_one) if isinstance(of_one, samara.Clusters) else of_one,
                                vars(of_list) if isinstance(of_list, samara.Clusters) else of_list)
    assert len(frame) == 54 and frame["release_tilt"].nunique() == 2
    np.testing.assert_array_equal(frame["inertia_ratio"][::2], swept.points[:, 0])
    steady = frame[frame["pattern"] == "zigzag"]
    assert (steady["flips"] < swept.thresholds["flips_plane"]).all()


def test_a_sweep_that_is_ended_keeps_what_was_done(tmp_path):
    plan = {**PLATES, "axes": {"inertia_ratio": {"from": 0.8, "to": 2.4, "count": 900}, "C_R": [2.2, 2.7, 3.2]}}
    ended = samara.sweep(plan, progress=lambda stage, fraction: fraction < 0.3, threads=1)
    assert not ended.complete and "cancelled" in ended.message
    assert 0 < len(ended.labels) < 5400 and len(ended.labels) == len(ended.features)
    refined = samara.sweep({**PLATES, "refine": {"rounds": 1}}, progress=False)
    assert [points for points, *_ in refined.rounds] == [27, 17 * 5]
    assert refined.rounds[0][1] == 27 and refined.rounds[1][1] == (refined.status[::2] != "inherited").sum()
    # The points of the plan are of round 0, in the file as well.
    refined.save(tmp_path / "refined.h5")
    again = samara.Sweep.open(tmp_path / "refined.h5")
    assert again.rounds == refined.rounds and list(np.bincount(again.round_of_point)) == [27, 17 * 5 - 27]
    whole = samara.sweep(PLATES, progress=False)
    np.testing.assert_array_equal(again.points[again.round_of_point == 0], whole.points)


def test_a_finished_sweep_is_no_checkpoint_and_stays(tmp_path):
    plan = {**PLATES, "run": {"until": 20, "step": 0.05}, "refine": {"rounds": 1}}
    leaf, table = tmp_path / "leaf.h5", tmp_path / "capture.csv"
    whole = samara.sweep(plan, progress=False)
    whole.save(leaf)
    table.write_text("t,z\n")
    for path in (leaf, table):
        before = path.read_bytes()
        with pytest.raises(samara.InputError, match="this is no checkpoint of a sweep, and would be lost"):
            samara.sweep(plan, progress=False, checkpoint=path)
        assert path.read_bytes() == before
    # One that cannot be written is a warning.
    with pytest.warns(UserWarning, match="no checkpoint: cannot write"):
        unkept = samara.sweep(plan, progress=False, checkpoint=tmp_path / ("n" * 300))
    np.testing.assert_array_equal(unkept.points, whole.points)


def test_warnings_are_told_when_they_happen_so_an_interruption_loses_none(tmp_path):
    def swept(**more):
        many = {"inertia_ratio": {"from": 0.8, "to": 2.4, "count": 900}, "C_R": [2.2, 2.7, 3.2]}
        return samara.sweep({**PLATES, "axes": many}, threads=1, **more)

    def realised(**more):
        return samara.realise("immersed_body_in_gusts", LEAF, [0.0, 0.05], samara.Turbulence(0.3, 0.2), 1000000, **more)

    # That of the sweep tries to keep its checkpoint when it ends: beyond a half of its 5400 falls 2048 are done, and the next
    # 1024 are told of before they fall.
    for call, beyond in [(realised, None), (swept, 0.5)]:
        told = interrupted(call, tmp_path, beyond)
        assert [warning.filename for warning in told] == [__file__]


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


def test_the_map_of_a_sweep_draws_and_clamps_as_the_command_does(tmp_path):
    swept = samara.sweep(PLATES, progress=False)
    swept.save(tmp_path / "plates.h5")
    drawn = swept.draw("zigzag", 5, seed=4, release=1)
    told = answer("patterns", tmp_path / "plates.h5", "--draw", "zigzag", "--count", 5, "--seed", 4, "--release", 1)
    np.testing.assert_array_equal(drawn, [point["values"] for point in told["points"]])
    # The first ones do not depend on how many there are.
    np.testing.assert_array_equal(swept.draw("zigzag", 2, seed=4, release=1), drawn[:2])
    moved = swept.clamp("zigzag", [[[2.4, 3.2]], [drawn[0]]], release=1)
    assert moved.shape == (2, 1, 2)
    # Where the map has it, or a fall of it that stands alone.
    own = swept.points[swept.labels[1::2] == "zigzag"]
    for place, called in zip(moved[:, 0], swept.at(moved[:, 0], release=1)[0]):
        assert called == "zigzag" or np.abs(own - place).max(axis=1).min() < 1e-12
    assert swept.at(drawn[0], release=1)[0] != "zigzag" or np.allclose(moved[1, 0], drawn[0], rtol=1e-12)
    with pytest.raises(samara.ArgumentError, match="helix is 0 of 27 points"):
        swept.draw("helix")
    with pytest.raises(samara.ArgumentError, match="no release 2"):
        swept.clamp("zigzag", [1.0, 2.5], release=2)


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


def test_landings_of_a_sweep_are_counted_by_pattern():
    pandas = pytest.importorskip("pandas")
    plan = {"model": "immersed_body", "fixed": {key: LEAF[key] for key in ("a", "b", "c", "density", "C_D0", "C_w")},
            "axes": {name: {"from": 0.4, "to": 2.6, "count": 2} for name in ("C_D90", "C_T", "C_R")},
            "releases": {"tilt": ["10 deg", "30 deg"]}, "run": {"until": "2 s", "step": "1 ms", "settle": "0.3 s", "height": "0.5 m"}}
    swept = samara.sweep(plan, progress=False)
    told = swept.landing_statistics(release=1)
    assert isinstance(told, pandas.DataFrame) and told["landed"].sum() == np.isfinite(swept.landing[1::2, 0]).sum() > 0
    for row in told.itertuples():
        landed = swept.landing[1::2][swept.labels[1::2] == row.pattern]
        landed = landed[np.isfinite(landed[:, 0])]
        assert row.landed == len(landed) and abs(row.share - (swept.labels[1::2] == row.pattern).mean()) < 1e-15
        if len(landed) > 1:
            np.testing.assert_allclose([row.x, row.y, row.time], landed.mean(0), atol=1e-15)
            np.testing.assert_allclose([[row.xx, row.xy], [row.xy, row.yy]], np.cov(landed[:, :2].T), atol=1e-15)
            np.testing.assert_allclose(row.x_error, landed[:, 0].std(ddof=1) / np.sqrt(len(landed)), atol=1e-15)
    with pytest.raises(samara.ArgumentError, match="no release 2"):
        swept.landing_statistics(2)


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


def test_a_wind_is_its_profile_and_its_field(tmp_path):
    path = tmp_path / "wind.toml"
    path.write_text('[mean]\nspeed = "4 m/s"\nroughness = "3 cm"\n[turbulence]\nsigma = "0.8 m/s"\nlength = "5 m"\n[series]\nsigma = "1 m/s"\n')
    wind = samara.Wind(path)
    heights = np.array([[2.0, 5.0], [10.0, 40.0]])
    np.testing.assert_allclose(wind.profile(heights), 4 * np.log(heights / 0.03) / np.log(10 / 0.03), rtol=1e-12)
    at = np.random.default_rng(0).uniform([0, 0, 2], [200, 200, 8], (300, 3))
    velocities = wind.velocity(0.0, at, seed=3)
    assert velocities.shape == (300, 3)
    np.testing.assert_array_equal(wind.velocity(0.0, at[7], seed=3), velocities[7])
    assert np.any(wind.velocity(0.0, at[7], seed=3, realisation=1) != velocities[7])
    np.testing.assert_array_equal(wind.velocity(0.0, at), wind.velocity(0.0, at, seed=1))
    deviation = velocities - np.c_[wind.profile(at[:, 2]), np.zeros((300, 2))]
    # Eddies of 5 m, some hundred of them in the box.
    np.testing.assert_allclose(deviation.std(axis=0), 0.8, rtol=0.25)
    times, series = wind.series([[0, 0, 10], [0, 5, 10]], "0.1 s", 600, seed=1)
    assert series.shape == (600, 2, 3) and times[1] == 0.1
    np.testing.assert_array_equal(wind.series([[0, 0, 10], [0, 5, 10]], "0.1 s", 600)[1], series)
    np.testing.assert_allclose(series[:, :, 0].mean(axis=0), 4.0, rtol=1e-9)
    with pytest.raises(samara.ArgumentError, match="do not broadcast"):
        wind.velocity([0.0, 1.0], at)
    with pytest.raises(samara.ArgumentError, match="heights: a number is nan, expected finite ones"):
        wind.profile([np.nan, 1.0])
    with pytest.raises(samara.InputError, match="missing.toml"):
        samara.Wind(tmp_path / "missing.toml").profile(2.0)


def test_a_cloud_is_that_of_the_command(tmp_path):
    path = tmp_path / "cloud.h5"
    times = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])  # as the command divides; linspace has 0.30000000000000004
    command("simulate", "immersed_body_in_gusts", *(x for n, v in LEAF.items() for x in ("--set", f"{n}={v}")), "--until", 0.5, "--frames", 6,
            "--turbulence", "k=0.3", "--turbulence", "epsilon=0.2", "--turbulence", "stream_x=1", "--realisations", 64, "--seed", 7,
            "--ground", 0.3, "--keep", 2, "-o", path)
    air = samara.Turbulence(0.3, "0.2 m^2/s^3", stream=(1, 0, 0))
    cloud = samara.realise("immersed_body_in_gusts", LEAF, times, air, 64, 7, ground="0.3 m", keep=2)
    with h5py.File(path) as file:
        np.testing.assert_array_equal(cloud.mean, file["mean"][:])
        np.testing.assert_array_equal(cloud.covariance, file["covariance"][:])
    assert cloud.states == ["x", "y", "z"] and cloud.covariance.shape == (6, 3, 3)
    # Of the same noise by default, too.
    command("simulate", "immersed_body_in_gusts", *(x for n, v in LEAF.items() for x in ("--set", f"{n}={v}")), "--until", 0.5, "--frames", 6,
            "--turbulence", "k=0.3", "--turbulence", "epsilon=0.2", "--turbulence", "stream_x=1", "--realisations", 8, "-o", path)
    with h5py.File(path) as file:
        np.testing.assert_array_equal(samara.realise("immersed_body_in_gusts", LEAF, times, air, 8).mean, file["mean"][:])
    assert cloud.kept.shape == (2, 6, len(cloud.all_states)) and cloud.status.shape == (64,)
    assert len(cloud.landings) == (cloud.status == "landed").sum() and np.allclose(cloud.landings[:, 4], 0.3)
    alone = samara.realise("immersed_body_in_gusts", LEAF, times, air, 1, 7, first=1, keep=1)
    seen = np.isfinite(cloud.kept[1]).all(axis=1)
    np.testing.assert_array_equal(alone.kept[0][seen], cloud.kept[1][seen])
    kept = tmp_path / "cloud.checkpoint"
    begun = samara.realise("immersed_body_in_gusts", LEAF, times, air, 1000000, 7, checkpoint=kept, progress=lambda stage, share: not kept.exists())
    assert begun.cancelled and kept.exists()
    more = len(begun.status) + 256
    resumed = samara.realise("immersed_body_in_gusts", LEAF, times, air, more, 7, checkpoint=kept)
    np.testing.assert_array_equal(resumed.mean, samara.realise("immersed_body_in_gusts", LEAF, times, air, more, 7).mean)
    assert not kept.exists()
    kept.write_text("t,z\n")
    with pytest.raises(samara.InputError, match="this is no checkpoint of a build or a cloud"):
        samara.realise("immersed_body_in_gusts", LEAF, times, air, 64, 7, checkpoint=kept)
    assert kept.read_text() == "t,z\n"
    # Steps that are too long are doubted as by the command, without a number where flights diverge.
    with pytest.warns(UserWarning) as told:
        samara.realise("immersed_body_in_gusts", LEAF, times, samara.Turbulence(5, 50), 64, step="20 ms")
    sentences = [str(warning.message) for warning in told]
    assert re.search("% of the steps of 0.02 s are longer than 0.3 of .*; flights diverged, shorter ones are needed", sentences[0])
    assert re.search("[0-9]+ of 64 flights diverged", sentences[1])
    # What is wrong with the call is said before a checkpoint that could be none.
    with pytest.raises(samara.ArgumentError, match='has no state "speed"'):
        samara.realise("immersed_body_in_gusts", LEAF, times, air, states=["speed"], checkpoint=tmp_path)
    with pytest.raises(samara.ArgumentError, match=r"stream has the shape \(1, 3\), expected \(3,\)"):
        samara.realise("immersed_body_in_gusts", LEAF, times, samara.Turbulence(0.3, 0.2, stream=[[1, 0, 0]]))
    with pytest.raises(samara.ArgumentError, match="expected a samara.Wind"):
        samara.realise("immersed_body_in_gusts", LEAF, times, "wind.toml")
    with pytest.raises(samara.ArgumentError, match="immersed_body"):
        samara.realise("immersed_body", LEAF, times, air)


def test_a_wind_from_a_pipe_is_read_once_beside_a_checkpoint_too(tmp_path):
    path, kept = tmp_path / "wind.toml", tmp_path / "cloud.checkpoint"
    text = MEADOW
    path.write_text(text)

    def cloud(air, count, **options):
        return samara.realise("immersed_body_in_gusts", LEAF, np.array([0, 0.05]), air, count, 7, **options)

    def cloud_of_pipe(content, count, **options):
        reading, writing = os.pipe()
        os.write(writing, content.encode())
        os.close(writing)
        try:
            return cloud(samara.Wind(f"/dev/fd/{reading}"), count, checkpoint=kept, **options)
        finally:
            os.close(reading)

    def begin():
        begun = cloud(samara.Wind(path), 1000000, checkpoint=kept, progress=lambda stage, share: not kept.exists())
        assert begun.cancelled and kept.exists()
        return len(begun.status)

    count = begin()
    # The same text: the checkpoint holds all that are asked for, so there is nothing left that could be cancelled.
    resumed = cloud_of_pipe(text, count, progress=lambda stage, share: False)
    assert not resumed.cancelled and not kept.exists()
    np.testing.assert_array_equal(resumed.mean, cloud(samara.Wind(path), count).mean)
    # Another text, and what the checkpoint holds does not count.
    count = begin()
    stronger = text.replace("4 m/s", "5 m/s")
    other = cloud_of_pipe(stronger, count)
    path.write_text(stronger)
    np.testing.assert_array_equal(other.mean, cloud(samara.Wind(path), count).mean)


FLOW = """title = "small"
[flow]
shape = { kind = "ellipse", length = 1, thickness = 1 }
reynolds = 10000
cells_per_length = 6
extent = { before = 3, behind = 6, side = 3 }
max_time = 3
"""


def test_a_flow_is_the_arrays_of_its_file_and_bodies_fly_in_its_wake(tmp_path):
    (tmp_path / "plan.toml").write_text(FLOW)
    command("flow", tmp_path / "plan.toml", "-o", tmp_path / "wake.h5", codes=(0, 4))
    flow = samara.Flow.open(tmp_path / "wake.h5")
    with h5py.File(tmp_path / "wake.h5") as file:
        u, k = file["centre/u"][:].T, file["centre/k"][:].T
        np.testing.assert_allclose(flow.x, file["axes/x"][:])
        np.testing.assert_array_equal(flow.open_share, file["body/open"][:].T)
    body = flow.open_share == 0
    assert body.any() and np.isnan(flow["u"][body]).all()
    np.testing.assert_array_equal(flow["u"][~body], u[~body])
    np.testing.assert_array_equal(flow["k"][~body], k[~body])
    assert list(flow) == list(flow.units) and flow.units["k"] == "U^2" and flow.z is None
    assert flow.summary["reynolds"] == 10000 and flow.summary["message"]
    with pytest.raises(samara.UnknownNameError, match="vorticity"):
        flow["vorticity"]
    times = np.linspace(0, 0.05, 3)
    values = {"diameter": "4 mm", "mass": "20 mg", "x(0)": 0.2}
    assert flow.summary["status"] == "max_time"
    with pytest.warns(UserWarning, match="the flow was not finished: .*max_time"):
        cloud = samara.realise("sphere_flight_in_gusts", values, times, samara.Wake(flow, "2 m/s", "10 cm"), 16, 3)
    assert cloud.mean.shape == (3, 3) and (cloud.mean_error[-1] > 0).all()
    # From beyond the grid, which ends 0.3 m above the body.
    values["z(0)"] = 0.4
    flown = {}
    with pytest.warns(UserWarning, match="not finished"):
        for outside in ("end", "stream"):
            wake = samara.Wake(flow, "2 m/s", "10 cm", outside=outside)
            flown[outside] = samara.realise("sphere_flight_in_gusts", values, times, wake, 16, 3)
    assert set(flown["end"].status) == {"left_flow"} and set(flown["stream"].status) == {"flying"}
    command("simulate", "sphere_flight_in_gusts", *(x for n, v in values.items() for x in ("--set", f"{n}={v}")), "--until", 0.05,
            "--frames", 3, "--flow", tmp_path / "wake.h5", "--speed", "2 m/s", "--length", "10 cm", "--outside", "stream",
            "--realisations", 16, "--seed", 3, "-o", tmp_path / "cloud.h5")
    with h5py.File(tmp_path / "cloud.h5") as file:
        np.testing.assert_array_equal(flown["stream"].mean, file["mean"][:])
    with pytest.raises(samara.ArgumentError, match="outside is 'sides', expected 'end' or 'stream'"):
        samara.realise("sphere_flight_in_gusts", values, times, samara.Wake(flow, 2, 0.1, outside="sides"), 4)
    with pytest.raises(samara.ArgumentError, match="of the type str, expected one of samara.Flow.open"):
        samara.realise("sphere_flight_in_gusts", values, times, samara.Wake("wake.h5", 2, 0.1), 4)


MOTIONS = {
    "model": "immersed_body",
    "fixed": {key: value for key, value in LEAF.items() if key in ("a", "b", "c", "density", "C_D0", "C_w")},
    "axes": {name: {"from": 0.4, "to": 2.6, "count": 3} for name in ("C_D90", "C_T", "C_R")},
    "releases": {"tilt": ["10 deg"], "axis": ["35 deg"]},
    "run": {"until": "2 s", "step": "1 ms", "settle": "0.5 s"},
}


def test_bodies_fall_by_the_motions_of_a_sweep(tmp_path):
    motions = samara.Motions.of(samara.sweep(MOTIONS, progress=False))
    assert motions.starts.shape == (len(motions.kinds), 13) and motions.report["segments"] == len(motions.kinds)
    follows = motions.runs[1:] == motions.runs[:-1]
    np.testing.assert_array_equal(motions.ends[:-1][follows], motions.starts[1:][follows])
    motions.save(tmp_path / "leaf.h5")
    with pytest.raises(samara.InputError, match="cannot write .*none/leaf.h5"):
        motions.save(tmp_path / "none" / "leaf.h5")
    again = samara.Motions.open(tmp_path / "leaf.h5")
    np.testing.assert_array_equal(again.starts, motions.starts)
    places = np.column_stack([np.arange(20.0), np.zeros(20), np.full(20, 1.0)])
    leaves = [samara.Bodies(one, 20, ground=0, wind=wind, step="2 ms", seed=3) for one, wind in [(motions, None), (again, None), (again, [1, 0, 0])]]
    for bodies in leaves:
        assert set(bodies.status) == {"waiting"}
        bodies.release(places, yaw=np.linspace(0, 6, 20))
        bodies.advance("100 ms")
    (still, turned), (same, _), (blown, _) = (bodies.poses() for bodies in leaves)
    np.testing.assert_array_equal(still, same)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1)
    np.testing.assert_allclose(blown - still, np.tile([0.1, 0, 0], (20, 1)), atol=1e-3)
    room = np.empty((20, 3)), np.empty((20, 4))
    for _ in range(600):
        leaves[0].advance(1 / 60)
        positions, _ = leaves[0].poses(*room)
        assert positions is room[0]
    assert leaves[0].falling == 0 and set(leaves[0].status) == {"landed"}
    # Threads take turns.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        list(pool.map(leaves[1].advance, [1 / 60] * 600))
    np.testing.assert_array_equal(leaves[1].poses()[0], positions)
    counts = leaves[0].counts
    assert counts["events"] == counts["drawn"] >= counts["planned"] >= counts["kept"] > 0 and 0 < counts["taken"] + counts["redrawn"] <= counts["drawn"]
    np.testing.assert_allclose(positions[:, 2], 0, atol=1e-12)
    some = samara.Bodies(motions, 5, ground=0)
    some.release([0, 0, 1], bodies=[])
    assert some.falling == 0
    some.release([0, 0, 1], bodies=np.arange(5) >= 3)
    assert list(some.status) == ["waiting"] * 3 + ["falling"] * 2
    for wrong, part in [([True, False], "mask of the shape"), ([0.0, 1.0], "of the type float64"), (["1"], "of the type <U1")]:
        with pytest.raises(samara.ArgumentError, match=part):
            some.release([0, 0, 1], bodies=wrong)
    for places, yaw in [(np.ones((4, 3)), 0.0), (np.ones(2), 0.0), (np.ones((0, 3)), 0.0), (np.ones(3), np.ones(4))]:
        with pytest.raises(samara.ArgumentError, match=r"(places|yaw) of 5 bodies: the shape is .*, expected \((3,)?\) or \(5,( 3)?\)"):
            some.release(places, yaw)
    with pytest.raises(samara.ArgumentError, match="choice is"):
        samara.Bodies(motions, 3, choice="best")
    for more, text in [({"count": 0}, "count is 0, expected a whole number from 1 on"), ({"tries": 9}, "tries is 9"), ({"step": 0}, "step is 0 s"),
                       ({"ramp": -1}, "ramp is -1 s, expected a finite number from 0 on"), ({"seed": None}, "seed is None")]:
        with pytest.raises(samara.ArgumentError, match=text):
            samara.Bodies(motions, **{"count": 1, **more})
    for call, text in [(lambda: some.advance("-1 ms"), "dt is -0.001 s, expected a finite number above 0"),
                       (lambda: some.release([0, 0, np.nan]), "places: a number is nan"),
                       (lambda: some.release([0, 0, 1], yaw=np.inf), "yaw: a number is inf")]:
        with pytest.raises(samara.ArgumentError, match=text):
            call()
    with pytest.raises(samara.InputError, match="no.h5"):
        samara.Motions.open(tmp_path / "no.h5")
