"""Codebooks from plans and from functions."""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core, _toml
from ._codebook import Codebook
from ._errors import ArgumentError, in_words_of_python
from ._identity import identity
from ._models import Model
from ._units import (
    Quantity, as_mapping, by_name, check_names, counted, file_in, names_in, one_si, text_in, truth, unmasked, whole,
)

if TYPE_CHECKING:
    from concurrent.futures import Executor

Report = Callable[[str, float], Optional[bool]]
Progress = Union[bool, Report]
Path = Union[str, "os.PathLike[str]"]


class ProgressLine:
    """One line on stderr that overwrites itself; nothing where stderr is neither a terminal nor a notebook's."""

    def __init__(self) -> None:
        self._is_shown = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._last = 0.0
        self._width = 0

    def __call__(self, stage: str, fraction: float) -> None:
        now = time.monotonic()
        if not self._is_shown or now - self._last < 0.1:
            return
        self._last = now
        line = f"{stage}: {100 * fraction:3.0f} %"
        sys.stderr.write("\r" + line.ljust(self._width))
        sys.stderr.flush()
        self._width = len(line)

    def clear(self) -> None:
        if self._width:
            sys.stderr.write("\r" + " " * self._width + "\r")
            sys.stderr.flush()


class Reported:
    """What the library is to tell of progress, as a context; and of what is to be warned of, when it happens."""

    def __init__(self, progress: Progress) -> None:
        if not callable(progress) and not isinstance(progress, (bool, np.bool_)):
            raise ArgumentError(f"progress is {progress!r}, expected True, False or a function of (stage, fraction)")
        self._line = None if callable(progress) or not progress else ProgressLine()
        self._report = progress if callable(progress) else self._line

    def __enter__(self) -> Any:
        return self._report

    def __exit__(self, kind: object, error: Optional[BaseException], trace: object) -> None:
        if self._line:
            self._line.clear()

    def warn(self, sentence: str) -> None:
        """Warns the caller of the function that has this context, which the library tells from the same thread (calls.h)."""
        if self._line:
            self._line.clear()
        warnings.warn(in_words_of_python(sentence), stacklevel=3)


def build(
    plan: Union[Path, Mapping[str, Any]],
    model: Optional[Model] = None,
    progress: Progress = True,
    *,
    checkpoint: Optional[Path] = None,
    resume: bool = True,
    certificate_points: Optional[int] = None,
) -> Codebook:
    """The codebook of a plan, with its certificate (docs/plans.md says what plans may hold).

    :param plan: a file, or a dictionary with the same keys; quantities are SI numbers or texts with a unit
    :param model: of your own, in place of the one that the plan names
    :param progress: a line on stderr; or a function of (stage, fraction), which ends the build by returning False: what
        there is then is a codebook whose certificate is not met
    :param checkpoint: a file that keeps the state between rounds, and is removed in the end. Ctrl-C raises
        ``KeyboardInterrupt`` and leaves it: the same call goes on from there, unless ``resume`` is False. Where it cannot
        be told whether a function is the same, the build warns and begins anew
    :param certificate_points: in place of what the plan asks for
    :returns: a codebook also where it misses its tolerance: ``certificate.met`` says so
    :raises InputError: for a plan that cannot be one, and a checkpoint of another plan or function, or a file that is none
    :raises NoResultError: where the build ends before anything is solved
    """
    definition = None if model is None else model
    if definition is not None and not isinstance(definition, Model):
        raise ArgumentError(f"the model is of the type {type(definition).__name__}, expected a samara.Model")
    if isinstance(plan, Mapping):
        if definition is not None:
            plan = {**plan, "model": plan.get("model", definition.name)}
        path, text = None, _toml.dumps(plan)
    elif isinstance(plan, (str, os.PathLike)):
        path, text = os.fspath(plan), ""
    else:
        raise ArgumentError(f"the plan is of the type {type(plan).__name__}, expected a file, or a dictionary with the same keys")
    certificate_points = whole(certificate_points, "certificate_points", least=1)
    resume, kept = truth(resume, "resume"), file_in(checkpoint, "checkpoint")
    if definition is not None:
        # Behind the plan: errors name its lines.
        comment, resume = _fingerprint(
            definition.rhs, kept, resume, definition.jacobian, repr(definition.states), repr(definition.parameters)
        )
        text += comment
    reporter = Reported(progress)
    with reporter as report:
        book, _, message = _core.build(
            path, text, definition, report, reporter.warn, kept, resume, certificate_points
        )
    return Codebook(book, message)


