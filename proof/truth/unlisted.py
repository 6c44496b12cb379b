"""Effects that are in no catalogue: what a diagnosis should notice and must not call by a listed name."""

import numpy as np

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


@effect('crosstalk', 'sensor', ('current_into_bead',), ('paper', 'prbs'), listed=False)
def crosstalk(d: Draw) -> Outcome:
    """The muscle's voltage leaks into the thermocouple."""
    gain = d.between(1.5, 12.0)

    def change(b: Bench) -> None:
        b.crosstalk = gain

    return {'gain': gain}, change


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
