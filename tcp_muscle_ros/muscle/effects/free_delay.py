"""Free delay: a first-order lag at one stage, given as a table.

    f(x) dz/dt = u - z,   x a temperature or the time

The stage is chosen. ``electrical``: the source lags its setting. ``thermal``: contraction and softening lag the fibre's
temperature. ``mechanical``: only the contraction does. ``sensor``: one channel lags. A mean delay
shorter than 0.05 s acts in part (see ``lag.py``): at zero there is none.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.clock_skew import CHANNELS
from tcp_muscle_ros.muscle.effects.effect import STAGES, Effect, Freedom
from tcp_muscle_ros.muscle.effects.lag import approach, fastest, lagging
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import (
    COMMAND,
    CORE_TEMPERATURE,
    DRIVE,
    DRIVING_TEMPERATURE,
    FORCE,
    LENGTH,
    RESISTANCE,
    SERIES,
    SHOWN_FORCE,
    SHOWN_LENGTH,
    SHOWN_RESISTANCE,
    SHOWN_TEMPERATURE,
    TEMPERATURE,
    TIME,
)

_DRIVERS = law.drivers('temperature', 'time')
_PLACES = (TEMPERATURE, TIME)
_ELECTRICAL, _THERMAL, _MECHANICAL, _SENSOR = range(len(STAGES))
_SHOWN = (SHOWN_TEMPERATURE, SHOWN_LENGTH, SHOWN_RESISTANCE, SHOWN_FORCE)  # as CHANNELS
_MEANING = 'mean delay there'
_STAGE, _CHANNEL = law.OWN, law.OWN + 1
_PIECES = _CHANNEL + 1
_SHOWN_AT = _PIECES + law.PREPARED
_SHARE, _VALUE = law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


@inner
def _delay(q: Array, c: Array) -> float:
    """The mean delay now, s."""
    value: float = max(c[_SHARE] * _curve(c, 0, _PIECES, _driver(q, c, _PIECES)), 0.0)
    return value


@inner
def _prompt(q: Array, c: Array) -> float:
    """What is followed."""
    value: float = q[TEMPERATURE]
    if c[_STAGE] == _ELECTRICAL:
        value = q[COMMAND]
    elif c[_STAGE] == _MECHANICAL:
        value = q[CORE_TEMPERATURE]
    elif c[_STAGE] == _SENSOR:
        if c[_CHANNEL] > 2.5:
            value = q[FORCE]
        elif c[_CHANNEL] > 1.5:
            value = q[RESISTANCE] + q[SERIES]
        elif c[_CHANNEL] > 0.5:
            value = q[LENGTH]
    return value


@inner
def _behind(q: Array, c: Array, s: Array) -> float:
    """How far what comes late is from what is followed."""
    prompt = _prompt(q, c)
    value: float = lagging(_delay(q, c), prompt, s[0]) - prompt
    return value


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Contraction and modulus follow late."""
    if c[_STAGE] == _THERMAL:
        q[CORE_TEMPERATURE] += _behind(q, c, s)


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The contraction follows late."""
    if c[_STAGE] == _MECHANICAL:
        q[DRIVING_TEMPERATURE] += _behind(q, c, s)


def drive(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The source follows late."""
    if c[_STAGE] == _ELECTRICAL:
        q[DRIVE] += _behind(q, c, s)


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What comes late approaches what it follows."""
    ds[0] = approach(_delay(q, c), _prompt(q, c), s[0])


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The channel shows late. Is the table asked outside its range?"""
    if c[_STAGE] == _SENSOR:
        q[int(c[_SHOWN_AT])] += _behind(q, c, s)
    _mark(q, c, _driver(q, c, _PIECES))


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest nothing is late."""
    s[0] = _prompt(q, c)


def _prepare(c: Array) -> None:
    law.prepare(c, _VALUE, _PIECES, _PLACES)
    c[_SHOWN_AT] = _SHOWN[int(c[_CHANNEL])]


EFFECT = Effect(
    name='free_delay',
    row='',
    stage='mechanical',
    equation='f(x) dz/dt = u - z',
    source='a table',
    parameters=(
        *law.table(tuple(_DRIVERS), (273.15, 333.15, 393.15), (1.0, 1.0, 1.0), 's', 0.0, 1000.0, _MEANING),
        Parameter(
            'stage', 2.0, '1', 0.0, 3.0, 'where it is late', 'a free choice',
            choices=STAGES, fitted=False, spelled=True,
        ),
        Parameter(
            'channel', 1.0, '1', 0.0, 3.0, 'stage sensor: what is shown late', 'a free choice',
            choices=CHANNELS, fitted=False, spelled=True,
        ),
    ),
    hooks={
        'surroundings': surroundings,
        'contraction': contraction,
        'drive': drive,
        'rates': rates,
        'sensor': sensor,
        'initial': initial,
    },
    strength='share',
    states=('late',),
    fastest_rate=lambda c, p: fastest(law.smallest(c)),
    listed=False,
    columns=law.columns('s', _MEANING),
    prepared=law.PREPARED + 1,
    prepare=_prepare,
    stage_by='stage',
    free=Freedom(_DRIVERS, width=1.5, bend=0.5),
)  # fmt: skip
