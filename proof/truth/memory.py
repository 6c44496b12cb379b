"""What the length remembers: creep, flow, twist, loops of three kinds, branches, and what heat sets free."""

import math

import numpy as np
from numba import njit

from proof.truth.plant import KELVIN, Array, Plant
from proof.truth.state import Arrays, State
from proof.truth.tables import of_T


@njit(cache=True, inline='always')
def remembered(p: Plant, s: State, m: Arrays) -> float:
    """The change of length that the past has left, m."""
    mean, dT = s.mean, s.mean - s.before
    inside = s.slipped - p.current_stroke * s.i * s.i
    if len(m.z) > 0:
        quick = of_T(p.shift, mean)
        for j in range(len(m.z)):
            goal = p.creep[j] * s.F / s.stiff
            m.z[j] = goal + (m.z[j] - goal) * math.exp(-s.h * quick / p.creep_tau[j])
            inside += m.z[j]
    _flow(p, s)
    if p.twist_direct > 0.0:
        _ageing_contact(p, s)
    elif p.twist > 0.0:
        _twist(p, s)
    inside += s.flowed + s.turned
    if len(m.relays) > 0:
        inside -= p.relay_stroke * _loops(p, m, mean)
    if p.near_stroke > 0.0:
        _near(p, s)
        share = 1.0 / (1.0 + math.exp((p.near_at - mean - s.late) / p.near_spread))
        inside -= p.near_stroke * (share - of_T(p.loop_centre, mean))
    if p.phase_stroke > 0.0:
        s.phase = _phase(p, s.phase, s.before, mean)
        inside -= p.phase_stroke * (s.phase - of_T(p.loop_centre, mean))
    if p.branch > 0:
        _branch(p, s, dT)
        inside += s.branch
    if p.surge != 0.0:
        s.surge = (s.surge + dT) * math.exp(-s.h / p.surge_tau)
        inside -= p.surge * s.surge
    return inside + _frozen(p, s, m)


@njit(cache=True, inline='always')
def _flow(p: Plant, s: State) -> None:
    """Length that never comes back."""
    F, mean = s.F, s.mean
    if p.flow == 1:
        pull = math.sinh(F / p.flow_scale) / math.sinh(0.6 / p.flow_scale)
        s.flowed += s.h * p.flow_rate * pull * math.exp(p.flow_heat * (mean - 60.0))
    elif p.flow == 2:
        pull = (F / 0.6) ** p.flow_scale / (1.0 + s.flowed / 0.5e-3)
        barrier = p.flow_heat * 333.15**2  # K; the same slope at 60 degC
        s.flowed += s.h * p.flow_rate * pull * math.exp(barrier * (1.0 / 333.15 - 1.0 / (mean + KELVIN)))
    elif p.flow == 3:  # nothing below the yield load; free volume from -30 degC on
        pull = max(F - p.flow_scale, 0.0) / (0.6 - p.flow_scale)
        barrier = p.flow_heat * 90.0**2  # K; the same slope at 60 degC
        s.flowed += s.h * p.flow_rate * pull * math.exp(barrier * (1.0 / 90.0 - 1.0 / max(mean + 30.0, 10.0)))


@njit(cache=True, inline='always')
def _twist(p: Plant, s: State) -> None:
    """An end that gives way to the torque beyond its grip."""
    torque = s.F / 0.6 * max(s.mean - p.T0, 0.0) / 47.0
    if torque > p.twist_grip:
        s.turned += s.h * p.twist / p.twist_tau * (torque - p.twist_grip) / (1.0 - p.twist_grip)
    elif torque < 0.3 * p.twist_grip:
        s.turned -= s.h * s.turned / (4.0 * p.twist_tau)


@njit(cache=True, inline='always')
def _ageing_contact(p: Plant, s: State) -> None:
    """An end held by a contact whose grip grows with its age and is renewed by sliding.

    Friction by rate and state with the ageing law (Dieterich 1979, Ruina 1983), regularised by a hyperbolic sine where
    nothing moves (Rice and Ben-Zion 1996). What turns takes torque away from itself; with the age held for a step, the
    way of a step is exact: its sine's argument y obeys dy/dt = -rate sinh y.
    """
    grip = p.twist_clamp + (1.0 - p.twist_clamp) * s.F / 0.6
    scale = p.twist_direct * grip  # of the torque
    torque = s.F / 0.6 * max((s.before + s.mean) / 2.0 - p.T0, 0.0) / 47.0
    fresh = p.twist_renewed * p.twist_tau  # s, the age at which a unit torque turns `twist` in twist_tau
    # an age of less than a tenth of that is as good as none
    y = (torque - p.twist_back * s.turned / p.twist) / scale
    pace = 1.0 / (p.twist_tau * math.sinh(1.0 / p.twist_direct))
    turn, halfway = 0.0, s.contact
    for _ in range(2):  # the age is that of the middle of the step
        weak = ((halfway + 0.1 * fresh) / (1.1 * fresh)) ** -p.twist_ageing
        later = 2.0 * math.atanh(math.tanh(y / 2.0) * math.exp(-s.h * pace * weak * p.twist_back / scale))
        turn = (y - later) * scale / p.twist_back
        halfway = _aged(s.contact, s.h / 2.0, abs(turn) / 2.0 / p.twist_renewed)
    s.turned += p.twist * turn
    s.contact = _aged(s.contact, s.h, abs(turn) / p.twist_renewed)


