"""Concealed physics of the mechanical stage."""

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import expit

from proof.truth.body import free_change
from proof.truth.concealed import HOT, Draw, Outcome, effect, reached
from proof.truth.memory import held_anew, still_free, unheld
from proof.truth.plant import D_GRID, F_GRID, H_GRID, KELVIN, T_GRID, Array


@effect(
    'creep',
    'mechanical',
    ('kelvin_chain', 'stretched', 'power_law'),
    ('paper', 'load_steps_cold', 'load_steps_hot', 'hold'),
)
def creep(d: Draw) -> Outcome:
    """Delayed elasticity with many times: four Kelvin units, a stretched exponential, or a power law without an end."""
    total, tau = d.between(0.02, 0.25), d.any(5.0, 60.0)
    faster = d.any(0.04, 0.08)
    if d.form == 0:
        J = total * np.array([0.2, 0.35, 0.3, 0.15])
        times = tau * np.array([0.25, 0.7, 1.6, 4.0])
        shift = np.exp(faster * (T_GRID - 50.0).clip(-40.0, 60.0))
    elif d.form == 2:  # Andrade's cube root or near it, as a spectrum of three decades; Williams, Landel and Ferry
        power = d.any(0.25, 0.4)
        times = tau * np.geomspace(0.03, 30.0, 10)
        J = times**power / np.sum(times**power)
        J *= total / np.sum(J * -np.expm1(-3.0 * tau / times))  # as much after three tau as the others
        above = (T_GRID - 50.0).clip(-35.0, 80.0)
        shift = np.exp(faster * 80.0 * above / (80.0 + above))
    else:
        spread = np.linspace(-2.2, 2.2, 8)
        J = total * np.exp(-(spread**2) / 3.0 + 0.25 * spread)
        J *= total / J.sum()
        times = tau * np.exp(spread * 0.9)
        barrier = faster * 323.0**2  # K, so that the slope at 50 degC is the same
        shift = np.exp((barrier / 323.15 - barrier / (T_GRID + KELVIN)).clip(-5.0, 5.0))
    return {'J': total, 'tau_at_50': tau, 'shift': faster}, lambda b: b.set(creep=J, creep_tau=times, shift=shift)


@effect('viscous_flow', 'mechanical', ('eyring', 'power_hardening', 'bingham'), ('paper', 'hold', 'repeat'))
def viscous_flow(d: Draw) -> Outcome:
    """It flows when hot and does not come back."""
    rate = d.between(0.05, 1.2) * 1e-3 / 200.0  # m/s at 60 degC under 60 g
    heat = d.any(0.03, 0.06)
    scale = d.any(*((0.3, 0.7), (0.8, 1.4), (0.05, 0.14))[d.form])
    return {'rate': rate, 'heat': heat}, lambda b: b.set(
        flow=1 + d.form, flow_rate=rate, flow_heat=heat, flow_scale=scale
    )


