"""Patterns of falling: records, features, labels (docs/explanation/pattern_names.md)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _core, _html
from ._building import Path
from ._captures import files_and_tables
from ._errors import ArgumentError
from ._labels import optional
from ._models import AnyModel, _info, core_model
from ._units import Quantity, as_mapping, check_names, counted, file_in, one_si, real_array, text_in, thresholds_in

PATTERNS: tuple[str, ...] = tuple(_core.pattern_names())
"""In the order of every array that has a column for each."""


@dataclass(frozen=True)
class Feature:
    """A number that tells how a body falls, with what it means."""

    name: str
    unit: str
    meaning: str
    needs_attitude: bool


FEATURES: tuple[Feature, ...] = tuple(Feature(*info) for info in _core.feature_infos())


@dataclass(frozen=True)
class Label:
    """What the rule calls a motion. ``margin`` is the distance to the nearest threshold that was asked, over it."""

    pattern: str
    margin: float
    why: str


@dataclass(frozen=True)
class Window:
    """Part of a fall with one label, from and to in s; ``windows`` of four swings were merged."""

    begin: float
    end: float
    label: Label
    windows: int


@dataclass(frozen=True, eq=False)
class Record:
    """One motion, simulated or filmed. World axes, z up.

    :param times: (frames,), s, increasing
    :param positions: (frames, 3), m
    :param normals: (frames, 3) unit normals of the plate, or None
    :param angles: (frames,) of a motion in the plane y = 0: the chord above the horizontal, unwrapped, rad; or None
    :param length: largest full length of the body, m; 0: not known
    :param left_out: frames that were not seen
    :param position_noise: deviation of a frame's noise, m; None: found from the frames. ``angle_noise`` likewise, rad
    """

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    normals: Optional[NDArray[np.float64]] = None
    angles: Optional[NDArray[np.float64]] = None
    length: float = 0.0
    name: str = "record"
    left_out: int = 0
    position_noise: Optional[float] = None
    angle_noise: Optional[float] = None

    def __post_init__(self) -> None:
        frames = np.shape(self.times)
        if len(frames) != 1:
            raise ArgumentError(f"times have the shape {frames}, expected (frames,)")
        for what, shape in (("times", frames), ("positions", (*frames, 3)), ("normals", (*frames, 3)), ("angles", frames)):
            given = getattr(self, what)
            if given is None and what in ("normals", "angles"):
                continue
            array = real_array(given, what)
            if array.shape != shape:
                raise ArgumentError(f"{what} have the shape {array.shape}, expected {shape}")
            object.__setattr__(self, what, array)
        for what, unit in (("length", "m"), ("position_noise", "m"), ("angle_noise", "rad")):
            given = getattr(self, what)
            if given is not None or what == "length":
                object.__setattr__(self, what, one_si(given, unit, what, least=0))
        counted(self.left_out, "left_out")
        text_in(self.name, "name")

    def features(self, settle: float = 0.5) -> dict[str, float]:
        """By name (``samara.FEATURES``); NaN where one is not known. ``settle``: share left out at the beginning."""
        numbers, *_ = _core.record_features(vars(self), _settle(settle), {})
        return dict(zip((f.name for f in FEATURES), map(float, numbers)))

    def label(self, settle: float = 0.5, thresholds: Optional[Mapping[str, float]] = None) -> Label:
        """What the rule calls the whole of it."""
        _, pattern, margin, why = _core.record_features(vars(self), _settle(settle), thresholds_in(thresholds))
        return Label(pattern, margin, why)

    def windows(
        self, swings: float = 4.0, overlap: float = 0.5, thresholds: Optional[Mapping[str, float]] = None
    ) -> list[Window]:
        """As a sequence of patterns: windows of some swings that overlap by a share, equal neighbours merged."""
        swings, overlap = one_si(swings, "1", "swings"), one_si(overlap, "1", "overlap")
        found = _core.record_windows(vars(self), swings, overlap, thresholds_in(thresholds))
        return [Window(a, b, Label(pattern, margin, why), count) for a, b, pattern, margin, why, count in found]

    @property
    def frame(self) -> Any:
        """A DataFrame with a row for each frame: t, x, y, z, and n_x, n_y, n_z or theta where they are known."""
        columns = {"t": self.times, **dict(zip("xyz", self.positions.T))}
        if self.normals is not None:
            columns |= dict(zip(("n_x", "n_y", "n_z"), self.normals.T))
        if self.angles is not None:
            columns["theta"] = self.angles
        return optional("pandas").DataFrame(columns)


def records(captures: Any, length: Quantity = 0.0, sidecar: Optional[Path] = None) -> list[Record]:
    """What captures know of their motions.

    :param captures: as of ``samara.fit``: files, frames with columns as ``t[s]``, ``x[m]``, or a mapping of them
    :param length: of the body, m; 0: not known
    """
    files, tables = files_and_tables(captures)
    found = _core.motion_records(files, tables, file_in(sidecar, "sidecar"), one_si(length, "m", "length", least=0))
    return [Record(**one) for one in found]


def _settle(share: float) -> float:
    number = one_si(share, "1", "settle")
    if not 0 <= number < 1:
        raise ArgumentError(f"settle is {number:g}, expected a share from 0 to below 1")
    return number


def pattern_thresholds(**changed: float) -> dict[str, float]:
    """All thresholds of the rule, those named with other values."""
    return _core.pattern_thresholds(thresholds_in(changed))


class Patterns:
    """Motions window by window: what ``samara patterns`` says of captures.

    Frames need pandas: ``windows`` (a row for each: record, begin, end, pattern, margin, why), ``features`` (a row for each
    record), ``transitions`` (a row for each change: count, probability and its 95 % interval).
    """

    def __init__(self, found: list[Record], swings: float, overlap: float, rule: dict[str, float]) -> None:
        self.records = found
        self.thresholds = pattern_thresholds(**rule)
        self._options = (swings, overlap, rule)
        self.sequences = [[(w.begin, w.end, w.label) for w in record.windows(swings, overlap, rule)] for record in found]

    def __repr__(self) -> str:
        return f"<samara.Patterns of {len(self.records)} records>"

    @property
    def windows(self) -> Any:
        rows = [
            (record.name, begin, end, label.pattern, label.margin, label.why)
            for record, sequence in zip(self.records, self.sequences)
            for begin, end, label in sequence
        ]
        return optional("pandas").DataFrame(rows, columns=["record", "begin", "end", "pattern", "margin", "why"])

    @property
    def features(self) -> Any:
        frame = optional("pandas").DataFrame([record.features() for record in self.records])
        frame.insert(0, "record", [record.name for record in self.records])
        frame.insert(1, "pattern", [sequence[-1][2].pattern for sequence in self.sequences])
        return frame

    @property
    def transitions(self) -> Any:
        sequences = [[label.pattern for *_, label in sequence] for sequence in self.sequences]
        counts, probability, lower, upper = _core.pattern_transitions(sequences)
        rows = [
            (PATTERNS[i], PATTERNS[j], int(counts[i, j]), probability[i, j], lower[i, j], upper[i, j])
            for i, j in zip(*np.nonzero(np.isfinite(probability)))
        ]
        return optional("pandas").DataFrame(rows, columns=["from", "to", "count", "probability", "lower", "upper"])

    def report(self, path: Path, body: Optional[Regime] = None) -> None:
        """The page for the browser. ``body``: what falls, in its diagram, as ``samara.regime`` has it."""
        swings, overlap, rule = self._options
        if body is not None and not isinstance(body, Regime):
            raise ArgumentError(f"the body is of the type {type(body).__name__}, expected a samara.Regime")
        numbers = None if body is None else {name: getattr(body, name) for name in ("Re", "I_disc", "I_plate", "I_ellipse")}
        page = _core.captures_html([vars(r) for r in self.records], swings, overlap, rule, numbers)
        _html.write_page(path, page)


def patterns(
    captures: Any,
    length: Quantity = 0.0,
    thresholds: Optional[Mapping[str, float]] = None,
    *,
    sidecar: Optional[Path] = None,
    swings: float = 4.0,
    overlap: float = 0.5,
) -> Patterns:
    """Which patterns motions go through.

    :param captures: as of ``samara.records``, or records
    :param thresholds: of the rule, those that are to be others than its own
    """
    is_records = isinstance(captures, Iterable) and not isinstance(captures, (str, os.PathLike, Mapping))
    given = list(captures) if is_records and not hasattr(captures, "columns") else captures
    own = isinstance(given, list) and bool(given) and all(isinstance(one, Record) for one in given)
    if own and (one_si(length, "m", "length") != 0 or sidecar is not None):
        raise ArgumentError("length and sidecar are of captures, but records were given, which have what they need")
    return Patterns(given if own else records(given, length, sidecar), swings, overlap, thresholds_in(thresholds))


@dataclass(frozen=True)
class Regime:
    """Where a body stands in the measured diagram of falling discs: its numbers, the regime, and what lies beyond the
    nearest boundary, ``distance`` away in ln Re and ln I*. ``measured``: whether discs were measured there."""

    length: float
    thickness: float
    speed: float
    Re: float
    I_disc: float
    I_plate: float
    I_ellipse: float
    regime: str
    beyond: str
    distance: float
    measured: bool


def regime(model: AnyModel, parameters: Mapping[str, Quantity]) -> Regime:
    """Of a model with a body, at parameters in SI or with a unit."""
    info = _info(model)
    units = {p.name: p.unit for p in info.parameters} | {f"{s.name}(0)": s.unit for s in info.states}
    check_names(as_mapping(parameters, "parameters"), list(units), "parameter")
    values = {name: one_si(value, units[name], name) for name, value in parameters.items()}
    return Regime(**_core.regime(core_model(model), values))