def separate(
    function: Callable[..., Any],
    box: Mapping[str, tuple[Quantity, Quantity]],
    outputs: Union[Sequence[str], Mapping[str, str]],
    tolerance: float = 1e-3,
    vectorised: bool = True,
    pool: Optional[Executor] = None,
    *,
    units: Optional[Mapping[str, str]] = None,
    end: Optional[Quantity] = None,
    absolute: Optional[Mapping[str, float]] = None,
    max_calls: Optional[int] = None,
    seed: int = 1,
    title: Optional[str] = None,
    progress: Progress = False,
    checkpoint: Optional[Path] = None,
    resume: bool = True,
    certificate_points: Optional[int] = None,
) -> Codebook:
    """The separated form of any function over a box, from few calls, certified on points that the builder did not see.

    ::

        book = samara.separate(lambda x: np.sin(x[:, 0] * x[:, 1]), {"a": (0, 1), "b": (0, 2)}, ["u"], tolerance=1e-6)

    :param function: of an array (points, coordinates), returning (points, outputs), or (points,) for one output; where it
        is not ``vectorised``, of one point (coordinates,). With time, of points and times (times,): (points, times, outputs)
    :param box: bounds by name, in the unit of the coordinate
    :param outputs: names; or units by name
    :param tolerance: largest error of an output over its range
    :param pool: an executor that makes the calls: point by point if not vectorised, else in pieces. Processes need a
        function that can be pickled
    :param units: of coordinates, of the SI; "1" where none is given
    :param end: s: the function is one of time, too, from 0 to there
    :param absolute: floor by output for the range that errors are divided by
    :param max_calls: of the builder; those of the certificate come on top
    :param certificate_points: 2,000 by default, fewer for slow functions
    :returns: a codebook also where it misses its tolerance: ``certificate.met`` says so
    """
    as_mapping(box, "bounds")
    names = names_in(outputs, "outputs")
    for name in names:
        if names.count(name) > 1:
            raise ArgumentError(f'outputs have "{name}" more than once, expected each name once')
    of = dict(outputs) if isinstance(outputs, Mapping) else dict.fromkeys(names, "1")
    given_units = as_mapping(units or {}, "units")
    check_names(given_units, list(box), "coordinate")
    unit = {name: given_units.get(name, "1") for name in box}
    tolerance = one_si(tolerance, "1", "tolerance")
    if not 0 < tolerance < 1:
        raise ArgumentError(f"tolerance is {tolerance:g}, expected more than 0 and less than 1")
    named = {} if absolute is None else by_name(absolute, "absolute")
    given_floors = as_mapping(absolute if named is None else named, "absolute")
    check_names(given_floors, names, "output")
    floors = {name: one_si(value, of[name], f"absolute of {name}", least=0) for name, value in given_floors.items()}
    calls_at_most = whole(max_calls, "max_calls", 10**12)
    certificate_points = whole(certificate_points, "certificate_points", least=1)
    resume, kept = truth(resume, "resume"), file_in(checkpoint, "checkpoint")
    if not callable(function):
        raise ArgumentError(f"the function is of the type {type(function).__name__}, expected one of an array of points")
    if pool is not None and not callable(getattr(pool, "map", None)):
        raise ArgumentError(f"pool is of the type {type(pool).__name__}, expected an executor of concurrent.futures")
    plan: dict[str, Any] = {
        "title": None if title is None else text_in(title, "title"),
        "command": {"run": [_name_of(function)], "inputs": unit, "outputs": of},
        "box": {n: _ends(bounds, unit[n], n) for n, bounds in box.items()},
        "time": None if end is None else {"end": one_si(end, "s", "end", above=0)},
        "tolerance": {"relative": tolerance, "absolute": floors or None},
        "builder": {"kind": "sampling", "seed": counted(seed, "seed", 2**63 - 1), "max_calls": calls_at_most},
    }
    calls = _Calls(function, len(box), len(of), truth(vectorised, "vectorised"), pool, end is not None)
    comment, resume = _fingerprint(function, kept, resume)
    reporter = Reported(progress)
    with reporter as report:
        book, _, message = _core.separate(
            calls, _toml.dumps(plan) + comment, report, reporter.warn, kept, resume, certificate_points
        )
    return Codebook(book, message)


