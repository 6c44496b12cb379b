"""The truth's muscle as numbers, and its integration in time.

Whatever is a function of one variable is a table (resistivity, heat loss, stiffness ... over temperature;
piezoresistance, exposed area, contact force over length; the spring over extension), so any form can be concealed
without a line here. What has memory is written out. The muscle is a grid: axial nodes along the coil, radial shells in
the fibre (0 = skin). Temperatures in degC, otherwise SI. Steps of about 5 ms: Heun for heat, exact exponentials for
relaxations, a balance of forces for the length.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

CURRENT, POWER, VOLTAGE = 0, 1, 2

T_LOW, T_STEP, T_COUNT = -20.0, 0.05, 5200  # degC, to 240
H_STEP, H_COUNT = 1e-4, 6000  # m, 0 to 0.6
D_LOW, D_STEP, D_COUNT = -0.3, 1e-4, 8000  # extension, m
F_STEP, F_COUNT = 1e-3, 5000  # N

SIGMA = 5.670374e-8
KELVIN = 273.15
GRAVITY = 9.80665
SWINGS = 20  # substeps of a swinging weight

Array = np.ndarray[Any, Any]

T_GRID: Array = T_LOW + T_STEP * np.arange(T_COUNT)
H_GRID: Array = H_STEP * np.arange(H_COUNT)
D_GRID: Array = D_LOW + D_STEP * np.arange(D_COUNT)
F_GRID: Array = F_STEP * np.arange(F_COUNT)
NONE: Array = np.zeros(0)


class Plant(NamedTuple):
    """All numbers of one muscle. Every default is "this physics is absent"."""

    R0: float
    C: float  # J/K
    hA: float  # W/K
    k0: float  # N/m
    H0: float  # m
    T0: float  # degC
    # over temperature
    rho: Array  # R/R0
    loss: Array  # hA factor over T - ambient
    capacity: Array  # C factor
    free: Array  # m, thermal change of length (negative: contraction)
    soft: Array  # k/k0
    shift: Array  # how much faster creep runs than at 50 degC
    loop_centre: Array  # middle of the hysteresis loop, 0..1
    # over length, extension and load
    piezo: Array  # R factor over H
    area: Array  # hA factor over H
    stop: Array  # N over H, pushing the coils apart
    spring: Array  # (force / k0) over extension, m
    gain: Array  # free-stroke factor over load
    # grid
    shell_share: Array  # share of C per shell, skin first
    shell_link: Array  # W/K between neighbouring shells
    shell_pull: Array  # share of each shell in what drives the stroke
    axial_nodes: int = 1
    axial_link: float = 0.0  # W/K between neighbouring axial nodes
    clamp_link: float = 0.0  # W/K from an end node to a clamp at ambient
    clamp_mass: float = 0.0  # J/K of a clamp (0: it stays at ambient)
    profile: Array = NONE  # hA factor along the coil (empty: 1)
    # electrical
    contact: float = 0.0  # ohm in the crimps
    supply: int = 0  # 1: two poles, 2: slew limit
    supply_rate: float = 0.0  # 1/s; slew: full scale per second
    ageing: int = 0  # 1: parabolic oxidation, 2: cracks per stretch
    ageing_rate: float = 0.0
    # thermal
    emission: float = 0.0  # eps A, m2
    wall_offset: float = 0.0  # K
    motion: int = 0  # 1: power of still and moving air, 2: square root
    motion_gain: float = 0.0  # at 10 mm/s
    latent: float = 0.0  # J, kinetic order-disorder
    latent_at: float = 60.0
    latent_width: float = 3.0
    latent_tau: float = 1.0
    latent_cooler: float = 0.0  # K, how much lower the way back lies
    water: int = 0  # 1: two populations, 2: diffusion through rings
    water_share: float = 0.0  # kg/kg at the start
    water_tau: float = 10.0  # s at 60 degC
    water_mass: float = 1e-4  # kg of polymer
    elastocaloric: float = 0.0  # 1 = thermodynamics
    elastocaloric_loss: float = 0.0  # share that does not come back on unloading
    # mechanical
    creep: Array = NONE  # compliances relative to 1/k
    creep_tau: Array = NONE  # s at 50 degC
    flow: int = 0  # 1: Eyring, 2: power law with hardening
    flow_rate: float = 0.0  # m/s at 0.6 N and 60 degC
    flow_heat: float = 0.05  # 1/K
    flow_scale: float = 0.4  # N, or the exponent
    relay_up: Array = NONE
    relay_down: Array = NONE
    relay_weight: Array = NONE
    relay_stroke: float = 0.0  # m
    duhem_slope: float = 0.0  # m/K
    duhem_path: float = 10.0  # K
    branch: int = 0  # 1: exponential approach, 2: saturating
    branch_share: float = 0.0
    branch_from: float = 50.0
    branch_path: float = 6.0  # K
    frozen: Array = NONE  # m per element
    frozen_at: Array = NONE  # degC
    frozen_tau: float = 3.0
    frozen_sharp: float = 1.0  # 1/K
    fatigue: int = 0  # 1: power of the dose, 2: saturating
    fatigue_share: float = 0.0
    fatigue_shape: float = 0.3
    mass: int = 0  # 1: linear damping, 2: drag on top
    mass_damping: float = 0.05
    mass_drag: float = 0.0  # N s2/m2
    rub: int = 0  # 1: Dahl, 2: Maxwell slip elements
    rub_limit: Array = NONE  # N
    rub_reach: Array = NONE  # m
    twist: float = 0.0  # m at 0.6 N, 70 degC
    twist_tau: float = 60.0
    # in no catalogue
    peltier: float = 0.0  # V
    varistor: float = 0.0  # share at 0.27 A
    switch_time: float = 1e9  # s
    switch_resistance: float = 0.0
    switch_stiffness: float = 0.0
    rate_stroke: float = 0.0
    current_stroke: float = 0.0  # m/A2
    resonance: float = 0.0
    resonance_rate: float = 2.5  # rad/s
    resonance_damping: float = 0.05


# The columns of what `run` returns.
SKIN, MEAN, RESISTANCE, LENGTH, FORCE, AMPERE, WATT, WATER = range(8)


@njit(cache=True)
def _look(table: Array, place: float) -> float:
    last = len(table) - 2
    if place <= 0.0:
        return table[0]
    if place >= last:
        return table[last]
    j = int(place)
    return table[j] + (place - j) * (table[j + 1] - table[j])


@njit(cache=True)
def _of_T(table: Array, T: float) -> float:
    return _look(table, (T - T_LOW) / T_STEP)


@njit(cache=True)
def _of_H(table: Array, H: float) -> float:
    return _look(table, H / H_STEP)


@njit(cache=True)
def _heat(
    p: Plant, T: Array, ambient: float, clamp: float, air: float, ohm: float, i: float, extra: float, out: Array
) -> float:
    """Rates of all nodes, K/s, into out. ohm: R without its rho; extra: W into the whole muscle. W into the clamp."""
    nodes, shells = T.shape
    to_clamp = 0.0
    for a in range(nodes):
        skin = T[a, 0]
        theta = skin - ambient
        along = p.profile[a] if len(p.profile) > 0 else 1.0
        q = i * i * ohm * _of_T(p.rho, skin) + extra - p.hA * air * along * _of_T(p.loss, theta) * theta
        if p.emission > 0.0:
            q -= p.emission * SIGMA * ((skin + KELVIN) ** 4 - (ambient + p.wall_offset + KELVIN) ** 4)
        q /= nodes
        if nodes > 1:
            if a > 0:
                q += p.axial_link * (T[a - 1, 0] - skin)
            else:
                q += p.clamp_link * (clamp - skin)
                to_clamp = p.clamp_link * (skin - clamp)
            if a < nodes - 1:
                q += p.axial_link * (T[a + 1, 0] - skin)
        for s in range(shells):
            if s > 0:
                q = p.shell_link[s - 1] / nodes * (T[a, s - 1] - T[a, s])
            if s < shells - 1:
                q += p.shell_link[s] / nodes * (T[a, s + 1] - T[a, s])
            out[a, s] = q * nodes / (p.C * p.shell_share[s] * _of_T(p.capacity, T[a, s]))
    return to_clamp


@njit(cache=True)
def _pull(p: Plant, T: Array, a: int) -> float:
    total = 0.0
    for s in range(T.shape[1]):
        total += p.shell_pull[s] * T[a, s]
    return total


@njit(cache=True)
def _rub_force(p: Plant, state: Array, step: float) -> float:
    """Friction after moving by `step`, N, positive when lengthening."""
    force = 0.0
    for j in range(len(state)):
        force += p.rub_limit[j] * _rubbed(p, state[j], step / p.rub_reach[j])
    return force


@njit(cache=True)
def _rubbed(p: Plant, state: float, way: float) -> float:
    if p.rub == 1:  # Dahl: approaches +-1 exponentially with the way
        goal = 1.0 if way > 0.0 else -1.0
        return goal + (state - goal) * math.exp(-abs(way))
    return min(1.0, max(-1.0, state + way))  # an element of a Maxwell slip chain


@njit(cache=True)
def _tension(p: Plant, k: float, extension: float) -> float:
    return k * _look(p.spring, (extension - D_LOW) / D_STEP)


@njit(cache=True)
def _balance(p: Plant, k: float, rest: float, F: float, H: float, rub: Array) -> float:
    """The length at which spring, friction, contact and load are in balance, m."""
    start = H
    eps = 1e-6
    for _ in range(40):
        f = _tension(p, k, H - rest) + _rub_force(p, rub, H - start) - _of_H(p.stop, H) - F
        up = _tension(p, k, H + eps - rest) + _rub_force(p, rub, H + eps - start) - _of_H(p.stop, H + eps) - F
        slope = max((up - f) / eps, 1.0)
        step = max(-0.004, min(0.004, -f / slope))
        H += step
        if abs(step) < 1e-9:
            break
    return H


@njit(cache=True)
def _resistance(p: Plant, T: Array, H: float, aged: float) -> tuple[float, float]:
    """The wire's resistance without its dependence on temperature, and with it, ohm."""
    ohm = p.R0 * aged * _of_H(p.piezo, H)
    rho = 0.0
    for a in range(T.shape[0]):
        rho += _of_T(p.rho, T[a, 0])
    return ohm, ohm * rho / T.shape[0]


