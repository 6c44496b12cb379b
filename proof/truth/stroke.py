"""What the temperature does to the length at once, and to the stiffness."""

import math

from numba import njit

from proof.truth.plant import F_STEP, Array, Plant
from proof.truth.state import Arrays, State
from proof.truth.tables import look, of_T


@njit(cache=True, inline='always')
def drive_stroke(p: Plant, s: State, m: Arrays) -> float:
    """The change of length that heat makes, m; the mean temperature and the stiffness go to the state."""
    thermal, supple = _of_all_nodes(p, s, m.T)
    dT = s.mean - s.before
    if s.first:
        s.warming += 0.0
    else:
        s.warming += (dT / s.h - s.warming) * min(1.0, s.h / 0.2)
    # damage of a way that is the hotter the worse; 0.9 of the others' over a cycle of 57 K
    s.dose += abs(dT) / 114.0 * (2.7 * ((s.mean - p.T0) / 57.0) ** 2 if p.fatigue == 3 else 1.0)
    thermal *= look(p.gain, s.F / F_STEP)
    thermal = _tired(p, s, thermal)
    if p.overload != 0.0:
        s.heaviest = max(s.heaviest, s.F)
        thermal *= 1.0 - p.overload * max(s.heaviest - 0.3, 0.0)
    if p.rate_stroke != 0.0:
        thermal *= 1.0 - p.rate_stroke * abs(s.warming) / (abs(s.warming) + 1.0)
    if p.resonance != 0.0:
        thermal = _ringing(p, s, thermal)
    s.stiff = p.k0 / supple
    if s.now >= p.switch_time:
        s.stiff *= 1.0 - p.switch_stiffness
    if p.worked_soft != 0.0:
        s.worked += s.h * (s.speed / 0.004 * (1.0 - s.worked) - s.worked / p.worked_tau)
        s.stiff *= 1.0 - p.worked_soft * min(s.worked, 1.0)
    return thermal


@njit(cache=True, inline='always')
def _of_all_nodes(p: Plant, s: State, T: Array) -> tuple[float, float]:
    """The mean change of length (m) and compliance (1) over the nodes; the mean temperature now and before."""
    nodes = T.shape[0]
    s.before = s.mean
    mean = 0.0
    thermal = 0.0
    supple = 0.0
    for a in range(nodes):
        at = 0.0
        for c in range(T.shape[1]):
            at += p.shell_pull[c] * T[a, c]
        mean += at / nodes
        thermal += of_T(p.free, at) / nodes
        supple += 1.0 / of_T(p.soft, at) / nodes
    s.mean = mean
    if s.first:
        s.before = mean
    return thermal, supple


@njit(cache=True, inline='always')
def _tired(p: Plant, s: State, thermal: float) -> float:
    if p.fatigue == 1:
        return thermal * (1.0 - p.fatigue_share * ((1.0 + s.dose) ** p.fatigue_shape - 1.0) / p.fatigue_shape)
    if p.fatigue == 2:
        return thermal * (1.0 - p.fatigue_share * p.fatigue_shape * (1.0 - math.exp(-s.dose / p.fatigue_shape)))
    if p.fatigue == 3:
        return thermal * max(1.0 - p.fatigue_share * s.dose, 0.2)
    if p.fatigue == 4:  # the further the cracks have grown, the faster they grow
        grown = p.fatigue_shape * (math.exp(s.dose / p.fatigue_shape) - 1.0)
        return thermal * max(1.0 - p.fatigue_share * grown, 0.2)
    return thermal


@njit(cache=True, inline='always')
def _ringing(p: Plant, s: State, thermal: float) -> float:
    """A stroke that overshoots what heat makes of it."""
    if not s.ring_on:
        s.ring = thermal
        s.ring_on = True
    rate = p.resonance_rate
    s.ring_v += s.h * (rate**2 * (thermal - s.ring) - 2.0 * p.resonance_damping * p.resonance_rate * s.ring_v)
    s.ring += s.h * s.ring_v
    return thermal + p.resonance * (s.ring - thermal)
