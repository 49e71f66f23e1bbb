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
from ._errors import ArgumentError, Error, InputError, MissingPackageError, NoResultError, OutsideBoxError, UnknownNameError
from ._building import build, separate
from ._codebook import Codebook
from ._contents import (Axis, Build, Certificate, Coordinate, Front, Group, ModelInfo, Output, OutputError, Parameter, Piece, State,
                        Statistics)
from ._fitting import CaptureFit, Coefficient, FitResult, Unknown, fit
from ._bodies import Bodies, Motions
from ._flows import Cloud, Flow, Turbulence, Wake, Wind, realise
from ._models import Model, Simulation, models, simulate
from ._pattern_tools import Agreement, Clusters, adjusted_rand, agreement, gaussian_mixture, k_means
from ._motion import (
    FEATURES,
    PATTERNS,
    Feature,
    Label,
    Patterns,
    Record,
    Regime,
    Window,
    pattern_thresholds,
    patterns,
    records,
    regime,
)
from ._sweeps import Sweep, sweep

__all__ = [
    "Agreement",
    "ArgumentError",
    "Axis",
    "Bodies",
    "Build",
    "CaptureFit",
    "Certificate",
    "Cloud",
    "Clusters",
    "Codebook",
    "Coefficient",
    "Coordinate",
    "Error",
    "FEATURES",
    "Feature",
    "FitResult",
    "Flow",
    "Front",
    "Group",
    "InputError",
    "Label",
    "MissingPackageError",
    "Model",
    "ModelInfo",
    "Motions",
    "NoResultError",
    "Output",
    "OutputError",
    "OutsideBoxError",
    "PATTERNS",
    "Parameter",
    "Patterns",
    "Piece",
    "Record",
    "Regime",
    "Simulation",
    "State",
    "Statistics",
    "Sweep",
    "Turbulence",
    "Unknown",
    "UnknownNameError",
    "Wake",
    "Wind",
    "Window",
    "__version__",
    "adjusted_rand",
    "agreement",
    "build",
    "fit",
    "gaussian_mixture",
    "k_means",
    "models",
    "pattern_thresholds",
    "patterns",
    "realise",
    "records",
    "regime",
    "separate",
    "simulate",
    "sweep",
]
