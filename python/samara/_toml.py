"""Plans and configs as dictionaries: the text of the file that says the same."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ._errors import ArgumentError
from ._units import text_in

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


def dumps(table: Mapping[str, Any]) -> str:
    """TOML text: each key on a line of its own, tables in braces."""
    return "".join(f"{_key(name)} = {_value(value, name)}\n" for name, value in table.items() if value is not None)


def _key(name: object) -> str:
    if not isinstance(name, str):
        raise ArgumentError(f"the key {name!r} is no text")
    return name if _BARE.match(name) else _text(name, "a key")


def _text(text: str, what: str) -> str:
    return json.dumps(text_in(text, what), ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, key: str) -> str:
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ArgumentError(f'"{key}" is {value}, expected a finite number')
        text = repr(value)
        return text if any(c in text for c in ".en") else text + ".0"
    if isinstance(value, (str, os.PathLike)):
        return _text(os.fspath(value), f'"{key}"')
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v, k)}" for k, v in value.items() if v is not None) + " }"
    if isinstance(value, (list, tuple, range)):
        return "[" + ", ".join(_value(v, key) for v in value) + "]"
    raise ArgumentError(f'"{key}" is of the type {type(value).__name__}, which no file of TOML can hold')
