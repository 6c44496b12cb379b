"""Length and force: springs, friction, contact of coils, and a weight that swings."""

import math

from numba import njit

from proof.truth.plant import D_LOW, D_STEP, GRAVITY, Array, Plant
from proof.truth.state import Arrays, State
from proof.truth.tables import look, of_H, of_T

SWINGS = 20  # substeps of a swinging weight


@njit(cache=True, inline='always')
def begin_length(p: Plant, s: State, m: Arrays, ambient: float) -> None:
    """The zero of displacement: the length at rest at T0 under the first load; creep has come to its end by then."""
    soft = of_T(p.soft, ambient)
    for j in range(len(m.z)):
        m.z[j] = p.creep[j] * s.F / (p.k0 * soft)
    frozen = p.fixed
    for j in range(len(m.left)):
        frozen += p.frozen[j]
    rest = p.H0 + frozen
    creep0 = 0.0
    for j in range(len(m.z)):
        creep0 += p.creep[j] * s.F / p.k0
    s.zero = rest + creep0 + s.F / p.k0
    if _bent(p):
        s.zero = _balance(p, p.k0, rest + creep0, s.F, s.zero, m.rubbing)
    s.H = s.held = s.longest = s.zero


@njit(cache=True, inline='always')
def pull(p: Plant, s: State, m: Arrays, rest: float, blocked: bool) -> None:
    """Length (or, blocked, force) after a step, and what moving leaves behind; ``rest``: the length without load, m."""
    old = s.H
    if blocked:
        s.H = s.held
        s.F = max(0.0, _tension(p, s.stiff, s.H - rest) - of_H(p.stop, s.H))
        if s.first:
            s.F_prev = s.F
    elif p.mass > 0 and not s.first:
        _swing(p, s, m, rest)
    elif _bent(p):
        s.H = _balance(p, s.stiff, rest, s.F, s.H, m.rubbing)
    else:
        s.H = rest + s.F / s.stiff
    for j in range(len(m.rubbing)):
        m.rubbing[j] = _rubbed(p, m.rubbing[j], (s.H - old) / p.rub_reach[j])
    if not s.first:
        s.speed += (abs(s.H - old) / s.h - s.speed) * min(1.0, s.h / 0.1)
        if s.longest < s.H:
            s.cracked += (s.H - s.longest) / 0.05
        elif old < s.H:
            s.cracked += (s.H - old) / 0.05 * 0.3
    else:
        s.loose = s.H
    s.longest = max(s.longest, s.H)


@njit(cache=True, inline='always')
def _bent(p: Plant) -> bool:
    """Whether the balance of forces is none of a straight line."""
    return len(p.rub_limit) > 0 or p.stop[0] > 0.0 or abs(p.spring[0] - D_LOW) > 1e-9


@njit(cache=True, inline='always')
def _swing(p: Plant, s: State, m: Arrays, rest: float) -> None:
    """A step of a hanging weight."""
    old, stiff = s.H, s.stiff
    kg = max(s.F / GRAVITY, 1e-3)
    # A swing of 40 rad/s turns by a fifth of a radian in a step, and so far would its phase be wrong.
    for _ in range(SWINGS):
        if p.mass == 3:  # relaxes as quickly as it swings; as much is lost in a swing as by the others
            s.damped += s.h / SWINGS * (s.V - s.damped * math.sqrt(stiff / kg))
            drag = 4.0 * p.mass_damping * stiff * s.damped
        elif p.mass == 4:
            drag = 2.0 * p.mass_damping * math.sqrt(stiff * kg) * s.V + kg * _loose(p, s, stiff / kg)
        else:
            drag = 2.0 * p.mass_damping * math.sqrt(stiff * kg) * s.V + p.mass_drag * abs(s.V) * s.V
        tension = _tension(p, stiff, s.H - rest) - of_H(p.stop, s.H) + _rub_force(p, m.rubbing, s.H - old, s.F)
        s.V += s.h / SWINGS * (s.F - tension - drag) / kg
        s.H += s.h / SWINGS * s.V


@njit(cache=True)
def _loose(p: Plant, s: State, square: float) -> float:
    """What a part of the mass that hangs from the rest by a hook of its own holds it back with, N per kg of all.

    ``square``: (rad/s)^2 of the swing of all.
    """
    pace = p.loose_pace * math.sqrt(square)
    pulled = pace**2 * (s.H - s.loose) + 2.0 * p.mass_damping * pace * (s.V - s.loose_v)
    s.loose_v += s.h / SWINGS * pulled
    s.loose += s.h / SWINGS * s.loose_v
    return p.loose_share * pulled


@njit(cache=True)
def _rub_force(p: Plant, state: Array, step: float, F: float) -> float:
    """Friction under a load F after moving by `step`, N, positive when lengthening."""
    grip = F / 0.6 if p.rub == 3 else 1.0
    if p.rub == 4:  # some of it whatever hangs on it
        grip = 0.4 + F
    force = 0.0
    for j in range(len(state)):
        force += p.rub_limit[j] * _rubbed(p, state[j], step / p.rub_reach[j])
    return force * grip


@njit(cache=True)
def _rubbed(p: Plant, state: float, way: float) -> float:
    goal = 1.0 if way > 0.0 else -1.0
    if p.rub == 1:  # Dahl: approaches +-1 exponentially with the way
        return goal + (state - goal) * math.exp(-abs(way))
    if p.rub == 3:  # the square of what is left: quick at first, then slower than Dahl
        left = 1.0 - goal * state
        return goal * (1.0 - left / (1.0 + left * abs(way)))
    if p.rub == 4:  # Bouc and Wen with the exponent 2: 1 - state^2 a way
        way = min(1.0 - 1e-9, max(1e-9 - 1.0, math.tanh(way)))
        return min(1.0 - 1e-6, max(1e-6 - 1.0, (state + way) / (1.0 + state * way)))
    return min(1.0, max(-1.0, state + way))  # an element of a Maxwell slip chain


@njit(cache=True)
def _tension(p: Plant, k: float, extension: float) -> float:
    return k * look(p.spring, (extension - D_LOW) / D_STEP)


@njit(cache=True)
def _balance(p: Plant, k: float, rest: float, F: float, H: float, rub: Array) -> float:
    """The length at which spring, friction, contact and load are in balance, m."""
    start = H
    eps = 1e-6
    for _ in range(40):
        f = _tension(p, k, H - rest) + _rub_force(p, rub, H - start, F) - of_H(p.stop, H) - F
        up = _tension(p, k, H + eps - rest) + _rub_force(p, rub, H + eps - start, F) - of_H(p.stop, H + eps) - F
        slope = max((up - f) / eps, 1.0)
        step = max(-0.004, min(0.004, -f / slope))
        H += step
        if abs(step) < 1e-9:
            break
    return H
