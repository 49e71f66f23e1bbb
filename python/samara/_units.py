"""Quantities: SI numbers, arrays of them, or texts such as ``"10 cm/s"``."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._errors import ArgumentError

Quantity = Any
"""A number in SI, a text with a unit, or an array of either."""


def to_si(value: Quantity, unit: str, what: str) -> NDArray[np.float64]:
    """The value in SI, as an array (of no dimension for one number)."""
    if isinstance(value, str):
        return np.asarray(_si(value, unit, what))
    array = unmasked(value, what)
    if array.dtype.kind in "US" or array.dtype.kind == "O":
        flat = [_si(v, unit, what) if isinstance(v, str) else _number(v, what) for v in array.ravel().tolist()]
        return np.array(flat, dtype=float).reshape(array.shape)
    if array.dtype.kind not in "fiub":
        raise ArgumentError(f"{what} is of the type {array.dtype}, expected numbers or texts with a unit")
    return array.astype(float, copy=False)


def one_si(value: Quantity, unit: str, what: str, *, least: Optional[float] = None, above: Optional[float] = None) -> float:
    """The same of a single number, finite where it has a limit."""
    array = to_si(value, unit, what)
    if array.size != 1:
        raise ArgumentError(f"{what} has {array.size} values, expected one")
    number = float(array.reshape(()))
    is_wrong = (least is not None and not least <= number < np.inf) or (above is not None and not above < number < np.inf)
    if is_wrong:
        limit = f"from {least:g} on" if least is not None else f"above {above:g}"
        raise ArgumentError(f"{what} is {number:g}{'' if unit == '1' else f' {unit}'}, expected a finite number {limit}")
    return number


def finite(array: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    """As it is, where all numbers are finite."""
    wrong = array[~np.isfinite(array)]
    if wrong.size:
        raise ArgumentError(f"{what}: a number is {wrong[0]:g}, expected finite ones")
    return array


def one_difference(value: Quantity, unit: str, what: str) -> float:
    """The same of what lies between two values, such as a deviation: "20 degC" is none."""
    if not isinstance(value, str):
        value = np.asarray(value)
        if value.dtype.kind in "USO" and value.size == 1:
            value = value.reshape(()).item()
    return _si(value, unit, what, _core.difference_si) if isinstance(value, str) else one_si(value, unit, what)


def _number(value: Any, what: str) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ArgumentError(f"{what} is beyond the largest number, {np.finfo(float).max:.1e}") from None
    except (TypeError, ValueError):
        raise ArgumentError(f"{what} is {value!r}, expected a number or a text with a unit") from None


def whole(value: Any, what: str, most: int = 2**31 - 1, least: int = 0) -> Optional[int]:
    """A count that may be left out."""
    if value is None:
        return None
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or value < least:
        raise ArgumentError(f"{what} is {value!r}, expected a whole number from {least} on")
    if value > most:
        raise ArgumentError(f"{what} is {value}, expected a whole number from {least} to {most}")
    return int(value)


def counted(value: Any, what: str, most: int = 2**31 - 1, least: int = 0) -> int:
    """A count that is given."""
    number = whole(value, what, most, least)
    if number is None:
        raise ArgumentError(f"{what} is None, expected a whole number from {least} on")
    return number


def truth(value: Any, what: str) -> bool:
    """True or False, of Python or NumPy."""
    if not isinstance(value, (bool, np.bool_)):
        raise ArgumentError(f"{what} is {value!r}, expected True or False")
    return bool(value)


def text_in(given: Any, what: str) -> str:
    """A text that a file can hold, which half of a surrogate pair is not."""
    if not isinstance(given, str):
        raise ArgumentError(f"{what} is {given!r}, expected a text")
    try:
        given.encode()
    except UnicodeEncodeError:
        raise ArgumentError(f"{what} is {given!r}, expected a text that UTF-8 can hold") from None
    return given


def names_in(given: Any, what: str) -> list[str]:
    """Names; one alone is a text."""
    names: list[Any] = [given] if isinstance(given, str) else list(given) if isinstance(given, Iterable) else [None]
    if not all(isinstance(name, str) for name in names):
        raise ArgumentError(f"{what} are {given!r}, expected names")
    return names


def file_in(given: Any, what: str) -> str:
    """A file's name; empty: none is given."""
    if given is not None and not isinstance(given, (str, os.PathLike)):
        raise ArgumentError(f"{what} is of the type {type(given).__name__}, expected a file")
    return "" if given is None else os.fspath(given)


