"""The muscle as everyone uses it: one that steps, and a whole recording at once."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import quantities as at
from tcp_muscle_ros.muscle import stepping
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.electrical import CURRENT, KINDS, POWER, VOLTAGE
from tcp_muscle_ros.muscle.parameters import Parameters

ENDS = ('load', 'blocked', 'spring')
_PIECE = 50_000  # instants of a recording that are shown at once
_KIND = dict(zip(KINDS, (CURRENT, POWER, VOLTAGE), strict=True))


class Reading(NamedTuple):
    """What a muscle shows at one instant. SI; temperatures in K; sensor effects are in, noise is not.

    ``velocity`` is the mean over the last step.
    """

    temperature: float
    fibre_temperature: float
    resistance: float
    displacement: float
    force: float
    length: float
    current: float
    voltage: float
    power: float
    in_domain: bool
    slack: bool
    velocity: float


_COLUMNS = tuple(name for name in Reading._fields if name != 'velocity')  # as the stepper shows them


class NoMuscle(BadInput):
    """Parameters that no muscle has: at rest there is nothing of it to hold."""


@dataclass(frozen=True)
class Outputs:
    """A simulated recording: arrays of shape (n,), named and in units as in Reading."""

    time: Array
    temperature: Array
    fibre_temperature: Array
    resistance: Array
    displacement: Array
    force: Array
    length: Array
    current: Array
    voltage: Array
    power: Array
    in_domain: NDArray[np.bool_]
    slack: NDArray[np.bool_]
    heated: float
    lost: float

    @classmethod
    def unknown(cls, time: Array) -> 'Outputs':
        """What nobody knows, at these instants: no number."""
        columns = {name: np.full(time.size, np.nan) for name in _COLUMNS}
        no = np.zeros(time.size, dtype=np.bool_)
        return cls(time=time, **columns | {'in_domain': no, 'slack': no}, heated=np.nan, lost=np.nan)

    def between(self, kept: slice) -> 'Outputs':
        """Some of the instants; ``heated`` and ``lost`` stay those of all."""
        columns = {name: getattr(self, name)[kept] for name in ('time', *_COLUMNS)}
        return replace(self, **columns)

    @property
    def velocity(self) -> Array:
        """Contraction speed (m/s), by differences towards the past; the first is 0."""
        velocity = np.zeros_like(self.displacement)
        velocity[1:] = np.diff(self.displacement) / np.diff(self.time)
        return velocity


@dataclass(frozen=True)
class Schedule:
    """What is imposed on a muscle, checked: ``drive`` (A, W or V), ``load`` (N) and ``ambient`` (K), each from
    ``time[k]`` (s) until ``time[k + 1]``, shape (n,)."""

    time: Array
    drive: Array
    load: Array
    ambient: Array

    @classmethod
    def of(cls, time: ArrayLike, drive: ArrayLike, load: ArrayLike, ambient: ArrayLike) -> 'Schedule':
        """From a column of times, and numbers or columns. Raises BadInput as ``simulate``."""
        times = np.require(time, np.float64, ('C', 'W'))
        if times.ndim != 1 or times.size == 0 or not (np.all(np.isfinite(times)) and np.all(np.diff(times) > 0.0)):
            raise BadInput('time: expected one finite, increasing column with at least one entry')
        drives = _column('drive', drive, times.shape)
        loads = _column('load', load, times.shape)
        ambients = _column('ambient', ambient, times.shape)
        if loads.min() < 0.0:
            raise BadInput(f'load = {loads.min()} N: a load pulls, 0 or more')
        return cls(times, drives, loads, ambients)

    def at(self, ambient: ArrayLike) -> 'Schedule':
        """The same at another ambient, K. Raises BadInput as ``simulate``."""
        return Schedule(self.time, self.drive, self.load, _column('ambient', ambient, self.time.shape))

    @cached_property
    def lowest_drive(self) -> float:
        """The least of the drive."""
        return float(self.drive.min())


def _column(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """A number or a column as a column of this shape."""
    given = np.asarray(values, dtype=np.float64)
    if given.shape not in ((), shape):
        raise BadInput(f'{name}: expected a number or {shape[0]} entries, as time has; got shape {given.shape}')
    filled = np.full(shape, given) if given.shape == () else np.require(given, requirements=('C', 'W'))
    finite = np.isfinite(filled)
    if not finite.all():
        raise BadInput(f'{name}: entry {int(np.argmin(finite))} is not a finite number')
    return filled


def _kind(kind: str) -> int:
    if kind not in _KIND:
        raise BadInput(f"unknown input '{kind}'{nearest(kind, KINDS)}")
    return _KIND[kind]


def _finite(name: str, value: float, unit: str, *, signed: bool = False) -> float:
    if not (isfinite(value) and (signed or value >= 0.0)):
        raise BadInput(f'{name} = {value} {unit}: expected a finite number' + ('' if signed else ', 0 or more'))
    return value


class Muscle:
    """One muscle: its parameters, what holds its end, and its state.

    Args:
        parameters: the muscle and the effects that are on.
        end: ``load`` (a force pulls), ``blocked`` (its length is held), ``spring`` (a spring pulls, the far end of
            which is fixed ``held_length`` away from the muscle's root).
        load: the starting load, N >= 0. Displacement is zero at rest at T0 under it, for every end.
        held_length: m; 0 takes the distance at which the tension at rest is ``load``.
        spring_rate: N/m, for ``spring``.
        spring_rest_length: m, for ``spring``.
        ambient: K; default T0.
        temperature: K at the start; default ambient.

    Raises:
        BadInput: an unknown end, a negative load, a spring without a rate, a value that is not finite.
    """

    def __init__(
        self,
        parameters: Parameters,
        *,
        end: str = 'load',
        load: float = 0.0,
        held_length: float = 0.0,
        spring_rate: float = 0.0,
        spring_rest_length: float = 0.0,
        ambient: float | None = None,
        temperature: float | None = None,
    ) -> None:
        if end not in ENDS:
            raise BadInput(f"unknown end '{end}'{nearest(end, ENDS)}")
        _finite('load', load, 'N')
        _finite('held_length', held_length, 'm')
        _finite('spring_rest_length', spring_rest_length, 'm')
        if end == 'spring' and not (isfinite(spring_rate) and spring_rate > 0.0):
            raise BadInput(f'spring_rate_n_per_m is {spring_rate}: a muscle held by a spring needs a rate above 0 N/m')
        self.parameters = parameters
        self._p, self._on = parameters.vector, parameters.mask
        self._q, self._work = stepping.scratch()
        self.state = np.zeros(stepping.STATE_SIZE)
        self._y = stepping.blank_outputs()
        self.imposed = np.zeros(at.N_INPUTS)
        self.imposed[at.IN_LOAD] = load
        self.imposed[at.IN_AMBIENT] = parameters['T0']
        rest = self._settle(parameters['T0'])
        self.imposed[at.IN_ZERO] = rest
        if end != 'load':
            compliance = 1.0 / spring_rate if end == 'spring' else 0.0
            self.imposed[at.IN_HELD] = 1.0
            self.imposed[at.IN_COMPLIANCE] = compliance
            self.imposed[at.IN_WALL] = held_length - spring_rest_length if held_length else rest + load * compliance
            if self.imposed[at.IN_WALL] <= 0.0:
                if not held_length:
                    raise NoMuscle(f'at T0, under {load:g} N, it is {rest:g} m long: no muscle has these parameters')
                raise BadInput(
                    f'held_length = {held_length:g} m leaves no room for the muscle beside the spring '
                    f'(spring_rest_length = {spring_rest_length:g} m)'
                )
        if ambient is not None:
            self.imposed[at.IN_AMBIENT] = _finite('ambient', ambient, 'K')
        self.reset(temperature)

    def _settle(self, temperature: float) -> float:
        length: float = stepping.settle(
            self.state, self.imposed, self._p, self._on, self._q, self._work, float(temperature)
        )
        return length

    def reset(self, temperature: float | None = None) -> None:
        """Back to rest at ``temperature`` (K; default the present ambient), time zero."""
        self.imposed[at.IN_DRIVE] = 0.0
        start = float(self.imposed[at.IN_AMBIENT]) if temperature is None else temperature
        self._settle(_finite('temperature', start, 'K'))
        self._velocity = 0.0
        self._last = self.advance(0.0).displacement

    def go_on_from(self, before: 'Muscle') -> None:
        """Move on as another did, from where this one is now: by taking its place it has not moved."""
        self._velocity = before._velocity
        self._last = self.advance(0.0).displacement

    def _impose(self, drive: float, kind: str, load: float | None, ambient: float | None) -> None:
        number = _kind(kind)
        self.imposed[at.IN_DRIVE] = _finite(kind, drive, 'AWV'[number], signed=number != POWER)
        self.imposed[at.IN_KIND] = number
        self.impose(load, ambient)

    def impose(self, load: float | None = None, ambient: float | None = None) -> None:
        """Load (N) and ambient (K) from now on; None = keep."""
        imposed = self.imposed
        if load is not None:
            imposed[at.IN_LOAD] = _finite('load', load, 'N')
        if ambient is not None:
            imposed[at.IN_AMBIENT] = _finite('ambient', ambient, 'K')

    def advance(self, dt: float) -> Reading:
        """Let ``dt`` (s) pass under what is imposed, then read; a ``dt`` of 0 only reads."""
        stepping.advance(self.state, self.imposed, self._p, self._on, self._q, self._work, dt, self._y)
        return self.shown(self._y.tolist(), dt)

    def shown(self, row: list[float], dt: float) -> Reading:
        """The reading that a row of outputs is, ``dt`` (s) after the last."""
        *values, in_domain, slack = row
        if dt > 0.0:
            displacement = values[at.Y_DISPLACEMENT]
            self._velocity = (displacement - self._last) / dt
            self._last = displacement
        return Reading._make((*values, in_domain > 0.5, slack > 0.5, self._velocity))

    def step(
        self, dt: float, drive: float, kind: str = 'current', load: float | None = None, ambient: float | None = None
    ) -> Reading:
        """Hold ``drive`` (A, W or V), ``load`` (N) and ``ambient`` (K) for ``dt`` (s), then read."""
        if not (isfinite(dt) and dt > 0.0):
            raise BadInput(f'dt = {dt} s: expected a finite number above 0')
        self._impose(drive, kind, load, ambient)
        return self.advance(dt)

    def reading(
        self, drive: float = 0.0, kind: str = 'current', load: float | None = None, ambient: float | None = None
    ) -> Reading:
        """What it shows now if this drive is applied now. No time passes."""
        self._impose(drive, kind, load, ambient)
        return self.advance(0.0)

    @property
    def blocked(self) -> bool:
        """Is its end held by what does not give way?"""
        return bool(self.imposed[at.IN_HELD] != 0.0 and self.imposed[at.IN_COMPLIANCE] == 0.0)

    @property
    def heated(self) -> float:
        """Joule heat since the last reset, J."""
        return float(self.state[at.X_HEATED])

    @property
    def lost(self) -> float:
        """Heat given to the ambient since the last reset, J."""
        return float(self.state[at.X_LOST])


def simulate(
    parameters: Parameters,
    time: ArrayLike,
    drive: ArrayLike,
    *,
    kind: str = 'current',
    load: ArrayLike | None = None,
    ambient: ArrayLike | None = None,
    end: str = 'load',
    starting_load: float | None = None,
    held_length: float = 0.0,
    spring_rate: float = 0.0,
    spring_rest_length: float = 0.0,
    temperature: float | None = None,
    resolution: float = 1.0,
    hottest: float | None = None,
    only: Collection[str] | None = None,
) -> Outputs:
    """Simulate a recording: what is shown at ``time[k]``, with input k held until ``time[k + 1]``.

    Args:
        parameters: the muscle and the effects that are on.
        time: s, shape (n,), increasing.
        drive: A, W or V by ``kind``, a number or shape (n,).
        kind: ``current``, ``power`` or ``voltage``.
        load, ambient: N and K, a number or shape (n,) each; default 0 and T0.
        end: as for Muscle, with ``held_length``, ``spring_rate`` and ``spring_rest_length``.
        starting_load: N, under which displacement is zero at rest at T0; default the first load.
        temperature: K at the start; default the first ambient.
        resolution: share of the usual number of substeps that effects get; a fit, which needs two parts in a
            thousand of a quick change and not one in a million, does with 0.125.
        hottest: K, up to which processes that heat quickens are followed, and beyond held; default the end of the
            model's domain, 120 degC. A fit of a recording that stays cooler needs fewer substeps.
        only: the outputs to keep; the others come back empty, shape (0,). Long recordings then need less memory.

    Raises:
        BadInput: times that do not increase, lengths that differ, values that are not finite.
    """
    schedule = Schedule.of(time, drive, 0.0 if load is None else load, parameters['T0'] if ambient is None else ambient)
    muscle = Muscle(
        parameters,
        end=end,
        load=float(schedule.load[0]) if starting_load is None else starting_load,
        held_length=held_length,
        spring_rate=spring_rate,
        spring_rest_length=spring_rest_length,
        ambient=float(schedule.ambient[0]),
        temperature=temperature,
    )
    return follow(muscle, schedule, kind=kind, resolution=resolution, hottest=hottest, only=only)


def simulate_on(
    muscle: Muscle, time: ArrayLike, drive: ArrayLike, *, kind: str = 'current', load: ArrayLike, ambient: ArrayLike
) -> Outputs:
    """As ``simulate``, from the state that a muscle is in, which it leaves in that of the last instant.

    A long simulation is done piece by piece so, with the same result to the last bit: each piece begins with the last
    instant of the one before, which is shown again.
    """
    return follow(muscle, Schedule.of(time, drive, load, ambient), kind=kind)


def follow(
    muscle: Muscle,
    schedule: Schedule,
    *,
    kind: str = 'current',
    resolution: float = 1.0,
    hottest: float | None = None,
    only: Collection[str] | None = None,
) -> Outputs:
    """As ``simulate_on``, of a schedule that has been checked: a fit follows the same one thousands of times."""
    muscle._impose(schedule.lowest_drive, kind, None, None)
    followed = muscle.parameters.followed(resolution, hottest)
    times, drives, loads, ambients = schedule.time, schedule.drive, schedule.load, schedule.ambient
    kept = [k for k, name in enumerate(_COLUMNS) if only is None or name in only]
    found = np.empty((len(kept), times.size))
    at_once = times.size if only is None else _PIECE
    for first in range(0, max(times.size - 1, 1), at_once):
        piece = slice(
            first, first + at_once + 1
        )  # with the first instant of the next: no time passes while it is shown
        shown = found if only is None else stepping.blank_outputs(times[piece].size)
        stepping.run(
            muscle.state, muscle.imposed, followed, muscle._on, muscle._q, muscle._work,
            times[piece], drives[piece], loads[piece], ambients[piece], muscle._y, shown,
        )  # fmt: skip
        if only is not None:
            found[:, piece] = shown[kept]
    columns = dict.fromkeys(_COLUMNS, np.empty(0)) | dict(zip((_COLUMNS[k] for k in kept), found, strict=True))
    in_domain, slack = (columns.pop(name) > 0.5 for name in ('in_domain', 'slack'))
    return Outputs(time=times, in_domain=in_domain, slack=slack, heated=muscle.heated, lost=muscle.lost, **columns)
