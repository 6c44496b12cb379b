"""Concealed physics of the thermal stage."""

import numpy as np

from proof.truth.bench import Bench
from proof.truth.body import Body
from proof.truth.concealed import Draw, Outcome, effect
from proof.truth.plant import H_GRID, KELVIN, NONE, T_GRID, Array


def air(film: Array) -> tuple[Array, Array, float, Array]:
    """Dry air at a film temperature, K: conductivity, kinematic viscosity, Prandtl number, thermal expansion."""
    ratio = film / 300.0
    return 0.0263 * ratio**0.85, 1.589e-5 * ratio**1.72, 0.707, 1.0 / film


def rayleigh_film(theta: Array, diameter: float, ambient: float = 23.0) -> tuple[Array, Array]:
    """Rayleigh number of a horizontal cylinder and conductivity of its air film, theta above ambient, K."""
    film = ambient + KELVIN + theta / 2.0
    conductivity, viscosity, prandtl, expansion = air(film)
    return 9.81 * expansion * np.abs(theta) * diameter**3 * prandtl / viscosity**2, conductivity


def churchill_chu(theta: Array, diameter: float) -> Array:
    """Heat transfer coefficient of a long horizontal cylinder, W/m2K (Churchill and Chu 1975)."""
    Ra, k = rayleigh_film(theta, diameter)
    nusselt = (0.60 + 0.387 * Ra ** (1 / 6) / (1.0 + (0.559 / 0.707) ** (9 / 16)) ** (8 / 27)) ** 2
    return nusselt * k / diameter


def conduction_and_plume(theta: Array, plume: float) -> Array:
    """A still sheath of air that conducts, and a plume that grows as the fourth root of the rise."""
    _, k = rayleigh_film(theta, 1e-3)
    return k / k[0] * (1.0 + plume * (np.abs(theta) / 40.0) ** 0.25)


def annulus(theta: Array, onset: float) -> Array:
    """In a tube of glass (Raithby and Hollands 1975): conduction up to an onset, then the fourth root of Rayleigh's."""
    Ra, k = rayleigh_film(theta, 1e-3)
    start, _ = rayleigh_film(np.array([onset]), 1e-3)
    # rounded, since the onset is not at the same place along the muscle
    return k * (1.0 + (Ra / start) ** 3) ** (1 / 12)


@effect(
    'natural_convection',
    'thermal',
    ('churchill_chu', 'conduction_and_plume', 'annulus'),
    ('paper', 'hold', 'staircase'),
)
def natural_convection(d: Draw) -> Outcome:
    """Heat transfer grows with the temperature difference. theta = 40 K keeps its hA."""
    theta = np.where(np.abs(T_GRID) < 0.02, 0.02, T_GRID)  # the table is over theta
    at = np.array([40.0])
    if d.form == 0:
        diameter = d.between(0.4e-3, 9e-3)  # n from about 0.10 to 0.21
        factor = churchill_chu(theta, diameter) / churchill_chu(at, diameter)
        values = {'diameter': diameter}
    elif d.form == 2:
        onset = d.between(38.0, 8.0)
        factor = annulus(theta, onset) / annulus(at, onset)
        values = {'onset': onset}
    else:
        plume = d.between(0.35, 4.0)
        low = conduction_and_plume(np.append(0.0, at), plume)
        factor = conduction_and_plume(np.append(0.0, theta), plume)[1:] / low[1]
        values = {'plume': plume}
    hot = np.interp([20.0, 57.0], T_GRID, factor)
    values['n_effective'] = float(np.log(hot[1] / hot[0]) / np.log(57.0 / 20.0))
    return values, lambda b: b.scale('loss', factor)


@effect(
    'radiation', 'thermal', ('grey_body', 'grey_body_colder_walls', 'brightens_when_hot'), ('paper', 'hold', 'hold')
)
def radiation(d: Draw) -> Outcome:
    """Radiation on top of a convection that is smaller by as much at 40 K: grey, or with an emissivity that grows."""
    emissivity = d.between(0.3, 0.95)
    area = d.any(3.5e-4, 4.5e-4)
    walls = d.any(-2.5, -0.5) if d.form == 1 else 0.0
    rise = d.any(0.001, 0.0022) if d.form == 2 else 0.0  # 1/K; of bare metals as T, 0.003

    def change(b: Bench) -> None:
        at40 = emissivity * area * 5.67e-8 * (336.15**4 - 296.15**4) / 40.0
        b.set(emission=emissivity * area, emission_rise=rise, wall_offset=walls, hA=b.plant.hA - 0.7 * at40)

    values = {'emissivity': emissivity, 'area': area, 'wall_offset': walls}
    return values | ({'rise': rise} if rise else {}), change