@njit(cache=True, inline='always')
def _aged(age: float, h: float, slid: float) -> float:
    """The age of a contact after h (s), in which it slid by so many times what renews it."""
    return age * math.exp(-slid) + h * (-math.expm1(-slid) / slid if slid > 1e-12 else 1.0)


@njit(cache=True)
def nearness(x: Array, bend: float) -> Array:
    """What is left at x of the distance to the limiting curve, where x is the way since the turn over that distance.

    The proximity function of de Almeida, Deep, Lima and Neff, "Limiting loop proximity hysteresis model", IEEE Trans.
    Magn. 39 (2003), made for the thermal loops of vanadium dioxide.
    """
    return 0.5 * (1.0 - np.sin(bend * x)) * (1.0 + np.tanh(np.pi**2 - 2.0 * np.pi * x))


@njit(cache=True)
def _lateness(p: Plant, s: State, T: float) -> float:
    """How far ahead of T (K) the curve is run through, on the way since the last turn."""
    limit = -s.way * p.near_half
    apart = s.late_turned - limit  # K, positive while it warms
    x = max(T - s.turned_at, 0.0) if s.way > 0.0 else max(s.turned_at - T, 0.0)
    return limit + apart * nearness(x / max(abs(apart), 1e-9), p.near_bend)


@njit(cache=True)
def _near(p: Plant, s: State) -> None:
    """A loop between two limiting curves, which remembers its last turn alone."""
    if s.way * (s.mean - s.furthest) >= 0.0:
        s.furthest = s.mean
    elif s.way * (s.furthest - s.mean) > p.near_rest:  # turned, at a temperature that no step of time decides
        turned_at = s.furthest - s.way * p.near_rest
        s.late_turned = _lateness(p, s, turned_at)
        s.turned_at, s.furthest, s.way = turned_at, s.mean, -s.way
    s.late = _lateness(p, s, s.mean)


@njit(cache=True, inline='always')
def _loops(p: Plant, m: Arrays, mean: float) -> float:
    """How far the relays are from the middle of their loop, as a share."""
    up = 0.0
    for j in range(len(m.relays)):
        if mean > p.relay_up[j]:
            m.relays[j] = 1.0
        elif mean < p.relay_down[j]:
            m.relays[j] = 0.0
        up += p.relay_weight[j] * m.relays[j]
    return up - of_T(p.loop_centre, mean)


@njit(cache=True)
def _phase(p: Plant, phase: float, before: float, now: float) -> float:
    """The share of a phase that grows while it warms and goes while it cools, each in proportion to what can."""
    side = p.phase_half if now > before else -p.phase_half
    old, new = (before - p.phase_at - side) / p.phase_width, (now - p.phase_at - side) / p.phase_width
    if now > before:
        return 1.0 - (1.0 - phase) * (1.0 + math.exp(old)) / (1.0 + math.exp(new))
    return phase * (1.0 + math.exp(-old)) / (1.0 + math.exp(-new))


@njit(cache=True, inline='always')
def _branch(p: Plant, s: State, dT: float) -> None:
    """A way back that is not the way there."""
    goal = 0.0
    if dT < 0.0:
        goal = max(of_T(p.free, p.branch_from) - of_T(p.free, s.mean), 0.0) * p.branch_share
        if p.branch == 2:
            goal = 0.004 * math.tanh(goal / 0.004)
    if dT != 0.0:
        s.branch = goal + (s.branch - goal) * math.exp(-abs(dT) / p.branch_path)
    top = max(of_T(p.free, p.branch_from) - of_T(p.free, s.mean), 0.0) * p.branch_share
    if p.branch == 3:
        s.leaning = min(1.0, max(0.0, s.leaning - dT / p.branch_path))
        s.branch = top * s.leaning**2 * (3.0 - 2.0 * s.leaning)
    s.branch = min(s.branch, top)


@njit(cache=True, inline='always')
def _frozen(p: Plant, s: State, m: Arrays) -> float:
    """What heat has not yet set free, m."""
    frozen = 0.0
    if p.fixed > 0.0:
        s.peak = max(s.peak, s.mean)
        frozen = p.fixed * math.exp(-(((s.peak - s.fixed_from) / p.fixed_span) ** 2))
    for j in range(len(m.left)):
        pace = math.exp(p.frozen_sharp * (s.mean - p.frozen_at[j]))
        pace = pace / (1.0 + pace) / p.frozen_tau if p.frozen_sharp > 0.3 else pace / p.frozen_tau
        m.left[j] *= math.exp(-s.h * pace)
        frozen += p.frozen[j] * m.left[j]
    return frozen
