"""Beside the rule: a person's labels, clusters, and how far two labellings agree (docs/filmed_patterns.md)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._building import Path
from ._captures import files_and_tables
from ._errors import ArgumentError
from ._labels import optional
from ._units import Quantity, as_mapping, counted, file_in, one_si, real_array, thresholds_in, whole


@dataclass(frozen=True)
class Agreement:
    """How far the rule agrees with a person's labels. Look at more than ``share``: where one class is large, a constant
    answer has a large share, too.

    :param words: of the person, in the order of rows and columns; the last is "other", what the rule calls by none of them
    :param confusion: (words, words), segments: rows the person's, columns the rule's
    :param share: on which both agree; ``balanced``: its mean over the words
    :param kappa: Cohen's; 1: full agreement, 0: that of chance
    :param adjusted_rand: over pairs, whatever the classes are called
    :param segments: per segment: capture, first and last frame, the person's word, pattern, margin and reason of the rule
    """

    words: list[str]
    confusion: NDArray[np.int64]
    share: float
    balanced: float
    kappa: float
    adjusted_rand: float
    segments: list[tuple[str, int, int, str, str, float, str]]

    @property
    def frame(self) -> Any:
        """A DataFrame with a row for each segment."""
        columns = ["capture", "first_frame", "last_frame", "label", "pattern", "margin", "why"]
        return optional("pandas").DataFrame(self.segments, columns=columns)


@dataclass(frozen=True)
class Clusters:
    """Kinds that points fall into; no patterns: which ones come out hangs on which numbers go in and how they are scaled.

    :param assignment: (points,), from 0, the largest first
    :param centres: (clusters, columns)
    :param objective: k-means: sum of squared distances; mixture: mean log-likelihood
    """

    assignment: NDArray[np.int64]
    centres: NDArray[np.float64]
    objective: float
    converged: bool
    message: str


def agreement(
    labels: Any,
    captures: Any,
    classes: Optional[Mapping[str, Union[str, Sequence[str]]]] = None,
    length: Quantity = 0.0,
    thresholds: Optional[Mapping[str, float]] = None,
    *,
    sidecar: Optional[Path] = None,
) -> Agreement:
    """The rule beside a person's labels of parts of captures, as ``samara patterns --labels``.

    :param labels: a table's file, a DataFrame, or rows (capture, first_frame, last_frame, label)
    :param captures: as of ``samara.records``
    :param classes: which patterns each word stands for; None: words are names of patterns
    :raises ArgumentError: for a word that stands for nothing, a capture that is not there, frames beyond its own
    """
    is_file = isinstance(labels, (str, os.PathLike))
    words = {str(k): [v] if isinstance(v, str) else list(v) for k, v in as_mapping(classes or {}, "classes").items()}
    files, tables = files_and_tables(captures)
    found, confusion, share, balanced, kappa, rand, segments = _core.segment_agreement(
        files, tables, file_in(sidecar, "sidecar"), os.fspath(labels) if is_file else None, [] if is_file else _rows(labels), words,
        one_si(length, "m", "length", least=0), thresholds_in(thresholds),
    )
    return Agreement(found, confusion.astype(np.int64), share, balanced, kappa, rand, segments)


def _rows(labels: Any) -> list[tuple[str, int, int, str]]:
    names = ("capture", "first_frame", "last_frame", "label")
    if hasattr(labels, "columns"):
        missing = [name for name in names if name not in labels.columns]
        if missing:
            raise ArgumentError(f"labels have no column {missing[0]}, expected {', '.join(names)}")
        labels = zip(*(labels[name] for name in names))
    if not isinstance(labels, Iterable):
        raise ArgumentError(f"labels are of the type {type(labels).__name__}, expected a file, a DataFrame or rows of {', '.join(names)}")
    rows = []
    for n, row in enumerate(labels):
        cells = list(row) if isinstance(row, Iterable) and not isinstance(row, str) else []
        if len(cells) != 4:
            raise ArgumentError(f"label {n} is {row!r}, expected {', '.join(names)}")
        first, last = (whole(int(cell) if isinstance(cell, np.integer) else cell, f"a frame of label {n}") for cell in cells[1:3])
        if first is None or last is None or not 0 <= first < last:
            raise ArgumentError(f"label {n} goes from frame {first} to {last}, expected from 0 on, and the last after the first")
        rows.append((str(cells[0]), first, last, str(cells[3])))
    if not rows:
        raise ArgumentError("there are no labels, expected at least one")
    return rows


def adjusted_rand(first: ArrayLike, second: ArrayLike) -> float:
    """Adjusted Rand index of two labellings of the same things, whatever classes are called: 1: the same, 0: as by chance."""
    numbers = [np.unique(np.asarray(one), return_inverse=True)[1].ravel().tolist() for one in (first, second)]
    return _core.adjusted_rand(*numbers)


def k_means(points: ArrayLike, clusters: int, *, restarts: int = 10, seed: int = 1) -> Clusters:
    """Lloyd's iterations from k-means++ seeds, the best of some starts. Columns are taken as they are: scale them first.

    :param points: (points, columns), finite
    """
    return _clusters(points, clusters, restarts, seed, mixture=False)


def gaussian_mixture(points: ArrayLike, clusters: int, *, restarts: int = 10, seed: int = 1) -> Clusters:
    """A mixture of normal distributions with full covariances, by expectation and maximisation, begun at k-means.

    :param points: (points, columns), finite
    """
    return _clusters(points, clusters, restarts, seed, mixture=True)


def _clusters(points: ArrayLike, clusters: int, restarts: int, seed: int, mixture: bool) -> Clusters:
    given = np.ascontiguousarray(real_array(points, "points"))
    if given.ndim != 2:
        raise ArgumentError(f"points have the shape {given.shape}, expected (points, columns)")
    numbers = [counted(value, what) for value, what in ((clusters, "clusters"), (restarts, "restarts"), (seed, "seed"))]
    assignment, centres, objective, converged, message = _core.clusters(given, mixture, *numbers)
    return Clusters(np.array(assignment, dtype=np.int64), centres, objective, converged, message)
