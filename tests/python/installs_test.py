"""The package as pip installs it from a build, without a network, and what an import takes."""

import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["SAMARA_BUILD"])

USE = """
import samara, numpy
book = samara.separate(lambda x: x[:, 0] * x[:, 1], {"a": (0, 1), "b": (0, 2)}, ["u"], 1e-3)
assert abs(book.query({"a": 0.5, "b": 0.5})[0] - 0.25) < 1e-2
print(samara.__file__)
print(samara.__version__)
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    sys.path.insert(0, str(ROOT / "python" / "backend"))
    import samara_backend as backend

    folder = tmp_path_factory.mktemp("wheel")
    return folder / backend.build_wheel(folder, {"build-dir": str(BUILD)})


def test_a_wheel_stands_alone(wheel, tmp_path):
    import zipfile

    place = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    run = subprocess.run([sys.executable, "-c", USE], env={**environment, "PYTHONPATH": str(place)}, cwd=tmp_path,
                         capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines() == [str(place / "samara" / "__init__.py"), "0.1.0"]
    loaded = subprocess.run(["ldd", *place.glob("samara/_core*.so")], capture_output=True, text=True).stdout
    ours = [line for line in loaded.splitlines() if "libsamara" in line]
    assert all(str(place) in line for line in ours), ours


def test_pip_installs_it_offline(tmp_path):
    if subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True).returncode != 0:
        pytest.skip("pip is not installed")
    run = subprocess.run(
        [sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--quiet", "--target", tmp_path / "site",
         "--config-settings", f"build-dir={BUILD}", ROOT], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    used = subprocess.run([sys.executable, "-c", USE], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert used.returncode == 0 and str(tmp_path) in used.stdout, used.stderr


def test_metadata_come_without_a_build(tmp_path):
    import samara_backend as backend

    name = backend.prepare_metadata_for_build_wheel(tmp_path)
    written = (tmp_path / name / "METADATA").read_text()
    assert "\nRequires-Dist: numpy>=1.24\n" in written and written == backend.metadata()


def test_an_import_loads_no_optional_package():
    code = "import sys, samara; print([m for m in ('pandas', 'xarray', 'matplotlib', 'scipy', 'IPython') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "[]"
