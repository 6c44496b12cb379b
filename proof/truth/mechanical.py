"""Concealed physics of the mechanical stage."""

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import expit

from proof.truth.bench import Bench
from proof.truth.body import free_change
from proof.truth.concealed import HOT, Draw, Outcome, effect, reached
from proof.truth.plant import D_GRID, F_GRID, H_GRID, KELVIN, T_GRID, Array


@effect('creep', 'mechanical', ('kelvin_chain', 'stretched'), ('paper', 'load_steps_cold', 'load_steps_hot', 'hold'))
def creep(d: Draw) -> Outcome:
    """Delayed elasticity with many times: four Kelvin units, or a stretched exponential as a spectrum of eight."""
    total, tau = d.between(0.02, 0.25), d.any(5.0, 60.0)
    faster = d.any(0.04, 0.08)
    if d.form == 0:
        J = total * np.array([0.2, 0.35, 0.3, 0.15])
        times = tau * np.array([0.25, 0.7, 1.6, 4.0])
        shift = np.exp(faster * (T_GRID - 50.0).clip(-40.0, 60.0))
    else:
        spread = np.linspace(-2.2, 2.2, 8)
        J = total * np.exp(-(spread**2) / 3.0 + 0.25 * spread)
        J *= total / J.sum()
        times = tau * np.exp(spread * 0.9)
        barrier = faster * 323.0**2  # K, so that the slope at 50 degC is the same
        shift = np.exp((barrier / 323.15 - barrier / (T_GRID + KELVIN)).clip(-5.0, 5.0))
    return {'J': total, 'tau_at_50': tau, 'shift': faster}, lambda b: b.set(creep=J, creep_tau=times, shift=shift)


@effect('viscous_flow', 'mechanical', ('eyring', 'power_hardening'), ('paper', 'hold', 'repeat'))
def viscous_flow(d: Draw) -> Outcome:
    """It flows when hot and does not come back."""
    rate = d.between(0.05, 1.2) * 1e-3 / 200.0  # m/s at 60 degC under 60 g
    heat = d.any(0.03, 0.06)
    scale = d.any(0.3, 0.7) if d.form == 0 else d.any(0.8, 1.4)
    return {'rate': rate, 'heat': heat}, lambda b: b.set(
        flow=1 + d.form, flow_rate=rate, flow_heat=heat, flow_scale=scale
    )


@effect('hysteresis', 'mechanical', ('relays', 'duhem'), ('staircase', 'paper', 'rates'))
def hysteresis(d: Draw) -> Outcome:
    """A loop that does not depend on the rate: a density of relays, or a semilinear Duhem model."""
    share, width = d.between(0.01, 0.10), d.any(5.0, 15.0)  # of the stroke; K
    stroke = abs(free_change(d.body, np.array([HOT]))[0])
    if d.form == 1:
        half = share * stroke / 2.0
        return {'loop_share': share, 'width': width}, lambda b: b.set(
            duhem_slope=half / (width / 2), duhem_path=width / 2
        )
    centre, half_width = np.meshgrid(np.linspace(24.0, 95.0, 40), np.linspace(0.15, 1.6, 9))
    half_width = half_width * width / 2.0
    weight = np.exp(-(((centre - 55.0) / 22.0) ** 2) - ((half_width / (width / 2.0) - 1.0) / 0.45) ** 2).ravel()
    weight /= weight.sum()
    up, down = (centre + half_width).ravel(), (centre - half_width).ravel()
    heating = (weight[:, None] * (T_GRID[None, ::20] > up[:, None])).sum(axis=0)
    cooling = (weight[:, None] * (T_GRID[None, ::20] > down[:, None])).sum(axis=0)
    middle = np.interp(T_GRID, T_GRID[::20], (heating + cooling) / 2.0)
    loop = float((cooling - heating).max())
    travel = share * stroke / loop
    return {'loop_share': share, 'width': width}, lambda b: b.set(
        relay_up=up, relay_down=down, relay_weight=weight, relay_stroke=travel, loop_centre=middle
    )