def _si(text: str, unit: str, what: str, reader: Callable[[str, str], float] = _core.si) -> float:
    try:
        return reader(text, unit)
    except ArgumentError as error:
        raise ArgumentError(f"{what}: {error}") from None


def real_array(values: Any, what: str) -> NDArray[np.float64]:
    """As doubles, which complex numbers and texts are not."""
    array = unmasked(values, what)
    if array.dtype.kind not in "fiub":
        raise ArgumentError(f"{what} are of the type {array.dtype}, expected numbers")
    return array.astype(float, copy=False)


def unmasked(values: Any, what: str) -> NDArray[Any]:
    """As an array, which knows nothing of a mask."""
    missing = mask_of(values)
    if missing is not None and missing.any():
        raise ArgumentError(f"{what}: {missing.sum()} of {missing.size} values are masked, expected none")
    return np.asarray(values)


def mask_of(values: Any) -> Optional[NDArray[np.bool_]]:
    """Where a masked array has no value; None of another one."""
    return np.broadcast_to(values.mask, values.shape) if isinstance(values, np.ma.MaskedArray) else None


def by_name(given: Any, what: str) -> Optional[Mapping[str, Any]]:
    """Values by name: of a mapping, by the columns of a frame, or of one of its rows; None of what has no names."""
    if isinstance(given, Mapping):
        return given
    if hasattr(given, "columns"):
        names = list(given.columns)
    elif hasattr(given, "keys") and hasattr(given, "index"):
        names = list(given.keys())
        if not all(isinstance(name, str) for name in names):
            return None
    else:
        return None
    for name in names:
        if names.count(name) > 1:
            raise ArgumentError(f'{what} have "{name}" more than once, expected each name once')
    return {name: given[name] for name in names}


def as_mapping(given: Any, what: str) -> Mapping[str, Any]:
    """Names with their values, or a sentence."""
    if isinstance(given, Mapping):
        return given
    raise ArgumentError(f"{what} are given as {type(given).__name__}, expected names with their values, as in {{'C_D': 1.1}}")


def thresholds_in(given: Optional[Mapping[str, float]]) -> dict[str, float]:
    """Of the rule of patterns, those that are to be others than its own."""
    return {} if given is None else {str(k): one_si(v, "1", str(k)) for k, v in as_mapping(given, "thresholds").items()}


def check_names(given: Iterable[str], known: Sequence[str], what: str, error: type[ArgumentError] = ArgumentError) -> None:
    """Raises for a name that is not known, with the nearest."""
    for name in given:
        if name in known:
            continue
        near = difflib.get_close_matches(str(name), known, 1)
        hint = f'; did you mean "{near[0]}"?' if near else f"; known: {', '.join(known) or 'none'}"
        raise error(f'{what} "{name}" is unknown{hint}')


def stacked(values: Mapping[str, Quantity], coordinates: Sequence[Any], what: str) -> NDArray[np.float64]:
    """Values by name, broadcast against each other, as an array (.., coordinates).

    :param coordinates: things with ``name``, ``unit``, ``lower`` and ``upper``
    """
    names = [c.name for c in coordinates]
    check_names(values, names, what)
    arrays = []
    for c in coordinates:
        if c.name not in values:
            unit = "" if c.unit == "1" else f" {c.unit}"
            raise ArgumentError(f"{what} {c.name} is not given, expected a value in [{c.lower:g}, {c.upper:g}]{unit}")
        arrays.append(to_si(values[c.name], c.unit, c.name))
    try:
        shape = np.broadcast_shapes(*(a.shape for a in arrays))
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in zip(names, arrays))
        raise ArgumentError(f"shapes that do not broadcast: {shapes}") from None
    result = np.empty((*shape, len(names)))
    for k, array in enumerate(arrays):
        result[..., k] = array
    return result
