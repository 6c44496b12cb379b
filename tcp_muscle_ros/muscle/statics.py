"""What the resolved model says without time: runaway, steady states, and its inverse.

Used by the controller's feed-forward and by the documents. With the paper's stages and, where they are on and do not
depend on time, the tables of ``free_stroke`` (its heating branch) and ``free_stiffness``: they are what the controller
inverts. A rate is none, current and power are those that hold the temperature in a room of T0. Of the effects
``geometric_stiffening`` and the like enter through ``Muscle``, not here.
"""

from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import entry, inner
from tcp_muscle_ros.muscle.effects import free_law, free_stiffness, free_stroke
from tcp_muscle_ros.muscle.electrical import resistance_at
from tcp_muscle_ros.muscle.layout import COEFFICIENTS
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW, contraction_coefficient, modulus_ratio
from tcp_muscle_ros.muscle.parameters import Parameters
from tcp_muscle_ros.muscle.table import INDEX

_H0, _K0, _B, _T0, _HA = (INDEX[name] for name in ('H0', 'k0', 'B', 'T0', 'hA'))
_STROKE, _STIFFNESS = (COEFFICIENTS[effect.EFFECT.name].start for effect in (free_stroke, free_stiffness))
_SHARE, _DRIVER, _curve = free_law.SHARE, free_law.DRIVER, free_law.curve
_STROKE_READY, _STROKE_PIECES = _STROKE + free_stroke.READY, free_stroke.PIECES
_STIFFNESS_READY, _STIFFNESS_PIECES, _SOFTEST = (
    _STIFFNESS + free_stiffness.READY,
    free_stiffness.PIECES,
    free_stiffness.LEAST,
)
_BY_TEMPERATURE, _BY_FORCE = free_stroke.BY_TEMPERATURE, free_stroke.BY_FORCE  # in both laws
_BY_RATE, _BY_CURRENT, _BY_POWER = free_stroke.BY_RATE, free_stroke.BY_CURRENT, free_stroke.BY_POWER
_STEP = 1.0  # K, by which a branch is looked for


def critical_current(p: Parameters) -> float:
    """The current (A) at and above which a current source heats without end: sqrt(hA / (R0 a_R)); inf if a_R <= 0."""
    return sqrt(p['hA'] / (p['R0'] * p['a_R'])) if p['a_R'] > 0.0 else inf


def steady_temperature(p: Parameters, current: float, ambient: float | None = None) -> float:
    """The temperature (K) at which a constant current (A) settles; inf at and above the critical current."""
    ambient = p['T0'] if ambient is None else ambient
    cold = current**2 * p['R0']
    loss = p['hA'] - cold * p['a_R']
    return ambient + cold * (1.0 + p['a_R'] * (ambient - p['T0'])) / loss if loss > 0.0 else inf


def steady_current(p: Parameters, temperature: float, ambient: float | None = None) -> float:
    """The current (A) that holds a temperature (K); 0 at or below ambient."""
    ambient = p['T0'] if ambient is None else ambient
    resistance_there = p['R0'] * (1.0 + p['a_R'] * (temperature - p['T0']))
    return sqrt(max(0.0, p['hA'] * (temperature - ambient)) / resistance_there)


def resistance(p: Parameters, temperature: ArrayLike) -> Array:
    """R(T), ohm, for temperatures (K) of any shape. Equation 4."""
    return np.asarray(p['R0'] * (1.0 + p['a_R'] * (np.asarray(temperature, dtype=np.float64) - p['T0'])))


@inner
def _table(p: Array, base: int, pieces: int, temperature: float, force: float) -> float:
    """What a free law adds, without time."""
    value = 0.0
    if p[base + _DRIVER] == _BY_TEMPERATURE:
        value = p[base + _SHARE] * _curve(p, base, pieces, temperature)
    elif p[base + _DRIVER] == _BY_FORCE:
        value = p[base + _SHARE] * _curve(p, base, pieces, force)
    elif p[base + _DRIVER] >= _BY_RATE:  # of the stroke alone
        holding = max(0.0, p[_HA] * (temperature - p[_T0]))
        x = 0.0
        if p[base + _DRIVER] == _BY_POWER:
            x = holding
        elif p[base + _DRIVER] == _BY_CURRENT:
            x = sqrt(holding / resistance_at(p, temperature))
        value = p[base + _SHARE] * _curve(p, base, pieces, x)
    return value


