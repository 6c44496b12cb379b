"""What the resolved model says without time: runaway, steady states, and its inverse.

Used by the controller's feed-forward and by the documents. With the paper's stages only: of the effects
``geometric_stiffening`` and the like enter through ``Muscle``, not here.
"""

from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import entry
from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW, contraction_coefficient, modulus_ratio
from tcp_muscle_ros.muscle.parameters import Parameters
from tcp_muscle_ros.muscle.table import INDEX

_H0, _K0, _B, _T0 = (INDEX[name] for name in ('H0', 'k0', 'B', 'T0'))


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


@entry
def _length(p: Array, temperature: float, force: float) -> float:
    thermal = p[_B] * contraction_coefficient(p, temperature) * (temperature - p[_T0])
    height: float = p[_H0] + thermal + force / (p[_K0] * modulus_ratio(p, temperature))
    return height


@entry
def _lengths(p: Array, temperature: Array, force: Array, out: Array) -> None:
    for k in range(temperature.size):
        out[k] = _length(p, temperature[k], force[k])


@entry
def _invert(p: Array, height: float, force: float) -> float:
    """Bisect T in the domain on the heating side: the length falls with T there."""
    low, high = DOMAIN_LOW, DOMAIN_HIGH
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

    Between 0 and 120 degC; the nearer end of that range for lengths that no temperature in it gives.
    """
    return float(_invert(p.vector, float(height), float(force)))


@entry
def _pull(p: Array, height: float, temperature: float) -> float:
    thermal = p[_B] * contraction_coefficient(p, temperature) * (temperature - p[_T0])
    pull: float = p[_K0] * modulus_ratio(p, temperature) * (height - p[_H0] - thermal)
    return max(0.0, pull)


def tension(p: Parameters, height: float, temperature: float) -> float:
    """The tension (N) of a muscle that is held at this length (m) at this temperature (K); 0 where it is slack."""
    return float(_pull(p.vector, float(height), float(temperature)))
