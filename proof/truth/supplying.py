"""A step of the circuit: what the supply gives, how the wire ages, which current flows."""

import math

from numba import njit

from proof.truth.plant import Array, Plant
from proof.truth.state import State
from proof.truth.tables import of_H, of_T


@njit(cache=True)
def resistance(p: Plant, T: Array, H: float, aged: float) -> tuple[float, float]:
    """The wire's resistance without its dependence on temperature, and with it, ohm."""
    ohm = p.R0 * aged * of_H(p.piezo, H)
    rho = 0.0
    for a in range(T.shape[0]):
        rho += of_T(p.rho, T[a, 0])
    return ohm, ohm * rho / T.shape[0]


@njit(cache=True)
def ampere(p: Plant, kind: int, drive: float, R: float) -> float:
    """The current that an input drives through R and the crimps, A."""
    if kind == 0:
        return drive
    if kind == 1:
        return math.sqrt(max(drive, 0.0) / (R + p.contact))
    return drive / (R + p.contact)


@njit(cache=True, inline='always')
def supply(p: Plant, s: State, asked: float) -> None:
    """What the supply really gives of what is asked."""
    h = s.h
    if p.supply == 1:
        keep = math.exp(-h * p.supply_rate)
        s.pole1 = asked + (s.pole1 - asked) * keep
        s.pole2 = s.pole1 + (s.pole2 - s.pole1) * keep
    elif p.supply == 2:
        reach = p.supply_rate * h
        s.pole2 += max(-reach, min(reach, asked - s.pole2))
    elif p.supply == 3:  # pole1 is the slope
        s.pole1 += h * p.supply_rate * (p.supply_rate * (asked - s.pole2) - 2.0 * p.supply_damping * s.pole1)
        s.pole2 += h * s.pole1
        if s.pole2 < 0.0:  # it gives nothing the other way round
            s.pole1 = s.pole2 = 0.0
    elif p.supply == 4:  # a capacitor that the supply fills and the muscle alone empties
        pace = p.supply_rate / (0.4 if asked > s.pole2 else 1.6)
        s.pole2 = asked + (s.pole2 - asked) * math.exp(-h * pace)
    else:
        s.pole2 = asked


@njit(cache=True, inline='always')
def age(p: Plant, s: State) -> None:
    """How much more the wire resists for its age."""
    if p.ageing == 1:
        s.oxide += s.h * math.exp((s.mean - 60.0) / 25.0)
        s.aged = 1.0 + p.ageing_rate * math.sqrt(s.oxide / 100.0)
    elif p.ageing == 2:
        s.aged = 1.0 + p.ageing_rate * math.log1p(s.cracked)
    elif p.ageing == 3:
        s.oxide += s.h * (s.i / 0.25) ** 2 * math.exp((s.mean - 60.0) / 20.0)
        s.aged = 1.0 + p.ageing_rate * s.oxide / 180.0
    elif p.ageing == 4 and not s.first:  # Coffin and Manson: a cycle costs the square of its height
        s.oxide += abs(s.mean - s.before) / 57.0 * max(s.mean - p.T0, 0.0) / 57.0
        s.aged = 1.0 + 0.9 * p.ageing_rate * s.oxide**0.6
    elif p.ageing == 5:
        s.oxide += s.h * ((s.i / 0.25) ** 2 - s.oxide) / p.ageing_tau
        s.aged = 1.0 - p.ageing_rate * s.oxide
    if p.switch_resistance != 0.0 and s.now >= p.switch_time:
        s.aged = 1.0 + p.switch_resistance
