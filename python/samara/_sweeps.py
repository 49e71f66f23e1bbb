"""Sweeps: thousands of falls over a box, and the map of their patterns (docs/pattern_maps.md)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _core, _html, _toml
from ._building import Path, Progress, Reported
from ._codebook import Points
from ._contents import Coordinate
from ._errors import ArgumentError, writing
from ._labels import optional
from ._motion import FEATURES, PATTERNS
from ._pattern_tools import Clusters, gaussian_mixture, k_means
from ._units import by_name, check_names, counted, file_in, names_in, real_array, stacked, truth, whole


class Sweep:
    """Thousands of falls over a box of coordinates, and what the rule calls each. Falls are numbered point after point,
    each from all releases: arrays of ``falls`` = points x releases rows.

    ``names``, ``units`` of the coordinates; ``points`` (points, coordinates), SI; ``releases``, pairs (tilt, axis), rad;
    ``features`` (falls, features), NaN where one is not known, columns as ``samara.FEATURES``; ``labels`` (falls,), names of
    patterns; ``margins``, ``status``, ``reached`` [s] (falls,); ``landing`` (falls, 3): x, y [m], t [s]; ``round_of_point``
    (points,), the round of refining that it came with, 0 for those of the plan; empty where an older file does not say it.
    ``complete``: whether all falls are there; ``message``: how it ended.
    """

    def __init__(self, core: _core.Sweep, complete: bool = True, message: str = "") -> None:
        self._core = core
        told = core.describe()
        self.rounds: list[tuple[int, int, float]] = told["rounds"]
        """Of refining: points, those of them that were run, and the share of those that came first that the others call right."""
        self.round_of_point: NDArray[np.int64] = np.array(told["round_of_point"], dtype=np.int64)
        self.model: str = told["model"]
        self.plan: str = told["plan"]
        self.names: list[str] = told["names"]
        self.units: list[str] = told["units"]
        self.axes: list[list[float]] = told["axes"]
        self.releases: list[tuple[float, float]] = told["releases"]
        self.thresholds: dict[str, float] = told["thresholds"]
        self._release_count: int = told["release_count"]
        self._states: list[str] = told["states"]
        self.points = core.points()
        self.features = core.features()
        labels, self.margins, self.reasons, status = core.labels()
        self.labels: NDArray[np.str_] = np.array(labels, dtype=str)
        self.status: NDArray[np.str_] = np.array(status, dtype=str)
        self.reached = core.reached()
        self.landing = core.landing()
        falls = len(self.points) * self._release_count
        self.complete = complete and len(self.labels) == falls
        self.message = message or ("" if self.complete else f"cancelled after {len(self.labels)} of {falls} falls")

    @staticmethod
    def open(path: Path) -> Sweep:
        """From the file that ``samara sweep`` or ``save`` wrote."""
        return Sweep(_core.Sweep.open(os.fspath(path)))

    def save(self, path: Path) -> None:
        """As HDF5, the format of ``samara sweep``.

        :raises ArgumentError: for a name with the ending of another format, such as ``.csv``
        :raises InputError: (an ``OSError``) where it cannot be written
        """
        _core.require_name_of_format(os.fspath(path), ".h5")
        with writing():
            self._core.save(os.fspath(path))

    def __repr__(self) -> str:
        return f"<samara.Sweep of {self.model}: {len(self.labels)} falls over {', '.join(self.names)}>"

    @property
    def frame(self) -> Any:
        """A DataFrame with a row for each fall: coordinates, tilt and axis of the release (rad), round of refining, pattern,
        margin, status, reached, landing_x, landing_y, landing_t, and all features."""
        count = len(self.labels)
        point = np.arange(count) // self._release_count
        columns: dict[str, Any] = dict(zip(self.names, self.points[point].T))
        if self.releases:
            release = np.array(self.releases)[np.arange(count) % self._release_count]
            columns |= {"release_tilt": release[:, 0], "release_axis": release[:, 1]}
        if len(self.round_of_point):
            columns["round"] = self.round_of_point[point]
        columns |= {"pattern": self.labels, "margin": self.margins, "status": self.status, "reached": self.reached}
        columns |= dict(zip(("landing_x", "landing_y", "landing_t"), self.landing.T))
        for k, feature in enumerate(FEATURES):
            columns[feature.name if feature.name not in columns else f"feature_{feature.name}"] = self.features[:, k]
        return optional("pandas").DataFrame(columns)

    def shares(self) -> NDArray[np.float64]:
        """(points, patterns): per point, of its falls from all releases, the share that has each of
        ``samara.PATTERNS``; NaN where a sweep that was ended has not all of a point's falls."""
        done = self._core.shares()
        shares = np.full((len(self.points), len(PATTERNS)), np.nan)
        shares[: len(done)] = done
        return shares

    def _points(self, points: Points) -> NDArray[np.float64]:
        named = by_name(points, "points")
        if named is None:
            given = np.ascontiguousarray(real_array(points, "points"))
        else:
            boxes = [(min(axis, default=-np.inf), max(axis, default=np.inf)) for axis in self.axes]
            given = stacked(named, [Coordinate(n, u, "", *box) for n, u, box in zip(self.names, self.units, boxes)], "points")
        if given.ndim == 0 or given.shape[-1] != len(self.names):
            raise ArgumentError(f"points have the shape {given.shape}, expected (.., {len(self.names)})")
        return given

    def at(self, points: Points, release: int = 0) -> tuple[NDArray[np.str_], NDArray[np.float64], NDArray[np.float64]]:
        """The map of one release at (.., coordinates), SI, or at those of a frame by name: patterns, the share of the seven
        nearest falls that have them, and the distance to the nearest fall of another one (the box has sides of length 1)."""
        given = self._points(points)
        found, probability, distance = self._core.at(given.reshape(-1, len(self.names)), counted(release, "release"))
        shape = given.shape[:-1]
        return np.array(found, dtype=str).reshape(shape), probability.reshape(shape), distance.reshape(shape)

    def draw(self, pattern: str, count: int = 1, *, seed: int = 1, release: int = 0) -> NDArray[np.float64]:
        """(count, coordinates), SI: points of the box whose falls from a release have a pattern: falls of it, moved by at most
        half the way to the nearest one of another."""
        numbers = [counted(value, what) for value, what in ((count, "count"), (seed, "seed"), (release, "release"))]
        return self._core.draw(pattern, *numbers)

    def clamp(self, pattern: str, points: Points, *, release: int = 0) -> NDArray[np.float64]:
        """Points (.., coordinates), SI, moved to where the map of a release has the pattern: as they are where it has it there,
        else the last place that has it on the way from the nearest fall of the pattern."""
        given = self._points(points)
        moved = self._core.clamp(pattern, given.reshape(-1, len(self.names)), counted(release, "release"))
        return moved.reshape(given.shape)

    def landing_statistics(self, release: int = 0) -> Any:
        """A DataFrame with a row for each pattern that fell from a release: its share of the falls with a 95 % interval, how
        many landed, mean x and y with standard errors, covariances, mean distance with its error [m], mean time [s]. NaN is
        what so few do not tell. In a refined sweep they are of its points, which crowd at borders."""
        names = ["pattern", "share", "share_lower", "share_upper", "landed", "x", "y", "x_error", "y_error", "xx", "xy", "yy", "distance",
                 "distance_error", "time"]
        return optional("pandas").DataFrame(self._core.landings(counted(release, "release")), columns=names)

    def clusters(
        self,
        count: int,
        features: Union[str, Iterable[str]] = ("tilt", "flips", "drift", "recurrence"),
        *,
        mixture: bool = False,
        release: int = 0,
        seed: int = 1,
    ) -> tuple[NDArray[np.int64], Clusters]:
        """Clusters of the falls of a release that know these features, each scaled to deviation 1: k-means, or a mixture of
        normal distributions. Returns numbers of these falls, and the clusters."""
        count, seed, release = counted(count, "count", least=1), counted(seed, "seed"), counted(release, "release")
        if release >= self._release_count:
            raise ArgumentError(f"there is no release {release}, expected 0 to {self._release_count - 1}")
        names = [feature.name for feature in FEATURES]
        wanted = names_in(features, "features")
        check_names(wanted, names, "feature")
        numbers = self.features[:, [names.index(name) for name in wanted]]
        known = np.isfinite(numbers).all(axis=1) & (np.arange(len(numbers)) % self._release_count == release)
        falls = np.flatnonzero(known)
        chosen = numbers[falls] - numbers[falls].mean(axis=0) if len(falls) else numbers[falls]
        spread = chosen.std(axis=0) if len(falls) else np.ones(len(wanted))
        scaled = chosen / np.where(spread > 0, spread, 1.0)
        return falls, (gaussian_mixture if truth(mixture, "mixture") else k_means)(scaled, count, seed=seed)

    def trajectories(self) -> tuple[NDArray[np.float64], NDArray[np.float64], list[str]]:
        """Of a plan that keeps them: times (frames,), states (falls, frames, states), NaN after a fall's end, and the names
        of the states."""
        kept = self._core.trajectories()
        if kept is None:
            raise ArgumentError('the sweep keeps no trajectories: run = { .., "keep": "trajectories" } was expected in its plan')
        return kept[0], kept[1], self._states

    def report(self, path: Path) -> None:
        """The page for the browser: diagram, map, features, transitions."""
        _html.write_page(path, self._core.html())


def sweep(
    plan: Union[Path, Mapping[str, Any]],
    progress: Progress = True,
    *,
    checkpoint: Optional[Path] = None,
    threads: Optional[int] = None,
) -> Sweep:
    """Runs the falls of a plan, and its rounds of refining.

    :param plan: a file, or a dictionary with the same keys (docs/reference/sweep.md); its arrays are lists of values
    :param progress: as of ``samara.build``; where it ends the work, the sweep holds what was done, and is not ``complete``
    :param checkpoint: a file for finished falls, from which the same call goes on, and which is removed in the end
    :raises InputError: for a plan that cannot be one, and a checkpoint of another plan, or a file that is none, such as a
        finished sweep
    """
    if isinstance(plan, Mapping):
        path, text = None, _toml.dumps(plan)
    elif isinstance(plan, (str, os.PathLike)):
        path, text = os.fspath(plan), ""
    else:
        raise ArgumentError(f"the plan is of the type {type(plan).__name__}, expected a file, or a dictionary with the same keys")
    reporter = Reported(progress)
    with reporter as report:
        core, complete, message = _core.run_sweep(
            path, text, report, reporter.warn, file_in(checkpoint, "checkpoint"), whole(threads, "threads") or 0
        )
    return Sweep(core, complete, message)
