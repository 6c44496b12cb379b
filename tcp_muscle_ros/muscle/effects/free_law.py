"""What the laws without a name share: a table, read as a natural cubic spline, of a quantity that drives it.

    y(x) = the natural cubic spline through (at, value);   straight beyond the first and the last of them

A natural spline is the smoothest curve through its knots (the least integral of y''^2: Green & Silverman 1994), goes on
straight beyond them, and is linear in the values, so that a fit finds them by least squares. ``share`` fades the law
out. Where the driver leaves the table, the muscle says that it is out of the model's domain.

A law offers the drivers that make sense at its stage. What is not offered, and why:

- conductance: no rate, for the rate follows from the conductance, and what lags is ``free_surroundings``;
- capacity: no rate, which follows from it, and what takes heat late is ``latent_heat`` or ``two_node``; no current or
  power, for a fibre is warmed by them and by nothing else that it could know of them;
- resistance: no rate, which a coating does not know; no current or power, which follow from it under a set voltage or
  power: a contact that current lowers is ``contact_resistance``;
- stiffness: no length, for what hangs has its length by its force; no rate, current or power, with which a length goes
  as well: ``free_stroke``, and ``free_slow_state`` where it lags;
- stroke: no length, which it is itself;
- surroundings: no rate, which their own lag makes; no time, which is ``ambient_drift``;
- delay: no rate, current, power, length or force, for a time constant is told over a state that changes little while it
  passes.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Column
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import BEYOND

KNOTS = 8
FEWEST = 2
PREPARED = 4 * (KNOTS + 1) + 1  # the cubics below, between and above the knots, and where in q the driver is
# Places in a law's coefficients; its own parameters begin at OWN.
SHARE, DRIVER, COUNT, AT, VALUE, OWN = 0, 1, 2, 3, 3 + KNOTS, 3 + 2 * KNOTS
KELVIN, METRE = 'K', 'm'
UNITS = {
    'temperature': KELVIN,
    'temperature_rate': 'K/s',
    'current': 'A',
    'power': 'W',
    'length': METRE,
    'force': 'N',
    'time': 's',
}
_FAR = 1e9


def drivers(*names: str) -> dict[str, str]:
    """Name and unit of what a law may depend on."""
    return {name: UNITS[name] for name in names}


def table(
    names: Sequence[str], at: Sequence[float], value: Sequence[float], unit: str, low: float, high: float, meaning: str
) -> tuple[Parameter, ...]:
    """The parameters that every law has, with a default table; ``low`` to ``high`` bound its values."""
    return (
        Parameter('share', 1.0, '1', 0.0, 2.0, 'how much of the table acts', 'a free choice'),
        Parameter(
            'driver', 0.0, '1', 0.0, max(len(names) - 1.0, 0.5), 'what it depends on', 'a free choice',
            choices=tuple(names), fitted=False, spelled=True,
        ),
        Parameter('knots', float(len(at)), '1', FEWEST, KNOTS, 'numbers in the table', 'a free choice', fitted=False),
        *series('at', at, 'SI', -_FAR, _FAR, 'where the law is given'),
        *series('value', value, unit, low, high, meaning),
    )  # fmt: skip


def series(
    name: str, values: Sequence[float], unit: str, low: float, high: float, meaning: str
) -> tuple[Parameter, ...]:
    """KNOTS parameters that are one array outside; those beyond ``values`` repeat its last."""
    filled = [*values, *[values[-1]] * (KNOTS - len(values))]
    return tuple(
        Parameter(f'{name}_{k + 1}', filled[k], unit, low, high, meaning, 'an example', fitted=False)
        for k in range(KNOTS)
    )


def columns(unit: str, meaning: str) -> tuple[Column, ...]:
    """The two arrays of a table."""
    return (
        Column('at', 'SI', 'where the law is given', members('at'), 'knots', rising=True),
        Column('value', unit, meaning, members('value'), 'knots'),
    )


def members(name: str) -> tuple[str, ...]:
    """The parameters of an array."""
    return tuple(f'{name}_{k + 1}' for k in range(KNOTS))


@lru_cache(maxsize=64)
def _pieces(at: tuple[float, ...]) -> Array:
    """The matrix that makes of the values at the knots the cubics (four coefficients each) below, between, above them.

    Each counts from the knot before it, the first from the first knot.
    """
    n, h = len(at), np.diff(at)
    values, bends = np.eye(n), np.zeros((n, n))
    slopes = np.diff(values, axis=0) / h[:, None]
    if n > FEWEST:  # second derivatives at the knots, none at both ends
        inside = np.diag((h[:-1] + h[1:]) / 3.0) + np.diag(h[1:-1] / 6.0, 1) + np.diag(h[1:-1] / 6.0, -1)
        bends[1:-1] = np.linalg.solve(inside, np.diff(slopes, axis=0))
    pieces = np.zeros((KNOTS + 1, 4, n))
    for k in range(n - 1):
        pieces[k + 1, 0] = values[k]
        pieces[k + 1, 1] = slopes[k] - h[k] * (2.0 * bends[k] + bends[k + 1]) / 6.0
        pieces[k + 1, 2] = 0.5 * bends[k]
        pieces[k + 1, 3] = (bends[k + 1] - bends[k]) / (6.0 * h[k])
    pieces[0, :2] = pieces[1, :2]
    pieces[n, :2] = values[-1], slopes[-1] + h[-1] * bends[-2] / 6.0
    return pieces.reshape(-1, n)


def prepare(c: Array, values: int, pieces: int, places: Sequence[int]) -> None:
    """Fill what the spline through the values that begin at ``values`` needs; ``places``: of the drivers in q."""
    n = int(c[COUNT])
    c[pieces : pieces + PREPARED - 1] = _pieces(tuple(c[AT : AT + n])) @ c[values : values + n]
    c[pieces + PREPARED - 1] = places[int(c[DRIVER])]


@inner
def driver(q: Array, c: Array, pieces: int) -> float:
    """x, of the law that is prepared at ``pieces``."""
    value: float = q[int(c[pieces + PREPARED - 1])]
    return value


@inner
def curve(c: Array, base: int, pieces: int, x: float) -> float:
    """y(x) for a law whose coefficients begin at ``base`` of ``c``, prepared at ``pieces`` from there."""
    at, n = base + AT, int(c[base + COUNT])
    k = 0
    while k < n and x >= c[at + k]:
        k += 1
    d = x - c[at + k - 1] if k > 0 else x - c[at]
    m = base + pieces + 4 * k
    y: float = c[m] + d * (c[m + 1] + d * (c[m + 2] + d * c[m + 3]))
    return y


@inner
def mark(q: Array, c: Array, x: float) -> None:
    """Say so where the driver is outside the table."""
    if c[SHARE] != 0.0 and not c[AT] <= x <= c[AT + int(c[COUNT]) - 1]:
        q[BEYOND] = 1.0


def largest(c: Array) -> float:
    """The largest value of the table that acts, or 0."""
    return float(c[SHARE] * max(0.0, *c[VALUE : VALUE + int(c[COUNT])]))


def smallest(c: Array) -> float:
    """The smallest value of the table that acts."""
    return float(c[SHARE] * min(c[VALUE : VALUE + int(c[COUNT])]))
