"""The integration of a Plant in time.

The muscle is a grid: axial nodes along the coil, radial shells in the fibre (0 = skin). Steps of about 5 ms: Heun for
heat, exact exponentials for relaxations, a balance of forces for the length.
"""

import math

import numpy as np
from numba import njit

from proof.truth.plant import D_LOW, D_STEP, F_STEP, GRAVITY, H_STEP, KELVIN, SIGMA, T_LOW, T_STEP, Array, Plant

SWINGS = 20  # substeps of a swinging weight


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
        for s in range(shells):
            if s > 0:
                before = 0 if p.shell_beside > 0 else s - 1
                q = p.shell_link[s - 1] / nodes * (T[a, before] - T[a, s])
            if p.shell_beside > 0:
                for c in range(1, shells if s == 0 else 0):
                    q += p.shell_link[c - 1] / nodes * (T[a, c] - T[a, 0])
            elif s < shells - 1:
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
def _rub_force(p: Plant, state: Array, step: float, F: float) -> float:
    """Friction under a load F after moving by `step`, N, positive when lengthening."""
    grip = F / 0.6 if p.rub == 3 else 1.0
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
        f = _tension(p, k, H - rest) + _rub_force(p, rub, H - start, F) - _of_H(p.stop, H) - F
        up = _tension(p, k, H + eps - rest) + _rub_force(p, rub, H + eps - start, F) - _of_H(p.stop, H + eps) - F
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
    frozen = p.fixed
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
    leaning = 0.0
    peak = ambient[0] + warm
    fixed_from = peak
    phase = 1.0 / (1.0 + math.exp(-(peak - p.phase_at - p.phase_half) / p.phase_width))
    rail = ambient[0]
    heat_to_come = 0.0
    damped = 0.0
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
            if p.hunting != 0.0 and k >= 0:
                asked = drive[k] * (1.0 + p.hunting * math.sin(p.hunting_rate * now))
            if p.supply == 1:
                keep = math.exp(-h * p.supply_rate)
                pole1 = asked + (pole1 - asked) * keep
                pole2 = pole1 + (pole2 - pole1) * keep
            elif p.supply == 2:
                reach = p.supply_rate * h
                pole2 += max(-reach, min(reach, asked - pole2))
            elif p.supply == 3:  # pole1 is the slope
                pole1 += h * p.supply_rate * (p.supply_rate * (asked - pole2) - 2.0 * p.supply_damping * pole1)
                pole2 += h * pole1
                if pole2 < 0.0:  # it gives nothing the other way round
                    pole1 = pole2 = 0.0
            else:
                pole2 = asked
            # --- electrical
            if p.ageing == 1:
                oxide += h * math.exp((mean - 60.0) / 25.0)
                aged = 1.0 + p.ageing_rate * math.sqrt(oxide / 100.0)
            elif p.ageing == 2:
                aged = 1.0 + p.ageing_rate * math.log1p(cracked)
            elif p.ageing == 3:
                oxide += h * (i / 0.25) ** 2 * math.exp((mean - 60.0) / 20.0)
                aged = 1.0 + p.ageing_rate * oxide / 180.0
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
            elif p.motion == 3:  # Churchill's cubes of a free and a forced part
                air *= (1.0 + ((1.0 + p.motion_gain) ** 3 - 1.0) * (speed / 0.01) ** 1.5) ** (1.0 / 3.0)
            extra = p.peltier * i
            if p.rail_link > 0.0:
                extra -= p.rail_link * (mean - rail)
                rail += h * (p.rail_link * (mean - rail) - p.rail_loss * (rail - outside)) / p.rail_mass
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
                heat_to_come += p.elastocaloric_late * warm
                warm *= 1.0 - p.elastocaloric_late
                for a in range(nodes):
                    for c in range(shells):
                        T[a, c] += warm
            if heat_to_come != 0.0:
                comes = heat_to_come * (1.0 - math.exp(-h / p.elastocaloric_tau))
                heat_to_come -= comes
                T += comes
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
            # damage of a way that is the hotter the worse; 0.9 of the others' over a cycle of 57 K
            dose += abs(dT) / 114.0 * (2.7 * ((mean - p.T0) / 57.0) ** 2 if p.fatigue == 3 else 1.0)
            thermal *= _look(p.gain, F / F_STEP)
            if p.fatigue == 1:
                thermal *= 1.0 - p.fatigue_share * ((1.0 + dose) ** p.fatigue_shape - 1.0) / p.fatigue_shape
            elif p.fatigue == 2:
                thermal *= 1.0 - p.fatigue_share * p.fatigue_shape * (1.0 - math.exp(-dose / p.fatigue_shape))
            elif p.fatigue == 3:
                thermal *= max(1.0 - p.fatigue_share * dose, 0.2)
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
            elif p.flow == 3:  # nothing below the yield load; free volume from -30 degC on
                pull = max(F - p.flow_scale, 0.0) / (0.6 - p.flow_scale)
                barrier = p.flow_heat * 90.0**2  # K; the same slope at 60 degC
                flowed += h * p.flow_rate * pull * math.exp(barrier * (1.0 / 90.0 - 1.0 / max(mean + 30.0, 10.0)))
            if p.twist > 0.0:
                torque = F / 0.6 * max(mean - p.T0, 0.0) / 47.0
                if p.twist_grip <= 0.0:
                    goal = p.twist * F / 0.6 * max(mean - p.T0, 0.0) / 47.0
                    turned += (goal - turned) * h / p.twist_tau
                elif torque > p.twist_grip:
                    turned += h * p.twist / p.twist_tau * (torque - p.twist_grip) / (1.0 - p.twist_grip)
                elif torque < 0.3 * p.twist_grip:
                    turned -= h * turned / (4.0 * p.twist_tau)
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
            if p.phase_stroke > 0.0:
                phase = _phase(p, phase, before, mean)
                inside -= p.phase_stroke * (phase - _of_T(p.loop_centre, mean))
            if p.branch > 0:
                goal = 0.0
                if dT < 0.0:
                    goal = max(_of_T(p.free, p.branch_from) - _of_T(p.free, mean), 0.0) * p.branch_share
                    if p.branch == 2:
                        goal = 0.004 * math.tanh(goal / 0.004)
                if dT != 0.0:
                    branch = goal + (branch - goal) * math.exp(-abs(dT) / p.branch_path)
                top = max(_of_T(p.free, p.branch_from) - _of_T(p.free, mean), 0.0) * p.branch_share
                if p.branch == 3:
                    leaning = min(1.0, max(0.0, leaning - dT / p.branch_path))
                    branch = top * leaning**2 * (3.0 - 2.0 * leaning)
                branch = min(branch, top)
                inside += branch
            frozen = 0.0
            if p.fixed > 0.0:
                peak = max(peak, mean)
                frozen = p.fixed * math.exp(-(((peak - fixed_from) / p.fixed_span) ** 2))
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
                    if p.mass == 3:  # relaxes as quickly as it swings; as much is lost in a swing as by the others
                        damped += h / SWINGS * (V - damped * math.sqrt(stiff / kg))
                        drag = 4.0 * p.mass_damping * stiff * damped
                    else:
                        drag = 2.0 * p.mass_damping * math.sqrt(stiff * kg) * V + p.mass_drag * abs(V) * V
                    tension = _tension(p, stiff, H - rest) - _of_H(p.stop, H) + _rub_force(p, rubbing, H - old, F)
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
def _phase(p: Plant, phase: float, before: float, now: float) -> float:
    """The share of a phase that grows while it warms and goes while it cools, each in proportion to what can."""
    side = p.phase_half if now > before else -p.phase_half
    old, new = (before - p.phase_at - side) / p.phase_width, (now - p.phase_at - side) / p.phase_width
    if now > before:
        return 1.0 - (1.0 - phase) * (1.0 + math.exp(old)) / (1.0 + math.exp(new))
    return phase * (1.0 + math.exp(-old)) / (1.0 + math.exp(-new))


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
