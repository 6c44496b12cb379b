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
    if p.twist_power > 0.0:
        _relaxing_crimp(p, s)
    elif p.twist > 0.0:
        _twist(p, s)
    inside += s.flowed + s.turned
    if len(m.relays) > 0:
        inside -= p.relay_stroke * _loops(p, m, mean)
    if p.wall_stroke > 0.0:
        _walls(p, s)
        inside -= p.wall_stroke * ((1.0 + s.aligned) / 2.0 - of_T(p.loop_centre, mean))
    if p.phase_stroke > 0.0:
        s.phase = _phase(p, s.phase, s.before, mean)
        inside -= p.phase_stroke * (s.phase - of_T(p.loop_centre, mean))
    if p.branch == 4:
        _lens(p, s)
        inside += s.branch
    elif p.branch > 0:
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
    elif p.flow == 4:  # a fluidity that rises straight from the glass transition on; the same slope at 60 degC
        s.flowed += s.h * p.flow_rate * (F / 0.6) ** p.flow_scale * max(1.0 + p.flow_heat * (mean - 60.0), 0.0)


@njit(cache=True, inline='always')
def _torque(p: Plant, s: State) -> float:
    """What load and heat turn the end with, as a share of that at 0.6 N, 70 degC."""
    return s.F / 0.6 * max(s.mean - p.T0, 0.0) / 47.0


@njit(cache=True, inline='always')
def _twist(p: Plant, s: State) -> None:
    """An end that gives way to the torque beyond its grip."""
    torque = _torque(p, s)
    if p.twist_log > 0.0:  # over barriers (Eyring) that each turn makes higher: as the logarithm of time
        pull = math.sinh(2.0 * torque) / math.sinh(2.0) * math.exp(-s.turned / (p.twist_log * p.twist))
        s.turned += s.h * p.twist / p.twist_tau * pull
    elif torque > p.twist_grip:
        s.turned += s.h * p.twist / p.twist_tau * (torque - p.twist_grip) / (1.0 - p.twist_grip)
    elif torque < 0.3 * p.twist_grip:
        s.turned -= s.h * s.turned / (4.0 * p.twist_tau)


@njit(cache=True, inline='always')
def _relaxing_crimp(p: Plant, s: State) -> None:
    """An end in a crimp: it turns at once by as much as the torque is beyond the grip, and the grip relaxes.

    Coulomb's slip with the torque that a turn takes away from itself (Prager 1956). The grip falls with the temperature
    as the polymer's own strength does, and with a power of time (Nutting 1921), which runs faster when hot (Leaderman
    1943). Turning back is uphill, as a screw is harder to fasten than to loosen.
    """
    s.relaxed += s.h * math.exp(p.twist_heat * ((s.before + s.mean) / 2.0 - 70.0))
    grip = p.twist_grip * (p.twist_clamp + (1.0 - p.twist_clamp) * s.F / 0.6)
    grip *= math.exp(p.twist_soft * (70.0 - s.mean) / 47.0) * (1.0 + s.relaxed / p.twist_tau) ** -p.twist_power
    torque = _torque(p, s)
    least, most = torque - grip, torque + p.twist_uphill * grip
    s.turned = min(max(s.turned, p.twist * least / p.twist_back), p.twist * most / p.twist_back)


@njit(cache=True)
def unheld(order: Array, lean: float) -> Array:
    """How far from the middle (K) domains have this order (-1 to 1) where nothing holds their walls.

    The reversible part of Hauser's energetic model of hysteresis, J. Appl. Phys. 75 (1994) and 96 (2004): a straight
    line, and the more domains have turned already, the more improbable is one that turns as well.
    """
    left, right = 1.0 - order, 1.0 + order
    odds = left * np.log(np.maximum(left, 1e-300)) + right * np.log(np.maximum(right, 1e-300))
    return lean * (order + np.sign(order) * (np.exp(odds) - 1.0) / 6.0)


@njit(cache=True)
def still_free(gone: Array, holding: float, grip: float) -> Array:
    """What is left of ``holding`` when the order has gone so far since its last turn; the walls put off 1 less that.

    The irreversible part of the same model.
    """
    return holding * np.exp(-grip * np.maximum(gone, 0.0) / holding)


