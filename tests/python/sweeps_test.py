"""Sweeps, their maps, and bodies that fall by their motions, beside the command."""

import concurrent.futures

import h5py
import numpy as np
import pytest

import samara
from conftest import LEAF, PLATES, answer, command, interrupted


def test_a_sweep_is_that_of_the_command(tmp_path):
    swept = samara.sweep(PLATES, progress=False)
    assert swept.complete and swept.points.shape == (27, 2) and swept.features.shape == (54, len(samara.FEATURES))
    swept.save(tmp_path / "mine.h5")
    with pytest.raises(samara.ArgumentError, match=r"HDF5 is written; a name that ends in \.h5 was expected"):
        swept.save(tmp_path / "mine.csv")
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


def test_a_sweep_that_is_ended_keeps_what_was_done_and_its_file_says_so(tmp_path):
    plan = {**PLATES, "axes": {"inertia_ratio": {"from": 0.8, "to": 2.4, "count": 900}, "C_R": [2.2, 2.7, 3.2]}}
    ended = samara.sweep(plan, progress=lambda stage, fraction: fraction < 0.3, threads=1)
    assert not ended.complete and "cancelled" in ended.message
    assert 0 < len(ended.labels) < 5400 and len(ended.labels) == len(ended.features)
    ended.save(tmp_path / "ended.h5")
    opened = samara.Sweep.open(tmp_path / "ended.h5")
    assert not opened.complete and opened.message == f"cancelled after {len(opened.labels)} of 5400 falls"
    assert opened.message == ended.message
    done = len(ended.labels) // 2
    shares = opened.shares()
    assert shares.shape == (2700, 8) and np.isnan(shares[done:]).all()
    np.testing.assert_allclose(shares[:done].sum(axis=1), 1)
    refined = samara.sweep({**PLATES, "refine": {"rounds": 1}}, progress=False)
    assert [points for points, *_ in refined.rounds] == [27, 17 * 5]
    assert refined.rounds[0][1] == 27 and refined.rounds[1][1] == (refined.status[::2] != "inherited").sum()
    # The points of the plan are of round 0, in the file as well.
    refined.save(tmp_path / "refined.h5")
    again = samara.Sweep.open(tmp_path / "refined.h5")
    assert again.complete and again.rounds == refined.rounds
    assert list(np.bincount(again.round_of_point)) == [27, 17 * 5 - 27]
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


MOTIONS = {
    "model": "immersed_body",
    "fixed": {key: value for key, value in LEAF.items() if key in ("a", "b", "c", "density", "C_D0", "C_w")},
    "axes": {name: {"from": 0.4, "to": 2.6, "count": 3} for name in ("C_D90", "C_T", "C_R")},
    "releases": {"tilt": ["10 deg"], "axis": ["35 deg"]},
    "run": {"until": "2 s", "step": "1 ms", "settle": "0.5 s"},
}


@pytest.fixture(scope="module")
def motions():
    return samara.Motions.of(samara.sweep(MOTIONS, progress=False))


def test_a_wind_is_one_velocity_for_all_bodies(motions):
    for wind in (np.ones((2, 3)), np.ones((1, 3)), np.ones((0, 3)), np.ones(2), 1.0):
        with pytest.raises(samara.ArgumentError, match=r"wind has the shape \(.*\), expected \(3,\)"):
            samara.Bodies(motions, 2, wind=wind)


def test_bodies_are_let_go_all_or_none(motions):
    bodies = samara.Bodies(motions, 3)
    for numbers, text in [([0, 1, 7], "there is no body 7, expected 0 to 2"), ([0, -1], "there is no body -1"),
                          ([[0, 1]], r"bodies have the shape \(1, 2\), expected \(bodies,\)")]:
        with pytest.raises(samara.ArgumentError, match=text):
            bodies.release([0, 0, 2.0], bodies=numbers)
        assert set(bodies.status) == {"waiting"}


def test_what_is_no_sweep_and_no_motions_is_refused_by_its_type(motions):
    for call, text in [(lambda: samara.Motions.of(motions), "sweep is of the type Motions, expected a samara.Sweep"),
                       (lambda: samara.Motions.of("s.h5"), "sweep is of the type str"),
                       (lambda: samara.Bodies("m.h5", 2), "motions are of the type str, expected samara.Motions"),
                       (lambda: samara.Bodies(samara.sweep(PLATES, False), 2), "motions are of the type Sweep")]:
        with pytest.raises(samara.ArgumentError, match=text):
            call()


def test_bodies_fall_by_the_motions_of_a_sweep(motions, tmp_path):
    assert motions.starts.shape == (len(motions.kinds), 13) and motions.report["segments"] == len(motions.kinds)
    follows = motions.runs[1:] == motions.runs[:-1]
    np.testing.assert_array_equal(motions.ends[:-1][follows], motions.starts[1:][follows])
    motions.save(tmp_path / "leaf.h5")
    with pytest.raises(samara.ArgumentError, match=r"HDF5 is written; a name that ends in \.h5 was expected"):
        motions.save(tmp_path / "leaf.csv")
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
    low = samara.Bodies(motions, 2, ground=0)
    with pytest.raises(samara.ArgumentError, match="^body 1 starts at a height of -1 m, expected above the ground at 0 m$"):
        low.release([[0, 0, 1], [0, 0, -1]])
    assert set(low.status) == {"waiting"}
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
