"""Models: those that Samara has, those that you write, and their trajectories."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union, overload

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._contents import ModelInfo, Output, Parameter, State, in_si
from ._errors import ArgumentError, UnknownNameError
from ._units import Quantity, as_mapping, check_names, names_in, one_si, text_in, to_si, truth, unmasked

_STEP = 1e-30
"""Of the complex step: so small that its square is lost to rounding, and no digit is."""


class Model:
    """A model from a Python function: x' = rhs(t, x, p).

    ``rhs`` is written for many points at once: ``x`` and ``p`` have a row for each state and parameter, and it returns
    a rate for each state::

        def pendulum(t, x, p):
            angle, speed = x
            length, damping = p
            return speed, -9.81 / length * np.sin(angle) - damping * speed

        model = samara.Model(
            pendulum,
            states={"angle": "rad", "speed": "rad/s"},
            parameters={"length": "m", "damping": samara.Parameter("damping", "1/s", default=0.1)},
        )

    Derivatives come from complex steps, exact to rounding, so that ``rhs`` must bear complex numbers: ``np.sqrt(v * v)``
    in place of ``np.abs(v)``, which forgets their derivative. Else ``jacobian(t, x, p)`` gives them: by states
    (states, states) and by parameters (states, parameters), each entry a number or, where ``x`` has many points, a row of
    them. Where derivatives are taken, both are held against differences now and then, and what does not agree is refused:
    sensitivities and fits take them, most builds do not.

    Where single trajectories are integrated, each step calls Python: some ten microseconds. Builders ask for many points
    in one call.
    """

    def __init__(
        self,
        rhs: Callable[[Any, Any, Any], Any],
        states: Mapping[str, Union[str, State]],
        parameters: Mapping[str, Union[str, Parameter]],
        jacobian: Optional[Callable[[Any, Any, Any], tuple[Any, Any]]] = None,
        *,
        name: Optional[str] = None,
        title: str = "",
        source: str = "",
        validity: str = "",
    ) -> None:
        self.rhs = rhs
        self.jacobian = jacobian
        for function, what in [(rhs, "rhs"), (jacobian, "jacobian")]:
            if not callable(function) and not (what == "jacobian" and function is None):
                raise ArgumentError(f"{what} is of the type {type(function).__name__}, expected a function of (t, x, p)")
        as_mapping(states, "states")
        as_mapping(parameters, "parameters")
        for key, state in states.items():
            if not isinstance(state, (str, State)):
                raise ArgumentError(f"{key} is {state!r}, expected its unit or a samara.State")
        for key, parameter in parameters.items():
            if not isinstance(parameter, (str, Parameter)):
                raise ArgumentError(f"{key} is {parameter!r}, expected its unit or a samara.Parameter")
        self.name = text_in(name or getattr(rhs, "__name__", type(rhs).__name__), "name")
        self.states = tuple(in_si(s if isinstance(s, State) else State(n, s)) for n, s in states.items())
        self.parameters = tuple(
            in_si(p if isinstance(p, Parameter) else Parameter(n, p)) for n, p in parameters.items()
        )
        own = [s.name for s in self.states] + [p.name for p in self.parameters]
        for name, given in zip(own, [*states, *parameters]):
            if name != given:
                raise ArgumentError(f'the model "{self.name}" has "{name}" under the name "{given}"; one name was expected')
        for name in own:
            if name == "t" or own.count(name) > 1:
                other = "that of the time" if name == "t" else "given twice"
                raise ArgumentError(f'the name "{name}" in the model "{self.name}" is {other}; one of its own was expected')
        if not self.states:
            raise ArgumentError(f'the model "{self.name}" has no state')
        text = (getattr(rhs, "__doc__", None) or "").strip().splitlines()
        self._calls = 0
        self._description = {
            "name": self.name,
            "title": text_in(title, "title") or (text[0] if text else "a model in Python"),
            "equations": f"Python: {getattr(rhs, '__module__', '')}.{getattr(rhs, '__qualname__', self.name)}(t, x, p)",
            "frames": "those of the function",
            "source": text_in(source, "source") or "the caller",
            "validity": text_in(validity, "validity") or "not said",
            "states": [vars(s) for s in self.states],
            "parameters": [
                {
                    **vars(p),
                    "lower": -math.inf if p.lower is None else p.lower,
                    "upper": math.inf if p.upper is None else p.upper,
                }
                for p in self.parameters
            ],
        }

    def __repr__(self) -> str:
        states = ", ".join(s.name for s in self.states)
        return f"<samara.Model {self.name}: {states}; parameters {', '.join(p.name for p in self.parameters)}>"

    def _rates(self, t: Any, x: NDArray[np.float64], p: NDArray[np.float64]) -> NDArray[np.float64]:
        rates = self._rows(self.rhs(t, x, p), x.shape)
        if rates.dtype.kind == "c":
            raise ArgumentError(f'the function of the model "{self.name}" gave complex numbers for real ones')
        return np.ascontiguousarray(rates, dtype=float)

    def _derivatives(self, t: Any, x: NDArray[np.float64], p: NDArray[np.float64]) -> tuple[Any, Any, Any]:
        n, m = len(x), len(p)
        if self.jacobian is not None:
            by_states, by_parameters = self._given(t, x, p)
            pair = self._shaped(by_states, (n, n), "states"), self._shaped(by_parameters, (n, m), "parameters")
            if self._is_to_check():
                self._check(t, x, p, np.hstack(pair))
            return self._rates(t, x, p), *pair
        xs = np.repeat(x[:, None].astype(complex), n + m, 1)
        ps = np.repeat(p[:, None].astype(complex), n + m, 1)
        xs[range(n), range(n)] += 1j * _STEP
        ps[range(m), range(n, n + m)] += 1j * _STEP
        rates = self._complex(t, xs, ps)
        slopes = rates.imag / _STEP
        if self._is_to_check():
            self._check(t, x, p, slopes)
        return rates[:, 0].real, slopes[:, :n], slopes[:, n:]

    def _jacobians(self, t: Any, x: NDArray[np.float64], p: NDArray[np.float64]) -> NDArray[np.float64]:
        n, points = x.shape
        if self.jacobian is not None:
            by_states, _ = self._given(t, x, p)
            result = np.empty((n, n, points))
            if len(by_states) != n or any(len(row) != n for row in by_states):
                raise ArgumentError(f'jacobian of the model "{self.name}" gave no {n} rows of {n} derivatives by states')
            for i in range(n):
                for k in range(n):
                    result[i, k] = by_states[i][k]
            self._check_some(t, x, p, result)
            return result
        # Point after point for each direction: (states, directions, points).
        xs = np.repeat(x[:, None, :].astype(complex), n, 1)
        xs[range(n), range(n)] += 1j * _STEP
        ps = np.repeat(p[:, None, :], n, 1)
        rates = self._complex(np.tile(t, n), xs.reshape(n, -1), ps.reshape(len(p), -1))
        slopes = np.ascontiguousarray((rates.imag / _STEP).reshape(n, n, points))
        self._check_some(t, x, p, slopes)
        return slopes

    def _given(self, t: Any, x: NDArray[np.float64], p: NDArray[np.float64]) -> tuple[Any, Any]:
        pair = self.jacobian(t, x, p)  # type: ignore[misc]
        if not isinstance(pair, (tuple, list)) or len(pair) != 2:
            raise ArgumentError(f'jacobian of the model "{self.name}" gave no pair: derivatives by states, and by parameters')
        return pair[0], pair[1]

    def _shaped(self, given: Any, shape: tuple[int, int], what: str) -> NDArray[np.float64]:
        slopes = np.array(given, float)
        if slopes.shape != shape and not (slopes.size == 0 and shape[1] == 0):
            raise ArgumentError(
                f'jacobian of the model "{self.name}" gave the shape {slopes.shape} of derivatives by {what}, expected {shape}: '
                "a row for each state"
            )
        return slopes.reshape(shape)

    def _check_some(self, t: Any, x: NDArray[np.float64], p: NDArray[np.float64], slopes: NDArray[np.float64]) -> None:
        points = x.shape[1]
        if points > 0 and self._is_to_check():
            for j in {0, points // 2, points - 1}:
                self._check(t[j], x[:, j], p[:, j], slopes[:, :, j])

    def _is_to_check(self) -> bool:
        """At calls 1, 2, 4, 8, ..: where a motion begins at rest, much looks right that is not."""
        self._calls += 1
        return self._calls & (self._calls - 1) == 0

    def _check(self, t: Any, x: NDArray[np.float64], p: NDArray[np.float64], slopes: NDArray[np.float64]) -> None:
        """Holds derivatives by states and parameters, as far as they are given, against differences.

        Differences count only where those of three steps agree: rounding, fast oscillations and the end of a domain make
        them differ. At a kink one of the two sides may agree.
        """
        at = np.concatenate([x, p])
        scales = [s.scale or 1.0 for s in self.states] + [1.0] * len(p)
        names = [s.name for s in self.states] + [q.name for q in self.parameters]
        with np.errstate(all="ignore"):
            here = self._rates(t, x, p)
            for k in range(slopes.shape[1]):
                # Below the size of a number, so that none changes its sign.
                size = abs(at[k]) or scales[k]
                sides = self._differences(t, at, here, k, size)
                if sides is None:
                    continue
                for i, slope in enumerate(slopes[:, k]):
                    ends = sides[0, :, i]
                    spread = np.abs(sides[:, :, i] - ends).max(axis=0)
                    if not np.all(spread <= 1e-4 * np.abs(ends)):
                        continue
                    if min(abs(slope - v) for v in (*ends, ends.mean())) <= 1e-3 * max(abs(slope), *np.abs(ends)):
                        continue
                    if not np.any(ends) and self._is_seen_afar(t, at, here, k, size, i):
                        continue
                    self._refuse(self.states[i].name, names[k], slope, ends.mean())

    def _differences(
        self, t: Any, at: NDArray[np.float64], here: NDArray[np.float64], k: int, size: float
    ) -> Optional[NDArray[np.float64]]:
        """By number k: (steps, the side above and the one below, states); None where the function does not bear them."""
        found = np.empty((3, 2, len(here)))
        for row, share in zip(found, (1e-6, 3e-7, 1e-7)):
            for side, sign in zip(row, (1.0, -1.0)):
                moved = at.copy()
                moved[k] += sign * share * size
                try:
                    side[:] = (self._rates(t, moved[: len(here)], moved[len(here) :]) - here) / (moved[k] - at[k])
                except Exception:
                    return None
        return found if np.isfinite(found).all() else None

    def _is_seen_afar(
        self, t: Any, at: NDArray[np.float64], here: NDArray[np.float64], k: int, size: float, i: int
    ) -> bool:
        """Whether a rate that small steps leave as it is, which rounding may do, changes with large ones."""
        moved = at.copy()
        moved[k] += 0.5 * size
        try:
            return bool(self._rates(t, moved[: len(here)], moved[len(here) :])[i] != here[i])
        except Exception:
            return True

    def _refuse(self, state: str, name: str, slope: float, difference: float) -> None:
        is_given = self.jacobian is not None
        why = (
            f'jacobian and the function of the model "{self.name}" do not belong together'
            if is_given
            else f'the function of the model "{self.name}" uses what forgets derivatives of complex numbers, as np.abs does; '
            "jacobian=.. gives them"
        )
        raise ArgumentError(
            f'the derivative of the rate of "{state}" by "{name}" is {slope:.6g} by {"jacobian" if is_given else "complex steps"} '
            f"and {difference:.6g} by differences: {why}"
        )

    def _complex(self, t: Any, x: NDArray[np.complex128], p: Any) -> NDArray[np.complex128]:
        try:
            return self._rows(self.rhs(t, x, p), x.shape).astype(complex)
        except TypeError as error:
            error.args = (
                f"{error} (derivatives of the model {self.name} are taken by complex steps; where its function does not "
                "bear complex numbers, samara.Model(.., jacobian=..) takes them)",
            )
            raise

    def _rows(self, rates: Any, shape: tuple[int, ...]) -> NDArray[Any]:
        what = "the function's answer"
        if isinstance(rates, np.ndarray) and rates.shape == shape:
            return unmasked(rates, what)
        rows = [unmasked(row, what) for row in rates]
        if len(rows) != len(self.states):
            raise ArgumentError(
                f'the function of the model "{self.name}" gave {len(rows)} rates, expected {len(self.states)}, one for each '
                "state"
            )
        result = np.empty(shape, np.result_type(*rows))
        for k, row in enumerate(rows):
            result[k] = row
        return result


AnyModel = Union[str, "os.PathLike[str]", Model]


def core_model(model: AnyModel) -> Any:
    """As the extension module takes it."""
    if isinstance(model, Model):
        return model
    if isinstance(model, (str, os.PathLike)):
        return os.fspath(model)
    raise ArgumentError(f"the model is of the type {type(model).__name__}, expected a name, a file, or a samara.Model")


@overload
def models() -> dict[str, ModelInfo]: ...
@overload
def models(model: AnyModel) -> ModelInfo: ...
def models(model: Optional[AnyModel] = None) -> Union[dict[str, ModelInfo], ModelInfo]:
    """All models and fields of Samara by name, or what is to be known of one: a name, a file of equations, a ``Model``."""
    if model is None:
        return {name: _info(name) for name in _core.model_names()}
    return _info(model)


def _info(model: AnyModel) -> ModelInfo:
    d = _core.describe_model(core_model(model))
    states = tuple(State(s["name"], s["unit"], s["default_initial"], s["description"]) for s in d.pop("states"))
    parameters = tuple(Parameter(**p) for p in d.pop("parameters"))
    outputs = tuple(Output(o["name"], o["unit"]) for o in d.pop("outputs"))
    terms = {t["name"]: t["description"] for t in d.pop("force_terms")}
    plain = {k: tuple(v) if isinstance(v, list) else v for k, v in d.items()}
    return ModelInfo(states=states, parameters=parameters, outputs=outputs, force_terms=terms, **plain)


@dataclass(frozen=True, eq=False)
class Simulation:
    """Trajectories of the reference integrator.

    ``values`` (.., times, outputs) and ``sensitivities`` (.., times, outputs, parameters) or None, SI, NaN after a
    trajectory has ended; ``problems`` (..) says why, an empty text where it came to the last time. ``outputs`` are the
    ``states`` and then what the model derives from them.
    """

    times: NDArray[np.float64]
    states: tuple[str, ...]
    outputs: tuple[str, ...]
    values: NDArray[np.float64]
    parameters: tuple[str, ...]
    sensitivities: Optional[NDArray[np.float64]]
    problems: NDArray[np.str_]

    @property
    def done(self) -> bool:
        """Whether all trajectories came to the last time."""
        return not np.any(self.problems != "")

    def __getitem__(self, output: str) -> NDArray[np.float64]:
        """One state, or what follows from the states, (.., times)."""
        check_names([output], self.outputs, "output", UnknownNameError)
        return self.values[..., self.outputs.index(output)]

    def __iter__(self) -> Iterator[str]:
        return iter(self.outputs)


def simulate(
    model: AnyModel,
    parameters: Mapping[str, Quantity],
    times: Union[Quantity, Sequence[Quantity]],
    sensitivities: Union[bool, Sequence[str]] = False,
    *,
    relative_tolerance: float = 1e-10,
    stiff: bool = False,
) -> Simulation:
    """Integrates a model by CVODES, from t = 0.

    :param parameters: by name, initial values as ``"s(0)"``, SI or with a unit; broadcast against each other
    :param times: (times,), not decreasing, from 0 on
    :param sensitivities: derivatives by all parameters given, or by those named
    """
    as_mapping(parameters, "parameters")
    info = _info(model)
    units = {p.name: p.unit for p in info.parameters} | {f"{s.name}(0)": s.unit for s in info.states}
    check_names(parameters, list(units), "parameter")
    frames = to_si(times, info.time_unit, "times")
    if frames.ndim != 1:
        raise ArgumentError(f"times have the shape {frames.shape}, expected (times,)")
    values = {name: to_si(value, units[name], name) for name, value in parameters.items()}
    if isinstance(sensitivities, bool):
        wanted = list(values) if sensitivities else []
    else:
        wanted = names_in(sensitivities, "sensitivities")
        check_names(wanted, list(units), "parameter")
        for name in wanted:
            if name not in values:
                raise ArgumentError(f'"{name}" of sensitivities is not given, expected among the parameters')
    try:
        shape = np.broadcast_shapes(*(v.shape for v in values.values()))
    except ValueError:
        shapes = ", ".join(f"{n} {v.shape}" for n, v in values.items())
        raise ArgumentError(f"shapes that do not broadcast: {shapes}") from None
    free = wanted + [n for n, v in values.items() if v.ndim > 0 and n not in wanted]
    fixed = {n: float(v) for n, v in values.items() if n not in free}
    points = np.empty((math.prod(shape), len(free)))
    for k, name in enumerate(free):
        points[:, k] = np.broadcast_to(values[name], shape).ravel()
    found, slopes, problems = _core.simulate(
        core_model(model), fixed, free, points, frames, bool(wanted), one_si(relative_tolerance, "1", "relative_tolerance"),
        truth(stiff, "stiff"),
    )
    names = tuple(s.name for s in info.states)
    outputs = (*names, *(o.name for o in info.outputs))
    size = (*shape, len(frames), len(outputs))
    if slopes is not None:
        slopes = slopes[..., : len(wanted)].reshape(*size, len(wanted))
    return Simulation(
        frames, names, outputs, found.reshape(size), tuple(wanted), slopes, np.array(problems, dtype=str).reshape(shape)
    )
