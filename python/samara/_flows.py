"""Winds, flows and clouds of realisations (docs/flow.md, docs/wind.md, docs/turbulence.md)."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._building import Path, Progress, Reported
from ._errors import ArgumentError, UnknownNameError
from ._labels import optional
from ._models import AnyModel, _info, core_model
from ._units import Quantity, as_mapping, check_names, counted, file_in, finite, names_in, one_si, real_array, to_si, truth, whole

_Array = NDArray[np.float64]


def _count(value: Any, what: str) -> int:
    """A whole number that may be large: a seed, the number of a realisation."""
    return counted(value, what, 2**62)


def _triples(values: ArrayLike, what: str) -> _Array:
    array = np.ascontiguousarray(real_array(values, what))
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ArgumentError(f"{what} have the shape {array.shape}, expected (.., 3)")
    return finite(array, what)


def _triple(values: ArrayLike, what: str) -> list[float]:
    array = real_array(values, what)
    if array.shape != (3,):
        raise ArgumentError(f"{what} has the shape {array.shape}, expected (3,)")
    return [float(value) for value in finite(array, what)]


class Wind:
    """A wind as its file says (docs/wind.md): mean profile, turbulence, gusts. World axes, z up, SI.

    :raises InputError: at the key that is wrong, when it is first asked
    """

    def __init__(self, path: Path) -> None:
        self.path = os.fspath(path)

    def __repr__(self) -> str:
        return f"<samara.Wind of {self.path}>"

    def profile(self, heights: Quantity) -> _Array:
        """Mean speed [m/s] at heights [m], any shape."""
        array = finite(to_si(heights, "m", "heights"), "heights")
        return _core.wind_profile(self.path, array.ravel()).reshape(array.shape)

    def velocity(
        self, times: Quantity, positions: ArrayLike, body_length: Quantity = 0.1, seed: int = 1, realisation: int = 0
    ) -> _Array:
        """One realisation of the field: velocities (.., 3) [m/s] at times (..,) [s] and positions (.., 3) [m], broadcast.

        :param body_length: the shortest wave, where the file names none
        """
        at = _triples(positions, "positions")
        t = finite(to_si(times, "s", "times"), "times")
        try:
            shape = np.broadcast_shapes(t.shape, at.shape[:-1])
        except ValueError:
            raise ArgumentError(f"shapes that do not broadcast: times {t.shape}, positions {at.shape}") from None
        found = _core.wind_velocities(
            self.path,
            one_si(body_length, "m", "body_length", above=0),
            _count(seed, "seed"),
            _count(realisation, "realisation"),
            np.ascontiguousarray(np.broadcast_to(t, shape)).ravel(),
            np.ascontiguousarray(np.broadcast_to(at, (*shape, 3))).reshape(-1, 3),
        )
        return found.reshape(*shape, 3)

    def series(
        self, points: ArrayLike, step: Quantity, samples: int, seed: int = 1, realisation: int = 0
    ) -> tuple[_Array, _Array]:
        """Series at points (points, 3): times (samples,) [s], and velocities (samples, points, 3) along, across and up [m/s].
        Points are along the wind, across it, and above the ground [m]; the file has ``[series]``."""
        at = _triples(points, "points")
        if at.ndim != 2:
            raise ArgumentError(f"points have the shape {at.shape}, expected (points, 3)")
        return _core.wind_series(
            self.path, at, one_si(step, "s", "step", above=0), _count(samples, "samples"), _count(seed, "seed"),
            _count(realisation, "realisation"),
        )


class Flow:
    """The flow about a body from the file of ``samara flow``: all in body lengths and U.

    ``summary`` is a dictionary (drag, Strouhal number, status and message, ..); ``units`` those of the fields; ``x``, ``y``
    (and ``z``) the centres of cells; ``flow["k"]`` a field as an array (x, y[, z]), NaN inside the body; ``open_share`` the open
    share of each cell.
    """

    def __init__(self, core: _core.Flow) -> None:
        self._core = core
        self.summary: dict[str, Any] = core.describe()
        self.units: dict[str, str] = self.summary.pop("fields")
        self.x = core.centres(0)
        self.y = core.centres(1)
        self.z = core.centres(2) if core.dimensions == 3 else None
        self.open_share = core.opened()

    @staticmethod
    def open(path: Path) -> Flow:
        """From its file."""
        return Flow(_core.Flow.open(os.fspath(path)))

    def __repr__(self) -> str:
        return f"<samara.Flow {' x '.join(map(str, self.open_share.shape))}: {', '.join(self.units)}>"

    def __getitem__(self, name: str) -> _Array:
        check_names([name], list(self.units), "field", UnknownNameError)
        return self._core.field(name)

    def __iter__(self) -> Any:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)


@dataclass(frozen=True, eq=False)
class Turbulence:
    """Energy that is the same everywhere, in a steady stream: k [m^2/s^2] and epsilon [m^2/s^3], or with units."""

    k: Quantity
    epsilon: Quantity
    stream: Sequence[float] = (0.0, 0.0, 0.0)
    decays: bool = False


@dataclass(frozen=True, eq=False)
class Wake:
    """The mean flow and the energy of a flow, of the size and at the place that is said: U [m/s], the body's length [m],
    the centre of its body [m]. What leaves its grid ends there as ``left_flow`` (``outside="end"``), or flies on in the stream
    as it flows in (``"stream"``)."""

    flow: Flow
    speed: Quantity
    length: Quantity
    place: Sequence[float] = (0.0, 0.0, 0.0)
    outside: str = "end"


@dataclass(frozen=True, eq=False)
class Cloud:
    """Many realisations of one motion. Statistics at a time are over those still flying then; errors are standard errors of
    the sampling, NaN where there are too few to tell.

    ``times`` (times,) [s]; ``states``, ``units`` of what statistics are of; ``flying`` (times,); ``mean``, ``mean_error``
    (times, states); ``covariance``, ``covariance_error`` (times, states, states); ``landings`` (landed, 5): number of the
    realisation, t [s], x, y, z [m]; ``status`` (realisations,); ``half_turns`` (realisations,), empty without an attitude;
    ``kept`` (kept, times, all_states), NaN after their end; ``steps_beyond_tenth``: share of steps longer than a tenth of the
    time in which the air changes.
    """

    times: _Array
    states: list[str]
    units: list[str]
    flying: _Array
    mean: _Array
    mean_error: _Array
    covariance: _Array
    covariance_error: _Array
    landings: _Array
    status: NDArray[np.str_]
    half_turns: NDArray[np.int64]
    all_states: list[str]
    kept: _Array
    first: int
    step: float
    steps_beyond_tenth: float
    cancelled: bool
    relative_error: float

    def __repr__(self) -> str:
        return f"<samara.Cloud of {len(self.status)} realisations, {len(self.landings)} landed>"

    @property
    def frame(self) -> Any:
        """A DataFrame with a row for each time: t, flying, and of each state its mean, the mean's error, its deviation."""
        columns: dict[str, Any] = {"t": self.times, "flying": self.flying}
        for k, name in enumerate(self.states):
            columns[name] = self.mean[:, k]
            columns[f"{name}_error"] = self.mean_error[:, k]
            columns[f"{name}_deviation"] = np.sqrt(self.covariance[:, k, k])
        return optional("pandas").DataFrame(columns)

    @property
    def landing_frame(self) -> Any:
        """A DataFrame with a row for each realisation that landed: realisation, t, x, y, z."""
        frame = optional("pandas").DataFrame(self.landings, columns=["realisation", "t", "x", "y", "z"])
        return frame.astype({"realisation": int})