def _name_of(function: Callable[..., Any]) -> str:
    return f"Python: {getattr(function, '__module__', '')}.{getattr(function, '__qualname__', type(function).__name__)}"


def _ends(bounds: Any, unit: str, name: str) -> list[float]:
    if isinstance(bounds, str) or not hasattr(bounds, "__len__") or len(bounds) != 2:
        raise ArgumentError(f"{name} has the bounds {bounds!r}, expected a pair of them")
    lower, upper = (one_si(bound, unit, name) for bound in bounds)
    if not -np.inf < lower < upper < np.inf:
        raise ArgumentError(f"{name} has the bounds {lower:g} and {upper:g}, expected finite ones, the lower first")
    return [lower, upper]


def _fingerprint(function: Any, checkpoint: str, resume: bool, *more: Any) -> tuple[str, bool]:
    """A comment at the end of a plan, so that a checkpoint of another function is not taken up, and whether one is."""
    comment = f"\n# {_name_of(function)}"
    if not checkpoint:
        return comment + "\n", resume
    digest, why = identity(function, *more)
    if why and resume and os.path.exists(checkpoint):
        warnings.warn(
            f"{checkpoint} is not taken up: whether it is of the same function cannot be told, for {why}", stacklevel=3
        )
    return f"{comment}, {digest}\n", resume and not why


class _Calls:
    """The user's function as the library calls it: (points, inputs and times) to (points, times x outputs)."""

    def __init__(
        self,
        function: Callable[..., Any],
        inputs: int,
        outputs: int,
        vectorised: bool,
        pool: Optional[Executor],
        has_time: bool,
    ) -> None:
        self._function = function
        self._inputs = inputs
        self._outputs = outputs
        self._vectorised = vectorised
        self._pool = pool
        self._has_time = has_time

    def __call__(self, given: NDArray[np.float64]) -> NDArray[np.float64]:
        points = np.ascontiguousarray(given[:, : self._inputs])
        times = given[0, self._inputs :].copy()
        more = (times,) if self._has_time else ()
        if self._vectorised:
            chunks = self._chunks(points)
            answers = list(self._map(chunks, more))
            shaped = [self._shaped(a, len(c), len(times)) for a, c in zip(answers, chunks)]
            return np.concatenate(shaped)
        answers = list(self._map(points, more))
        return np.concatenate([self._shaped([a], 1, len(times)) for a in answers])

    def _chunks(self, points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        workers = getattr(self._pool, "_max_workers", os.cpu_count() or 1) if self._pool else 1
        return np.array_split(points, max(1, min(workers, len(points))))

    def _map(self, items: Any, more: tuple[Any, ...]) -> Iterator[NDArray[Any]]:
        if self._pool is None:
            answers: Iterable[Any] = (self._function(item, *more) for item in items)
        else:
            answers = self._pool.map(self._function, items, *([m] * len(items) for m in more))
        return (unmasked(answer, "the function's answer") for answer in answers)

    def _shaped(self, answer: Any, points: int, times: int) -> NDArray[np.float64]:
        answers = np.asarray(answer)
        if answers.dtype.kind == "c":
            raise ArgumentError("the function gave complex numbers, expected real ones")
        values = answers.astype(float, copy=False)
        expected = (points, times, self._outputs) if self._has_time else (points, self._outputs)
        if values.shape != expected and not (self._outputs == 1 and values.shape == expected[:-1]):
            raise ArgumentError(f"the function gave the shape {values.shape}, expected {expected}")
        return values.reshape(points, -1)
