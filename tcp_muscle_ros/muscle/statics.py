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
_SLOPE, _HALVINGS = 1e-3, 20  # K, over which a slope is seen where a branch ends, and what finds its end to 2e-6 K


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


@inner
def _turn(p: Array, force: float, inside: float, outside: float) -> float:
    """Where (K) the length ceases to fall with T between a temperature at which it does and one beyond the turn."""
    back = _SLOPE if inside < outside else -_SLOPE  # towards the inside: beyond an edge of the domain the law differs
    if (_length(p, outside - back, force) - _length(p, outside, force)) * back > 0.0:
        return outside
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        if (_length(p, middle - back, force) - _length(p, middle, force)) * back > 0.0:
            inside = middle
        else:
            outside = middle
    return inside


@inner
def _begin(p: Array, force: float) -> float:
    """The temperature (K) from which on heating shortens the muscle: T0, or where a table or softening lets it."""
    rest: float = max(p[_T0], DOMAIN_LOW)
    begin = rest
    while begin + _STEP < DOMAIN_HIGH:
        if _length(p, begin + _STEP, force) < _length(p, begin, force):
            return _turn(p, force, begin + _STEP, max(begin - _STEP, rest))
        begin += _STEP
    return rest  # it does nowhere: then no warmth is of use


@inner
def _walk(p: Array, force: float, begin: float, step: float, height: float) -> float:
    """From a temperature (K) by steps (K, either way) to the end of the stretch on which the length falls with T.

    No further than to the first step past ``height`` (m): who asks for a length need not know where the stretch ends.
    """
    here, long = begin, _length(p, begin, force)
    near = _SLOPE if step > 0.0 else -_SLOPE
    if (long - _length(p, begin + near, force)) * step <= 0.0:  # it turns here, and a whole step may hide it
        return begin
    while (long - height) * step > 0.0:
        ahead = min(max(here + step, DOMAIN_LOW), DOMAIN_HIGH)
        there = _length(p, ahead, force)
        if (long - there) * step <= 0.0:  # it turns within a step of here, ahead or behind
            return _turn(p, force, begin if here == begin else here - step, ahead)
        here, long = ahead, there
    return here


@entry
def _branch(p: Array, force: float) -> tuple[float, float]:
    """The temperatures (K) between which heating shortens the muscle; of several such stretches the first from T0 on.

    It need not do so all over the domain: under a heavy load softening overtakes the contraction, and a table may
    turn anywhere.
    """
    begin = _begin(p, force)
    return _walk(p, force, begin, -_STEP, inf), _walk(p, force, begin, _STEP, -inf)


@entry
def _invert(p: Array, height: float, force: float) -> float:
    """Bisect T on the branch on which the length falls with T."""
    low = high = _begin(p, force)
    if _length(p, low, force) > height:
        high = _walk(p, force, low, _STEP, height)
    else:
        low = _walk(p, force, high, -_STEP, height)
    for _ in range(50):
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

    On the branch on which heating shortens it (``shortening``), which is within 0 to 120 degC; the nearer end of it for
    lengths that no temperature in it gives.
    """
    return float(_invert(p.vector, float(height), float(force)))


def shortening(p: Parameters, force: float) -> tuple[float, float]:
    """The temperatures (K) between which heating shortens the muscle under this tension (N); the first such stretch.

    It ends at 120 degC, or where softening or a free law turns the stroke back; at T0 where heating shortens nowhere.
    """
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