@effect('branch_cte', 'mechanical', ('path_exponential', 'path_saturating'), ('staircase', 'paper', 'rates'))
def branch_cte(d: Draw) -> Outcome:
    """Above the glass transition it contracts more on the way up than on the way down; the loop shuts at both ends."""
    share, start, path = d.between(0.012, 0.2), d.any(46.0, 54.0), d.any(4.0, 10.0)
    return {'share': share, 'from': start}, lambda b: b.set(
        branch=1 + d.form, branch_share=share, branch_from=start, branch_path=path
    )


@effect('shear_softening', 'mechanical', ('measured_ratio', 'glass_step'), ('load_steps_hot', 'paper', 'hold_loads'))
def shear_softening(d: Draw) -> Outcome:
    """The spring follows the shear modulus, which softens less than E of eq. 27."""
    blend = d.between(0.12, 1.15)
    if d.form == 0:  # after the ratio 0.78 between 40 and 90 degC
        knots = [-20.0, 23.0, 40.0, 60.0, 75.0, 90.0, 120.0, 240.0]
        ratio = PchipInterpolator(knots, [1.12, 1.0, 0.955, 0.875, 0.805, 0.745, 0.66, 0.5])(T_GRID)
    else:
        ratio = 1.0 - 0.30 * (expit((T_GRID - 65.0) / 16.0) - expit((23.0 - 65.0) / 16.0))
    return {'blend': blend}, lambda b: b.set(soft=b.plant.soft ** (1.0 - blend) * np.asarray(ratio) ** blend)


@effect('load_stroke', 'mechanical', ('power_of_length', 'saturating'), ('paper', 'load_steps_hot', 'hold_loads'))
def load_stroke(d: Draw) -> Outcome:
    """The thermal stroke shrinks with the load."""
    strength = d.between(0.08, 1.2)
    if d.form == 0:
        gain = (1.0 + F_GRID / d.body.k0 / d.body.H0) ** -strength
    else:
        gain = 1.0 - 0.33 * strength * (1.0 - np.exp(-F_GRID / 0.9))
    return {'strength': strength}, lambda b: b.set(gain=b.plant.gain * gain)


@effect(
    'geometric_stiffening',
    'mechanical',
    ('series_quartic', 'free_ends'),
    ('load_steps_cold', 'load_steps_hot', 'paper_heavy'),
)
def geometric_stiffening(d: Draw) -> Outcome:
    """An opening helix grows stiffer: eq. 24 in its corrected form, or a rod with bending that takes over."""
    blend = d.between(0.15, 1.6)
    H0, L, k0 = d.body.H0, 0.5, d.body.k0
    span = D_GRID.clip(-0.08, 0.34)
    H = H0 + span
    if d.form == 0:
        flexible = (L**2 - H**2) ** 2 + 1.4 * (L**2 - H**2) * H**2 / 1.0
        cold = (L**2 - H0**2) ** 2 + 1.4 * (L**2 - H0**2) * H0**2
        force = span * cold / np.maximum(flexible, 1e-3 * cold)
    else:
        angle, rest = np.arcsin(H / L), np.arcsin(H0 / L)
        bend = np.tan(angle) * (np.cos(rest) - np.cos(angle)) * 1.25
        wind = np.sin(angle) - np.sin(rest)
        force = wind + bend
        force = force / np.interp(1e-4, D_GRID, force) * 1e-4
    force = force + (D_GRID - span)  # straight beyond what the geometry allows
    return {'blend': blend, 'k0': k0}, lambda b: b.set(spring=D_GRID + blend * (force - D_GRID))


@effect('cte_kink', 'mechanical', ('smooth_switch', 'three_slopes'), ('paper', 'staircase', 'rates'))
def cte_kink(d: Draw) -> Outcome:
    """Little motion below the glass transition, more above; the stroke at 80 degC stays."""
    share, at = d.between(0.02, 0.5), d.any(42.0, 58.0)
    free = free_change(d.body, T_GRID)
    slope = np.gradient(free, T_GRID)
    if d.form == 0:
        factor = 1.0 + share * np.tanh((T_GRID - at) / 4.0)
    else:
        factor = np.interp(
            T_GRID, [0.0, at - 3.0, at + 5.0, 90.0, 240.0], [1 - share, 1 - share, 1.0, 1 + share, 1 + share]
        )
    bent = np.cumsum(slope * factor) * (T_GRID[1] - T_GRID[0])
    bent -= np.interp(d.body.T0, T_GRID, bent)
    bent *= np.interp(HOT, T_GRID, free) / np.interp(HOT, T_GRID, bent)
    return {'share': share, 'at': at}, lambda b: b.set(free=bent)


