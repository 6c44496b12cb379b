"""Effects that are in no catalogue: what a diagnosis should notice and must not call by a listed name."""

import numpy as np
from numba import njit
from scipy.special import expit

from proof.truth.bench import Bench
from proof.truth.concealed import Draw, Outcome, effect
from proof.truth.plant import D_GRID, T_GRID, Array


@effect('varistor', 'electrical', ('current_squared',), ('paper', 'prbs'), listed=False)
def varistor(d: Draw) -> Outcome:
    """A contact whose resistance falls with current."""
    share = -d.between(0.01, 0.06)
    return {'share': share}, lambda b: b.set(varistor=share)


@effect('resistance_jump', 'electrical', ('sudden',), ('paper', 'hold'), listed=False)
def resistance_jump(d: Draw) -> Outcome:
    """A strand breaks once."""
    share, at = d.between(0.008, 0.06), d.any(60.0, 160.0)

    def change(b: Bench) -> None:
        b.set(switch_resistance=share, switch_time=at)

    return {'share': share, 'time': at}, change


@effect('peltier', 'thermal', ('linear_in_current',), ('paper', 'hold'), listed=False)
def peltier(d: Draw) -> Outcome:
    """Heat that is linear in the current, at junctions on the muscle."""
    volt = d.between(0.06, 0.6)
    return {'volt': volt}, lambda b: b.set(peltier=volt)


@effect('boiling_film', 'thermal', ('threshold',), ('paper', 'hold'), listed=False)
def boiling_film(d: Draw) -> Outcome:
    """Above a threshold the heat loss drops, as if a film lifted."""
    drop, at = d.between(0.08, 0.4), d.any(24.0, 36.0)
    factor = 1.0 - drop / (1.0 + np.exp(-(T_GRID - at) / 0.8))
    return {'drop': drop, 'theta': at}, lambda b: b.scale('loss', factor)


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


@njit(cache=True)
def _passed_on(T: Array, least: float) -> Array:
    """The last value that was passed on, until the next differs from it by as much as it must."""
    y = T.copy()
    for k in range(1, len(T)):
        if abs(T[k] - y[k - 1]) < least:
            y[k] = y[k - 1]
    return y


@effect('other_logger', 'sensor', ('as_built',), ('paper', 'staircase', 'prbs'), listed=False)
def other_logger(d: Draw) -> Outcome:
    """A logger that saves its line passes a temperature on only where that is news; until then it repeats the last."""
    least = d.between(0.6, 4.5)  # K
    return {'size': least}, lambda b: b.thermometer.append(lambda time, T, recording: _passed_on(T, least))


# --- of the third suite ---


@effect('seebeck_voltage', 'electrical', ('linear_in_temperature',), ('hold', 'prbs', 'load_steps_hot'), listed=False)
def seebeck_voltage(d: Draw) -> Outcome:
    """Unlike metals at warm clamps add a voltage, which an ohmmeter takes for resistance: the more the less current."""
    volt = d.between(1.2e-5, 1.2e-4) * d.rng.choice([-1.0, 1.0])  # V/K

    def change(b: Bench) -> None:
        b.seebeck = volt

    return {'volt_per_kelvin': volt}, change


@effect('hunting_supply', 'electrical', ('sine',), ('paper', 'hold'), listed=False)
def hunting_supply(d: Draw) -> Outcome:
    """The regulation of the supply never settles: what flows swings about what was asked for."""
    share, period = d.between(0.012, 0.10), d.any(5.0, 14.0)
    return {'share': share, 'period': period}, lambda b: b.set(hunting=share, hunting_rate=2.0 * np.pi / period)


@effect('touching_rail', 'thermal', ('one_mass',), ('paper', 'hold', 'repeat'), listed=False)
def touching_rail(d: Draw) -> Outcome:
    """The muscle leans on a rail of metal, which takes heat and gives it back minutes later."""
    link, mass = d.between(0.0008, 0.008), d.any(0.3, 0.8)  # W/K, J/K
    return {'link': link, 'mass': mass}, lambda b: b.set(
        rail_link=link, rail_mass=mass, rail_loss=0.006, hA=b.plant.hA - 0.6 * link
    )


@effect('slow_stroke', 'mechanical', ('one_pole',), ('paper', 'hold', 'prbs'), listed=False)
def slow_stroke(d: Draw) -> Outcome:
    """A share of the contraction comes long after the heat, whatever the load, as if something crystallised."""
    share, tau = d.between(0.015, 0.20), d.any(12.0, 40.0)
    # the swing of `self_resonance`, damped until it only creeps
    return {'share': share, 'tau': tau}, lambda b: b.set(
        resonance=share, resonance_rate=8.0 / tau, resonance_damping=4.0
    )