@effect('airflow', 'thermal', ('telegraph_gusts', 'wandering_wind', 'swinging_fan'), ('paper', 'hold', 'repeat'))
def airflow(d: Draw) -> Outcome:
    """Moving air: gusts, a wandering wind, a fan that swings or is switched on once, a door that is opened."""
    peak = d.between(1.05, 2.3)  # factor of hA in the gust
    seed = d.seed()
    fan = d.rng.random() < 0.3
    pace = d.any(8.0, 25.0)

    def gusts(time: Array, factor: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        if d.form == 2:
            return factor * (1.0 + (peak - 1.0) * (door(rng, time, pace) if fan else swing(rng, time, pace)) ** 0.4)
        if fan:
            on = float(rng.uniform(0.25, 0.7)) * time[-1]
            settled = 1.0 - np.exp(-np.maximum(time - on, 0.0) / 1.5)
            return factor * (1.0 + (peak - 1.0) * settled)
        if d.form == 0:
            edges = np.cumsum(rng.exponential(pace, int(time[-1] / pace * 3) + 8))
            blowing = np.searchsorted(edges, time) % 2
            reach = rng.uniform(0.5, 1.0, len(edges) + 1)[np.searchsorted(edges, time)]
            # Hilpert at these Reynolds numbers: Nu ~ Re^0.33
            return factor * np.where(blowing == 1, 1.0 + (peak - 1.0) * reach**0.33, 1.0)
        wander = ornstein_uhlenbeck(rng, time, pace)
        velocity = np.exp(wander)
        return factor * (1.0 + (peak - 1.0) * velocity**0.5 / (1.0 + velocity**0.5))

    return {'peak': peak, 'pace': pace, 'fan': float(fan)}, lambda b: b.wind.append(gusts)


def swing(rng: np.random.Generator, time: Array, period: float) -> Array:
    """Speed of the air, 0 to 1, as a fan that turns to and fro passes by."""
    away = np.sin(2.0 * np.pi * time / period + rng.uniform(0.0, 2.0 * np.pi))
    return np.exp(-((away / 0.45) ** 2))


def door(rng: np.random.Generator, time: Array, pace: float) -> Array:
    """Speed of the air, 0 to 1: a door is opened now and then, and the air comes to rest again."""
    opened = np.cumsum(rng.exponential(3.0 * pace, int(time[-1] / pace) + 8))
    since = time[:, None] - opened[None, :]
    return np.minimum(np.where(since > 0.0, np.exp(-since.clip(0.0) / pace), 0.0).sum(axis=1), 1.0)


def ornstein_uhlenbeck(rng: np.random.Generator, time: Array, tau: float) -> Array:
    """A wandering number of variance one and correlation time tau, on the ticks."""
    from scipy.signal import lfilter

    keep = np.exp(-np.median(np.diff(time)) / tau)
    noise = rng.standard_normal(len(time)) * np.sqrt(1.0 - keep**2)
    noise[0] = rng.standard_normal()
    return np.asarray(lfilter([1.0], [1.0, -keep], noise))


@effect('ambient_drift', 'thermal', ('heating_cycle', 'wandering', 'towards_another_room'), ('paper', 'hold', 'rest'))
def ambient_drift(d: Draw) -> Outcome:
    """The room's temperature changes: the heating switches, it wanders, or it goes to another level for good."""
    size, seed = d.between(0.35, 2.5), d.seed()
    period = d.any(250.0, 700.0)

    def drift(time: Array, ambient: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        if d.form == 0:
            phase = rng.uniform(0.0, 2.0 * np.pi)
            wave = np.sin(2.0 * np.pi * time / period + phase)
            saw = np.tanh(2.0 * wave)
            return ambient + size * (saw - saw[0]) * 0.7
        if d.form == 2:
            gone = 1.0 - np.exp(-time / (period / 3.0))
            return ambient + 1.7 * size * np.sign(rng.standard_normal()) * gone
        wander = ornstein_uhlenbeck(rng, time, period / 3.0)
        return ambient + size * (wander - wander[0])

    return {'size': size, 'period': period}, lambda b: b.room.append(drift)


@effect(
    'motion_convection',
    'thermal',
    ('power_of_speed', 'square_root', 'mixed_cubes'),
    ('light_hot', 'load_steps_hot', 'prbs'),
)
def motion_convection(d: Draw) -> Outcome:
    """The muscle fans itself while it moves."""
    gain = d.between(0.04, 0.35)
    return {'gain_at_10_mm_per_s': gain}, lambda b: b.set(motion=1 + d.form, motion_gain=gain)


@effect('exposed_area', 'thermal', ('shadow', 'open_packed', 'film_of_air'), ('paper', 'load_steps_hot', 'paper_light'))
def exposed_area(d: Draw) -> Outcome:
    """Open coils lose heat better than packed ones."""
    span = d.between(0.04, 0.40)  # between packed (90 mm) and open (200 mm)
    if d.form == 0:
        shadow = 1.0 / (1.0 + (H_GRID / 0.11) ** 2)
        factor = 1.0 - span * (shadow - np.interp(d.body.H0, H_GRID, shadow)) / 0.40
    elif d.form == 2:  # turns closer than a film of air is thick share it
        free = -np.expm1(-np.maximum(H_GRID - 0.07, 0.0) / 0.05)
        factor = 1.0 + span * (free - np.interp(d.body.H0, H_GRID, free)) / 0.60
    else:
        factor = 1.0 + span * (np.tanh((H_GRID - 0.14) / 0.05) - np.tanh((d.body.H0 - 0.14) / 0.05)) / 1.5
    return {'span': span}, lambda b: b.scale('area', np.maximum(factor, 0.3))


@effect('heat_capacity', 'thermal', ('glass_step', 'measured_table', 'thawing_chains'), ('paper', 'prbs', 'hold'))
def heat_capacity(d: Draw) -> Outcome:
    """The heat capacity grows: a slope with a glass step, a table with three slopes, or as chains thaw one by one."""
    grow = d.between(0.0007, 0.0045)  # 1/K, mean
    if d.form == 0:
        at, width = d.any(44.0, 60.0), d.any(4.0, 9.0)
        step = 57.0 * grow * 0.55
        factor = 1.0 + 0.45 * grow * (T_GRID - 23.0) + step / (1.0 + np.exp(-(T_GRID - at) / width))
        factor /= np.interp(23.0, T_GRID, factor)
    elif d.form == 2:
        thaw = d.any(20.0, 32.0)  # K in which e times as many move
        moving = np.expm1((T_GRID.clip(0.0, 110.0) - 23.0) / thaw)
        factor = 1.0 + 57.0 * grow * moving / np.expm1(57.0 / thaw)
    else:
        knots = [-20.0, 23.0, 45.0, 62.0, 120.0, 240.0]
        rise = np.array([-20.0, 0.0, 12.0, 40.0, 97.0, 130.0])
        factor = np.interp(T_GRID, knots, 1.0 + grow * rise)
    return {'mean_slope': grow}, lambda b: b.scale('capacity', np.maximum(factor, 0.3))


@effect('latent_heat', 'thermal', ('skew_peak', 'kinetic_order', 'two_peaks'), ('paper', 'prbs', 'hold'))
def latent_heat(d: Draw) -> Outcome:
    """A little order melts: one skew peak of heat capacity or two, or with its own pace and a cooler way back."""
    peak, at = d.between(0.008, 0.09), d.any(45.0, 62.0)  # J/K
    if d.form != 1:
        width = d.any(3.0, 6.0)
        y = (T_GRID - at) / width
        if d.form == 0:
            bump = np.exp(1.0 - y - np.exp(-np.clip(y, -4.0, 60.0))) * (y > -4.0)
        else:  # small crystals, then the larger ones
            apart = d.any(2.5, 3.5)
            bump = (
                0.6 / np.cosh((y + 1.0).clip(-99.0, 99.0)) ** 2
                + 1.0 / np.cosh((y + 1.0 - apart).clip(-99.0, 99.0)) ** 2
            )

        def change(b: Bench) -> None:
            b.set(capacity=b.plant.capacity + peak / b.plant.C * bump)

        return {'peak': peak, 'at': at, 'width': width}, change
    width, tau, cooler = d.any(1.5, 3.0), d.any(0.3, 1.2), d.any(0.5, 3.0)
    heat = 4.0 * width * peak
    return {'peak': peak, 'at': at, 'width': width}, lambda b: b.set(
        latent=heat, latent_at=at, latent_width=width, latent_tau=tau, latent_cooler=cooler
    )


@effect('moisture', 'thermal', ('two_populations', 'rings', 'vapour_pressure'), ('paper', 'hold', 'repeat'))
def moisture(d: Draw) -> Outcome:
    """Water leaves the fibre when it is first heated, and takes its heat along."""
    share, tau = d.between(0.002, 0.028), d.any(6.0, 40.0)
    return {'share': share, 'tau_at_60': tau}, lambda b: b.set(water=1 + d.form, water_share=share, water_tau=tau)


@effect(
    'two_node', 'thermal', ('three_shells', 'five_shells', 'thin_and_thick_filaments'), ('prbs', 'paper', 'staircase')
)
def two_node(d: Draw) -> Outcome:
    """Heat enters at the skin, where thermometer and silver are; the core, which pulls, follows."""
    link = min(d.between(0.6, 0.09), 0.7)  # W/K, total
    if d.form == 2:  # side by side under the same skin, the thick ones later
        thick = d.any(0.4, 0.6)
        share = np.array([0.30, 0.70 * (1.0 - thick), 0.70 * thick])
        beside = link * np.array([1.4, 0.7])
        pull = np.array([0.0, 1.0 - thick, thick])
        return {'link': link, 'thick': thick}, lambda b: b.set(
            shell_share=share, shell_link=beside, shell_pull=pull, shell_beside=1
        )
    shells = 3 if d.form == 0 else 5
    share = np.array([0.30, *np.full(shells - 1, 0.70 / (shells - 1))])
    between = np.full(shells - 1, link * (shells - 1))
    between[0] = link * (shells - 1) * 1.2
    pull = np.array([0.0, *np.full(shells - 1, 1.0 / (shells - 1))])
    return {'link': link}, lambda b: b.set(shell_share=share, shell_link=between, shell_pull=pull)


@effect('end_conduction', 'thermal', ('cold_clamps', 'heavy_clamps', 'collars'), ('hold', 'paper', 'paper'))
def end_conduction(d: Draw) -> Outcome:
    """Heat flows into the clamps, or into collars in the air: the ends are cooler than the middle, which is read."""
    fin, nodes = d.between(0.003, 0.015), 30  # m along the coil; half the muscle, mirrored in the middle
    body: Body = d.body
    half = body.H0 / 2.0
    link = 0.5 * body.hA * (fin / half) ** 2 * nodes
    if d.form == 2:
        collar, gain = d.any(0.6, 1.0) * fin, d.any(3.0, 5.0)  # m of the coil in each; hA there
        covered = (nodes * collar / half - np.arange(nodes)).clip(0.0, 1.0)
        return {'fin_length': fin, 'collar': collar, 'gain': gain}, lambda b: b.set(
            axial_nodes=nodes, axial_link=2.0 * link, profile=1.0 + (gain - 1.0) * covered
        )
    profile = NONE if d.form == 0 else 1.0 + d.any(-0.06, 0.06) * np.linspace(-1.0, 1.0, nodes)
    mass = 0.0 if d.form == 0 else d.any(0.05, 0.2)

    def change(b: Bench) -> None:
        # half a muscle would have half of everything; the grid keeps the whole's numbers, so links count twice
        b.set(axial_nodes=nodes, axial_link=2.0 * link, clamp_link=4.0 * link, clamp_mass=mass, profile=profile)

    return {'fin_length': fin}, change


@effect(
    'elastocaloric',
    'thermal',
    ('reversible', 'lossy', 'partly_late'),
    ('load_steps_hot', 'load_steps_cold', 'load_steps_hot'),
)
def elastocaloric(d: Draw) -> Outcome:
    """Stretching warms: from the slope dH/dT of this muscle at its temperature."""
    gain = d.between(0.35, 2.0)
    if d.form == 2:  # chains in the crystals' shadow turn later
        late, tau = d.any(0.3, 0.6), d.any(0.8, 3.0)
        return {'gain': gain, 'late': late, 'tau': tau}, lambda b: b.set(
            elastocaloric=gain, elastocaloric_late=late, elastocaloric_tau=tau
        )
    loss = 0.0 if d.form == 0 else d.any(0.1, 0.3)
    return {'gain': gain, 'loss': loss}, lambda b: b.set(elastocaloric=gain, elastocaloric_loss=loss)