@njit(cache=True)
def held_anew(gone: float, holding: float, grip: float) -> float:
    """``holding`` from a turn on, after the order has gone so far: 2 less what was left, so that nothing jumps."""
    return max(2.0 - still_free(gone, holding, grip), 1e-6)


@njit(cache=True)
def _aligned(p: Plant, s: State, T: float) -> float:
    """The order at T (degC) on the way since the last turn: the law gives T by it, so Newton's steps, kept within."""
    low, high, order = -1.0, 1.0, s.aligned
    for _ in range(80):
        gone = s.way * (order - s.aligned_turned)
        left = still_free(gone, s.holding, p.wall_grip)
        free = unheld(order, p.wall_lean)
        off = free + s.way * p.wall_half * (1.0 - left) - (T - p.wall_at)
        if off > 0.0:
            high = order
        else:
            low = order
        odds = abs(math.log(max(1.0 + order, 1e-17) / max(1.0 - order, 1e-17)))
        slope = p.wall_lean + (p.wall_lean / 6.0 + abs(free - p.wall_lean * order)) * odds
        if gone >= 0.0:
            slope += p.wall_half * p.wall_grip * left / s.holding
        old, order = order, order - off / slope
        if order < low or order > high:
            order = (low + high) / 2.0
        if abs(order - old) < 1e-13:
            break
    return order


@njit(cache=True)
def _walls(p: Plant, s: State) -> None:
    """The order of domains whose walls are held, from one turn of the temperature to the next."""
    if s.way * (s.mean - s.furthest) >= 0.0:
        s.furthest = s.mean
    elif s.way * (s.furthest - s.mean) > p.wall_rest:  # turned, at a temperature that no step of time decides
        s.aligned = _aligned(p, s, s.furthest - s.way * p.wall_rest)
        s.holding = held_anew(s.way * (s.aligned - s.aligned_turned), s.holding, p.wall_grip)
        s.aligned_turned, s.furthest, s.way = s.aligned, s.mean, -s.way
    s.aligned = _aligned(p, s, s.mean)


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


@njit(cache=True)
def _lens(p: Plant, s: State) -> None:
    """A way back that leaves the way there with the distance from the turn and meets it again where both began.

    A parabola, as Rayleigh's loops have it (1887). A way that turns inside goes straight to where its goal lies, at the
    turn above or at the start below, so that no step of time decides anything.
    """
    start, T, before = p.branch_from, s.mean, s.before
    if start >= T:
        s.branch, s.crest = 0.0, start
    elif before < T:
        s.branch = 0.0 if s.crest <= T else s.branch * (s.crest - T) / (s.crest - before)
        s.crest = max(s.crest, T)
    elif before > T:
        s.crest = max(s.crest, before)
        behind = _bulge(p, s.crest, before) - s.branch
        s.branch = _bulge(p, s.crest, T) - behind * (T - start) / (before - start)


@njit(cache=True)
def _bulge(p: Plant, crest: float, T: float) -> float:
    """The whole lens at T (degC) on the way down from ``crest``, m."""
    start = p.branch_from
    return p.branch_share * (of_T(p.free, start) - of_T(p.free, T)) * (crest - T) / (crest - start)


@njit(cache=True, inline='always')
def _frozen(p: Plant, s: State, m: Arrays) -> float:
    """What heat has not yet set free, m."""
    frozen = 0.0
    if p.fixed_way > 0.0:
        s.freed += max(s.mean - s.before, 0.0)
        frozen = p.fixed * math.exp(-s.freed / p.fixed_way)
    elif p.fixed > 0.0:
        s.peak = max(s.peak, s.mean)
        frozen = p.fixed * math.exp(-(((s.peak - s.fixed_from) / p.fixed_span) ** 2))
    for j in range(len(m.left)):
        pace = math.exp(p.frozen_sharp * (s.mean - p.frozen_at[j]))
        pace = pace / (1.0 + pace) / p.frozen_tau if p.frozen_sharp > 0.3 else pace / p.frozen_tau
        m.left[j] *= math.exp(-s.h * pace)
        frozen += p.frozen[j] * m.left[j]
    return frozen
