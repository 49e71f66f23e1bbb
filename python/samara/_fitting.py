"""From captures to coefficients with uncertainty."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _html, _toml
from ._building import Path, Progress, Reported
from ._captures import files_and_tables
from ._codebook import Codebook
from ._errors import ArgumentError, NoResultError, UnknownNameError
from ._labels import optional
from ._models import Model
from ._units import Quantity, check_names, file_in, one_si, real_array, truth


@dataclass(frozen=True)
class Coefficient:
    """A coordinate that all captures share, SI. Errors are None where there is none to give.

    ``interval`` holds 95 %: from the profile, if there is one, else from the standard error, widened for few clusters. An
    end that the profile did not find is infinite; None where it met a better fit elsewhere.
    """

    name: str
    unit: str
    value: float
    standard_error: Optional[float]
    naive_standard_error: Optional[float]
    interval: Optional[tuple[float, float]]
    lower: float
    upper: float
    at_bound: bool
    determined: bool
    verdict: str


@dataclass(frozen=True, eq=False)
class CaptureFit:
    """What the fit made of one capture: frames used, and per output what was measured (NaN if missing) and what the model
    says, SI. ``own`` are its own unknowns by name."""

    id: str
    labels: dict[str, str]
    notes: tuple[str, ...]
    own: dict[str, float]
    times: NDArray[np.float64]
    measured: dict[str, NDArray[np.float64]]
    model: dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit, with its box (infinite where it has none), SI."""

    name: str
    unit: str
    lower: float
    upper: float


def _array(values: Any) -> NDArray[np.float64]:
    """JSON's null is no number."""
    return np.array(values, dtype=float)