@effect(
    'sticky_turns',
    'mechanical',
    ('soft_plateau',),
    ('load_steps_cold', 'load_steps_hot', 'hold_loads'),
    listed=False,
)
def sticky_turns(d: Draw) -> Outcome:
    """Turns that stick to one another let go between two loads: the spring gives way there and is stiff beyond."""
    give, at = d.between(0.0006, 0.008), d.any(0.016, 0.028)  # m, more than the spring alone; at which extension
    width = 0.004
    spare = give * (np.tanh((D_GRID - at) / width) - np.tanh(-at / width)) / 2.0
    # the same force at an extension that is longer by what gave way
    spring = np.interp(D_GRID, D_GRID + spare, D_GRID)
    return {'give': give, 'at': at}, lambda b: b.set(spring=spring)


@effect('loosening_bead', 'sensor', ('linear_in_length',), ('load_steps_hot', 'hold_loads', 'paper'), listed=False)
def loosening_bead(d: Draw) -> Outcome:
    """The bead sits between two turns, and the wider they part the worse it is held and the less it reads."""
    share = d.between(0.03, 0.35)

    def change(b: Bench) -> None:
        b.loosening = share / b.body.H0

    return {'share': share}, change


# --- in no suite: each could be written as a smooth curve over one quantity at one stage ---


@effect('wicking_coat', 'thermal', ('bump_over_rise',), ('hold', 'staircase', 'paper'), listed=False)
def wicking_coat(d: Draw) -> Outcome:
    """A waxy coat melts and fills the gaps between the filaments, so that more heat gets out; hotter, it drains."""
    share, at, width = d.between(0.04, 0.3), d.any(24.0, 31.0), d.any(7.0, 9.0)
    # the table is over the rise above the room
    factor = 1.0 + share * np.exp(-(((T_GRID - at) / width) ** 2) / 2.0)
    return {'share': share, 'theta': at, 'width': width}, lambda b: b.scale('loss', factor)


@effect('reorganising_crystals', 'thermal', ('dip_and_peak',), ('prbs', 'paper', 'rates'), listed=False)
def reorganising_crystals(d: Draw) -> Outcome:
    """Small crystals gain order before they melt: the heat that it gives, then takes, is a dip of C and a peak."""
    share, at, width = d.between(0.06, 0.5), d.any(60.0, 66.0), d.any(5.0, 6.0)
    apart = d.any(16.0, 19.0)  # K from the dip to the peak, which give and take the same heat
    peak, dip = (np.exp(-(((T_GRID - middle) / width) ** 2) / 2.0) for middle in (at, at - apart))
    return {'share': share, 'at': at, 'width': width, 'apart': apart}, lambda b: b.scale(
        'capacity', 1.0 + share * (peak - dip)
    )


@effect('percolating_coat', 'electrical', ('falls_then_recovers',), ('hold', 'hold_loads', 'staircase'), listed=False)
def percolating_coat(d: Draw) -> Outcome:
    """A filled coat beside the silver conducts the better the warmer, until its swelling parts the grains: R has a knee
    (a minimum, if that is strong), above which it climbs back to that of the silver alone."""
    share, at = d.between(0.005, 0.03), d.any(53.0, 62.0)
    conducts = np.exp((T_GRID - at) / d.any(4.5, 6.0)) * expit((at - T_GRID) / 1.5)
    conducts /= conducts.max()
    return {'share': share, 'at': at}, lambda b: b.scale('rho', 1.0 / (1.0 + share * conducts))


@effect('reentrant_phase', 'mechanical', ('comes_and_goes',), ('paper', 'staircase', 'hold_loads'), listed=False)
def reentrant_phase(d: Draw) -> Outcome:
    """Between two temperatures the chains pack in another way, which is longer: contraction is behind there, and
    recovers where that packing goes again."""
    longer, at, band = d.between(0.4e-3, 6e-3), d.any(42.0, 50.0), d.any(14.0, 20.0)  # m, degC, K
    packed = expit((T_GRID - at) / 2.5) - expit((T_GRID - at - band) / 2.5)
    packed -= np.interp(d.body.T0, T_GRID, packed)
    return {'longer': longer, 'at': at, 'band': band}, lambda b: b.set(free=b.plant.free + longer * packed)


@effect('gelling_resin', 'mechanical', ('bump_over_temperature',), ('hold_loads', 'load_steps_hot'), listed=False)
def gelling_resin(d: Draw) -> Outcome:
    """A resin between the filaments sets to a gel when warm and flows when hot: in between, the spring is stiffer."""
    share, at, width = d.between(0.008, 0.15), d.any(46.0, 58.0), d.any(6.0, 9.0)
    factor = 1.0 + share * np.exp(-(((T_GRID - at) / width) ** 2) / 2.0)
    return {'share': share, 'at': at, 'width': width}, lambda b: b.scale('soft', factor)


@effect('relaxing_untwist', 'mechanical', ('one_pole',), ('load_steps_hot', 'hold_loads'), listed=False)
def relaxing_untwist(d: Draw) -> Outcome:
    """A part of the untwist is carried by chains that slip: with each change of temperature the stroke overshoots, and
    comes back within a fraction of a minute, warm or cold and whatever the load."""
    gain, tau = d.between(1.2e-5, 2.2e-4), d.any(10.0, 30.0)  # m/K, s
    return {'gain': gain, 'tau': tau}, lambda b: b.set(surge=gain, surge_tau=tau)
