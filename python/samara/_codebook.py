"""Codebooks: opening, asking, looking into them."""

from __future__ import annotations

import os
import pathlib
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _html, _labels
from ._contents import Axis, Build, Certificate, Coordinate, Front, Group, Output, Piece, Statistics, certificate_of
from ._errors import ArgumentError, writing
from ._units import (
    Quantity, as_mapping, by_name, check_names, counted, names_in, one_difference, one_si, real_array, stacked, to_si,
    whole,
)

Precision = Literal["double", "single", "auto"]
Points = Union[Mapping[str, Quantity], ArrayLike]


class Codebook:
    """The solution of a model over time, parameters and initial values, or what a function answers over a box.

    Coordinates and outputs are in SI units. Safe to share between threads. ``samara.build``, ``samara.separate`` and
    ``Codebook.open`` make them::

        book = samara.Codebook.open("coin.h5")
        v, dv = book.query({"C_D": 1.15, "v(0)": "10 cm/s"}, times=[0.1, 0.2, 0.3], gradient=True)
    """

    __slots__ = ("_book", "_description", "_coordinates", "_outputs", "_certificate", "message", "__weakref__")

    def __init__(self, book: _core.Book, message: str = "") -> None:
        """Not to be called: see ``open``."""
        self._book = book
        self._description = book.describe()
        self._coordinates = tuple(Coordinate(**c) for c in self._description["coordinates"])
        self._outputs = tuple(Output(**o) for o in self._description["outputs"])
        self._certificate = certificate_of(self._description["certificate"], self._coordinates)
        self.message = message
        """What the build said in the end, in one sentence; empty of a codebook from a file."""

    @classmethod
    def open(cls, path: Union[str, os.PathLike[str]]) -> "Codebook":
        """The codebook of a file. Pieces of a large one are read when they are first asked for.

        :raises InputError: (an ``OSError``) if the file is missing, damaged or no codebook
        """
        return cls(_core.Book.open(os.fspath(path)))

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the file, whole or not at all.

        :raises ArgumentError: for a name with the ending of another format, such as ``.csv``
        :raises InputError: (an ``OSError``) where it cannot be written
        """
        _core.require_name_of_format(os.fspath(path), ".h5")
        with writing():
            self._book.save(os.fspath(path))

    @property
    def title(self) -> str:
        return str(self._description["title"])

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Time first, if there is one, then parameters and initial values ``"s(0)"``."""
        return self._coordinates

    @property
    def parameters(self) -> tuple[Coordinate, ...]:
        """The coordinates without time."""
        return self._coordinates[1:] if self.has_time else self._coordinates

    @property
    def has_time(self) -> bool:
        return self._coordinates[0].role == "time"

    @property
    def outputs(self) -> tuple[Output, ...]:
        return self._outputs

    @property
    def derived(self) -> tuple[Output, ...]:
        """What the model derives from the states (``[outputs]`` of a model as text): asked for by name, with derivatives."""
        return tuple(Output(**o) for o in self._description["derived"])

    @property
    def certificate(self) -> Optional[Certificate]:
        """None of a slice, and of a file without one."""
        return self._certificate

    @property
    def model(self) -> dict[str, Any]:
        """Name, title, equations, frames, source, and what was ``fixed`` (SI)."""
        return dict(self._description["model"])

    @property
    def build(self) -> Build:
        return Build(**self._description["build"])

    @property
    def provenance(self) -> dict[str, Any]:
        return dict(self._description["provenance"])

    def query(
        self,
        parameters: Points,
        times: Union[Quantity, Sequence[Quantity], None] = None,
        *,
        gradient: bool = False,
        outputs: Optional[Sequence[str]] = None,
        labels: Optional[Literal["pandas", "xarray"]] = None,
        out: Optional[NDArray[np.float64]] = None,
        threads: Optional[int] = None,
        precision: Precision = "double",
    ) -> Any:
        """Trajectories: values (.., times, outputs), and with ``gradient`` also (.., times, outputs, parameters).

        :param parameters: by name, SI or with a unit, broadcast against each other; a frame with a column for each; or an
            array (.., parameters), SI
        :param times: s, or texts with a unit, (times,); one number for no such dimension; none of a codebook without time
        :param gradient: exact derivatives by the parameters; with it the answer is a pair
        :param outputs: names, in the order wanted, or one, ``derived`` ones included; all that are stored by default
        :param labels: ``"pandas"``: a tidy frame, a row for each sample and time; ``"xarray"``: a Dataset
        :param out: an array to write the values to, of their shape. Times run fastest in memory: one that an earlier call
            returned is written to directly, another one by a copy
        :param threads: 0: as many as the machine has; by default so where it pays
        :param precision: ``"single"`` factors are twice as fast; ``"auto"``: where the certificate bears it
        :raises OutsideBoxError: naming the coordinate; it is a ``ValueError``
        """
        if labels not in (None, "pandas", "xarray"):
            raise ArgumentError(f'labels is "{labels}", expected None, "pandas" or "xarray"')
        if out is not None and not isinstance(out, np.ndarray):
            raise ArgumentError(f"out is {type(out).__name__}, expected an array")
        if labels and out is not None:
            raise ArgumentError("labels and out were given, expected one of the two")
        outputs = names_in(outputs, "outputs") if outputs is not None else None
        q = self._array(parameters, self.parameters, "parameters")
        if not self.has_time:
            if times is not None:
                raise ArgumentError("times were given, and the codebook has no time")
            if out is not None:
                _check_room(out, (*q.shape[:-1], len(outputs or self._outputs)))
            threads, precision = _checked(threads, precision)
            pair = self._values_at(q, gradient, outputs or (), out, threads, precision)
            answer: Any = pair if gradient else pair[0]
            frames = None
        else:
            frames = self._times(times)
            if out is not None:
                _check_room(out, (*q.shape[:-1], *frames.shape, len(outputs or self._outputs)))
            room = out[..., None, :] if out is not None and frames.ndim == 0 else out
            threads, precision = _checked(threads, precision)
            pair = self._trajectories(q, np.atleast_1d(frames), gradient, outputs, room, threads, precision)
            if frames.ndim == 0:
                pair = (pair[0][..., 0, :], *(slopes[..., 0, :, :] for slopes in pair[1:]))
            values = pair[0] if out is None else out
            answer = (values, *pair[1:]) if gradient else values
        if labels is None:
            return answer
        values, slopes = answer if gradient else (answer, None)
        known = (*self._outputs, *(self.derived if outputs else ()))
        chosen = [o for n in outputs for o in known if o.name == n] if outputs else self._outputs
        answer = _labels.Answer(q, self.parameters, frames, self._coordinates[0], values, slopes, chosen)
        return answer.labelled(labels)

    def at(
        self,
        points: Points,
        *,
        gradient: bool = False,
        hessian: bool = False,
        outputs: Optional[Sequence[str]] = None,
        fixed: Optional[Mapping[str, Quantity]] = None,
        precision: Precision = "double",
        out: Optional[NDArray[np.float64]] = None,
        threads: Optional[int] = None,
    ) -> Any:
        """Values (.., outputs) at points, time one of the coordinates.

        With ``gradient`` a pair with the derivatives (.., outputs, coordinates); with ``hessian`` a triple with the second
        ones (.., outputs, coordinates, coordinates), too.

        :param points: an array (.., coordinates), SI, in the order of ``coordinates``; or by name as in ``query``
        :param fixed: coordinates that are held: the points have none of them
        """
        held = self._held(fixed) if fixed else {}
        if type(points) is not np.ndarray or points.dtype.kind != "f":
            free = self._coordinates if not held else tuple(c for c in self._coordinates if c.name not in held)
            points = self._array(points, free, "points")
        if out is not None:
            points = _apart(points, out)
        if outputs is not None:
            outputs = names_in(outputs, "outputs")
        if threads is not None or precision != "double":
            threads, precision = _checked(threads, precision)
        order = 2 if hessian else 1 if gradient else 0
        answer = self._book.at(points, outputs or (), held, precision, order, out, threads)
        if order == 0:
            return answer
        if order == 1:
            return answer[0], answer[1].swapaxes(-1, -2)
        return answer[0], answer[1].swapaxes(-1, -2), np.moveaxis(answer[2], -1, -3)

    def slice(self, **fixed: Quantity) -> "Codebook":
        """The codebook with coordinates held, exactly; of names like ``v(0)``: ``slice(**{"v(0)": 0})``.

        It has no certificate: that of the whole says how few of its points are wrong, not where.
        """
        return Codebook(self._book.slice(self._held(fixed)))

    def sobol(
        self,
        inputs: Optional[Mapping[str, tuple[str, Quantity, Quantity]]] = None,
        *,
        fixed: Optional[Mapping[str, Quantity]] = None,
        groups: Union[str, Sequence[Union[str, Sequence[str]]]] = (),
        quantiles: ArrayLike = (),
        draws: int = 4096,
        seed: int = 1,
    ) -> Statistics:
        """Mean, deviation, Sobol' indices and quantiles of the outputs, as ``samara stats`` gives them.

        :param inputs: how parameters are distributed that are not uniform over the box: ``("normal", mean, deviation)``,
            ``("lognormal", median, deviation of the logarithm)``, ``("uniform", least, largest)``
        :param fixed: parameters that are held
        :param groups: parameters to give indices of together; a name is a group of its own
        :param quantiles: shares between 0 and 1, or one; ``draws`` points and ``seed`` are those of the quantiles
        """
        draws, seed = counted(draws, "draws"), counted(seed, "seed", 2**64 - 1)
        together = [groups] if isinstance(groups, str) else groups
        if not isinstance(together, Iterable):
            raise ArgumentError(f"groups are {groups!r}, expected lists of names")
        s = self._book.statistics(
            self._distributions(inputs or {}),
            self._held(fixed or {}),
            [names_in(names, "the names of a group") for names in together],
            real_array(quantiles, "quantiles").ravel().tolist(),
            draws,
            seed,
        )
        keys = ("mean", "deviation", "first_order", "total", "group_closed", "group_total", "quantiles")
        of = {key: {o["name"]: o[key] for o in s["outputs"]} for key in keys}
        return Statistics(
            inputs=tuple(s["inputs"]), groups=tuple(map(tuple, s["groups"])), times=s["times"], notes=tuple(s["notes"]), **of
        )

    def to_numpy(self) -> tuple[Piece, ...]:
        """The pieces as they are stored: axes, and factors or cores as read-only views, which keep the codebook."""
        return tuple(
            Piece(
                tuple(Axis(**a) for a in p["axes"]),
                tuple(
                    Group(**{k: tuple(v) if isinstance(v, list) else v for k, v in g.items()}) for g in p["groups"]
                ),
                Front(p["front"]["coordinate"], tuple(p["front"]["others"]), p["front"]["place"]) if "front" in p else None,
            )
            for p in self._book.numbers()
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_bytes, (self._to_bytes(), self.message)

    def _to_bytes(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "book.h5"
            self.save(path)
            return path.read_bytes()

    def __repr__(self) -> str:
        verdict = self._certificate.verdict if self._certificate else "no certificate"
        box = ", ".join(f"{c.name} {c.lower:g}..{c.upper:g}{_html.unit(c.unit)}" for c in self._coordinates)
        return f"<samara.Codebook of {self.model['name']}: {', '.join(o.name for o in self._outputs)} over {box}; {verdict}>"

    def _repr_html_(self) -> str:
        return _html.codebook(self, self._book.outlines())

    def _array(self, points: Points, coordinates: Sequence[Coordinate], what: str) -> NDArray[np.float64]:
        named = by_name(points, what)
        return real_array(points, what) if named is None else stacked(named, coordinates, what)

    def _distributions(self, inputs: Mapping[str, tuple[str, Quantity, Quantity]]) -> dict[str, tuple[str, float, float]]:
        found = {}
        for name, (given, unit) in self._with_units(inputs, "inputs").items():
            if not isinstance(given, (tuple, list)) or len(given) != 3:
                raise ArgumentError(f"{name} is {given!r}, expected such as ('normal', 1.1, 0.05)")
            kind, first, second = given
            if kind == "normal":
                spread = one_difference(second, unit, name)
            else:
                spread = one_si(second, "1" if kind == "lognormal" else unit, name)
            found[name] = (str(kind), one_si(first, unit, name), spread)
        return found

    def _held(self, fixed: Mapping[str, Quantity]) -> dict[str, float]:
        held = self._with_units(fixed, "held coordinates")
        return {name: one_si(value, unit, name) for name, (value, unit) in held.items()}

    def _with_units(self, given: Mapping[str, Any], what: str) -> dict[str, tuple[Any, str]]:
        """What is given of coordinates, each with the unit of its own."""
        units = {c.name: c.unit for c in self._coordinates}
        check_names(as_mapping(given, what), list(units), "coordinate")
        return {name: (value, units[name]) for name, value in given.items()}

    def _times(self, times: Any) -> NDArray[np.float64]:
        time = self._coordinates[0]
        if times is None:
            raise ArgumentError(f"times are not given, expected some from {time.lower:g} to {time.upper:g} {time.unit}")
        frames = to_si(times, time.unit, "times")
        if frames.ndim > 1:
            raise ArgumentError(f"times have the shape {frames.shape}, expected (times,) or one number")
        return frames

    def _trajectories(
        self,
        q: NDArray[np.float64],
        frames: NDArray[np.float64],
        gradient: bool,
        outputs: Optional[Sequence[str]],
        out: Optional[NDArray[np.float64]],
        threads: Optional[int],
        precision: Precision,
    ) -> tuple[NDArray[np.float64], ...]:
        if outputs and not {o.name for o in self._outputs}.issuperset(outputs):
            return self._derived_trajectories(q, frames, gradient, outputs, out, threads, precision)
        # Times run fastest in what the library writes: a view has the axes in the order of the answer.
        room = None if out is None or out.ndim < 2 else out.swapaxes(-1, -2)
        is_ours = room is not None and room.flags.c_contiguous
        answer = self._book.trajectories(
            _apart(q, room), frames, outputs or (), {}, precision, gradient, room if is_ours else None, threads
        )
        values = answer[0] if gradient else answer
        shown = values.swapaxes(-1, -2)
        if out is not None and not is_ours:
            np.copyto(out, shown)
        result = shown if out is None else out
        if not gradient:
            return (result,)
        return result, answer[1].swapaxes(-1, -3)

    def _derived_trajectories(
        self,
        q: NDArray[np.float64],
        frames: NDArray[np.float64],
        gradient: bool,
        outputs: Sequence[str],
        out: Optional[NDArray[np.float64]],
        threads: Optional[int],
        precision: Precision,
    ) -> tuple[NDArray[np.float64], ...]:
        """Point by point: what a model derives from its states is not stored."""
        points = np.empty((*q.shape[:-1], frames.size, q.shape[-1] + 1))
        points[..., 0] = frames
        points[..., 1:] = q[..., None, :]
        values, *slopes = self._values_at(points, gradient, outputs, out, threads, precision)
        return values, *(by_all[..., 1:] for by_all in slopes)

    def _values_at(
        self,
        points: NDArray[np.float64],
        gradient: bool,
        outputs: Sequence[str],
        out: Optional[NDArray[np.float64]],
        threads: Optional[int],
        precision: Precision,
    ) -> tuple[NDArray[np.float64], ...]:
        """As ``at``, written to any array, where it takes those in C order only."""
        room = out if out is not None and out.flags.c_contiguous else None
        answer = self._book.at(_apart(points, room), outputs, {}, precision, int(gradient), room, threads)
        values = answer[0] if gradient else answer
        if out is not None and room is None:
            np.copyto(out, values)
        result = values if out is None else out
        return (result, answer[1].swapaxes(-1, -2)) if gradient else (result,)


def _checked(threads: Any, precision: Any) -> tuple[Optional[int], Precision]:
    if not isinstance(precision, str):
        raise ArgumentError(f'precision is {precision!r}, expected "double", "single" or "auto"')
    return whole(threads, "threads"), precision  # type: ignore[return-value]


def _apart(points: NDArray[Any], out: Any) -> NDArray[Any]:
    """Points that are still the same when a part of the answer stands in ``out``."""
    is_shared = isinstance(out, np.ndarray) and np.may_share_memory(points, out)
    return points.copy() if is_shared else points


def _check_room(out: NDArray[Any], shape: tuple[int, ...]) -> None:
    if out.shape != shape:
        raise ArgumentError(f"out has the shape {out.shape}, expected {shape}")
    if out.dtype != np.float64:
        raise ArgumentError(f"out is of the type {out.dtype}, expected float64")
    if not out.flags.writeable:
        raise ArgumentError("out is read-only, expected an array that may be written")


def _from_bytes(data: bytes, message: str = "") -> Codebook:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "book.h5"
        path.write_bytes(data)
        # A large file stays open, and lives on without its name.
        return Codebook(_core.Book.open(os.fspath(path)), message)
