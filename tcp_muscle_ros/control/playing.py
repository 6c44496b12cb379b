"""A protocol played on a muscle: in which parts, which command when, whether it may be, and when it must end.

Pure: time is passed in (s of a steady clock). Everything that talks to a muscle is in ``nodes/runner.py``.
"""

from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import NoReturn

import numpy as np

from tcp_muscle_ros.control.safety import celsius
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters, simulate
from tcp_muscle_ros.recording.protocol import Protocol
from tcp_muscle_ros.recording.recording import Array

LONGEST_HOLD = 0.1  # s, after which a command is repeated: five times within the usual watchdog time
SILENCE = 1.0  # s, at least so long a measurement may stay away
SAME_LOAD = 0.01  # of the load: less than a person changes
_GAPS = 5.0  # usual gaps between two messages, after which a measurement has gone silent
_COLD_WITHIN = 1.0  # K above the ambient
_COLD_FOR = 10.0  # s, over which a muscle in a room of another temperature changes by less than _STILL
_STILL = 0.1  # K
_MEAN_OVER = 1.0  # s


@dataclass(frozen=True)
class Part:
    """What is played in one go: a drive at ``time[k]`` holds until ``time[k + 1]``, the last for no time.

    number  from 1
    time    float64[n], s from the part's start
    drive   float64[n], A, W or V
    load    float64[n], N
    """

    number: int
    time: Array
    drive: Array
    load: Array


def parts(protocol: Protocol, by_person: bool) -> list[Part]:
    """The parts of a protocol: one, or where a person hangs the loads one for each load.

    Raises:
        BadInput: a load that changes all the time, which no person can hang.
    """
    sampled = protocol.sampled()
    changes = np.flatnonzero(np.abs(np.diff(sampled.load)) > SAME_LOAD * sampled.load[:-1]) + 1
    if not by_person or len(sampled.time) == 1:
        return [Part(1, sampled.time, sampled.drive, sampled.load)]
    if changes.size > 1 and np.any(np.diff(changes) == 1):
        _refuse_gradual(sampled.time[changes[int(np.argmax(np.diff(changes) == 1))]])
    bounds = [0, *changes.tolist(), len(sampled.time) - 1]
    hung = np.repeat(sampled.load[bounds[:-1]], np.diff(bounds))
    slow = np.abs(sampled.load[:-1] - hung) > SAME_LOAD * hung  # from tick to tick it hardly changes
    if slow.any():
        until = int(slow.argmax())
        still = np.flatnonzero(sampled.load[:until] == hung[:until])
        _refuse_gradual(sampled.time[still[-1]])
    return [
        Part(
            number,
            sampled.time[first : last + 1] - sampled.time[first],
            sampled.drive[first : last + 1],
            np.full(last + 1 - first, sampled.load[first]),
        )
        for number, (first, last) in enumerate(pairwise(bounds), 1)
        if last > first
    ]


def _refuse_gradual(when: float) -> NoReturn:
    raise BadInput(f'the load changes gradually from {when:g} s on, which no person can hang; expected steps')


def instants(part: Part) -> tuple[Array, Array, Array]:
    """When (s) to command what (A, W or V) under which load (N), each float64[m]: at the part's ticks, and between
    them so often that no watchdog takes a slow protocol for a dead commander.
    """
    steps = np.diff(part.time)
    repeats = np.maximum(np.ceil(steps / LONGEST_HOLD - 1e-9).astype(np.int64), 1)
    index = np.repeat(np.arange(len(steps)), repeats)
    within = np.arange(index.size) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    return part.time[index] + within * (steps / repeats)[index], part.drive[index], part.load[index]


@dataclass(frozen=True)
class Allowed:
    """What a protocol may ask for, SI. ``loads``: those that there are; none: any.

    ``current_limit_of`` and ``temperature_limit_of`` say in errors whose limit it is.
    """

    current: float
    temperature: float
    loads: tuple[float, ...] = ()
    duration: float = float('inf')
    held_end: bool = True
    current_limit_of: str = 'the rig'
    temperature_limit_of: str = 'the rig'


