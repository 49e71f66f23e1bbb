"""What the tests of the Python package share: codebooks, and the command, whose answers are the reference."""

import json
import os
import pathlib
import subprocess

import numpy as np
import pytest

import samara

ROOT = pathlib.Path(__file__).resolve().parents[2]
COIN = ROOT / "examples" / "coin"
COMMAND = os.environ["SAMARA"]

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


def command(*arguments, codes=(0,)):
    result = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert result.returncode in codes, result.stderr
    return result


def answer(*arguments):
    """JSON of the command."""
    return json.loads(command(*arguments, "--json").stdout)


def interrupted(call, folder, beyond=None):
    """A call that cannot write its checkpoint, and is interrupted after its first warning, or beyond a share of the work."""
    with pytest.warns(UserWarning, match="no checkpoint: cannot write .*none/x.checkpoint") as told:
        def progress(stage, fraction):
            if told if beyond is None else fraction > beyond:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            call(progress=progress, checkpoint=folder / "none" / "x.checkpoint")
    return told


@pytest.fixture(scope="session")
def coin_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("books") / "coin.h5"
    command("build", COIN / "plan.toml", "-o", path)
    return path


@pytest.fixture(scope="session")
def coin(coin_path):
    return samara.Codebook.open(coin_path)


@pytest.fixture(scope="session")
def product():
    """A codebook without time: u = a b, v = 1 + a."""
    return samara.separate(
        lambda x: np.stack([x[:, 0] * x[:, 1], 1 + x[:, 0]], 1),
        {"a": (-1, 2), "b": (0, 1)},
        {"u": "m", "v": "1"},
        tolerance=1e-6,
        units={"a": "m"},
    )