def realise(
    model: AnyModel,
    parameters: Mapping[str, Quantity],
    times: Quantity,
    air: Union[Wind, Wake, Turbulence],
    realisations: int = 1000,
    seed: int = 1,
    *,
    ground: Optional[Quantity] = None,
    states: Sequence[str] = (),
    keep: int = 0,
    step: Optional[Quantity] = None,
    first: int = 0,
    antithetic: bool = False,
    relative_error: float = 0.0,
    C_0: float = 0.0,
    body_radius: Optional[Quantity] = None,
    rotation: bool = False,
    threads: Optional[int] = None,
    checkpoint: Optional[Path] = None,
    progress: Progress = False,
) -> Cloud:
    """Flies one release many times through a fluid that is random, as ``samara simulate --realisations`` does.

    :param model: one in gusts, such as ``immersed_body_in_gusts``
    :param parameters: by name, initial values as ``"s(0)"``, SI or with a unit
    :param times: (times,), not decreasing, from 0 on [s]: those of the statistics
    :param ground: height at which a body has landed [m]
    :param states: whose statistics are kept; none: those of the place
    :param keep: trajectories of so many first realisations are kept
    :param relative_error: stop as soon as the mean displacement is known so well
    :param C_0: of the fluid seen; 0: that of the local Reynolds number
    :param body_radius: over which the body averages the fluid [m]; None: its own
    :param checkpoint: a file that keeps what is done until all is: the same call goes on from it, to the same bits, and may ask
        for more realisations. That of another call is replaced; another file is refused
    :param progress: as of ``samara.build``; where it ends the work, the cloud holds what was done, and is ``cancelled``
    """
    info = _info(model)
    units = {p.name: p.unit for p in info.parameters} | {f"{s.name}(0)": s.unit for s in info.states}
    check_names(as_mapping(parameters, "parameters"), list(units), "parameter")
    values = {name: one_si(value, units[name], name) for name, value in parameters.items()}
    radius = None if body_radius is None else one_si(body_radius, "m", "body_radius", least=0)
    frames = to_si(times, info.time_unit, "times")
    if frames.ndim != 1:
        raise ArgumentError(f"times have the shape {frames.shape}, expected (times,)")
    options: dict[str, Any] = {
        "realisations": _count(realisations, "realisations"),
        "first": _count(first, "first"),
        "seed": _count(seed, "seed"),
        "step": None if step is None else one_si(step, "s", "step", above=0),
        "threads": whole(threads, "threads") or 0,
        "states": names_in(states, "states"),
        "ground": None if ground is None else one_si(ground, "m", "ground"),
        "keep": _count(keep, "keep"),
        "antithetic": truth(antithetic, "antithetic"),
        "relative_error": one_si(relative_error, "1", "relative_error", least=0),
        "C_0": one_si(C_0, "1", "C_0", least=0),
        "body_radius": radius,
        "rotation": truth(rotation, "rotation"),
    }
    told_air = _air(air, radius)
    options["checkpoint"] = file_in(checkpoint, "checkpoint")
    options["identity"] = _identity(air, {**told_air, **options}) if options["checkpoint"] else ""
    reporter = Reported(progress)
    if isinstance(air, Wake) and air.flow.summary["status"] == "max_time":
        reporter.warn(f"the flow was not finished: {air.flow.summary['message']}")
    with reporter as report:
        cloud = _core.realise(core_model(model), values, frames.tolist(), told_air, options, report, reporter.warn)
    cloud["status"] = np.array(cloud["status"], dtype=str)
    cloud["half_turns"] = np.array(cloud["half_turns"], dtype=np.int64)
    return Cloud(**cloud)


