"""What codebooks and models consist of, as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Optional, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._units import Quantity, finite, one_si, text_in


@dataclass(frozen=True)
class Coordinate:
    """One coordinate of a codebook, with its box in SI."""

    name: str
    unit: str
    role: str
    lower: float
    upper: float


@dataclass(frozen=True)
class Output:
    """What a codebook gives, in SI."""

    name: str
    unit: str


@dataclass(frozen=True)
class OutputError:
    """How far one output is from the independent integrator, over ``range`` unless it says SI."""

    name: str
    unit: str
    range: float
    max: float
    p95: float
    mean: float
    rms: float
    max_si: float
    worst: dict[str, float]


@dataclass(frozen=True)
class Certificate:
    """The measured error of a codebook on points that no builder saw."""

    met: bool
    verdict: str
    tolerance: float
    max_error: float
    points: int
    times: int
    failed_points: int
    wrong_points: Optional[int]
    share_above: Optional[float]
    climbed_points: int
    refuted_before: int
    seed: int
    integrator: str
    integrator_tolerance: float
    residual: float
    spent: dict[str, float]
    """Of the tolerance, by the builder: discretisation, compression, nonlinearity."""
    norm_defect: Optional[dict[str, float]]
    """How far stored quaternions are from their length, largest and root mean square."""
    outputs: dict[str, OutputError] = field(repr=False)


@dataclass(frozen=True)
class Build:
    """How the builder went."""

    builder: str
    strategy: str
    status: str
    message: str
    evaluations: float
    grid_size: float
    iterations: int
    rounds: int


@dataclass(frozen=True)
class Statistics:
    """Mean, deviation, Sobol' indices and quantiles at ``times``, of inputs that are independent.

    Arrays by output: ``mean`` and ``deviation`` (times,), SI; ``first_order`` and ``total`` (times, inputs), NaN where
    the certificate does not stand for them; ``group_closed`` and ``group_total`` (times, groups); ``quantiles`` (times,
    shares). Without time there is one row.
    """

    inputs: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    times: NDArray[np.float64]
    mean: dict[str, NDArray[np.float64]]
    deviation: dict[str, NDArray[np.float64]]
    first_order: dict[str, NDArray[np.float64]]
    total: dict[str, NDArray[np.float64]]
    group_closed: dict[str, NDArray[np.float64]]
    group_total: dict[str, NDArray[np.float64]]
    quantiles: dict[str, NDArray[np.float64]]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Group:
    """Outputs in one separated form, as read-only views of the codebook's own memory.

    A sum of products has ``factors``, per axis (nodes, terms), and ``weights`` (outputs, terms): u_m = sum_r weights[m, r]
    prod_k factors[k][:, r]. A train has ``cores`` (left, size, right), the first over the outputs.
    """

    kind: str
    outputs: tuple[str, ...]
    factors: tuple[NDArray[np.float64], ...] = ()
    weights: Optional[NDArray[np.float64]] = None
    cores: tuple[NDArray[np.float64], ...] = ()


@dataclass(frozen=True)
class Axis:
    """One axis of a piece; ``nodes`` in SI."""

    name: str
    basis: str
    transform: str
    nodes: NDArray[np.float64]


@dataclass(frozen=True)
class Front:
    """From which a coordinate is counted on its axis: on [-1, 1] by (X - G) / (1 - G X), G the place of the front.

    ``place`` holds the coefficients of G, products of Chebyshev polynomials of the ``others``, as many of each as is said
    with its name, the first fastest.
    """

    coordinate: str
    others: tuple[tuple[str, int], ...]
    place: NDArray[np.float64]


@dataclass(frozen=True)
class Piece:
    """One time slab of one cell of the box."""

    axes: tuple[Axis, ...]
    groups: tuple[Group, ...]
    front: Optional[Front] = None


def certificate_of(given: Optional[dict[str, Any]], coordinates: Sequence[Coordinate]) -> Optional[Certificate]:
    if given is None:
        return None
    names = [c.name for c in coordinates]
    outputs: dict[str, OutputError] = {}
    for o in given["outputs"]:
        numbers: dict[str, Any] = {**o, "worst": dict(zip(names, o["worst"]))}
        outputs[o["name"]] = OutputError(**numbers)
    entries: dict[str, Any] = {**given, "outputs": outputs}
    return Certificate(**entries)


@dataclass(frozen=True)
class State:
    """A state of a model. ``initial`` is its default at t = 0; ``scale`` its characteristic size. SI, or with a unit."""

    name: str
    unit: str = "1"
    initial: Quantity = 0.0
    description: str = ""
    scale: Quantity = None


@dataclass(frozen=True)
class Parameter:
    """A parameter of a model, SI or with a unit. Without a ``default`` it must be given."""

    name: str
    unit: str = "1"
    default: Quantity = None
    description: str = ""
    lower: Quantity = None
    upper: Quantity = None
    derived: Optional[str] = None


_Described = TypeVar("_Described", State, Parameter)


def in_si(given: _Described) -> _Described:
    """With numbers in SI, which are finite but for bounds."""
    numbers: dict[str, Any] = {}
    for what, value in vars(given).items():
        told = f"{what} of {given.name}"
        if what in ("name", "unit", "description"):
            text_in(value, told)
        elif what == "initial" or (what != "derived" and value is not None):
            number = one_si(value, given.unit, told, above=0 if what == "scale" else None)
            if not (what in ("lower", "upper") and np.isinf(number)):
                finite(np.asarray(number), told)
            numbers[what] = number
    return replace(given, **numbers)


@dataclass(frozen=True)
class ModelInfo:
    """What ``samara models NAME`` says. ``outputs`` follow from the states; a field of space has none, and its field is a state."""

    name: str
    title: str
    equations: str
    frames: str
    source: str
    validity: str
    symmetries: tuple[str, ...]
    time_unit: str
    states: tuple[State, ...]
    parameters: tuple[Parameter, ...]
    outputs: tuple[Output, ...]
    affine_in: tuple[str, ...]
    force_terms: dict[str, str]