@entry
def _length(p: Array, temperature: float, force: float) -> float:
    thermal = p[_B] * contraction_coefficient(p, temperature) * (temperature - p[_T0])
    height: float = p[_H0] + thermal
    ratio = modulus_ratio(p, temperature)
    if p[_STIFFNESS_READY] > 0.0:
        ratio *= max(1.0 + _table(p, _STIFFNESS, _STIFFNESS_PIECES, temperature, force), _SOFTEST)
    height += force / (p[_K0] * ratio)
    if p[_STROKE_READY] > 0.0:
        height += _table(p, _STROKE, _STROKE_PIECES, temperature, force)
    return height


@entry
def _lengths(p: Array, temperature: Array, force: Array, out: Array) -> None:
    for k in range(temperature.size):
        out[k] = _length(p, temperature[k], force[k])


@entry
def _branch(p: Array, force: float) -> tuple[float, float]:
    """The temperatures (K) between which heating shortens the muscle; of several such stretches the first from T0 on.

    The paper's own model shortens all over the domain; a table need not.
    """
    low, high = DOMAIN_LOW, DOMAIN_HIGH
    if p[_STROKE_READY] == 0.0 and p[_STIFFNESS_READY] == 0.0:
        return low, high
    begin = p[_T0]
    while begin + _STEP < high and _length(p, begin + _STEP, force) >= _length(p, begin, force):
        begin += _STEP
    end = begin
    while end + _STEP < high and _length(p, end + _STEP, force) < _length(p, end, force):
        end += _STEP
    if end + _STEP >= high and _length(p, high, force) < _length(p, end, force):
        end = high
    while begin - _STEP > low and _length(p, begin - _STEP, force) > _length(p, begin, force):
        begin -= _STEP
    return begin if begin - _STEP > low else low, end


@entry
def _invert(p: Array, height: float, force: float) -> float:
    """Bisect T on the branch on which the length falls with T."""
    low, high = _branch(p, force)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _length(p, middle, force) > height:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def length(p: Parameters, temperature: ArrayLike, force: ArrayLike) -> Array:
    """H(T, F) = H0 + B alpha(T) (T - T0) + F/k(T), m, for temperatures (K) and tensions (N) that broadcast."""
    t, f = np.broadcast_arrays(np.asarray(temperature, dtype=np.float64), np.asarray(force, dtype=np.float64))
    out = np.empty(t.size)
    _lengths(p.vector, np.array(t).ravel(), np.array(f).ravel(), out)
    return out.reshape(t.shape)


def length_at(p: Parameters, temperature: float, force: float) -> float:
    """As ``length``, for one temperature (K) and one tension (N): a controller asks several times a period."""
    return float(_length(p.vector, float(temperature), float(force)))


def stiffness(p: Parameters, temperature: ArrayLike) -> Array:
    """k(T) = k0 E(T)/E(T0), N/m, for temperatures (K) of any shape."""
    slack = length(p, temperature, 0.0)
    return np.asarray(1.0 / (length(p, temperature, 1.0) - slack))


def temperature_for_length(p: Parameters, height: float, force: float) -> float:
    """The temperature (K) at which the muscle has this length (m) under this tension (N).

    Between 0 and 120 degC, and where a free law turns the stroke back, on the first branch (``shortening``); the nearer
    end of it for lengths that no temperature in it gives.
    """
    return float(_invert(p.vector, float(height), float(force)))


def shortening(p: Parameters, force: float) -> tuple[float, float]:
    """The temperatures (K) between which heating shortens the muscle under this tension (N); the first such stretch."""
    low, high = _branch(p.vector, float(force))
    return float(low), float(high)


@entry
def _pull(p: Array, height: float, temperature: float) -> float:
    thermal = p[_B] * contraction_coefficient(p, temperature) * (temperature - p[_T0])
    pull: float = p[_K0] * modulus_ratio(p, temperature) * (height - p[_H0] - thermal)
    if p[_STROKE_READY] == 0.0 and p[_STIFFNESS_READY] == 0.0:
        return max(0.0, pull)
    low, high = 0.0, max(pull, 1e-3)
    while _length(p, temperature, high) < height and high < 1e6:
        high *= 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _length(p, temperature, middle) < height:
            low = middle
        else:
            high = middle
    return low if low > 0.0 else 0.0


def tension(p: Parameters, height: float, temperature: float) -> float:
    """The tension (N) of a muscle that is held at this length (m) at this temperature (K); 0 where it is slack."""
    return float(_pull(p.vector, float(height), float(temperature)))
