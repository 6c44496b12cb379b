"""The mechanical stage: modulus, stiffness, free length.

H(T, F) = H0 + B alpha(T) (T - T0) + F/k(T), with k(T) = k0 E(T)/E(T0): the paper's equations 8, 11, 13, 14 and 17 with
the corrections of docs/paper.md (sign of the thermal term, F/k for k F, B for the printed bracket of equation 16).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import entry, inner
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS
from tcp_muscle_ros.muscle.table import INDEX

# Equation 27 was fitted to data from 0 to about 120 degC; outside, the modulus is held at the edge's value.
DOMAIN_LOW, DOMAIN_HIGH = ZERO_CELSIUS, ZERO_CELSIUS + 120.0
COIL_SHORTEST, COIL_LONGEST = 0.5, 3.0  # times its own length (H0), between which a coil can be

_A1, _A2, _A3, _C1, _C2 = (INDEX[name] for name in ('a1', 'a2', 'a3', 'c1', 'c2'))
_T0 = INDEX['T0']
_REFERENCE = INDEX['modulus_at_T0']


@inner
def modulus(p: Array, temperature: float) -> float:
    """E(T) = a1 (T/1 degC)^a2 + a3, Pa, held constant outside 0 to 120 degC. Equations 8 and 27."""
    inside = min(max(temperature, DOMAIN_LOW), DOMAIN_HIGH) - ZERO_CELSIUS
    # A fitted curve may reach zero within the domain; a hundredth of E(0 degC) keeps stiffness positive there.
    value: float = max(p[_A1] * inside ** p[_A2] + p[_A3], 0.01 * p[_A3])
    return value


@entry
def reference_modulus(p: Array) -> float:
    """E(T0), Pa, from the muscle's own parameters."""
    value: float = modulus(p, p[_T0])
    return value


@inner
def modulus_ratio(p: Array, temperature: float) -> float:
    """E(T)/E(T0)."""
    ratio: float = modulus(p, temperature) / p[_REFERENCE]
    return ratio


@inner
def contraction_coefficient(p: Array, temperature: float) -> float:
    """alpha(T) = c1 T + c2, 1/K, T in K: a secant from T0. Equations 14 and 26."""
    coefficient: float = p[_C1] * temperature + p[_C2]
    return coefficient
