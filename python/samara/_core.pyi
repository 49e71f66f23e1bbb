"""The extension module; what users call stands in the modules beside it."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

__version__: str

_Array = NDArray[np.float64]
_Report = Optional[Callable[[str, float], Optional[bool]]]
_Path = Union[str, "os.PathLike[str]"]

def si(text: str, unit: str) -> float: ...
def si_unit(unit: str) -> str: ...

class Book:
    @staticmethod
    def open(path: _Path) -> Book: ...
    def save(self, path: _Path) -> None: ...
    def describe(self) -> dict[str, Any]: ...
    def outlines(self) -> list[dict[str, Any]]: ...
    def numbers(self) -> list[dict[str, Any]]: ...
    def statistics(
        self,
        inputs: Mapping[str, tuple[str, float, float]],
        fixed: Mapping[str, float],
        groups: Sequence[Sequence[str]],
        quantiles: Sequence[float],
        draws: int,
        seed: int,
    ) -> dict[str, Any]: ...
    def slice(self, held: Mapping[str, float]) -> Book: ...
    def at(
        self,
        points: _Array,
        outputs: Sequence[str] = ...,
        held: Mapping[str, float] = ...,
        precision: str = ...,
        order: int = ...,
        out: Optional[_Array] = ...,
        threads: Optional[int] = ...,
    ) -> Any: ...
    def trajectories(
        self,
        parameters: _Array,
        times: _Array,
        outputs: Sequence[str] = ...,
        held: Mapping[str, float] = ...,
        precision: str = ...,
        gradient: bool = ...,
        out: Optional[_Array] = ...,
        threads: Optional[int] = ...,
    ) -> Any: ...

class Fit:
    @property
    def is_usable(self) -> bool: ...
    @property
    def message(self) -> str: ...
    @property
    def has_objective(self) -> bool: ...
    @property
    def widened_errors(self) -> list[Optional[float]]: ...
    def json(self) -> str: ...
    def series_json(self) -> Optional[str]: ...
    def text(self) -> str: ...
    def html(self) -> str: ...
    def series_book(self) -> Book: ...
    def unknowns(self) -> list[dict[str, Any]]: ...
    def answer(self) -> _Array: ...
    def residuals(self, q: _Array) -> _Array: ...
    def jacobian(self, q: _Array) -> _Array: ...
    def log_posterior(self, q: _Array, gradient: bool) -> Any: ...

def build(
    path: Optional[_Path],
    text: str,
    model: Any,
    progress: _Report,
    checkpoint: _Path,
    resume: bool,
    certificate_points: Optional[int],
) -> tuple[Book, bool, str, list[str]]: ...
def separate(
    call: Callable[[_Array], _Array],
    plan: str,
    progress: _Report,
    checkpoint: _Path,
    resume: bool,
    certificate_points: Optional[int],
) -> tuple[Book, bool, str]: ...
def model_names() -> list[str]: ...
def describe_model(model: Any) -> dict[str, Any]: ...
def simulate(
    model: Any,
    fixed: Mapping[str, float],
    free: Sequence[str],
    points: _Array,
    times: _Array,
    sensitivities: bool,
    relative_tolerance: float,
    stiff: bool,
) -> tuple[_Array, Optional[_Array], list[str]]: ...
def fit(request: Mapping[str, Any], book: Optional[Book], model: Any, progress: _Report) -> Fit: ...
