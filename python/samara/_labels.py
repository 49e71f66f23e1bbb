"""Answers with labels: pandas and xarray, where they are installed."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._errors import ArgumentError, MissingPackageError


def optional(name: str) -> ModuleType:
    """A package that Samara itself does not need."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise MissingPackageError(f"{name} is not installed, and this answer needs it", name=name) from None


@dataclass
class Answer:
    """Of ``Codebook.query``: values (.., [times,] outputs), slopes (.., [times,] outputs, parameters)."""

    q: NDArray[np.float64]
    parameters: Sequence[Any]
    frames: Optional[NDArray[np.float64]]
    time: Any
    values: NDArray[np.float64]
    slopes: Optional[NDArray[np.float64]]
    outputs: Sequence[Any]

    def labelled(self, kind: str) -> Any:
        """As a DataFrame ("pandas") or a Dataset ("xarray")."""
        if self.frames is not None and self.frames.ndim == 0:
            self.frames = self.frames.reshape(1)
            self.values = self.values[..., None, :]
            self.slopes = None if self.slopes is None else self.slopes[..., None, :, :]
        return _frame(self) if kind == "pandas" else _dataset(self)


def _frame(answer: Answer) -> Any:
    q, parameters, frames, time = answer.q, answer.parameters, answer.frames, answer.time
    values, slopes, outputs = answer.values, answer.slopes, answer.outputs
    pandas = optional("pandas")
    shape = values.shape[:-1]
    columns = {}
    for k, p in enumerate(parameters):
        column = q[..., k] if frames is None else q[..., None, k]
        columns[p.name] = np.broadcast_to(column, shape).ravel()
    if frames is not None:
        columns[time.name] = np.broadcast_to(frames, shape).ravel()
    for k, o in enumerate(outputs):
        columns[o.name] = values[..., k].ravel()
    if slopes is not None:
        for k, o in enumerate(outputs):
            for j, p in enumerate(parameters):
                columns[f"d{o.name}/d{p.name}"] = slopes[..., k, j].ravel()
    frame = pandas.DataFrame(columns)
    frame.attrs["units"] = {x.name: x.unit for x in (*parameters, time, *outputs) if x.name in columns}
    return frame


def _dataset(answer: Answer) -> Any:
    q, parameters, frames, time = answer.q, answer.parameters, answer.frames, answer.time
    values, slopes, outputs = answer.values, answer.slopes, answer.outputs
    count = q.ndim - 1
    samples = ("sample",) if count == 1 else tuple(f"sample_{k}" for k in range(count))
    dims = samples if frames is None else (*samples, "time")
    variables: list[tuple[str, Any]] = []
    coords: list[tuple[str, Any]] = []
    for k, o in enumerate(outputs):
        variables.append((o.name, (dims, values[..., k], {"units": o.unit})))
    for k, p in enumerate(parameters):
        coords.append((p.name, (samples, q[..., k], {"units": p.unit})))
    if frames is not None:
        coords.append(("time", ("time", frames, {"units": time.unit})))
    if slopes is not None:
        for k, o in enumerate(outputs):
            variables.append((f"d{o.name}", ((*dims, "parameter"), slopes[..., k, :], {"long_name": "derivative"})))
        coords.append(("parameter", ("parameter", [p.name for p in parameters])))
    names = [name for name, _ in (*variables, *coords)]
    for name in names:
        if names.count(name) > 1:
            raise ArgumentError(f'the Dataset of this answer has "{name}" more than once, expected each name once')
    return optional("xarray").Dataset(dict(variables), coords=dict(coords))
