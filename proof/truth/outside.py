"""Fourth forms of the mechanical stage, on which nothing is tuned: other laws of the same mechanisms.

The probabilities of findings are weighed on these, and on nothing else of them.
"""

import numpy as np

from proof.truth.body import free_change
from proof.truth.concealed import HOT, Draw, Outcome, fourth, reached
from proof.truth.plant import D_GRID, F_GRID, H_GRID, KELVIN, T_GRID, Array


@fourth('creep', 'flat_spectrum')
def creep(d: Draw) -> Outcome:
    """As the logarithm of time between two ends: Tobolsky's box of equal weights (1960); quick above the glass alone.

    Below the glass transition it runs by one barrier and above it by another that is three times as high, as a kink in
    an Arrhenius plot.
    """
    total, tau = d.between(0.02, 0.25), d.any(5.0, 60.0)
    slow, kink = d.any(0.015, 0.03), d.any(40.0, 50.0)  # 1/K, degC
    times = tau * np.geomspace(0.12, 6.0, 9)
    J = np.full(len(times), total / len(times))
    turn, fifty = kink + KELVIN, 323.15

    def barriers(kelvin: Array) -> Array:
        barrier = slow * fifty**2 * np.where(kelvin > turn, 3.0, 1.0)
        return np.asarray(barrier * (1.0 / turn - 1.0 / kelvin))

    shift = np.exp((barriers(T_GRID + KELVIN) - barriers(np.array([fifty]))).clip(-5.0, 5.0))
    return {'J': total, 'tau_at_50': tau, 'kink': kink}, lambda b: b.set(creep=J, creep_tau=times, shift=shift)


@fourth('viscous_flow', 'norton_above_glass')
def viscous_flow(d: Draw) -> Outcome:
    """Norton's power of the load (1929), with a fluidity that is nothing below a temperature and straight above it."""
    rate = d.between(0.05, 1.2) * 1e-3 / 200.0  # m/s at 60 degC under 60 g
    heat, power = d.any(0.03, 0.06), d.any(1.8, 3.0)
    return {'rate': rate, 'heat': heat, 'power': power}, lambda b: b.set(
        flow=4, flow_rate=rate, flow_heat=heat, flow_scale=power
    )


@fourth('hysteresis', 'plays')
def hysteresis(d: Draw) -> Outcome:
    """Plays side by side (Prandtl 1928, Ishlinskii 1944): no middle and no saturation, each follows once it is taken
    along; it has cooled down before. A play is a line of relays of one width."""
    share, width = d.between(0.01, 0.10), d.any(5.0, 15.0)  # of the stroke; K
    half = width / 2.0 * np.array([0.3, 0.6, 1.0, 1.5])
    weight = np.array([0.2, 0.3, 0.3, 0.2])
    step, low, high = 0.8, -12.0, 118.0
    centre = np.concatenate([np.arange(low + step * k / 4.0, high, step) for k in range(4)])
    each = np.repeat(np.arange(4), [len(np.arange(low + step * k / 4.0, high, step)) for k in range(4)])
    up, down = centre + half[each], centre - half[each]
    # relays of a play that all have turned are its way, in K
    loop = float((2.0 * half * weight).sum())  # K
    stroke = 0.8 * share * abs(free_change(d.body, np.array([HOT]))[0]) / loop  # m/K; it is as wide everywhere
    falls = step * (weight[each, None] * (T_GRID[None, ::20] > down[:, None])).sum(axis=0)
    return {'loop_share': share, 'width': width}, lambda b: b.set(
        relay_up=up,
        relay_down=down,
        relay_weight=step * weight[each],
        relay_stroke=stroke,
        relay_cooled=1,
        loop_centre=np.interp(T_GRID, T_GRID[::20], falls),
    )


@fourth('branch_cte', 'lens_from_the_turn')
def branch_cte(d: Draw) -> Outcome:
    """The way back leaves with the distance from the turn, as Rayleigh's loops do: a lens, the larger the hotter."""
    share, start = d.between(0.03, 0.5), d.any(42.0, 50.0)
    return {'share': share, 'from': start}, lambda b: b.set(branch=4, branch_share=share, branch_from=start)


@fourth('shear_softening', 'moist_glass')
def shear_softening(d: Draw) -> Outcome:
    """Moist nylon, whose glass transition is near the room: it softens at once and less and less further on."""
    blend, span = d.between(0.12, 1.15), d.any(18.0, 28.0)
    ratio = 1.0 + 0.24 * np.expm1(-(T_GRID - 23.0).clip(-12.0) / span)
    return {'blend': blend}, lambda b: b.set(soft=b.plant.soft ** (1.0 - blend) * ratio**blend)


@fourth('load_stroke', 'slips_beyond')
def load_stroke(d: Draw) -> Outcome:
    """No loss up to a load, and beyond it the twist slips by as much as the load is too large."""
    strength, from_load, width = d.between(0.08, 1.2), d.any(0.3, 0.5), 0.06
    beyond = width * (np.logaddexp(0.0, (F_GRID - from_load) / width) - np.logaddexp(0.0, -from_load / width))
    gain = np.maximum(1.0 - 0.42 * strength * beyond, 0.1)
    return {'strength': strength, 'from': from_load}, lambda b: b.set(gain=b.plant.gain * gain)


