"""Parametric solution codebooks of dynamical systems: build, ask, fit.

::

    import samara

    book = samara.build("plan.toml")                      # or samara.Codebook.open("coin.h5")
    v, dv = book.query({"C_D": 1.15, "v(0)": "10 cm/s"}, times=[0.1, 0.2], gradient=True)
    result = samara.fit(book, ["coin.toml"], "fit.toml")
    print(result["C_D"])

Numbers are in SI; where one is expected, a text with a unit will do. Errors are Python's own kinds, too: see ``samara.Error``.
"""

from ._core import __version__
from ._errors import ArgumentError, Error, InputError, MissingPackageError, NoResultError, OutsideBoxError
from ._building import build, separate
from ._codebook import Codebook
from ._contents import Axis, Build, Certificate, Coordinate, Group, Output, OutputError, Piece, Statistics
from ._fitting import CaptureFit, Coefficient, FitResult, Unknown, fit
from ._models import Model, ModelInfo, Parameter, Simulation, State, models, simulate

__all__ = [
    "ArgumentError",
    "Axis",
    "Build",
    "CaptureFit",
    "Certificate",
    "Codebook",
    "Coefficient",
    "Coordinate",
    "Error",
    "FitResult",
    "Group",
    "InputError",
    "MissingPackageError",
    "Model",
    "ModelInfo",
    "NoResultError",
    "Output",
    "OutputError",
    "OutsideBoxError",
    "Parameter",
    "Piece",
    "Simulation",
    "State",
    "Statistics",
    "Unknown",
    "__version__",
    "build",
    "fit",
    "models",
    "separate",
    "simulate",
]
