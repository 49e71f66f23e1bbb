"""Whether a function is the one of an earlier run: what it computes depends on, as one hash."""

from __future__ import annotations

import functools
import hashlib
import io
import pathlib
import pickle
import sys
import types
from typing import Any, Optional

import numpy as np

_LIBRARIES = frozenset((*sys.stdlib_module_names, __name__.partition(".")[0]))

_TOLD = (types.FunctionType, functools._lru_cache_wrapper, np.vectorize, type, set, frozenset)
"""What is told also where it stands inside of something that is pickled."""


class _Unknown(Exception):
    """What cannot be told of something."""


class _Pickler(pickle.Pickler):
    """Leaves to a teller what a pickle only names, or has in another order in each run."""

    def __init__(self, file: io.BytesIO, teller: _Teller) -> None:
        super().__init__(file, 4)
        self._teller = teller

    def persistent_id(self, thing: Any) -> Optional[str]:
        if not isinstance(thing, _TOLD):
            return None
        self._teller.tell(thing)
        return "told"


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
        elif isinstance(thing, functools._lru_cache_wrapper):
            self._add("cached")
            self.tell(thing.__wrapped__)
        elif isinstance(thing, functools.partial):
            self._add("partial")
            for part in (thing.func, thing.args, thing.keywords):
                self.tell(part)
        elif isinstance(thing, np.vectorize):
            # Without what it keeps of its calls.
            for part in (type(thing), thing.pyfunc, thing.otypes, thing.signature, thing.excluded):
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
        elif isinstance(thing, type):
            self._class(thing)
        else:
            self._object(thing)

    def _function(self, function: types.FunctionType) -> None:
        self._add(f"function {function.__module__}.{function.__qualname__}")
        # What a function of a library makes holds what it was given.
        if self._is_library(function.__module__) and "<locals>" not in function.__qualname__:
            return
        for part in (function.__code__, function.__defaults__, function.__kwdefaults__, vars(function)):
            self.tell(part)
        for cell in function.__closure__ or ():
            try:
                contents = cell.cell_contents
            except ValueError:
                self._add("an empty cell")
                continue
            self.tell(contents)
        self._globals(_names(function.__code__), function.__globals__)

    def _globals(self, names: list[str], first: dict[str, Any]) -> None:
        """What names stand for in a module, and in those of the user that it names: ``helper`` of ``own.helper``."""
        spaces = [first]
        for space in spaces:
            for name in names:
                if name not in space:
                    continue
                thing = space[name]
                self._add(f"global {name}")
                self.tell(thing)
                is_own = isinstance(thing, types.ModuleType) and not self._is_library(thing.__name__)
                if is_own and not any(vars(thing) is known for known in spaces):
                    spaces.append(vars(thing))

    def _class(self, kind: type) -> None:
        self._add(f"class {kind.__module__}.{kind.__qualname__}")
        for base in kind.__mro__:
            if self._is_library(base.__module__):
                continue
            for name, member in vars(base).items():
                for part in _parts(name, member):
                    self._add(f"member {name}")
                    self.tell(part)

    def _object(self, thing: Any) -> None:
        self.tell(type(thing))
        file = io.BytesIO()
        try:
            _Pickler(file, self).dump(thing)
        except _Unknown:
            raise
        except Exception as error:
            raise _Unknown(f"its {type(thing).__name__} cannot be pickled: {error}") from None
        self.digest.update(file.getvalue())

    def _is_library(self, name: Optional[str]) -> bool:
        """Whether a module is Python's, Samara's, or was installed: what it holds is told by its name."""
        if name is None or name == self._module:
            return False
        if name.partition(".")[0] in _LIBRARIES:
            return True
        file = getattr(sys.modules.get(name), "__file__", None)
        if file is None:
            return False
        return not {"site-packages", "dist-packages"}.isdisjoint(pathlib.Path(file).parts)

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
    is_pythons = isinstance(member, (types.MemberDescriptorType, types.GetSetDescriptorType)) or name == "_abc_impl"
    return () if is_pythons or (name.startswith("__") and not callable(member)) else (member,)


def _names(code: types.CodeType) -> list[str]:
    """Names that the code and those inside it ask for, which may be globals."""
    inner = [name for c in code.co_consts if isinstance(c, types.CodeType) for name in _names(c)]
    return sorted({*code.co_names, *inner})


def identity(function: Any, *more: Any) -> tuple[str, str]:
    """A hash of the function and what it holds: code, defaults, closures, its object with its class, what it
    takes from its module and from others of the user.

    :param more: what else makes the difference
    :returns: the hash, and why it says nothing, or an empty text
    """
    inner = function
    while isinstance(inner, (functools.partial, np.vectorize)):
        inner = inner.func if isinstance(inner, functools.partial) else inner.pyfunc
    teller = _Teller(getattr(inner, "__module__", None))
    try:
        for thing in (function, *more):
            teller.tell(thing)
    except (_Unknown, RecursionError) as unknown:
        return "unknown", str(unknown)
    return teller.digest.hexdigest()[:16], ""
