"""A step of heat: what flows in and out of every node, Heun's way, and what comes and goes at once."""

import math

from numba import njit

from proof.truth.plant import KELVIN, SIGMA, T_LOW, T_STEP, Array, Plant
from proof.truth.state import Arrays, State
from proof.truth.tables import look, of_H, of_T


@njit(cache=True, inline='always')
def warm_up(p: Plant, s: State, m: Arrays, ohm: float, still: bool) -> None:
    """All temperatures after a step; ohm: R without its rho; ``still``: only what comes and goes at once."""
    air = _air(p, s)
    extra = _extra(p, s, m)
    if not still:
        _heat_all(p, s, m, air, ohm, extra)
    if p.elastocaloric > 0.0 and s.F_prev != s.F:
        _elastocaloric(p, s, m)
    if s.heat_to_come != 0.0:
        comes = s.heat_to_come * (1.0 - math.exp(-s.h / p.elastocaloric_tau))
        s.heat_to_come -= comes
        for a in range(m.T.shape[0]):
            for c in range(m.T.shape[1]):
                m.T[a, c] += comes
    s.F_prev = s.F


@njit(cache=True, inline='always')
def _air(p: Plant, s: State) -> float:
    """The factor of hA for wind, length and motion."""
    air = s.wind * of_H(p.area, s.H)
    if p.load_loss != 0.0:
        air *= max(1.0 + p.load_loss * (s.F / 0.6 - 1.0), 0.2)
    if p.motion == 1:
        air *= (1.0 + (s.speed / 0.01) ** 2) ** math.log2(1.0 + p.motion_gain)
    elif p.motion == 2:
        air *= 1.0 + p.motion_gain * math.sqrt(s.speed / 0.01)
    elif p.motion == 3:  # Churchill's cubes of a free and a forced part
        air *= (1.0 + ((1.0 + p.motion_gain) ** 3 - 1.0) * (s.speed / 0.01) ** 1.5) ** (1.0 / 3.0)
    elif p.motion == 4:  # as the square of a slow motion; the air goes along with a quick one
        square = (s.speed / 0.01) ** 2
        air *= 1.0 + 2.5 * p.motion_gain * square / (square + 1.5)
    return air


@njit(cache=True, inline='always')
def _extra(p: Plant, s: State, m: Arrays) -> float:
    """Heat into the whole muscle other than Joule's, W: at the crimps, from a rail, of ordering, of drying."""
    h, mean = s.h, s.mean
    extra = p.peltier * s.i
    if p.rail_link > 0.0:
        extra -= p.rail_link * (mean - s.rail)
        s.rail += h * (p.rail_link * (mean - s.rail) - p.rail_loss * (s.rail - s.outside)) / p.rail_mass
    if p.latent > 0.0:
        at = p.latent_at - (p.latent_cooler if s.warming < 0.0 else 0.0)
        goal = 1.0 / (1.0 + math.exp(-(mean - at) / p.latent_width))
        new = goal + (s.order - goal) * math.exp(-h / p.latent_tau)
        if not s.first:
            extra -= p.latent * (new - s.order) / h
        s.order = goal if s.first else new
    if p.water > 0:
        before = s.wet
        s.wet = _dry(p, m.water, mean, h)
        extra += p.water_mass * 2.4e6 * (s.wet - before) / h  # leaving water takes its heat along
    return extra


@njit(cache=True, inline='always')
def _heat_all(p: Plant, s: State, m: Arrays, air: float, ohm: float, extra: float) -> None:
    """Heun's step of all nodes, and the clamp's."""
    h, T = s.h, m.T
    nodes, shells = T.shape
    to_clamp = _heat(p, T, s.outside, s.clamp, air, ohm, s.i, extra, m.rate)
    for a in range(nodes):
        for c in range(shells):
            m.ahead[a, c] = T[a, c] + h * m.rate[a, c]
    _heat(p, m.ahead, s.outside, s.clamp, air, ohm, s.i, extra, m.rate2)
    for a in range(nodes):
        for c in range(shells):
            T[a, c] += 0.5 * h * (m.rate[a, c] + m.rate2[a, c])
    if p.clamp_mass > 0.0:
        s.clamp += h * (to_clamp - p.hA * 0.15 * (s.clamp - s.outside)) / p.clamp_mass
    else:
        s.clamp = s.outside