@effect('coil_contact', 'mechanical', ('spread_gaps', 'barrier'), ('light_hot', 'paper_light', 'rates_light'))
def coil_contact(d: Draw) -> Outcome:
    """Coils touch one after the other and push back: gaps of many sizes, or a barrier that steepens."""
    # Stronger = touching earlier: from just before full contraction to a third of the stroke lost.
    at = reached(d, 0.15) + d.between(0.001, 0.024) - 0.002
    if d.form == 0:
        gaps = at + d.any(0.001, 0.0035) * np.linspace(-1.7, 1.7, 35)
        push = 400.0 * np.maximum(gaps[:, None] - H_GRID[None, :], 0.0).mean(axis=0) * 2.0
    else:
        push = 0.9 * d.any(0.0008, 0.002) * 400.0 * np.logaddexp(0.0, (at - H_GRID) / 0.0015)
    return {'at': at}, lambda b: b.set(stop=push)


@effect('slack', 'mechanical', ('soft_dead_zone', 'loop_of_thread'), ('paper_light', 'light_hot', 'staircase'))
def slack(d: Draw) -> Outcome:
    """A slack link takes up the first millimetres of contraction; a load pulls it straight."""
    dead = d.between(0.0006, 0.007)
    soft, straight = d.any(1e-4, 3e-4), d.any(0.3, 0.6)  # m; N

    def link(x: Array, force: Array) -> Array:
        up = np.maximum(x, 0.0)
        if d.form == 0:
            way = dead / (1.0 + (force / straight) ** 2)
            taken = up - soft * (np.logaddexp(0.0, (up - way) / soft) - np.logaddexp(0.0, -way / soft))
        else:
            way = dead * np.maximum(1.0 - force / (3.0 * straight), 0.0)
            taken = up - (np.hypot(up, way) - way)
        return x - taken

    return {'dead': dead, 'straight_at': straight}, lambda b: b.link.append(link)


@effect('first_cycle', 'mechanical', ('threshold_elements', 'activated_elements'), ('paper', 'repeat', 'staircase'))
def first_cycle(d: Draw) -> Outcome:
    """Strain frozen in at rest is set free by the first warming."""
    length = d.between(0.0006, 0.010)
    n = 12
    frozen = length * d.rng.dirichlet(np.full(n, 6.0))
    at = np.linspace(d.any(27.0, 32.0), d.any(46.0, 54.0), n)
    tau, sharp = (d.any(1.0, 4.0), 0.9) if d.form == 0 else (d.any(4.0, 10.0), 0.22)
    return {'length': length}, lambda b: b.set(frozen=frozen, frozen_at=at, frozen_tau=tau, frozen_sharp=sharp)


@effect('fatigue', 'mechanical', ('power_of_dose', 'saturating'), ('repeat', 'paper', 'repeat'))
def fatigue(d: Draw) -> Outcome:
    """The stroke shrinks with every cycle."""
    share = d.between(0.0015, 0.025)
    shape = d.any(0.1, 0.4) if d.form == 0 else d.any(8.0, 25.0)
    return {'share': share}, lambda b: b.set(fatigue=1 + d.form, fatigue_share=share, fatigue_shape=shape)


@effect('inertia', 'mechanical', ('linear_damping', 'drag'), ('load_steps_cold', 'load_steps_hot', 'load_steps_cold'))
def inertia(d: Draw) -> Outcome:
    """The load is a mass on a spring."""
    zeta = d.between(0.25, 0.02)
    drag = 0.0 if d.form == 0 else d.any(0.3, 1.5)
    return {'zeta': zeta}, lambda b: b.set(mass=1 + d.form, mass_damping=zeta, mass_drag=drag)


