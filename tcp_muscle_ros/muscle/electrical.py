"""The electrical stage: resistance of the coating, and the current that each kind of source drives.

Karami & Tadesse 2017, equations 3 and 4 (equation 2 is not used: see docs/paper.md).
"""

from math import sqrt

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.table import INDEX

CURRENT, POWER, VOLTAGE = 0, 1, 2
KINDS = ('current', 'power', 'voltage')

_R0, _A_R, _T0 = INDEX['R0'], INDEX['a_R'], INDEX['T0']


@inner
def resistance_at(p: Array, temperature: float) -> float:
    """R(T) = R0 (1 + a_R (T - T0)), ohm. Equation 4."""
    value: float = p[_R0] * (1.0 + p[_A_R] * (temperature - p[_T0]))
    return value


@inner
def source_current(kind: float, drive: float, resistance: float) -> float:
    """The current (A) that a source of this kind drives through ``resistance`` (ohm)."""
    if kind == CURRENT:
        return drive
    if kind == POWER:
        return sqrt(drive / resistance)
    return drive / resistance


@inner
def joule_heating(kind: float, drive: float, resistance: float) -> float:
    """Heat (W) released by a source of this kind in ``resistance`` (ohm): i^2 R, P or V^2/R."""
    if kind == CURRENT:
        return drive * drive * resistance
    if kind == POWER:
        return drive
    return drive * drive / resistance