def refuse_beyond(protocol: Protocol, model: Parameters, allowed: Allowed) -> float:
    """Raise BadInput where a protocol asks for more than is allowed; returns the hottest that the model foresees, K."""
    if protocol.duration > allowed.duration:
        raise BadInput(f'the protocol lasts {protocol.duration:g} s, but the longest run is {allowed.duration:g} s')
    if protocol.end != 'load' and not allowed.held_end:
        raise BadInput(f"the protocol's end is '{protocol.end}', but the rig cannot hold the end (held_end: false)")
    sampled = protocol.sampled()
    for load in np.unique(sampled.load).tolist() if allowed.loads else ():
        nearest = min(allowed.loads, key=lambda one, wanted=load: abs(one - wanted))  # type: ignore[misc]
        if abs(nearest - load) > SAME_LOAD * max(load, SAME_LOAD):
            raise BadInput(f'the protocol asks for a load of {load:g} N, which the rig has not; nearest {nearest:g} N')
    if sampled.drive.min() < 0.0:
        raise BadInput(f'the protocol asks for {sampled.drive.min():g}; expected 0 or more: a muscle is only heated')
    outputs = simulate(
        model,
        sampled.time,
        sampled.drive,
        kind=sampled.kind,
        load=sampled.load,
        ambient=sampled.ambient,
        end=protocol.end,
        held_length=protocol.end_options.get('held_length_m', 0.0),
        spring_rate=protocol.end_options.get('spring_rate_n_per_m', 0.0),
        spring_rest_length=protocol.end_options.get('spring_rest_length_m', 0.0),
        only=('fibre_temperature', 'current'),
    )
    current, hottest = float(outputs.current.max()), float(outputs.fibre_temperature.max())
    if not np.isfinite([current, hottest]).all():
        raise BadInput('the model has no finite answer to the protocol: the muscle would burn; expected less current')
    if current > allowed.current * (1.0 + 1e-6):
        raise BadInput(
            f'the protocol asks for {current:.3g} A, above the limit of {allowed.current:.3g} A of '
            f'{allowed.current_limit_of}'
        )
    if hottest > allowed.temperature:
        raise BadInput(
            f'the model predicts {celsius(hottest)}, above the {celsius(allowed.temperature)} of '
            f'{allowed.temperature_limit_of}; expected less current or shorter heating'
        )
    return hottest


class Cold:
    """Whether a muscle without current has cooled: it is near the ambient, or it does not change any more.

    Seconds are averaged: a thermometer's noise is no warmth.
    """

    def __init__(self, ambient: float) -> None:
        self._ambient = ambient
        self._second: list[float] = []
        self._began: float | None = None
        self._means: deque[tuple[float, float]] = deque()
        self.temperature: float | None = None  # K, the latest mean

    def measure(self, temperature: float, now: float) -> None:
        """A measured temperature, K."""
        self._began = now if self._began is None else self._began
        self._second.append(temperature)
        if now - self._began >= _MEAN_OVER:
            self.temperature = sum(self._second) / len(self._second)
            self._means.append((now, self.temperature))
            self._second, self._began = [], None
            while self._means[0][0] < now - 2.0 * _COLD_FOR:
                self._means.popleft()

    def reached(self, now: float) -> bool:
        """Whether it is cold."""
        if self.temperature is None:
            return False
        if self.temperature <= self._ambient + _COLD_WITHIN:
            return True
        before = [mean for then, mean in self._means if then <= now - _COLD_FOR]
        return bool(before) and abs(before[-1] - self.temperature) < _STILL


class Supervisor:
    """When a run must end: what is heard of the muscle goes in, why it must end comes out.

    Measurements that come while no current flows are expected to go on coming (a resistance that is measured with the
    current itself may be absent). ``hottest`` K: no measured temperature may pass it.
    """

    def __init__(self, hottest: float) -> None:
        self.hottest = hottest
        self.problem = ''  # why the run must end; the first one stays
        self.overheated = False  # whether that is the temperature
        self._last: dict[str, float] = {}
        self._longest_gap: dict[str, float] = {}
        self._watched: frozenset[str] = frozenset()

    def hear(self, name: str, now: float) -> None:
        """A message of a measurement."""
        before = self._last.get(name)
        if before is not None and not self._watched:
            self._longest_gap[name] = max(self._longest_gap.get(name, 0.0), now - before)
        self._last[name] = now

    def listen_anew(self, now: float) -> None:
        """Nobody has listened until now, however long that was: it is no usual gap between two messages."""
        self._last = dict.fromkeys(self._last, now)

    def temperature(self, value: float) -> None:
        """A measured temperature, K."""
        if not value < self.hottest:  # also NaN
            self.overheated = self.overheated or (not self.problem and isfinite(value))
            self.end(f'the temperature is {celsius(value)}, the limit {celsius(self.hottest)}')

    def end(self, why: str) -> None:
        """Something else that ends the run."""
        self.problem = self.problem or why

    @property
    def heard(self) -> frozenset[str]:
        """The measurements that have come more than once."""
        return frozenset(self._longest_gap)

    def begin(self) -> None:
        """From now on what has come must go on coming."""
        self._watched = self.heard

    def look(self, now: float) -> str:
        """Why the run must end now, '' where it may go on."""
        for name in sorted(self._watched):
            patience = max(SILENCE, _GAPS * self._longest_gap[name])
            if now - self._last[name] > patience:
                self.end(f'no {name} for {patience:.1f} s')
        return self.problem