@effect('friction', 'mechanical', ('dahl', 'maxwell_slip'), ('staircase', 'load_steps_cold', 'paper', 'rates'))
def friction(d: Draw) -> Outcome:
    """A guide that rubs: force against the motion, built up over a small way."""
    force = d.between(0.0025, 0.025)
    if d.form == 0:
        limit, reach = np.array([force]), np.array([d.any(1e-4, 4e-4)])
    else:
        limit = force * np.array([0.35, 0.3, 0.2, 0.15])
        reach = np.array([0.5, 1.0, 2.0, 4.0]) * d.any(1e-4, 3e-4)
    return {'force': force}, lambda b: b.set(rub=1 + d.form, rub_limit=limit, rub_reach=reach)


@effect('torsional_leakage', 'mechanical', ('slips', 'slow_turn'), ('hold', 'paper', 'repeat'))
def torsional_leakage(d: Draw) -> Outcome:
    """The end turns: sudden slips, or slowly towards what load and heat ask for."""
    size, seed = d.between(0.0002, 0.0025), d.seed()
    if d.form == 1:
        tau = d.any(40.0, 150.0)
        return {'size': size, 'tau': tau}, lambda b: b.set(twist=size, twist_tau=tau)

    def slips(time: Array, slip: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        slip = slip.copy()
        for _ in range(int(rng.integers(2, 6))):
            at = int(rng.uniform(0.08, 0.95) * len(time))
            slip[at] += size * float(rng.uniform(0.4, 1.0))
        return slip

    return {'size': size}, lambda b: b.slip.append(slips)


# --- in no catalogue --------------------------------------------------------------------------------------------------


@effect('periodic_friction', 'mechanical', ('sine_of_length',), ('paper', 'staircase'), listed=False)
def periodic_friction(d: Draw) -> Outcome:
    """A worn pulley: an error that repeats along the way."""
    size, period, phase = d.between(0.15e-3, 1.2e-3), d.any(3e-3, 8e-3), d.any(0.0, 6.28)

    def wobble(time: Array, x: Array, recording: int) -> Array:
        return x + size * (np.sin(2.0 * np.pi * x / period + phase) - np.sin(phase))

    return {'size': size, 'period': period}, lambda b: b.ruler.append(wobble)


@effect('stiffness_switch', 'mechanical', ('sudden',), ('paper', 'hold'), listed=False)
def stiffness_switch(d: Draw) -> Outcome:
    """A strand breaks once and the spring is softer from then on."""
    share, at = d.between(0.015, 0.12), d.any(60.0, 160.0)
    return {'share': share, 'time': at}, lambda b: b.set(switch_stiffness=share, switch_time=at)


@effect('rate_stroke', 'mechanical', ('slower_when_changing',), ('paper', 'prbs'), listed=False)
def rate_stroke(d: Draw) -> Outcome:
    """The stroke is smaller while the temperature changes, whichever way."""
    share = d.between(0.015, 0.12)
    return {'share': share}, lambda b: b.set(rate_stroke=share)


@effect('cubic_softening', 'mechanical', ('third_power',), ('load_steps_hot', 'paper_heavy'), listed=False)
def cubic_softening(d: Draw) -> Outcome:
    """The spring softens far more than any modulus table when hot."""
    share = d.between(0.06, 0.40)
    factor = 1.0 - share * np.clip((T_GRID - d.body.T0) / 57.0, 0.0, 1.2) ** 3
    return {'share': share}, lambda b: b.scale('soft', factor)


@effect('current_stroke', 'mechanical', ('current_squared',), ('paper', 'prbs'), listed=False)
def current_stroke(d: Draw) -> Outcome:
    """It contracts a little at the very moment when the current flows."""
    gain = d.between(4e-3, 4e-2)
    return {'gain': gain}, lambda b: b.set(current_stroke=gain)


@effect('self_resonance', 'mechanical', ('slow_swing',), ('paper', 'prbs'), listed=False)
def self_resonance(d: Draw) -> Outcome:
    """Load and muscle swing slowly at every change of pace."""
    share = d.between(0.2, 1.5)
    pace, damping = d.any(1.5, 3.5), d.any(0.03, 0.10)

    def change(b: Bench) -> None:
        b.set(resonance=share, resonance_rate=pace, resonance_damping=damping)

    return {'share': share, 'rate': pace}, change
