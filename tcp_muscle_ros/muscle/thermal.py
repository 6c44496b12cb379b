"""The thermal stage of the paper, stepped by its exact solution.

C dT/dt = -hA (T - Tinf) + heating (equation 1). For a drive that is constant over the step the equation is linear,

    C dtheta/dt = lam theta + P,   theta = T - Tinf,

with lam = i^2 R0 a_R - hA, P = i^2 R0 [1 + a_R (Tinf - T0)] for a current, and lam = -hA for a power. Its solution
holds for every sign of lam; equation 7 is the special case theta(0) = 0, lam != 0.
"""

from math import expm1

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.electrical import CURRENT
from tcp_muscle_ros.muscle.table import INDEX

_R0, _A_R, _T0, _HA, _C = (INDEX[name] for name in ('R0', 'a_R', 'T0', 'hA', 'C'))


@inner
def phi1(z: float) -> float:
    """(e^z - 1)/z, 1 at z = 0."""
    if abs(z) < 1e-8:
        return 1.0 + z / 2.0 + z * z / 6.0
    return expm1(z) / z


@inner
def phi2(z: float) -> float:
    """(phi1(z) - 1)/z, 1/2 at z = 0. The series serves where the difference would cancel."""
    if abs(z) < 1e-2:
        return 0.5 + z * (1 / 6 + z * (1 / 24 + z * (1 / 120 + z * (1 / 720 + z / 5040))))
    return (expm1(z) / z - 1.0) / z


@inner
def exact_step(
    p: Array, kind: float, drive: float, ambient: float, temperature: float, dt: float
) -> tuple[float, float, float]:
    """Advance the fibre temperature (K) by ``dt`` (s) under a constant current or power.

    Returns the new temperature (K) and the heat (J) that the source gave and the ambient took in the step.
    """
    theta = temperature - ambient
    if kind == CURRENT:
        cold = drive * drive * p[_R0]
        slope = cold * p[_A_R]
        constant = cold * (1.0 + p[_A_R] * (ambient - p[_T0]))
    else:
        slope = 0.0
        constant = drive
    z = (slope - p[_HA]) * dt / p[_C]
    weight = phi1(z)
    rise = constant * dt / p[_C]
    integral = dt * (theta * weight + rise * phi2(z))
    after = theta + (theta * z + rise) * weight  # theta e^z + rise phi1(z), without a second exponential
    return ambient + after, constant * dt + slope * integral, p[_HA] * integral