@fourth('geometric_stiffening', 'exponential')
def geometric_stiffening(d: Draw) -> Outcome:
    """The force grows as an exponential of the stretch, as that of soft tissue does (Fung 1967)."""
    blend, curve = d.between(0.15, 1.6), 3.3  # 1/m
    span = D_GRID.clip(-0.12, 0.25)
    force = np.expm1(curve * span) / curve + (D_GRID - span)
    return {'blend': blend}, lambda b: b.set(spring=D_GRID + blend * (force - D_GRID))


@fourth('cte_kink', 'square_root_onset')
def cte_kink(d: Draw) -> Outcome:
    """The slope rises from the transition on as an order parameter does, as the square root (Landau 1937)."""
    share, at = d.between(0.02, 0.5), d.any(42.0, 56.0)
    free = free_change(d.body, T_GRID)
    factor = 1.0 - share + 1.9 * share * np.sqrt((T_GRID - at).clip(0.0, 60.0) / 20.0)
    bent = np.cumsum(np.gradient(free, T_GRID) * factor) * (T_GRID[1] - T_GRID[0])
    bent -= np.interp(d.body.T0, T_GRID, bent)
    bent *= np.interp(HOT, T_GRID, free) / np.interp(HOT, T_GRID, bent)
    return {'share': share, 'at': at}, lambda b: b.set(free=bent)


@fourth('coil_contact', 'hertz')
def coil_contact(d: Draw) -> Outcome:
    """Round turns that are pressed together: the power 3/2 of the way (Hertz 1881)."""
    at = reached(d, 0.15) + d.between(0.001, 0.024) - 0.002
    stiff = d.any(1500.0, 3500.0)  # N/m^1.5
    push = stiff * (at - H_GRID).clip(0.0) ** 1.5
    return {'at': at}, lambda b: b.set(stop=push)


@fourth('slack', 'crimped_thread')
def slack(d: Draw) -> Outcome:
    """A thread with many crimps, which pull straight one by one: it never takes up all, and a load straightens it as
    1/F."""
    dead, straight = d.between(0.0006, 0.007), d.any(0.3, 0.6)  # m; N

    def link(x: Array, force: Array) -> Array:
        up, way = np.maximum(x, 0.0), 0.4 * dead / (1.0 + force / straight)
        return x - way * np.arcsinh(up / way)

    return {'dead': dead, 'straight_at': straight}, lambda b: b.link.append(link)


@fourth('first_cycle', 'shaken_down')
def first_cycle(d: Draw) -> Outcome:
    """Each kelvin of warming sets a share of what is left free, the highest or not: later cycles do the rest."""
    length, way = d.between(0.0006, 0.010), d.any(22.0, 40.0)
    return {'length': length, 'way': way}, lambda b: b.set(fixed=length, fixed_way=way)


@fourth('fatigue', 'crack_growth')
def fatigue(d: Draw) -> Outcome:
    """Cracks that grow the faster the longer they are (Paris and Erdogan 1963): each cycle costs more than the last."""
    share, shape = d.between(0.0015, 0.025), d.any(18.0, 30.0)
    return {'share': share, 'shape': shape}, lambda b: b.set(fatigue=4, fatigue_share=share, fatigue_shape=shape)


@fourth('inertia', 'loose_part')
def inertia(d: Draw) -> Outcome:
    """A part of the load hangs from the rest by a hook of its own, as in an absorber of vibrations: the swing beats."""
    zeta, share, pace = d.between(0.25, 0.02), d.any(0.1, 0.25), d.any(0.9, 1.6)
    return {'zeta': zeta, 'share': share, 'pace': pace}, lambda b: b.set(
        mass=4, mass_damping=zeta, loose_share=share, loose_pace=pace
    )


@fourth('friction', 'bouc_wen')
def friction(d: Draw) -> Outcome:
    """Bouc and Wen (1976) with the exponent 2: stiff for longer than Dahl's, then sooner at its limit; some of that
    is the guide's own and some goes with the load."""
    force, reach = d.between(0.0025, 0.025), d.any(2e-4, 6e-4)
    return {'force': force}, lambda b: b.set(rub=4, rub_limit=np.array([force]), rub_reach=np.array([reach]))


@fourth('torsional_leakage', 'logarithmic')
def torsional_leakage(d: Draw) -> Outcome:
    """The end turns over barriers that each turn makes higher: as the logarithm of time, and never back."""
    size, tau, hardens = d.between(0.0002, 0.0025), d.any(15.0, 40.0), d.any(0.25, 0.45)
    return {'size': size, 'tau': tau, 'hardens': hardens}, lambda b: b.set(twist=size, twist_tau=tau, twist_log=hardens)
