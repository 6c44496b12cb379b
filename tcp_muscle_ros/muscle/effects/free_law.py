"""What the laws without a name share: a table, read as a natural cubic spline, of a quantity that drives it.

    y(x) = the natural cubic spline through (at, value);   straight beyond the first and the last of them

A natural spline is the smoothest curve through its knots (the least integral of y''^2: Green & Silverman 1994), goes on
straight beyond them, and is linear in the values, so that a fit finds them by least squares. ``share`` fades the law
out. Where the driver leaves the table, the muscle says that it is out of the model's domain.
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
# Second derivatives at the knots, the slopes below the first and above the last, and where in q the driver is.
PREPARED = KNOTS + 3
# Places in a law's coefficients; its own parameters begin at OWN.
SHARE, DRIVER, COUNT, AT, VALUE, OWN = 0, 1, 2, 3, 3 + KNOTS, 3 + 2 * KNOTS
UNITS = {
    'temperature': 'K',
    'temperature_rate': 'K/s',
    'current': 'A',
    'power': 'W',
    'length': 'm',
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
def _bending(at: tuple[float, ...]) -> Array:
    """The matrix that makes of the values at the knots second derivatives there, and the slopes beyond the ends."""
    n, h = len(at), np.diff(at)
    matrix = np.zeros((PREPARED - 1, n))
    if n > FEWEST:
        inside = np.diag((h[:-1] + h[1:]) / 3.0) + np.diag(h[1:-1] / 6.0, 1) + np.diag(h[1:-1] / 6.0, -1)
        slopes = np.zeros((n - 2, n))
        for k in range(n - 2):
            slopes[k, k : k + 3] = 1.0 / h[k], -1.0 / h[k] - 1.0 / h[k + 1], 1.0 / h[k + 1]
        matrix[1 : n - 1] = np.linalg.solve(inside, slopes)
    for place, first, second, sign in ((KNOTS, 0, 1, -1.0), (KNOTS + 1, n - 2, n - 2, 1.0)):
        gap = h[first]
        matrix[place] = sign * gap / 6.0 * matrix[second]
        matrix[place, first] -= 1.0 / gap
        matrix[place, first + 1] += 1.0 / gap
    return matrix


def prepare(c: Array, values: int, bends: int, places: Sequence[int]) -> None:
    """Fill what the spline needs beside its values, which begin at ``values``: of the drivers, where they are in q."""
    n = int(c[COUNT])
    c[bends : bends + PREPARED - 1] = _bending(tuple(c[AT : AT + n])) @ c[values : values + n]
    c[bends + PREPARED - 1] = places[int(c[DRIVER])]


@inner
def driver(q: Array, c: Array, bends: int) -> float:
    """x, of the law that is prepared at ``bends``."""
    value: float = q[int(c[bends + PREPARED - 1])]
    return value


@inner
def curve(c: Array, base: int, values: int, bends: int, x: float) -> float:
    """y(x) for a law whose coefficients begin at ``base`` of ``c``, with its values and their bends at these places."""
    at, v, m = base + AT, base + values, base + bends
    last = int(c[base + COUNT]) - 1
    within = min(max(x, c[at]), c[at + last])
    k = 0
    while k < last - 1 and within > c[at + k + 1]:
        k += 1
    h = c[at + k + 1] - c[at + k]
    b = (within - c[at + k]) / h
    a = 1.0 - b
    bow = ((a * a - 1.0) * a * c[m + k] + (b * b - 1.0) * b * c[m + k + 1]) * h * h / 6.0
    y: float = a * c[v + k] + b * c[v + k + 1] + bow
    if x != within:
        y += (x - within) * c[m + KNOTS if x < within else m + KNOTS + 1]
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
