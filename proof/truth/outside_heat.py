"""Fourth forms of the electrical and the thermal stage, on which nothing is tuned (see `outside.py`)."""

import numpy as np
from scipy.stats import norm

from proof.truth.bench import Bench
from proof.truth.concealed import Draw, Outcome, fourth, reached
from proof.truth.plant import H_GRID, KELVIN, SIGMA, T_GRID, Array
from proof.truth.thermal import ornstein_uhlenbeck, rayleigh_film


@fourth('resistance_strain', 'tunnelling')
def resistance_strain(d: Draw) -> Outcome:
    """From flake to flake of the coat electrons tunnel: an exponential of the gap (Simmons 1963)."""
    gauge, span = d.between(0.04, 1.0), d.any(0.3, 0.5)
    strain = (H_GRID / d.body.H0 - 1.0).clip(-1.0, 0.6)
    factor = 1.0 + gauge * span * np.expm1(strain / span)
    return {'gauge_factor': gauge, 'span': span}, lambda b: b.scale('piezo', np.maximum(factor, 0.1))


@fourth('contact_shorting', 'percolation')
def contact_shorting(d: Draw) -> Outcome:
    """Bridges join to paths beside the wire, which conduct from a threshold on with the power 1.3 of what is beyond it
    (percolation in two dimensions, Stauffer and Aharony 1992)."""
    share, width = d.between(0.015, 0.30), d.any(0.003, 0.008)
    at = float(np.clip(reached(d, 0.2) + d.any(0.002, 0.010), 0.084, 0.130))
    beyond = np.maximum(at + 0.5 * width - H_GRID, 0.0) / (2.2 * width)
    return {'share': share, 'length': at, 'width': width}, lambda b: b.scale('piezo', 1.0 / (1.0 + share * beyond**1.3))


@fourth('tcr_curvature', 'closing_cracks')
def tcr_curvature(d: Draw) -> Outcome:
    """The fibre swells sideways when hot and shuts the cracks of its coat, whose widths are a normal distribution."""
    curvature = d.between(1.2e-6, 1.0e-5)
    at, width = d.any(52.0, 62.0), d.any(9.0, 14.0)
    shut, cold, hot = (norm.cdf((T - at) / width) for T in (T_GRID, d.body.T0, 80.0))
    rho = 1.0 + d.body.a_R * (T_GRID - d.body.T0) - curvature * 57.0**2 * (shut - cold) / (hot - cold)
    return {'curvature': -curvature, 'at': at}, lambda b: b.set(rho=rho)


@fourth('resistance_drift', 'thermal_cycling')
def resistance_drift(d: Draw) -> Outcome:
    """Coat and fibre swell by different amounts: what tears goes with the ways of the temperature, up or down, the
    higher the more (Coffin 1954, Manson 1953), and not with time."""
    rate = d.between(0.002, 0.02)
    return {'rate': rate}, lambda b: b.set(ageing=4, ageing_rate=rate)


@fourth('supply_lag', 'source_without_sink')
def supply_lag(d: Draw) -> Outcome:
    """The supply fills the capacitor at its output and cannot empty it: up sooner than down."""
    lag = d.between(0.1, 0.6)
    return {'lag': lag}, lambda b: b.set(supply=4, supply_rate=1.0 / lag)


def elenbaas(theta: Array, Rayleigh: float) -> Array:
    """Nusselt number between parallel plates (Elenbaas 1942); ``Rayleigh``: the channel's at 40 K."""
    at, _ = rayleigh_film(np.array([40.0]), 1e-3)
    Ra, k = rayleigh_film(theta, 1e-3)
    Ra = np.maximum(Ra / at * Rayleigh, 1e-9)
    return np.asarray(k * Ra / 24.0 * (-np.expm1(-35.0 / Ra)) ** 0.75)


@fourth('natural_convection', 'channels_between_turns')
def natural_convection(d: Draw) -> Outcome:
    """Air rises between the turns as between plates: with the rise at first, later with its fourth root; outside, the
    loss is a constant. theta = 40 K keeps its hA."""
    share, Rayleigh = d.between(0.14, 0.75), d.any(10.0, 60.0)
    flow = elenbaas(T_GRID, Rayleigh) / elenbaas(np.array([40.0]), Rayleigh)  # the table is over theta
    factor = 1.0 - share + share * flow
    return {'share': share, 'rayleigh': Rayleigh}, lambda b: b.scale('loss', factor)