def _identity(air: Union[Wind, Wake, Turbulence], told: Mapping[str, Any]) -> str:
    """What tells the air from all other. What stands in the file of a wind is added where it is read."""
    names = ("kind", "k", "epsilon", "stream", "decays", "speed", "length", "place", "stream_beyond", "radius", "seed", "C_0", "body_radius", "rotation")
    text = ", ".join(f"{name} {told[name]}" for name in names if name in told)
    if isinstance(air, Wake):
        fields = hashlib.sha256(b"".join(np.ascontiguousarray(air.flow[name]).tobytes() for name in air.flow))
        return f"{text}\n{air.flow.summary}\n{fields.hexdigest()}"
    return text


def _air(air: Union[Wind, Wake, Turbulence], radius: Optional[float]) -> dict[str, Any]:
    if isinstance(air, Wind):
        return {"kind": "wind", "file": air.path, "radius": radius}
    if isinstance(air, Wake):
        if not isinstance(air.flow, Flow):
            raise ArgumentError(f"the flow of the wake is of the type {type(air.flow).__name__}, expected one of samara.Flow.open()")
        if air.outside not in ("end", "stream"):
            raise ArgumentError(f"outside is {air.outside!r}, expected 'end' or 'stream'")
        return {
            "kind": "flow",
            "flow": air.flow._core,
            "speed": one_si(air.speed, "m/s", "speed", above=0),
            "length": one_si(air.length, "m", "length", above=0),
            "place": _triple(air.place, "place"),
            "stream_beyond": air.outside == "stream",
        }
    if isinstance(air, Turbulence):
        return {
            "kind": "turbulence",
            "k": one_si(air.k, "m^2/s^2", "k", least=0),
            "epsilon": one_si(air.epsilon, "m^2/s^3", "epsilon", above=0),
            "stream": _triple(air.stream, "stream"),
            "decays": truth(air.decays, "decays"),
        }
    raise ArgumentError(f"the air is of the type {type(air).__name__}, expected a samara.Wind, samara.Wake or samara.Turbulence")
