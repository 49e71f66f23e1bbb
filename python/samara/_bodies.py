"""Motions as segments to go on from, and many bodies that fall by them (docs/motion.md)."""

from __future__ import annotations

import json
import os
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._building import Path, Progress, Reported
from ._errors import ArgumentError, writing
from ._sweeps import Sweep
from ._units import Quantity, counted, finite, one_si, real_array

_STATES = ("falling", "landed", "not_finite", "waiting")


def _chosen(bodies: ArrayLike, count: int) -> NDArray[Any]:
    """Numbers of bodies, given as such or as a mask of all."""
    chosen: NDArray[Any] = np.atleast_1d(np.asarray(bodies))
    if chosen.dtype == bool:
        if chosen.shape != (count,):
            raise ArgumentError(f"bodies are a mask of the shape {chosen.shape}, expected ({count},)")
        return np.flatnonzero(chosen)
    if chosen.size == 0:
        return np.arange(0)
    if chosen.dtype.kind not in "iu":
        raise ArgumentError(f"bodies are of the type {chosen.dtype}, expected whole numbers or a mask")
    if chosen.ndim != 1:
        raise ArgumentError(f"bodies have the shape {chosen.shape}, expected (bodies,)")
    unknown = chosen[(chosen < 0) | (chosen >= count)]
    if unknown.size:
        raise ArgumentError(f"there is no body {unknown[0]}, expected 0 to {count - 1}")
    return chosen


def _for_each(values: NDArray[np.float64], count: int, one: tuple[int, ...], what: str) -> NDArray[np.float64]:
    """Of so many bodies, given of each or the same of all."""
    if values.shape not in (one, (1, *one), (count, *one)):
        raise ArgumentError(f"{what} of {count} bodies: the shape is {values.shape}, expected {one} or {(count, *one)}")
    return np.broadcast_to(values, (count, *one))


class Motions:
    """The falls of a sweep, cut at their events: what ``samara database`` makes.

    ``kinds`` (segments,) "swing-", "swing+", "turn-", "turn+"; ``runs``, ``durations`` [s] (segments,); ``starts``, ``ends``
    (segments, states), SI, columns as ``states``; ``report``: the curve of thresholds, the chain, as the command prints them.
    """

    def __init__(self, core: _core.Motions) -> None:
        self._core = core
        self.states: list[str] = core.state_names()
        kinds, runs, self.durations, self.starts, self.ends = core.segments()
        self.kinds: NDArray[np.str_] = np.array(kinds, dtype=str)
        self.runs: NDArray[np.int64] = np.array(runs, dtype=np.int64)
        self.report: dict[str, Any] = json.loads(core.report())

    @staticmethod
    def open(path: Path) -> Motions:
        """From the file that ``samara database`` or ``save`` wrote."""
        return Motions(_core.Motions.open(os.fspath(path)))

    @staticmethod
    def of(sweep: Sweep, *, threads: int = 0, progress: Progress = True) -> Motions:
        """Runs the falls of a sweep again and cuts them."""
        if not isinstance(sweep, Sweep):
            raise ArgumentError(f"the sweep is of the type {type(sweep).__name__}, expected a samara.Sweep")
        with Reported(progress) as report:
            return Motions(_core.Motions.of(sweep._core, report, counted(threads, "threads")))

    def save(self, path: Path) -> None:
        """As HDF5, the format of ``samara database``.

        :raises ArgumentError: for a name with the ending of another format, such as ``.csv``
        :raises InputError: (an ``OSError``) where it cannot be written
        """
        _core.require_name_of_format(os.fspath(path), ".h5")
        with writing():
            self._core.save(os.fspath(path))

    def __repr__(self) -> str:
        return f"<samara.Motions: {len(self.kinds)} segments of {self.report['model']}>"


class Bodies:
    """Many bodies at run time, each one solution of the model: at its events its coefficients begin to move to those of a
    segment that began in a state like its own. They rest on the ground and do not see each other.

    ``choice``: next pieces come from the "chain" of kinds, or evenly from the "graph". ``ramp``: time in which coefficients
    change, a quarter of the median segment by default. ``tries``: pieces that are tried ahead at an event, 0 to 8, so that
    the kind that was chosen comes about. ``wind``: a steady velocity (3,), m/s, of models with a sibling in gusts.
    """

    def __init__(
        self,
        motions: Motions,
        count: int,
        *,
        choice: str = "chain",
        step: Optional[Quantity] = None,
        ramp: Optional[Quantity] = None,
        ground: Optional[Quantity] = None,
        tries: int = 0,
        wind: Optional[ArrayLike] = None,
        seed: int = 1,
    ) -> None:
        if not isinstance(motions, Motions):
            raise ArgumentError(f"the motions are of the type {type(motions).__name__}, expected samara.Motions")
        if choice not in ("chain", "graph"):
            raise ArgumentError(f'choice is {choice!r}, expected "chain" or "graph"')
        self._ground = None if ground is None else one_si(ground, "m", "ground")
        self._core = _core.Bodies.of(
            motions._core,
            counted(count, "count", least=1),
            choice == "graph",
            0.0 if step is None else one_si(step, "s", "step", above=0),
            -1.0 if ramp is None else one_si(ramp, "s", "ramp", least=0),
            self._ground,
            counted(tries, "tries"),
            None if wind is None else real_array(wind, "wind"),
            counted(seed, "seed"),
        )
        self.count = count

    def release(self, places: ArrayLike, yaw: ArrayLike = 0.0, bodies: Optional[ArrayLike] = None) -> None:
        """Lets bodies go, moving as if they had fallen for a while: all, or those of these numbers or of a mask (count,).
        ``places`` (3,) or (bodies, 3), m, z up, above the ground; ``yaw`` about the vertical, rad."""
        numbers = np.arange(self.count) if bodies is None else _chosen(bodies, self.count)
        where = _for_each(finite(real_array(places, "places"), "places"), len(numbers), (3,), "places")
        turned = _for_each(finite(real_array(yaw, "yaw"), "yaw"), len(numbers), (), "yaw")
        # Where one is refused, none was let go.
        if self._ground is not None and np.min(where[:, 2], initial=np.inf) <= self._ground:
            low = int(np.argmin(where[:, 2]))
            raise ArgumentError(
                f"body {numbers[low]} starts at a height of {where[low, 2]:g} m, expected above the ground at {self._ground:g} m"
            )
        for number, place, angle in zip(numbers, where, turned):
            self._core.release(int(number), place, float(angle))

    def advance(self, dt: Quantity) -> None:
        """By steps of equal length, at most ``step``."""
        self._core.advance(one_si(dt, "s", "dt", above=0))

    @property
    def counts(self) -> dict[str, int]:
        """Since they were made: ``events``; ``planned``, those that ended a chosen segment and are not steady, and ``kept``, of its kind;
        ``drawn``, at which the chain drew a kind, ``taken``, with a piece of it, and ``redrawn``, with one of a kind that it
        drew then, among those that were left."""
        return self._core.counts()

    @property
    def falling(self) -> int:
        """Bodies that fall."""
        return self._core.falling()

    @property
    def status(self) -> NDArray[np.str_]:
        """Of each body: "falling", "landed", "not_finite", "waiting"."""
        return np.array(_STATES)[self._core.states()]

    def poses(
        self, positions: Optional[NDArray[np.float64]] = None, rotations: Optional[NDArray[np.float64]] = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Places (bodies, 3), m, z up, and quaternions w, x, y, z (bodies, 4), body to world; into the arrays given."""
        return self._core.poses(positions, rotations)
