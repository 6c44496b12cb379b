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

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS

ABSURD = 1e3  # A, W or V: more is no wish for a muscle of some ohm but a wrong unit or a broken message
WRONG_UNIT = 10.0  # times the current limit; what asks for more means mA
REPEATED = 2  # times the same before a value can be called frozen
STILL = 1.0  # s, a model that moves by less than a quantum for so long has come to rest
ASKED, FLOWS = 0.02, 0.005  # A: so much is asked for, and less than that flows: nothing does
UNTAKEN = 1.0  # s, twice a receiver's watchdog: who is still being discovered has heard the command by then


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
        self._clock = _Forward()
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


class FeedbackWatch:
    """Whether a measured signal is alive: it comes, it is a number, and it moves when the muscle must.

    ``timeout`` s without a good value and it is lost. It is frozen once the model has moved by more than ``quanta``
    quanta of the sensor since the value last changed by so much as a bit, and messages have said the same again
    meanwhile: a message that is late, or a sensor slower than the controller, is not frozen. It thaws with the next
    change, or when the model has come to rest too: then nothing contradicts it any more, and a driver that was merely
    off gets its chance.
    """

    def __init__(self, name: str, timeout: float, quantum: float, quanta: float = 5.0) -> None:
        self.name = name
        self.timeout = timeout
        self.quantum = quantum
        self.quanta = quanta
        self.value: float | None = None  # the last good one
        self._clock = _Forward()
        self._received_at: float | None = None
        self._predicted_then: float | None = None  # when the value last changed
        self._repeated = 0  # messages since then that said the same
        self._frozen = False
        self._still_at = self._still_since = 0.0

    def receive(self, value: float, now: float) -> bool:
        """A message. False where it is no number: it does not count as a sign of life."""
        time = self._clock.at(now)
        if not isfinite(value):
            return False
        if value != self.value:
            self.value = value
            self.expect_anew()
        else:
            self._repeated += 1
        self._received_at = time
        return True

    def expect_anew(self) -> None:
        """The model was set to another state: what it said before is not to be compared with."""
        self._predicted_then = None
        self._repeated = 0
        self._frozen = False

    def problem(self, now: float, predicted: float | None) -> str:
        """'' while the signal is alive, else what is wrong; ``predicted`` is what the model says it reads."""
        time = self._clock.at(now)
        if self._received_at is None:
            return f'no {self.name} yet'
        if time - self._received_at > self.timeout:
            self.expect_anew()
            return f'no {self.name} for {self.timeout:g} s'
        if predicted is not None and isfinite(predicted):
            self._frozen = self._contradicted(predicted, time)
        return f'{self.name} frozen at {self.value:g} while the model moves' if self._frozen else ''

    def _contradicted(self, predicted: float, time: float) -> bool:
        if self._predicted_then is None:
            self._predicted_then = predicted
        moved = abs(predicted - self._predicted_then) > self.quanta * self.quantum
        if not self._frozen or abs(predicted - self._still_at) > self.quantum:
            self._still_at, self._still_since = predicted, time
        if self._frozen and time - self._still_since >= STILL:
            self._predicted_then = predicted
            return False
        return self._frozen or (moved and self._repeated >= REPEATED)


class CurrentWatch:
    """Whether the current that is asked for flows: its receiver may be disabled, or in a fault, without a word.

    It does not once at least ``ASKED`` was asked for and less than ``FLOWS`` was applied for ``UNTAKEN`` s, until it
    flows again or nobody says any more what does. While less is asked for, nothing is concluded.
    """

    def __init__(self) -> None:
        self.untaken = False
        self._since: float | None = None

    def update(self, now: float, asked: float, applied: float | None) -> None:
        """``now`` steady time, s; ``asked`` A; ``applied`` A, measured; None where that is not known."""
        if applied is None or applied >= FLOWS:
            self._since, self.untaken = None, False
        elif asked < ASKED:
            self._since = None
        elif self._since is None:
            self._since = now
        elif now - self._since > UNTAKEN:
            self.untaken = True


class _Forward:
    """The forward steps of a clock, summed: setting it back cannot prolong the life of what came before."""

    def __init__(self) -> None:
        self.time = 0.0  # s
        self._last: float | None = None

    def at(self, now: float) -> float:
        if isfinite(now):
            if self._last is not None:
                self.time += max(now - self._last, 0.0)
            self._last = now
        return self.time


def celsius(temperature: float) -> str:
    """A temperature as people read it."""
    return f'{temperature - ZERO_CELSIUS:.1f} degC'
