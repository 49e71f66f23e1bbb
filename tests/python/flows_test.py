"""Winds, clouds, flows and wakes, beside the command."""

import os
import re

import h5py
import numpy as np
import pytest

import samara
from conftest import LEAF, MEADOW, command


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
    # Of a mean that was not reached.
    assert all(flow.summary[name] is None for name in ["drag_half_width", "drag_rms", "lift_rms", "strouhal"])
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