@njit(cache=True)
def _heat(
    p: Plant, T: Array, ambient: float, clamp: float, air: float, ohm: float, i: float, extra: float, out: Array
) -> float:
    """Rates of all nodes, K/s, into out. ohm: R without its rho; extra: W into the whole muscle. W into the clamp."""
    nodes = T.shape[0]
    to_clamp = 0.0
    for a in range(nodes):
        skin = T[a, 0]
        theta = skin - ambient
        along = p.profile[a] if len(p.profile) > 0 else 1.0
        q = i * i * ohm * of_T(p.rho, skin) + extra - p.hA * air * along * of_T(p.loss, theta) * theta
        if p.emission > 0.0:
            shine = p.emission * (1.0 + p.emission_rise * (skin - 60.0))
            q -= shine * SIGMA * ((skin + KELVIN) ** 4 - (ambient + p.wall_offset + KELVIN) ** 4)
        q /= nodes
        if nodes > 1:
            if a > 0:
                q += p.axial_link * (T[a - 1, 0] - skin)
            else:
                q += p.clamp_link * (clamp - skin)
                to_clamp = p.clamp_link * (skin - clamp)
            if a < nodes - 1:
                q += p.axial_link * (T[a + 1, 0] - skin)
        _through_shells(p, T, a, q, out)
    return to_clamp


@njit(cache=True, inline='always')
def _through_shells(p: Plant, T: Array, a: int, q: float, out: Array) -> None:
    """The rates of one axial node's shells, K/s, into out; q: W into its skin."""
    nodes, shells = T.shape
    for s in range(shells):
        if s > 0:
            before = 0 if p.shell_beside > 0 else s - 1
            q = p.shell_link[s - 1] / nodes * (T[a, before] - T[a, s])
        if p.shell_beside > 0:
            for c in range(1, shells if s == 0 else 0):
                q += p.shell_link[c - 1] / nodes * (T[a, c] - T[a, 0])
        elif s < shells - 1:
            q += p.shell_link[s] / nodes * (T[a, s + 1] - T[a, s])
        out[a, s] = q * nodes / (p.C * p.shell_share[s] * of_T(p.capacity, T[a, s]))


@njit(cache=True, inline='always')
def _elastocaloric(p: Plant, s: State, m: Arrays) -> None:
    """The heat of a step of the load."""
    at = (s.mean - T_LOW) / T_STEP
    slope = (look(p.free, at + 10.0) - look(p.free, at - 10.0)) / (20.0 * T_STEP)
    warm = -p.elastocaloric * (s.mean + KELVIN) * slope * (s.F - s.F_prev) / p.C
    if s.F_prev > s.F:
        warm *= 1.0 - p.elastocaloric_loss
    if p.elastocaloric_power > 0.0:
        warm *= max((s.F + s.F_prev) / 1.2, 0.0) ** p.elastocaloric_power
    s.heat_to_come += p.elastocaloric_late * warm
    warm *= 1.0 - p.elastocaloric_late
    for a in range(m.T.shape[0]):
        for c in range(m.T.shape[1]):
            m.T[a, c] += warm


@njit(cache=True)
def _vapour(T: float) -> float:
    """Pressure of saturated water vapour relative to that at 60 degC (Magnus)."""
    return math.exp(17.62 * T / (243.1 + T) - 17.62 * 60.0 / 303.1)


@njit(cache=True)
def _dry(p: Plant, water: Array, T: float, h: float) -> float:
    """Water leaving over h; the mean share that is left, kg/kg."""
    goal = p.water_share * math.exp(-max(T - 23.0, 0.0) / 22.0)
    quick = math.exp(0.045 * (T - 60.0)) / p.water_tau
    if p.water == 1:  # bound in two populations: thin filaments and thick ones
        for j in range(2):
            pace = quick if j == 0 else quick / 6.0
            water[j] = goal + (water[j] - goal) * math.exp(-h * pace)
        return 0.65 * water[0] + 0.35 * water[1]
    if p.water == 3:  # the surface's pressure against the room's; a little water is held tighter than much
        held = water[0] / p.water_share
        water[0] -= h * p.water_share / p.water_tau * (held * abs(held) * _vapour(T) - _vapour(23.0))
        return water[0]
    if p.water == 4:  # Elovich: each that has left makes the next harder to move; it comes back slowly
        gone = 1.0 - water[0] / p.water_share
        if water[0] > goal:
            water[0] = max(goal, water[0] - h * 1.5 * quick * p.water_share * math.exp(-3.0 * gone))
        else:
            water[0] += h * (goal - water[0]) / (5.0 * p.water_tau)
        return water[0]
    total = 0.0
    outer = goal  # rings of equal width, the outermost in balance with the air
    for j in range(6):
        inner = water[j + 1] if j < 5 else water[5]
        r_out, r_in = 6.0 - j, 5.0 - j
        width = (r_out * r_out - r_in * r_in) / 2.0
        link_out = 2.0 * r_out if j == 0 else r_out
        step = h * quick * 6.0 * (link_out * (outer - water[j]) + r_in * (inner - water[j])) / width
        outer = water[j]
        water[j] += step
        total += water[j] * width / 18.0
    return total