def planck(kelvin: Array, shortest: float, longest: float) -> Array:
    """What a black body sends out between two wavelengths (m), W/m2."""
    wave = np.linspace(shortest, longest, 80)
    spectrum = 3.741772e-16 / wave**5 / np.expm1(1.438777e-2 / (wave * np.asarray(kelvin)[:, None]))
    return np.asarray(np.trapezoid(spectrum, wave, axis=1))


@fourth('radiation', 'bands_of_a_polymer')
def radiation(d: Draw) -> Outcome:
    """The coat shines in the bands of its bonds (C=O, N-H and C-H, 3 to 8 um) and is clear between them: these short
    waves rise faster than the fourth power. The convection is smaller by as much at 40 K."""
    emissivity, area, rest = d.between(0.3, 0.95), d.any(5.0e-4, 6.5e-4), d.any(0.3, 0.5)
    coarse, cold = np.linspace(-20.0, 240.0, 521), np.array([23.0 + KELVIN])

    def net(theta: Array) -> Array:
        """W over theta."""
        kelvin = 23.0 + KELVIN + theta.clip(-100.0)
        band = planck(kelvin, 3e-6, 8e-6) - planck(cold, 3e-6, 8e-6)
        all_waves = SIGMA * (kelvin**4 - cold**4)
        return np.asarray(emissivity * area * (band + rest * (all_waves - band)))

    def change(b: Bench) -> None:
        theta = np.where(np.abs(coarse) < 0.01, 0.01, coarse)
        over = np.interp(T_GRID, coarse, net(theta) / theta)
        less = 0.7 * float(net(np.array([40.0]))[0]) / 40.0
        b.scale('loss', (b.plant.hA - less + over) / b.plant.hA)

    return {'emissivity': emissivity, 'area': area, 'rest': rest}, change


