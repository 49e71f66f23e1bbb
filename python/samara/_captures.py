"""Captures as they are given: files, or tables in memory."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._errors import ArgumentError
from ._units import mask_of

_COLUMN = re.compile(r"\s*(?P<name>.+?)\s*\[(?P<unit>[^\]]*)\]\s*\Z")


def files_and_tables(given: Any) -> tuple[list[str], list[dict[str, Any]]]:
    """Files, and captures in memory."""
    if isinstance(given, (str, os.PathLike)) or _is_table(given):
        given = [given]
    elif isinstance(given, Mapping):
        return [], [_capture(table, str(name)) for name, table in given.items()]
    if not isinstance(given, Iterable):
        raise ArgumentError(f"captures are of the type {type(given).__name__}, expected files or tables")
    files, tables = [], []
    for k, item in enumerate(given):
        if isinstance(item, (str, os.PathLike)):
            files.append(os.fspath(item))
        else:
            tables.append(_capture(item, getattr(item, "attrs", {}).get("id", f"capture {k + 1}")))
    return files, tables


def _is_table(given: Any) -> bool:
    """A frame, or a mapping of columns: its keys name units, and its values are no tables, whose names may look alike."""
    if hasattr(given, "columns"):
        return True
    return isinstance(given, Mapping) and any(
        _COLUMN.match(str(key)) and not isinstance(value, Mapping) and not hasattr(value, "columns")
        for key, value in given.items()
    )


def _numbers(values: Any, factor: float, is_time: bool, what: str) -> NDArray[np.float64]:
    """A column in SI, what is masked or missing as NaN. Differences of times know their unit, whatever the head says."""
    array = np.asarray(values)
    mask = mask_of(values)
    missing = np.zeros(array.shape, bool) if mask is None else mask
    if array.dtype.kind == "m" and is_time:
        numbers, factor = array / np.timedelta64(1, "s"), 1.0
    elif array.dtype.kind in "fiu":
        numbers = array.astype(float)
    elif array.dtype.kind in "OUS":
        cells = zip(array.ravel().tolist(), missing.ravel().tolist())
        numbers = np.array([math.nan if gone else _number(cell, what) for cell, gone in cells], float).reshape(array.shape)
    else:
        raise ArgumentError(f"{what} is of the type {array.dtype}, expected numbers")
    return factor * np.where(missing, np.nan, numbers)


def _number(cell: Any, what: str) -> float:
    if cell is None or type(cell).__name__ == "NAType":  # of pandas
        return math.nan
    try:
        if not isinstance(cell, (bool, np.bool_)):
            return float(cell)
    except (TypeError, ValueError, OverflowError):
        pass
    raise ArgumentError(f"{what} has the value {cell!r:.60}, expected numbers")


def _capture(table: Any, name: str) -> dict[str, Any]:
    """A capture of columns such as ``t[s]`` and ``x[m]``; those without a unit are labels, the same in all frames.

    As of a file, it begins at the first frame in which all its quantities are seen, and times count from there.
    """
    if not isinstance(table, Mapping) and not hasattr(table, "columns"):
        raise ArgumentError(f"{name} is of the type {type(table).__name__}, expected a file, a DataFrame or columns by name")
    times: Any = None
    channels: list[dict[str, Any]] = []
    labels: dict[str, str] = {}
    seen: set[str] = set()
    for column in table.columns if hasattr(table, "columns") else table:
        values = table[column]
        match = _COLUMN.match(str(column))
        if not match:
            distinct = np.unique(np.asarray(values).astype(str))
            if len(distinct) != 1:
                raise ArgumentError(f'the column "{column}" of {name} has no unit; a head like "{column}[m]" was expected')
            labels[str(column)] = str(distinct[0])
            continue
        quantity, unit = match["name"], match["unit"]
        if quantity in seen:
            raise ArgumentError(f'{name} has two columns of "{quantity}", expected one of each quantity')
        try:
            factor = _core.si(f"1 {unit}", "s" if quantity == "t" else unit)
        except ArgumentError as error:
            raise ArgumentError(f'the column "{column}" of {name}: {error}') from None
        seen.add(quantity)
        numbers = _numbers(values, factor, _core.si_unit(unit) == "s", f'the column "{column}" of {name}')
        if numbers.ndim != 1:
            raise ArgumentError(f'the column "{column}" of {name} has the shape {numbers.shape}, expected (frames,)')
        if np.any(np.isinf(numbers)):
            raise ArgumentError(f'the column "{column}" of {name} has an infinite value; NaN stands for a missing one')
        if quantity == "t":
            times = numbers
        else:
            channels.append({"name": quantity, "unit": _core.si_unit(unit), "values": numbers})
    if times is None:
        raise ArgumentError(f'{name} has no column of times; "t[s]" was expected')
    for c in channels:
        if c["values"].shape != times.shape:
            raise ArgumentError(f'"{c["name"]}" of {name} has the shape {c["values"].shape}, expected that of its times, {times.shape}')
    if np.any(np.isnan(times)) or not np.all(np.diff(times) > 0):
        raise ArgumentError(f"the times of {name} do not increase, or one is missing")
    is_seen = np.all([~np.isnan(c["values"]) for c in channels], axis=0)
    if not channels or not np.any(is_seen):
        raise ArgumentError(f"there is no frame of {name} in which all its quantities are seen")
    first = int(np.argmax(is_seen))
    for c in channels:
        c["values"] = c["values"][first:]
    return {"id": name, "labels": labels, "times": times[first:] - times[first], "channels": channels}
