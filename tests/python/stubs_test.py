"""What stubs and annotations say, against the module."""

import ast
import inspect
import pathlib
import re
import subprocess
import sys
import tomllib

import pytest

import samara
from samara import _core

PACKAGE = pathlib.Path(samara.__file__).parent
STUB = ast.parse((PACKAGE / "_core.pyi").read_text())


def arguments_of(function):
    """Names of a function of the extension module, by the first line that pybind11 writes of it."""
    head = function.__doc__.splitlines()[0]
    while "[" in head:
        head = re.sub(r"\[[^\[\]]*\]", "", head)  # types inside types
    return re.findall(r"(?:^|[(,] ?)(\w+)(?=: |[,)])", head[head.index("("):].split(" -> ")[0])


def declared(node):
    return [a.arg for a in (*node.args.args, *node.args.kwonlyargs)]


def functions(nodes):
    return {n.name: n for n in nodes if isinstance(n, ast.FunctionDef)}


def test_the_stub_names_what_the_module_has():
    classes = {n.name: n for n in STUB.body if isinstance(n, ast.ClassDef)}
    public = {n for n in dir(_core) if not n.startswith("_")}
    assert public == set(functions(STUB.body)) | set(classes)
    for name, node in functions(STUB.body).items():
        assert declared(node) == arguments_of(getattr(_core, name)), name
    for name, node in classes.items():
        found = {n for n in vars(getattr(_core, name)) if not n.startswith("_")}
        assert found == set(functions(node.body)), name
        for method, of in functions(node.body).items():
            member = inspect.getattr_static(getattr(_core, name), method)
            if isinstance(member, property):
                continue
            names = [a for a in arguments_of(getattr(getattr(_core, name), method)) if a != "self"]
            assert [a for a in declared(of) if a != "self"] == names, (name, method)


def test_the_version_is_that_of_the_project():
    project = tomllib.loads((pathlib.Path(__file__).resolve().parents[2] / "pyproject.toml").read_text())["project"]
    assert samara.__version__ == project["version"]


def test_everything_public_is_documented():
    for name in samara.__all__:
        thing = getattr(samara, name)
        if callable(thing):
            assert inspect.getdoc(thing), name
    assert (PACKAGE / "py.typed").exists()


def check_types(*what):
    pytest.importorskip("mypy")
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir=/dev/null", *what],
                         cwd=PACKAGE.parent, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


def test_annotations_hold():
    check_types("-p", "samara")


CALLS = """
import numpy as np
import samara
def call(book: samara.Codebook, swept: samara.Sweep, result: samara.FitResult) -> float:
    falls, kinds = swept.clusters(3, ["tilt", "flips"])
    swept.at({"inertia_ratio": 1.1, "C_R": 2.5})
    swept.clamp("zigzag", {"inertia_ratio": [1.1, 2.0], "C_R": 2.5})
    book.sobol(quantiles=np.array([0.1]))
    print([name.upper() for name in result])
    return samara.adjusted_rand(swept.labels[falls], kinds.assignment) + samara.adjusted_rand(["a", "b"], [0, 1])
"""


def test_annotations_take_what_is_given(tmp_path):
    (tmp_path / "calls.py").write_text(CALLS)
    check_types(str(tmp_path / "calls.py"))