@fourth('airflow', 'cascade')
def airflow(d: Draw) -> Outcome:
    """Turbulence: eddies of all sizes, whose variance goes with how long they last (Kolmogorov 1941), felt by King's
    law (1914); or ventilation that comes up slowly and is shut off."""
    peak, seed, pace = d.between(1.05, 2.3), d.seed(), d.any(8.0, 25.0)
    slowly = d.rng.random() < 0.3

    def gusts(time: Array, factor: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        if slowly:
            on, off = float(rng.uniform(0.1, 0.3)) * time[-1], float(rng.uniform(0.6, 0.85)) * time[-1]
            ramp = np.clip((time - on) / (4.0 * pace), 0.0, 1.0)
            left = np.exp(-np.maximum(time - off, 0.0) / 3.0)
            return factor * (1.0 + (peak - 1.0) * (ramp * left) ** 0.45)
        eddies = sum(0.5**k * ornstein_uhlenbeck(rng, time, 1.4 * pace / 4.0**k) for k in range(4))
        speed = np.maximum(1.0 + 0.75 * eddies, 0.0)
        return factor * (1.0 + 0.55 * (peak - 1.0) * speed**0.45)

    return {'peak': peak, 'pace': pace, 'slowly': float(slowly)}, lambda b: b.wind.append(gusts)


@fourth('ambient_drift', 'sun_and_clouds')
def ambient_drift(d: Draw) -> Outcome:
    """The sun shines through the window, and clouds pass: on and off at random, as the air near the bench follows."""
    size, seed, period = d.between(0.35, 2.5), d.seed(), d.any(250.0, 700.0)

    def drift(time: Array, ambient: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        turns = np.cumsum(rng.exponential(period / 4.0, int(8.0 * time[-1] / period) + 12))
        turns[0] = rng.uniform(0.05, 0.3) * time[-1]
        turns[1:] = np.maximum.accumulate(np.maximum(turns[1:], turns[0] + 15.0))
        sun = -1.0 if rng.random() < 0.5 else 1.0  # it comes, or goes
        follows = [-np.expm1(-np.maximum(time - turn, 0.0) / 35.0) for turn in turns]
        return ambient + 1.7 * size * sun * sum((-1.0) ** k * one for k, one in enumerate(follows))

    return {'size': size, 'period': period}, lambda b: b.room.append(drift)


@fourth('motion_convection', 'air_that_goes_along')
def motion_convection(d: Draw) -> Outcome:
    """As the square of a slow motion; of a quick one no more than a limit, since the air goes along."""
    gain = d.between(0.04, 0.35)
    return {'gain_at_10_mm_per_s': gain}, lambda b: b.set(motion=4, motion_gain=gain)


@fourth('exposed_area', 'view_of_a_row')
def exposed_area(d: Draw) -> Outcome:
    """What turns see of one another in a row of cylinders, by Hottel's crossed strings (1954); the rest sees the
    room."""
    span, packed = d.between(0.04, 0.40), d.any(0.07, 0.08)  # between 90 and 200 mm; m
    ratio = np.maximum(H_GRID / packed, 1.0)
    seen = 1.0 - 2.0 / np.pi * (np.sqrt(ratio**2 - 1.0) + np.arcsin(1.0 / ratio) - ratio)
    open_, shut, rest = np.interp([0.2, 0.09, d.body.H0], H_GRID, seen)
    factor = 1.0 + span * (seen - rest) / (open_ - shut)
    return {'span': span}, lambda b: b.scale('area', np.maximum(factor, 0.3))


@fourth('heat_capacity', 'exhausted_motions')
def heat_capacity(d: Draw) -> Outcome:
    """Motions that set in near the room, until all that can move do: steep at first, later flat."""
    grow, span = d.between(0.0007, 0.0045), d.any(22.0, 35.0)  # 1/K, mean; K
    factor = 1.0 + 57.0 * grow * np.expm1(-(T_GRID.clip(5.0) - 23.0) / span) / np.expm1(-57.0 / span)
    return {'mean_slope': grow, 'span': span}, lambda b: b.scale('capacity', np.maximum(factor, 0.3))


@fourth('latent_heat', 'premelting')
def latent_heat(d: Draw) -> Outcome:
    """The smaller a crystal the sooner it melts (Gibbs and Thomson): an exponential up to an end, where all is over."""
    peak, end, width = d.between(0.008, 0.09), d.any(52.0, 68.0), d.any(5.0, 9.0)  # J/K, degC, K
    bump = np.exp((T_GRID - end) / width) / (1.0 + np.exp(((T_GRID - end) / 0.8).clip(-60.0, 60.0)))
    bump = bump / bump.max()

    def change(b: Bench) -> None:
        b.set(capacity=b.plant.capacity + peak / b.plant.C * bump)

    return {'peak': peak, 'at': end, 'width': width}, change


@fourth('moisture', 'elovich')
def moisture(d: Draw) -> Outcome:
    """What leaves first is held least, and each part that has left makes the next slower (Elovich's equation)."""
    share, tau = d.between(0.002, 0.028), d.any(6.0, 40.0)
    return {'share': share, 'tau_at_60': tau}, lambda b: b.set(water=4, water_share=share, water_tau=tau)


@fourth('two_node', 'filaments_of_all_sizes')
def two_node(d: Draw) -> Outcome:
    """A yarn: six filaments under one skin, each the later the thicker it is, so that the core has a spectrum."""
    link = min(d.between(0.6, 0.09), 0.7)  # W/K, total
    size = np.geomspace(0.35, 2.8, 6) ** d.any(0.7, 1.0)  # the time of each
    inside = np.full(6, 1.0 / 6.0)
    links = inside / size
    links *= 1.8 * link / links.sum()
    return {'link': link}, lambda b: b.set(
        shell_share=np.array([0.28, *(0.72 * inside)]),
        shell_link=links,
        shell_pull=np.array([0.0, *inside]),
        shell_beside=1,
    )


@fourth('end_conduction', 'leads_as_fins')
def end_conduction(d: Draw) -> Outcome:
    """The leads are wound around the ends, ever more loosely: they draw heat off as fins do, and clamps of plastic
    take little."""
    fin, nodes = d.between(0.003, 0.015), 30  # m along the coil; half the muscle, mirrored in the middle
    half = d.body.H0 / 2.0
    link = 0.5 * d.body.hA * (fin / half) ** 2 * nodes
    reach, gain, poor = d.any(0.8, 1.6) * fin, d.any(0.6, 1.2), d.any(0.1, 0.3)
    along = (np.arange(nodes) + 0.5) * half / nodes
    profile = 1.0 + gain * np.exp(-along / reach)
    return {'fin_length': fin, 'reach': reach, 'gain': gain}, lambda b: b.set(
        axial_nodes=nodes, axial_link=2.0 * link, clamp_link=4.0 * poor * link, profile=profile
    )


@fourth('elastocaloric', 'grows_with_load')
def elastocaloric(d: Draw) -> Outcome:
    """Entropy goes with the square of a stretch, as in rubber (Treloar 1975): under a heavy load each newton warms more
    than under a light one."""
    gain, power = d.between(0.35, 2.0), d.any(0.7, 1.0)
    return {'gain': gain, 'power': power}, lambda b: b.set(elastocaloric=gain, elastocaloric_power=power)