class FitResult:
    """Coefficients with uncertainty, what may be said of them, and what was minimised.

    ``status`` is "converged", "not_determined", "max_iterations" or "failed": outcomes are no exceptions. ``raw`` is all
    of it, as ``samara fit --json`` prints it.
    """

    def __init__(self, fit: _core.Fit) -> None:
        """Not to be called: see ``samara.fit``."""
        self._fit = fit
        self.raw: dict[str, Any] = json.loads(fit.json())
        series = fit.series_json()
        self.series: Optional[dict[str, Any]] = None if series is None else json.loads(series)
        """Coefficients that change in time, where the config asks for some."""
        self._coefficients = {
            c["name"]: self._coefficient(c, widened)
            for c, widened in zip(self.raw["coefficients"], fit.widened_errors)
        }
        self._unknowns: Optional[tuple[Unknown, ...]] = None

    @property
    def is_usable(self) -> bool:
        """Converged, with every coefficient determined."""
        return self._fit.is_usable

    @property
    def status(self) -> str:
        return str(self.raw["status"])

    @property
    def message(self) -> str:
        return self._fit.message

    @property
    def warnings(self) -> tuple[str, ...]:
        return tuple(self.raw["warnings"])

    def __getitem__(self, name: str) -> Coefficient:
        """One coefficient by name; ``coefficients`` is the table of all.

        :raises NoResultError: where the fit has none, as no start succeeded
        """
        if not self._coefficients and self.status == "failed":
            raise NoResultError(f'there is no coefficient "{name}", for the fit has the status "{self.status}": {self.message}')
        check_names([name], list(self._coefficients), "coefficient", UnknownNameError)
        return self._coefficients[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._coefficients)

    @property
    def coefficients(self) -> Any:
        """A pandas.DataFrame with a row for each coefficient, by name: value, standard error, interval, verdict .. as in
        ``Coefficient``. NaN where there is nothing to give.

        :raises MissingPackageError: (an ``ImportError``) without pandas; ``result["C_D"]`` needs none
        """
        rows = [{**vars(c), "interval_lower": c.interval[0] if c.interval else np.nan,
                 "interval_upper": c.interval[1] if c.interval else np.nan} for c in self._coefficients.values()]
        columns = ["name", "unit", "value", "standard_error", "interval_lower", "interval_upper", "verdict",
                   "naive_standard_error", "lower", "upper", "at_bound", "determined"]
        table = optional("pandas").DataFrame(rows, columns=columns).set_index("name")
        return table.astype({"standard_error": float, "naive_standard_error": float})

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Of the coefficients, from the scatter between clusters of captures where there are two or more."""
        return _array(self.raw["covariance"])

    @property
    def correlation(self) -> NDArray[np.float64]:
        return _array(self.raw["correlation"])

    @property
    def profiles(self) -> dict[str, dict[str, Any]]:
        """By coefficient, where they were asked for."""
        return {p["name"]: p for p in self.raw["profiles"]}

    @property
    def captures(self) -> tuple[CaptureFit, ...]:
        return tuple(
            CaptureFit(
                c["id"],
                c["labels"],
                tuple(c["notes"]),
                {n["name"]: n["value"] for n in c["nuisances"]},
                _array(c["times"]),
                {name: _array(o["measured"]) for name, o in c["outputs"].items()},
                {name: _array(o["model"]) for name, o in c["outputs"].items()},
            )
            for c in self.raw["captures"]
        )

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """All unknowns of the fit: the coefficients, then those of each capture. The order of ``q`` below."""
        if self._unknowns is None:
            self._unknowns = tuple(Unknown(**u) for u in self._fit.unknowns())
        return self._unknowns

    @property
    def answer(self) -> NDArray[np.float64]:
        """Where the fit ended, (unknowns,)."""
        return self._fit.answer()

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper ends of the unknowns, as scipy takes them."""
        return np.array([u.lower for u in self.unknowns]), np.array([u.upper for u in self.unknowns])

    @property
    def middle(self) -> NDArray[np.float64]:
        """The middle of the box; 0 where there is none."""
        lower, upper = self.bounds
        is_boxed = np.isfinite(lower) & np.isfinite(upper)
        return np.where(is_boxed, 0.5 * (np.where(is_boxed, lower, 0) + np.where(is_boxed, upper, 0)), 0.0)

    def residuals(self, q: ArrayLike) -> NDArray[np.float64]:
        """(residuals,): half the sum of their squares is the cost that the fit minimised, its loss and priors included.

        ``scipy.optimize.least_squares(fit.residuals, fit.middle, fit.jacobian, fit.bounds)`` is the same fit. NaN where
        there is no trajectory, or an output is no finite number.
        """
        return self._fit.residuals(real_array(q, "unknowns"))

    def jacobian(self, q: ArrayLike) -> NDArray[np.float64]:
        """Exact derivatives of the residuals, (residuals, unknowns). NaN where there are no residuals; not finite where an output
        has no derivative."""
        return self._fit.jacobian(real_array(q, "unknowns"))

    def log_posterior(self, q: ArrayLike, gradient: bool = False) -> Any:
        """Logarithm of the density of the unknowns, but for a constant; with ``gradient`` a pair with it (unknowns,).

        The noise is that of the residuals at the answer; uniform in the box, -infinity outside it, and where there are no
        residuals. The gradient is not finite where an output has no derivative.
        """
        return self._fit.log_posterior(real_array(q, "unknowns"), truth(gradient, "gradient"))

    def report(self, path: Path) -> None:
        """Writes the page for the browser, complete in one file.

        :raises InputError: (an ``OSError``) where it cannot be written
        """
        _html.write_page(path, self._fit.html())

    def series_codebook(self) -> Codebook:
        """The series as a codebook over time, for ``samara simulate --coefficients``."""
        return Codebook(self._fit.series_book())

    def plot(self, axes: Any = None) -> Any:
        """Captures and model over time with matplotlib, a row for each output; returns the axes."""
        pyplot = optional("matplotlib.pyplot")
        captures = self.captures
        outputs = list(dict.fromkeys(o for c in captures for o in c.measured))
        if axes is None:
            _, axes = pyplot.subplots(len(outputs), 1, sharex=True, squeeze=False)
        units = {r["output"]: r["unit"] for r in self.raw["residuals"]}
        for row, output in zip(np.ravel(axes), outputs):
            for c in captures:
                if output in c.measured:
                    (line,) = row.plot(c.times, c.measured[output], ".", label=c.id)
                    row.plot(c.times, c.model[output], "-", color=line.get_color())
            row.set_ylabel(f"{output} [{units.get(output, '1')}]")
        np.ravel(axes)[-1].set_xlabel("t [s]")
        return axes

    def __str__(self) -> str:
        return self._fit.text()

    def __repr__(self) -> str:
        values = ", ".join(f"{c.name} {c.verdict}" for c in self._coefficients.values())
        return f"<samara.FitResult {self.status}: {values}>"

    def _repr_html_(self) -> str:
        return _html.fit(self, self._coefficients.values())

    def _coefficient(self, c: dict[str, Any], widened: Optional[float]) -> Coefficient:
        interval = None if widened is None else (c["value"] - 2.0 * widened, c["value"] + 2.0 * widened)
        profile = self.profiles.get(c["name"])
        if profile is not None and profile["better"] is not None:
            interval = None
        elif profile is not None:
            lower, upper = profile["interval"]
            interval = (-np.inf if lower is None else lower, np.inf if upper is None else upper)
        return Coefficient(
            c["name"],
            c["unit"],
            c["value"],
            c["standard_error"],
            c["naive_standard_error"],
            interval,
            c["lower"],
            c["upper"],
            c["at_bound"],
            c["determined"],
            c["verdict"],
        )


