"""Builds wheels by CMake (PEP 517), with nothing but the standard library.

    pip install .                                                  # everything from nothing, for this machine
    pip wheel . --config-settings=cmake=-DSAMARA_MACHINE_FLAGS=    # the same for others
    pip install . --config-settings=build-dir=build/release        # what was built there, with its shared libraries
    pip install -e . --config-settings=build-dir=build/release     # a link to the package in that build
"""

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
NAME = f"{PROJECT['name']}-{PROJECT['version']}"
PYTHON = f"cp{sys.version_info[0]}{sys.version_info[1]}"
TAG = f"{PYTHON}-{PYTHON}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
OPTIONS = ["SAMARA_PYTHON=ON", "SAMARA_UNITY_BUILD=ON", "SAMARA_APPS=OFF", "SAMARA_TESTS=OFF",
           "SAMARA_BENCHMARKS=OFF", "SAMARA_EXAMPLES=OFF", "CMAKE_BUILD_TYPE=Release", "SAMARA_MACHINE_FLAGS=-march=native"]


def metadata():
    extras = [f"Provides-Extra: {extra}\n" + "".join(f'Requires-Dist: {need}; extra == "{extra}"\n' for need in needs)
              for extra, needs in PROJECT["optional-dependencies"].items()]
    return (f"Metadata-Version: 2.1\nName: {PROJECT['name']}\nVersion: {PROJECT['version']}\n"
            f"Summary: {PROJECT['description']}\nRequires-Python: {PROJECT['requires-python']}\n"
            + "".join(f"Requires-Dist: {need}\n" for need in PROJECT["dependencies"]) + "".join(extras)
            + "Description-Content-Type: text/markdown\n\n" + (ROOT / PROJECT["readme"]).read_text())


def cmake(*arguments):
    subprocess.run(["cmake", *map(str, arguments)], check=True, stdout=sys.stderr)


def information_files():
    """What every wheel says of itself, path in the wheel -> bytes."""
    information = f"{NAME}.dist-info"
    return {f"{information}/METADATA": metadata().encode(),
            f"{information}/LICENSE": (ROOT / "LICENSE").read_bytes(),
            f"{information}/WHEEL": f"Wheel-Version: 1.0\nGenerator: samara\nRoot-Is-Purelib: false\nTag: {TAG}\n".encode()}


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Without a build: pip asks for it first, and may then find that a requirement is missing."""
    for path, data in information_files().items():
        target = pathlib.Path(metadata_directory) / path
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(data)
    return f"{NAME}.dist-info"


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


def write_wheel(folder, files):
    """@param files: path in the wheel -> bytes"""
    information = f"{NAME}.dist-info"
    files = {**files, **information_files()}
    record = ""
    name = f"{NAME}-{TAG}.whl"
    with zipfile.ZipFile(os.path.join(folder, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(path, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")
            record += f"{path},sha256={digest},{len(data)}\n"
        wheel.writestr(f"{information}/RECORD", record + f"{information}/RECORD,,\n")
    return name


def installed(build, folder):
    """Files of the component "python", path -> bytes. A wheel has no links: a library is there by the name it is loaded by."""
    cmake("--install", build, "--prefix", folder, "--component", "python")
    files = [f for f in sorted(pathlib.Path(folder).rglob("*")) if f.is_file()]
    behind_links = {f.resolve() for f in files if f.is_symlink()}
    return {str(f.relative_to(folder)): f.read_bytes() for f in files if f.is_symlink() or f.resolve() not in behind_links}


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    settings = config_settings or {}
    with tempfile.TemporaryDirectory() as folder:
        if "build-dir" in settings:
            build = ROOT / settings["build-dir"]
        else:
            build = pathlib.Path(folder) / "build"
            cmake("-G", "Ninja", "-S", ROOT, "-B", build, f"-DPython3_EXECUTABLE={interpreter()}",
                  *(f"-D{option}" for option in OPTIONS), *settings.get("cmake", "").split())
        cmake("--build", build, "--target", "samara_python")
        return write_wheel(wheel_directory, installed(build, os.path.join(folder, "wheel")))


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    build = ROOT / (config_settings or {}).get("build-dir", "build/release")
    cmake("--build", build, "--target", "samara_python")
    return write_wheel(wheel_directory, {"samara.pth": f"{build / 'python'}\n".encode()})


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("sources are distributed by git")


def interpreter():
    """Not that of a virtual environment, beside which there are no headers."""
    real = os.path.realpath(sys.executable)
    return real if os.path.exists(real) else sys.executable