@njit(cache=True)
def _ampere(p: Plant, kind: int, drive: float, R: float) -> float:
    if kind == 0:
        return drive
    if kind == 1:
        return math.sqrt(max(drive, 0.0) / (R + p.contact))
    return drive / (R + p.contact)


@njit(cache=True)
def run(
    p: Plant,
    time: Array,
    drive: Array,
    kind: int,
    load: Array,
    ambient: Array,
    wind: Array,
    slip: Array,
    substeps: int,
    blocked: bool,
    dose: float,
    warm: float,
) -> tuple[Array, float, float]:
    """Integrate over the ticks `time`; inputs hold from their tick to the next.

    ambient, wind (hA factor) and slip (m added to the length at that tick) are the environment's. dose: cycles of 57 K
    that the muscle has behind it; warm: how far above the room it starts, K. Returns a column for each of SKIN..WATER,
    the zero of displacement (the length at rest at T0 under the first load), and the new dose.
    """
    n = len(time)
    nodes, shells = p.axial_nodes, len(p.shell_share)
    out = np.empty((n, 8))
    T = np.full((nodes, shells), ambient[0] + warm)
    rate = np.empty_like(T)
    rate2 = np.empty_like(T)
    ahead = np.empty_like(T)
    clamp = ambient[0]
    site = 0 if nodes == 1 else nodes - 1  # the thermometer is far from the clamp (the middle)
    rubbing = np.zeros(len(p.rub_limit))
    relays = np.zeros(len(p.relay_up))
    left = np.ones(len(p.frozen))
    z = np.zeros(len(p.creep))
    bent = len(p.rub_limit) > 0 or p.stop[0] > 0.0 or abs(p.spring[0] - D_LOW) > 1e-9

    F = load[0]
    soft = _of_T(p.soft, ambient[0])
    for j in range(len(z)):
        z[j] = p.creep[j] * F / (p.k0 * soft)
    frozen = 0.0
    for j in range(len(left)):
        frozen += p.frozen[j]
    rest = p.H0 + frozen
    creep0 = 0.0
    for j in range(len(z)):
        creep0 += p.creep[j] * F / p.k0
    zero = rest + creep0 + F / p.k0
    if bent:
        zero = _balance(p, p.k0, rest + creep0, F, zero, rubbing)
    H = zero
    held = zero
    first = True
    V = 0.0
    speed = 0.0
    warming = 0.0
    flowed = 0.0
    duhem = 0.0
    branch = 0.0
    turned = 0.0
    slipped = 0.0
    order = 0.0
    cracked = 0.0
    oxide = 0.0
    loops = _of_T(p.loop_centre, ambient[0])
    ring = 0.0
    ring_v = 0.0
    ring_on = False
    pole1 = 0.0
    pole2 = 0.0
    aged = 1.0
    longest = zero
    water = np.empty(6)
    for j in range(6):
        water[j] = p.water_share
    wet = p.water_share
    i = 0.0
    R = p.R0
    F_prev = F
    mean = ambient[0] + warm

    # Pass -1 settles the length; pass k goes from tick k to k + 1 and then writes the state of tick k + 1: a state is
    # what was before the inputs of its own tick act.
    for k in range(-1, n - 1):
        now = time[max(k, 0)]
        steps = substeps if k >= 0 else 1
        h = (time[k + 1] - now) / steps if k >= 0 else 1e-9
        asked = drive[k] if k >= 0 else 0.0
        slipped += slip[max(k, 0)]
        if not blocked:
            F = load[max(k, 0)]
        outside = ambient[max(k, 0)]
        for _s in range(steps):
            now += h
            # --- what the supply really gives
            if p.supply == 1:
                keep = math.exp(-h * p.supply_rate)
                pole1 = asked + (pole1 - asked) * keep
                pole2 = pole1 + (pole2 - pole1) * keep
            elif p.supply == 2:
                reach = p.supply_rate * h
                pole2 += max(-reach, min(reach, asked - pole2))
            else:
                pole2 = asked
            # --- electrical
            if p.ageing == 1:
                oxide += h * math.exp((mean - 60.0) / 25.0)
                aged = 1.0 + p.ageing_rate * math.sqrt(oxide / 100.0)
            elif p.ageing == 2:
                aged = 1.0 + p.ageing_rate * math.log1p(cracked)
            if p.switch_resistance != 0.0 and now >= p.switch_time:
                aged = 1.0 + p.switch_resistance
            ohm, R = _resistance(p, T, H, aged)
            i = _ampere(p, kind, pole2, R)
            ohm *= 1.0 + p.varistor * (i / 0.27) ** 2
            # --- heat
            air = wind[max(k, 0)] * _of_H(p.area, H)
            if p.motion == 1:
                air *= (1.0 + (speed / 0.01) ** 2) ** math.log2(1.0 + p.motion_gain)
            elif p.motion == 2:
                air *= 1.0 + p.motion_gain * math.sqrt(speed / 0.01)
            extra = p.peltier * i
            if p.latent > 0.0:
                at = p.latent_at - (p.latent_cooler if warming < 0.0 else 0.0)
                goal = 1.0 / (1.0 + math.exp(-(mean - at) / p.latent_width))
                new = goal + (order - goal) * math.exp(-h / p.latent_tau)
                if not first:
                    extra -= p.latent * (new - order) / h
                order = goal if first else new
            if p.water > 0:
                before = wet
                wet = _dry(p, water, mean, h)
                extra += p.water_mass * 2.4e6 * (wet - before) / h  # leaving water takes its heat along
            if k >= 0:
                to_clamp = _heat(p, T, outside, clamp, air, ohm, i, extra, rate)
                for a in range(nodes):
                    for c in range(shells):
                        ahead[a, c] = T[a, c] + h * rate[a, c]
                _heat(p, ahead, outside, clamp, air, ohm, i, extra, rate2)
                for a in range(nodes):
                    for c in range(shells):
                        T[a, c] += 0.5 * h * (rate[a, c] + rate2[a, c])
                if p.clamp_mass > 0.0:
                    clamp += h * (to_clamp - p.hA * 0.15 * (clamp - outside)) / p.clamp_mass
                else:
                    clamp = outside
            if p.elastocaloric > 0.0 and F_prev != F:
                at = (mean - T_LOW) / T_STEP
                slope = (_look(p.free, at + 10.0) - _look(p.free, at - 10.0)) / (20.0 * T_STEP)
                warm = -p.elastocaloric * (mean + KELVIN) * slope * (F - F_prev) / p.C
                if F_prev > F:
                    warm *= 1.0 - p.elastocaloric_loss
                for a in range(nodes):
                    for c in range(shells):
                        T[a, c] += warm
            F_prev = F
            # --- what the temperature does to length
            before = mean
            mean = 0.0
            thermal = 0.0
            supple = 0.0
            for a in range(nodes):
                at = _pull(p, T, a)
                mean += at / nodes
                thermal += _of_T(p.free, at) / nodes
                supple += 1.0 / _of_T(p.soft, at) / nodes
            if first:
                before = mean
            dT = mean - before
            warming += (dT / h - warming) * min(1.0, h / 0.2) if not first else 0.0
            dose += abs(dT) / 114.0
            thermal *= _look(p.gain, F / F_STEP)
            if p.fatigue == 1:
                thermal *= 1.0 - p.fatigue_share * ((1.0 + dose) ** p.fatigue_shape - 1.0) / p.fatigue_shape
            elif p.fatigue == 2:
                thermal *= 1.0 - p.fatigue_share * p.fatigue_shape * (1.0 - math.exp(-dose / p.fatigue_shape))
            if p.rate_stroke != 0.0:
                thermal *= 1.0 - p.rate_stroke * abs(warming) / (abs(warming) + 1.0)
            if p.resonance != 0.0:
                if not ring_on:
                    ring = thermal
                    ring_on = True
                ring_v += h * (
                    p.resonance_rate**2 * (thermal - ring) - 2.0 * p.resonance_damping * p.resonance_rate * ring_v
                )
                ring += h * ring_v
                thermal += p.resonance * (ring - thermal)
            stiff = p.k0 / supple
            if now >= p.switch_time:
                stiff *= 1.0 - p.switch_stiffness
            # --- what it remembers
            inside = slipped - p.current_stroke * i * i
            if len(z) > 0:
                quick = _of_T(p.shift, mean)
                for j in range(len(z)):
                    goal = p.creep[j] * F / stiff
                    z[j] = goal + (z[j] - goal) * math.exp(-h * quick / p.creep_tau[j])
                    inside += z[j]
            if p.flow == 1:
                pull = math.sinh(F / p.flow_scale) / math.sinh(0.6 / p.flow_scale)
                flowed += h * p.flow_rate * pull * math.exp(p.flow_heat * (mean - 60.0))
            elif p.flow == 2:
                pull = (F / 0.6) ** p.flow_scale / (1.0 + flowed / 0.5e-3)
                barrier = p.flow_heat * 333.15**2  # K; the same slope at 60 degC
                flowed += h * p.flow_rate * pull * math.exp(barrier * (1.0 / 333.15 - 1.0 / (mean + KELVIN)))
            if p.twist > 0.0:
                goal = p.twist * F / 0.6 * max(mean - p.T0, 0.0) / 47.0
                turned += (goal - turned) * h / p.twist_tau
            inside += flowed + turned
            if len(relays) > 0:
                up = 0.0
                for j in range(len(relays)):
                    if mean > p.relay_up[j]:
                        relays[j] = 1.0
                    elif mean < p.relay_down[j]:
                        relays[j] = 0.0
                    up += p.relay_weight[j] * relays[j]
                loops = up - _of_T(p.loop_centre, mean)
                inside -= p.relay_stroke * loops
            if p.duhem_slope > 0.0:
                duhem = duhem * math.exp(-abs(dT) / p.duhem_path) - p.duhem_slope * dT
                inside -= duhem
            if p.branch > 0:
                goal = 0.0
                if dT < 0.0:
                    goal = max(_of_T(p.free, p.branch_from) - _of_T(p.free, mean), 0.0) * p.branch_share
                    if p.branch == 2:
                        goal = 0.004 * math.tanh(goal / 0.004)
                if dT != 0.0:
                    branch = goal + (branch - goal) * math.exp(-abs(dT) / p.branch_path)
                top = max(_of_T(p.free, p.branch_from) - _of_T(p.free, mean), 0.0) * p.branch_share
                branch = min(branch, top)
                inside += branch
            frozen = 0.0
            for j in range(len(left)):
                pace = math.exp(p.frozen_sharp * (mean - p.frozen_at[j]))
                pace = pace / (1.0 + pace) / p.frozen_tau if p.frozen_sharp > 0.3 else pace / p.frozen_tau
                left[j] *= math.exp(-h * pace)
                frozen += p.frozen[j] * left[j]
            inside += frozen
            # --- length or force
            rest = p.H0 + thermal + inside
            old = H
            if blocked:
                H = held
                F = max(0.0, _tension(p, stiff, H - rest) - _of_H(p.stop, H))
                if first:
                    F_prev = F
            elif p.mass > 0 and not first:
                kg = max(F / GRAVITY, 1e-3)
                # A swing of 40 rad/s turns by a fifth of a radian in a step, and so far would its phase be wrong.
                for _ in range(SWINGS):
                    drag = 2.0 * p.mass_damping * math.sqrt(stiff * kg) * V + p.mass_drag * abs(V) * V
                    tension = _tension(p, stiff, H - rest) - _of_H(p.stop, H) + _rub_force(p, rubbing, H - old)
                    V += h / SWINGS * (F - tension - drag) / kg
                    H += h / SWINGS * V
            elif bent:
                H = _balance(p, stiff, rest, F, H, rubbing)
            else:
                H = rest + F / stiff
            for j in range(len(rubbing)):
                rubbing[j] = _rubbed(p, rubbing[j], (H - old) / p.rub_reach[j])
            if not first:
                speed += (abs(H - old) / h - speed) * min(1.0, h / 0.1)
                if longest < H:
                    cracked += (H - longest) / 0.05
                elif old < H:
                    cracked += (H - old) / 0.05 * 0.3
            longest = max(longest, H)
            first = False
        ohm, R = _resistance(p, T, H, aged)
        i = _ampere(p, kind, pole2 if p.supply > 0 else drive[k + 1], R)
        R *= 1.0 + p.varistor * (i / 0.27) ** 2
        out[k + 1, 0] = T[site, 0]
        out[k + 1, 1] = mean
        out[k + 1, 2] = R + p.contact
        out[k + 1, 3] = H
        out[k + 1, 4] = F
        out[k + 1, 5] = i
        out[k + 1, 6] = i * i * R
        out[k + 1, 7] = wet
    return out, zero, dose


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
