"""When current may flow and how much: one state machine for the simulated muscle and for the controller.

Pure: time is passed in, in seconds of a clock that never stops (steady time), and nothing here waits, prints
or publishes.

    DISABLED -> ENABLED <-> TIMED_OUT
                ENABLED <-> DERATING
    any -> FAULT, latched until ``clear_fault``

Current flows in ENABLED and DERATING only, and never above ``Limits.current``.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from math import inf, isfinite, sqrt

from tcp_muscle_ros.control.forward_clock import ForwardClock
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS

ABSURD = 1e3  # A, W or V: more is no wish for a muscle of some ohm but a wrong unit or a broken message
WRONG_UNIT = 10.0  # times the current limit; what asks for more means mA


class State(Enum):
    """What the machine is doing; the value is what people read."""

    DISABLED = 'disabled'
    ENABLED = 'enabled'
    TIMED_OUT = 'timed out'
    DERATING = 'derating'
    FAULT = 'fault'

    @property
    def lets_flow(self) -> bool:
        """Whether current may flow."""
        return self in (State.ENABLED, State.DERATING)


class Kind(Enum):
    """What a command asks for; the value is its unit."""

    CURRENT = 'A'
    POWER = 'W'
    VOLTAGE = 'V'


@dataclass(frozen=True)
class Limits:
    """What the muscle may be given. Temperatures in K; a slew or a timeout of 0 is off."""

    current: float  # A
    slew: float  # A/s, up and down; a limit or a stop cuts at once
    command_timeout: float  # s
    derate_temperature: float  # K, from here the limit falls linearly
    max_temperature: float  # K, to zero here, where the fault latches
    longest_step: float  # s, a longer step of the clock is not a step but a jump

    def __post_init__(self) -> None:
        for name in ('current', 'slew', 'command_timeout', 'longest_step'):
            value = getattr(self, name)
            if not 0.0 <= value < inf:
                raise BadInput(f'safety limit {name} is {value:g}; expected a number >= 0')
        if not 0.0 < self.derate_temperature < self.max_temperature < inf:
            raise BadInput(
                f'derating must begin below the maximum temperature, not at '
                f'{celsius(self.derate_temperature)} with a maximum of {celsius(self.max_temperature)}'
            )

    def current_at(self, temperature: float) -> float:
        """The current allowed at the temperature, A: derated linearly to zero at the maximum."""
        span = self.max_temperature - self.derate_temperature
        share = min(max((self.max_temperature - temperature) / span, 0.0), 1.0)
        return self.current * share


@dataclass(frozen=True)
class Report:
    """What the machine decided last, for diagnostics."""

    state: State
    why: str  # what keeps the current at zero, '' where nothing does
    current: float  # A, decided
    limit: float  # A, the highest current allowed at this temperature
    limited_by: tuple[str, ...]  # the limits that bite now: 'current limit', 'derating', 'slew'
    temperature: float | None  # K, the hottest known
    command_age: float | None  # s, of the last good command; None before the first
    rejected: int  # commands that were no usable number
    last_rejected: str  # why the last of them was rejected
    timeouts: int  # times that the commander fell silent
    skipped: int  # steps with a useless time


class Safety:
    """Turns commands into the current that may flow. Events in any order; ``update`` once a tick decides."""

    def __init__(self, limits: Limits, *, enabled: bool = True) -> None:
        self.limits = limits
        self._enabled = enabled
        self._fault = ''  # latched
        self._cause = ''  # of a fault, as of the last update
        self._clock = ForwardClock()
        self._wanted = 0.0
        self._kind = Kind.CURRENT
        self._commanded_at: float | None = None
        self._timed_out = False
        self._rejected = 0
        self._last_rejected = ''
        self._timeouts = 0
        self._skipped = 0
        self._current = 0.0
        self._state = State.ENABLED if enabled else State.DISABLED
        self._why = '' if enabled else 'disabled'
        self._limit = limits.current
        self._limited_by: tuple[str, ...] = ()
        self._temperature: float | None = None

    # Events

    def command(self, value: float, now: float, kind: Kind = Kind.CURRENT) -> str:
        """A wish. Returns '' where it counts, else why not: then the age of the last good one runs on.

        A command given while disabled is not kept: enabling starts from zero and waits for the next one.
        """
        time = self._clock.at(now)
        if not isfinite(value) or not 0.0 <= value <= ABSURD:
            self._rejected += 1
            self._last_rejected = f'{kind.name.lower()} command of {value:g}; expected 0 to {ABSURD:g} {kind.value}'
            return self._last_rejected
        if kind is Kind.CURRENT and 0.0 < WRONG_UNIT * self.limits.current < value:
            self._rejected += 1
            self._last_rejected = (
                f'current command of {value:g} A: more than ten times the limit of {self.limits.current:g} A; mA?'
            )
            return self._last_rejected
        if not self._enabled:
            return 'disabled'
        self._wanted = value + 0.0  # no negative zero
        self._kind = kind
        self._commanded_at = time
        self._timed_out = False
        return ''

    def enable(self) -> str:
        """Lets current flow again. Returns '' where done, else why not."""
        if self._fault:
            return f'fault latched ({self._fault}): clear it first'
        self._enabled = True
        return ''

    def disable(self) -> None:
        """No current from now on, whatever else happens, and the command in force is forgotten."""
        self._enabled = False
        self._forget_command()
        self._stop(State.FAULT if self._fault else State.DISABLED, self._fault or 'disabled')

    def trip(self, why: str) -> None:
        """Latches a fault that the caller has found."""
        self._fault = self._fault or why
        self._stop(State.FAULT, self._fault)

    def pause(self, why: str) -> None:
        """No current until the next update, which may be long in coming."""
        if self._enabled and not self._fault:
            self._stop(State.TIMED_OUT, why)

    def clear_fault(self) -> str:
        """Back to work, if the cause is gone and the command is 0. Returns '' where done, else why not."""
        if not self._fault:
            return ''
        if self._cause:
            return f'the cause is still there: {self._cause}'
        if self._wanted != 0.0:
            return f'the command is {self._wanted:g} {self._kind.value}: command 0 first'
        self._fault = ''
        # The state says so at once: who asks again before the next update is told that there is none.
        self._stop(*((State.ENABLED, '') if self._enabled else (State.DISABLED, 'disabled')))
        return ''

    def update(
        self,
        now: float,
        dt: float,
        *,
        resistance: float | None = None,
        temperatures: Iterable[float | None] = (),
        silent: str = '',
    ) -> float:
        """Decides the current for the next tick, A.

        ``now`` steady time, s; ``dt`` the time by which the muscle's own clock advanced, s; ``resistance``
        ohm, needed by power and voltage commands; ``temperatures`` K, measured and modelled, None where
        unknown; ``silent`` why nothing may be built on the feedback ('' where it is alive). A ``dt`` that is
        no step (<= 0, NaN, longer than ``longest_step``) is counted, and the current may then fall but not
        rise.
        """
        time = self._clock.at(now)
        known = [temperature for temperature in temperatures if temperature is not None]
        hottest = max(known, default=None) if all(isfinite(t) for t in known) else None
        self._temperature = hottest
        self._cause = self._find_cause(known, hottest, resistance)
        if self._cause and not self._fault:
            self._fault = self._cause
        stepped = 0.0 < dt <= self.limits.longest_step
        if not stepped:
            self._skipped += 1
        self._watch_commander(time)

        self._limit = self.limits.current if hottest is None else self.limits.current_at(hottest)
        if self._fault:
            return self._stop(State.FAULT, self._fault)
        if not self._enabled:
            return self._stop(State.DISABLED, 'disabled')
        if silent:
            return self._stop(State.TIMED_OUT, silent)
        if self._timed_out:
            return self._stop(State.TIMED_OUT, f'no command for {self.limits.command_timeout:g} s')

        self._state = State.DERATING if self._limit < self.limits.current else State.ENABLED
        self._why = ''
        self._current = self._limited(self._wanted_current(resistance), dt, stepped)
        return self._current

    @property
    def state(self) -> State:
        """The present state."""
        return self._state

    @property
    def current(self) -> float:
        """The current decided last, A."""
        return self._current

    def report(self) -> Report:
        """What was decided last, and what has been counted."""
        return Report(
            state=self._state,
            why=self._why,
            current=self._current,
            limit=self._limit,
            limited_by=self._limited_by,
            temperature=self._temperature,
            command_age=None if self._commanded_at is None else self._clock.time - self._commanded_at,
            rejected=self._rejected,
            last_rejected=self._last_rejected,
            timeouts=self._timeouts,
            skipped=self._skipped,
        )

    # What they are made of

    def _find_cause(self, known: list[float], hottest: float | None, resistance: float | None) -> str:
        if any(not isfinite(temperature) for temperature in known):
            return 'temperature is not a number'
        if resistance is not None and not 0.0 < resistance < inf:
            return f'resistance is {resistance:g} ohm'
        if hottest is not None and hottest >= self.limits.max_temperature:
            return f'over-temperature: {celsius(hottest)}, maximum {celsius(self.limits.max_temperature)}'
        return ''

    def _watch_commander(self, time: float) -> None:
        timeout = self.limits.command_timeout
        if timeout == 0.0 or self._commanded_at is None or self._timed_out:
            return
        if time - self._commanded_at > timeout:
            self._timed_out = True
            self._wanted = 0.0
            if self._enabled:
                self._timeouts += 1

    def _wanted_current(self, resistance: float | None) -> float:
        if self._kind is Kind.CURRENT:
            return self._wanted
        if resistance is None:
            return 0.0
        if self._kind is Kind.POWER:
            return sqrt(self._wanted / resistance)
        return self._wanted / resistance

    def _limited(self, wanted: float, dt: float, stepped: bool) -> float:
        limited_by = []
        current = wanted
        if current > self.limits.current:
            limited_by.append('current limit')
        if self.limits.slew > 0.0 and stepped:
            reach = self.limits.slew * dt
            current = min(max(current, self._current - reach), self._current + reach)
            if current != wanted:
                limited_by.append('slew')
        elif not stepped:
            current = min(current, self._current)
        if current > self._limit:
            current = self._limit
            if self._limit < self.limits.current:
                limited_by.append('derating')
        self._limited_by = tuple(limited_by)
        return current

    def _forget_command(self) -> None:
        self._wanted = 0.0
        self._commanded_at = None
        self._timed_out = False

    def _stop(self, state: State, why: str) -> float:
        self._state = state
        self._why = why
        self._current = 0.0
        self._limited_by = ()
        return 0.0


def celsius(temperature: float) -> str:
    """A temperature as people read it."""
    return f'{temperature - ZERO_CELSIUS:.1f} degC'