def _files(given: Any, what: str) -> list[str]:
    """Names of files; one alone may stand for itself."""
    is_one = isinstance(given, (str, os.PathLike, Mapping)) or hasattr(given, "columns") or not isinstance(given, Iterable)
    files = [given] if is_one else list(given)
    for file in files:
        if not isinstance(file, (str, os.PathLike)):
            raise ArgumentError(f"{what} has one of the type {type(file).__name__}, expected files of captures")
    return [os.fspath(file) for file in files]


def fit(
    source: Union[Codebook, Model, Path],
    captures: Any,
    config: Union[Mapping[str, Any], Path, None] = None,
    *,
    span: Optional[Quantity] = None,
    left_out: Union[Path, Sequence[Path]] = (),
    left_out_span: Optional[Quantity] = None,
    ahead: Optional[Quantity] = None,
    sidecar: Optional[Path] = None,
    coefficients: Optional[Path] = None,
    reference: bool = False,
    profiles: bool = False,
    progress: Progress = False,
) -> FitResult:
    """Fits coefficients to captures, as ``samara fit`` does.

    ::

        result = samara.fit(book, ["coin.toml"], {"span": "0.4 s", "outputs": ["x"], "cluster_by": ["drop"]})
        result = samara.fit("vertical_fall", frame, {"box": {"C_D": [0.6, 2.0]}, "fixed": {...}})

    :param source: a codebook, or its file; a model: a name, a file of equations, or a ``Model``
    :param captures: files (tables, or sidecars), or pandas.DataFrames with columns as ``t[s]``, ``x[m]``, or a mapping
        of id to frame, or of id to a mapping of such columns; one of them, or several
    :param config: a file, or a dictionary with the same keys (docs/reference/fit_config.md)
    :param span: of each capture, from its first frame
    :param left_out: files of captures to predict, or one, ``ahead`` of what is seen of them
    :param coefficients: JSON of another fit, where this one begins
    :param reference: integrate the equations of a codebook instead of asking it
    :param profiles: of the coefficients
    :param progress: as of ``samara.build``; told between starts, where Ctrl-C ends the fit, too
    :raises InputError: naming the file for everything wrong in one
    """
    book = source._book if isinstance(source, Codebook) else None
    model = source if isinstance(source, Model) else None
    if book is None and model is None and not isinstance(source, (str, os.PathLike)):
        raise ArgumentError(f"the source is of the type {type(source).__name__}, expected a codebook, a model, or the file of one")
    if config is not None and not isinstance(config, (str, os.PathLike, Mapping)):
        raise ArgumentError(f"the config is of the type {type(config).__name__}, expected a file or a dictionary")
    files, measured = files_and_tables(captures)
    has_table = isinstance(config, Mapping)
    request = {
        "source": "" if book is not None or model is not None else os.fspath(source),  # type: ignore[arg-type]
        "captures": files,
        "measured": measured,
        "left_out": _files(left_out, "left_out"),
        "sidecar": file_in(sidecar, "sidecar"),
        "config": "" if config is None or has_table else os.fspath(config),  # type: ignore[arg-type]
        "config_text": _toml.dumps(config) if has_table else "",  # type: ignore[arg-type]
        "coefficients": file_in(coefficients, "coefficients"),
        "span": None if span is None else one_si(span, "s", "span"),
        "left_out_span": None if left_out_span is None else one_si(left_out_span, "s", "left_out_span"),
        "ahead": None if ahead is None else one_si(ahead, "s", "ahead"),
        "reference": truth(reference, "reference"),
        "profiles": truth(profiles, "profiles"),
    }
    with Reported(progress) as report:
        made = _core.fit(request, book, model, report)
    return FitResult(made)