@effect('hysteresis', 'mechanical', ('relays', 'held_walls', 'phase_kinetics'), ('staircase', 'paper', 'rates'))
def hysteresis(d: Draw) -> Outcome:
    """A loop that does not depend on the rate: a density of relays, domains whose walls are held the more firmly the
    further they have gone, or a phase that lingers."""
    share, width = d.between(0.01, 0.10), d.any(5.0, 15.0)  # of the stroke; K
    stroke = abs(free_change(d.body, np.array([HOT]))[0])
    if d.form == 1:
        return _held_walls(d, share * stroke, share, width)
    if d.form == 2:  # Ivshin and Pence: each phase turns in proportion to what of it is left
        at, spread = d.any(52.0, 60.0), d.any(7.0, 11.0)
        comes, goes = (expit((T_GRID - at - side * width / 2.0) / spread) for side in (1.0, -1.0))
        # of the loop that is shut at HOT
        loop = float((goes * np.interp(HOT, T_GRID, comes / goes) - comes).max())
        return {'loop_share': share, 'width': width, 'at': at}, lambda b: b.set(
            phase_stroke=share * stroke / loop,
            phase_at=at,
            phase_half=width / 2.0,
            phase_width=spread,
            loop_centre=(comes + goes) / 2.0,
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


def _held_walls(d: Draw, size: float, share: float, width: float) -> Outcome:
    """The loop of Hauser's energetic model (1994); ``size`` (m): its opening on the way to HOT and back."""
    at, lean, grip = d.any(48.0, 60.0), d.any(13.0, 20.0), d.any(4.0, 9.0)
    half, rest = width / 2.0, d.body.T0

    def branch(turned: float, way: float, holding: float) -> Array:
        """The order over temperature after a turn."""
        order = np.linspace(turned, way, 4001)
        T = at + unheld(order, lean) + way * half * (1.0 - still_free(way * (order - turned), holding, grip))
        rising = slice(None, None, int(way))
        return np.asarray(np.interp(T_GRID, T[rising], order[rising]))

    up, down = branch(-1.0, 1.0, 2.0), branch(1.0, -1.0, 2.0)
    cold = float(np.interp(rest, T_GRID, down))
    holding = held_anew(1.0 - cold, 2.0, grip)
    comes = branch(cold, 1.0, holding)
    hot = float(np.interp(HOT, T_GRID, comes))
    goes = branch(hot, -1.0, held_anew(hot - cold, holding, grip))
    between = (rest < T_GRID) & (T_GRID < HOT)
    loop = float((goes - comes)[between].max()) / 2.0
    # where it has cooled down to T0 is its zero
    middle = (up + down + float(np.interp(rest, T_GRID, down - up))) / 2.0
    return {'loop_share': share, 'width': width, 'at': at, 'grip': grip}, lambda b: b.set(
        wall_stroke=size / loop,
        wall_at=at,
        wall_half=half,
        wall_lean=lean,
        wall_grip=grip,
        loop_centre=(1.0 + middle) / 2.0,
    )


@effect(
    'branch_cte', 'mechanical', ('path_exponential', 'path_saturating', 'play_between'), ('staircase', 'paper', 'rates')
)
def branch_cte(d: Draw) -> Outcome:
    """Above the glass transition it contracts more on the way up than on the way down; the loop shuts at both ends."""
    share, start, path = d.between(0.012, 0.2), d.any(46.0, 54.0), d.any(4.0, 10.0)
    path *= 2.0 if d.form == 2 else 1.0  # K from one curve to the other, and not to a share of what is left
    return {'share': share, 'from': start}, lambda b: b.set(
        branch=1 + d.form, branch_share=share, branch_from=start, branch_path=path
    )


@effect(
    'shear_softening',
    'mechanical',
    ('measured_ratio', 'glass_step', 'series_mixture'),
    ('load_steps_hot', 'paper', 'hold_loads'),
)
def shear_softening(d: Draw) -> Outcome:
    """The spring follows the shear modulus, which softens less than E of eq. 27."""
    blend = d.between(0.12, 1.15)
    if d.form == 0:  # after the ratio 0.78 between 40 and 90 degC
        knots = [-20.0, 23.0, 40.0, 60.0, 75.0, 90.0, 120.0, 240.0]
        ratio = PchipInterpolator(knots, [1.12, 1.0, 0.955, 0.875, 0.805, 0.745, 0.66, 0.5])(T_GRID)
    elif d.form == 2:  # chains that move in series with those that do not yet (Reuss)
        ratio = 1.0 / (1.0 + 0.0055 * (T_GRID - 23.0).clip(-40.0))
    else:
        ratio = 1.0 - 0.30 * (expit((T_GRID - 65.0) / 16.0) - expit((23.0 - 65.0) / 16.0))
    return {'blend': blend}, lambda b: b.set(soft=b.plant.soft ** (1.0 - blend) * np.asarray(ratio) ** blend)


@effect(
    'load_stroke',
    'mechanical',
    ('power_of_length', 'saturating', 'square_of_load'),
    ('paper', 'load_steps_hot', 'hold_loads'),
)
def load_stroke(d: Draw) -> Outcome:
    """The thermal stroke shrinks with the load."""
    strength = d.between(0.08, 1.2)
    if d.form == 0:
        gain = (1.0 + F_GRID / d.body.k0 / d.body.H0) ** -strength
    elif d.form == 2:  # little as long as the twist can carry the load
        gain = 1.0 / (1.0 + 0.24 * strength * F_GRID**2)
    else:
        gain = 1.0 - 0.33 * strength * (1.0 - np.exp(-F_GRID / 0.9))
    return {'strength': strength}, lambda b: b.set(gain=b.plant.gain * gain)


@effect(
    'geometric_stiffening',
    'mechanical',
    ('series_quartic', 'free_ends', 'finite_chain'),
    ('load_steps_cold', 'load_steps_hot', 'paper_heavy'),
)
def geometric_stiffening(d: Draw) -> Outcome:
    """An opening helix grows stiffer: eq. 24 in its corrected form, a rod with bending, or a finite length."""
    blend = d.between(0.15, 1.6)
    H0, L, k0 = d.body.H0, 0.5, d.body.k0
    span = D_GRID.clip(-0.08, 0.34)
    H = H0 + span
    if d.form == 0:
        flexible = (L**2 - H**2) ** 2 + 1.4 * (L**2 - H**2) * H**2 / 1.0
        cold = (L**2 - H0**2) ** 2 + 1.4 * (L**2 - H0**2) * H0**2
        force = span * cold / np.maximum(flexible, 1e-3 * cold)
    elif d.form == 2:  # Warner's law of what cannot be stretched without end
        span = D_GRID.clip(-0.10, 0.13)
        force = span / (1.0 - (span / 0.21) ** 2)
    else:
        angle, rest = np.arcsin(H / L), np.arcsin(H0 / L)
        bend = np.tan(angle) * (np.cos(rest) - np.cos(angle)) * 1.25
        wind = np.sin(angle) - np.sin(rest)
        force = wind + bend
        force = force / np.interp(1e-4, D_GRID, force) * 1e-4
    force = force + (D_GRID - span)  # straight beyond what the geometry allows
    return {'blend': blend, 'k0': k0}, lambda b: b.set(spring=D_GRID + blend * (force - D_GRID))


@effect('cte_kink', 'mechanical', ('smooth_switch', 'three_slopes', 'burst'), ('paper', 'staircase', 'rates'))
def cte_kink(d: Draw) -> Outcome:
    """Little motion below the glass transition, more above; the stroke at 80 degC stays."""
    share, at = d.between(0.02, 0.5), d.any(42.0, 58.0)
    free = free_change(d.body, T_GRID)
    slope = np.gradient(free, T_GRID)
    if d.form == 0:
        factor = 1.0 + share * np.tanh((T_GRID - at) / 4.0)
    elif d.form == 2:  # what was held sets free at the transition, and there is less of it further on
        above = T_GRID - at
        factor = 1.0 - share + 2.6 * share * expit(above / 1.5) * np.exp(-above.clip(0.0) / 30.0)
    else:
        factor = np.interp(
            T_GRID, [0.0, at - 3.0, at + 5.0, 90.0, 240.0], [1 - share, 1 - share, 1.0, 1 + share, 1 + share]
        )
    bent = np.cumsum(slope * factor) * (T_GRID[1] - T_GRID[0])
    bent -= np.interp(d.body.T0, T_GRID, bent)
    bent *= np.interp(HOT, T_GRID, free) / np.interp(HOT, T_GRID, bent)
    return {'share': share, 'at': at}, lambda b: b.set(free=bent)


@effect(
    'coil_contact',
    'mechanical',
    ('spread_gaps', 'barrier', 'pressed_fibres'),
    ('light_hot', 'paper_light', 'rates_light'),
)
def coil_contact(d: Draw) -> Outcome:
    """Coils touch and push back: over gaps of many sizes, as a barrier that steepens, or through fibres in between."""
    # Stronger = touching earlier: from just before full contraction to a third of the stroke lost.
    at = reached(d, 0.15) + d.between(0.001, 0.024) - 0.002
    if d.form == 0:
        gaps = at + d.any(0.001, 0.0035) * np.linspace(-1.7, 1.7, 35)
        push = 400.0 * np.maximum(gaps[:, None] - H_GRID[None, :], 0.0).mean(axis=0) * 2.0
    elif d.form == 2:  # van Wyk: the pressure of a mass of fibres goes with the cube of its density
        fluff = d.any(0.005, 0.009)
        left = (H_GRID - at + 0.6 * fluff).clip(0.15 * fluff, fluff)
        push = 0.12 * ((fluff / left) ** 3 - 1.0)
        push += 2000.0 * (at - 0.45 * fluff - H_GRID).clip(0.0)  # the turns themselves
    else:
        push = 0.9 * d.any(0.0008, 0.002) * 400.0 * np.logaddexp(0.0, (at - H_GRID) / 0.0015)
    return {'at': at}, lambda b: b.set(stop=push)


@effect(
    'slack',
    'mechanical',
    ('soft_dead_zone', 'loop_of_thread', 'shared_thread'),
    ('paper_light', 'light_hot', 'staircase'),
)
def slack(d: Draw) -> Outcome:
    """A slack link takes up the first millimetres of contraction; a load pulls it straight."""
    dead = d.between(0.0006, 0.007)
    soft, straight = d.any(1e-4, 3e-4), d.any(0.3, 0.6)  # m; N

    def link(x: Array, force: Array) -> Array:
        up = np.maximum(x, 0.0)
        if d.form == 0:
            way = dead / (1.0 + (force / straight) ** 2)
            taken = up - soft * (np.logaddexp(0.0, (up - way) / soft) - np.logaddexp(0.0, -way / soft))
        elif d.form == 2:  # a thread beside a soft one: part of the motion passes until it is taut
            way = 1.2 * dead * np.exp(-force / straight)
            taken = -way * np.expm1(-0.75 * up / np.maximum(way, 1e-9))
        else:
            way = dead * np.maximum(1.0 - force / (3.0 * straight), 0.0)
            taken = up - (np.hypot(up, way) - way)
        return x - taken

    return {'dead': dead, 'straight_at': straight}, lambda b: b.link.append(link)


@effect(
    'first_cycle',
    'mechanical',
    ('threshold_elements', 'activated_elements', 'highest_so_far'),
    ('paper', 'repeat', 'staircase'),
)
def first_cycle(d: Draw) -> Outcome:
    """Strain frozen in at rest is set free by the first warming."""
    length = d.between(0.0006, 0.010)
    if d.form == 2:  # whatever the time: each degree above all before sets a little free
        span = d.any(10.0, 22.0)
        return {'length': length, 'span': span}, lambda b: b.set(fixed=length, fixed_span=span)
    n = 12
    frozen = length * d.rng.dirichlet(np.full(n, 6.0))
    at = np.linspace(d.any(27.0, 32.0), d.any(46.0, 54.0), n)
    tau, sharp = (d.any(1.0, 4.0), 0.9) if d.form == 0 else (d.any(4.0, 10.0), 0.22)
    return {'length': length}, lambda b: b.set(frozen=frozen, frozen_at=at, frozen_tau=tau, frozen_sharp=sharp)


@effect('fatigue', 'mechanical', ('power_of_dose', 'saturating', 'hot_damage'), ('repeat', 'paper', 'repeat'))
def fatigue(d: Draw) -> Outcome:
    """The stroke shrinks with every cycle."""
    share = d.between(0.0015, 0.025)
    shape = d.any(0.1, 0.4) if d.form == 0 else d.any(8.0, 25.0)  # the third has none: so much with every cycle
    return {'share': share}, lambda b: b.set(fatigue=1 + d.form, fatigue_share=share, fatigue_shape=shape)


@effect(
    'inertia',
    'mechanical',
    ('linear_damping', 'drag', 'relaxing_damper'),
    ('load_steps_cold', 'load_steps_hot', 'load_steps_cold'),
)
def inertia(d: Draw) -> Outcome:
    """The load is a mass on a spring."""
    zeta = d.between(0.25, 0.02)
    drag = d.any(0.3, 1.5) if d.form == 1 else 0.0
    return {'zeta': zeta}, lambda b: b.set(mass=1 + d.form, mass_damping=zeta, mass_drag=drag)


@effect(
    'friction', 'mechanical', ('dahl', 'maxwell_slip', 'pulley'), ('staircase', 'load_steps_cold', 'paper', 'rates')
)
def friction(d: Draw) -> Outcome:
    """A guide that rubs, or a pulley, which does so the more the more it carries: built up over a small way."""
    force = d.between(0.0025, 0.025)
    if d.form != 1:
        limit, reach = np.array([force]), np.array([d.any(1e-4, 4e-4)])
    else:
        limit = force * np.array([0.35, 0.3, 0.2, 0.15])
        reach = np.array([0.5, 1.0, 2.0, 4.0]) * d.any(1e-4, 3e-4)
    return {'force': force}, lambda b: b.set(rub=1 + d.form, rub_limit=limit, rub_reach=reach)


@effect('torsional_leakage', 'mechanical', ('slips', 'relaxing_crimp', 'giving_grip'), ('hold', 'paper', 'repeat'))
def torsional_leakage(d: Draw) -> Outcome:
    """The end turns: sudden slips, in a crimp that relaxes, or as long as load and heat overcome its grip."""
    size, seed = d.between(0.0002, 0.0025), d.seed()
    if d.form == 1:
        tau, power, grip = d.any(12.0, 30.0), d.any(0.5, 0.8), d.any(0.9, 1.3)
        numbers = {
            'twist_heat': d.any(0.035, 0.06),
            'twist_soft': d.any(0.5, 0.9),
            'twist_back': d.any(0.5, 0.7),
            'twist_clamp': d.any(0.1, 0.4),
        }
        return {'size': size, 'tau': tau, 'power': power, 'grip': grip}, lambda b: b.set(
            twist=size, twist_tau=tau, twist_power=power, twist_grip=grip, **numbers
        )

    if d.form == 2:
        tau, grip = d.any(50.0, 110.0), d.any(0.25, 0.5)
        return {'size': size, 'tau': tau, 'grip': grip}, lambda b: b.set(twist=size, twist_tau=tau, twist_grip=grip)

    def slips(time: Array, slip: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        slip = slip.copy()
        for _ in range(int(rng.integers(2, 6))):
            at = int(rng.uniform(0.08, 0.95) * len(time))
            slip[at] += size * float(rng.uniform(0.4, 1.0))
        return slip

    return {'size': size}, lambda b: b.slip.append(slips)
