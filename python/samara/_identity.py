"""Whether a function is the one of an earlier run: what it computes depends on, as one hash."""

from __future__ import annotations

import functools
import hashlib
import pickle
import types
from typing import Any, Optional


class _Unknown(Exception):
    """What cannot be told of something."""


class _Teller:
    """Feeds a hash with all that a function consists of, alike in each run of the same program."""

    def __init__(self, module: Optional[str]) -> None:
        self.digest = hashlib.sha256()
        self._module = module
        self._seen: dict[int, int] = {}
        self._kept: list[Any] = []

    def tell(self, thing: Any) -> None:
        if thing is None or isinstance(thing, (bool, int, float, complex, str, bytes)) or thing is Ellipsis:
            self._add(f"{type(thing).__name__} {thing!r}")
            return
        if id(thing) in self._seen:
            self._add(f"again {self._seen[id(thing)]}")
            return
        self._seen[id(thing)] = len(self._seen)
        self._kept.append(thing)  # so that no other thing gets its id
        if isinstance(thing, types.CodeType):
            self._add(f"code {thing.co_code.hex()} {thing.co_names!r}")
            self.tell(thing.co_consts)
        elif isinstance(thing, types.FunctionType):
            self._function(thing)
        elif isinstance(thing, types.MethodType):
            self._add("method")
            self.tell(thing.__func__)
            self.tell(thing.__self__)
        elif isinstance(thing, functools.partial):
            self._add("partial")
            for part in (thing.func, thing.args, thing.keywords):
                self.tell(part)
        elif isinstance(thing, types.ModuleType):
            self._add(f"module {thing.__name__}")
        elif type(thing) in (list, tuple):
            self._add(f"{type(thing).__name__} {len(thing)}")
            for item in thing:
                self.tell(item)
        elif type(thing) is dict:
            self._add(f"dict {len(thing)}")
            for key, value in thing.items():
                self.tell(key)
                self.tell(value)
        elif isinstance(thing, (set, frozenset)):
            # Their order is another one in each run.
            self._add(f"set {sorted(map(repr, thing))!r}")
        else:
            self._other(thing)

    def _function(self, function: types.FunctionType) -> None:
        self._add(f"function {function.__module__}.{function.__qualname__}")
        if self._module is not None and function.__module__ != self._module:
            return  # of a library
        for part in (function.__code__, function.__defaults__, function.__kwdefaults__):
            self.tell(part)
        for cell in function.__closure__ or ():
            try:
                contents = cell.cell_contents
            except ValueError:
                self._add("an empty cell")
                continue
            self.tell(contents)
        for name in _names(function.__code__):
            if name in function.__globals__:
                self._add(f"global {name}")
                self.tell(function.__globals__[name])

    def _class(self, kind: type) -> None:
        for base in kind.__mro__:
            if base.__module__ != self._module:
                continue  # of a library
            for name, member in vars(base).items():
                for part in _parts(name, member):
                    self._add(f"member {name}")
                    self.tell(part)

    def _other(self, thing: Any) -> None:
        if isinstance(thing, type):
            self._class(thing)
        else:
            self._class(type(thing))
            call = getattr(type(thing), "__call__", None)
            if isinstance(call, types.FunctionType):
                self.tell(call)
        try:
            self.digest.update(pickle.dumps(thing, 4))
        except Exception as error:
            raise _Unknown(f"its {type(thing).__name__} cannot be pickled: {error}") from None

    def _add(self, text: str) -> None:
        self.digest.update(text.encode() + b"\0")


def _parts(name: str, member: Any) -> tuple[Any, ...]:
    """What a member of a class computes with: its functions, or its value."""
    if isinstance(member, property):
        return (member.fget, member.fset, member.fdel)
    if isinstance(member, (staticmethod, classmethod)):
        return (member.__func__,)
    if isinstance(member, functools.cached_property):
        return (member.func,)
    is_value = isinstance(member, (bool, int, float, complex, str, bytes)) and not name.startswith("__")
    return (member,) if is_value or isinstance(member, types.FunctionType) else ()


def _names(code: types.CodeType) -> list[str]:
    """Names that the code and those inside it ask for, which may be globals."""
    inner = [name for c in code.co_consts if isinstance(c, types.CodeType) for name in _names(c)]
    return sorted({*code.co_names, *inner})


def identity(function: Any, *more: Any) -> tuple[str, str]:
    """A hash of the function and what it holds: code, defaults, closures, its object with its class, what it
    takes from its module.

    :param more: what else makes the difference
    :returns: the hash, and why it says nothing, or an empty text
    """
    inner = function
    while isinstance(inner, functools.partial):
        inner = inner.func
    teller = _Teller(getattr(inner, "__module__", None))
    try:
        for thing in (function, *more):
            teller.tell(thing)
    except _Unknown as unknown:
        return "unknown", str(unknown)
    return teller.digest.hexdigest()[:16], ""
