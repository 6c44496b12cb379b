"""Fourth forms of the faults of instruments, and what no catalogue holds beside them (see `outside.py`)."""

import numpy as np

from proof.truth.bench import Bench
from proof.truth.concealed import HOT, Draw, Outcome, effect, fourth
from proof.truth.instruments import FULL_CURRENT, lagged
from proof.truth.plant import Array


@fourth('thermocouple_lag', 'two_paths')
def thermocouple_lag(d: Draw) -> Outcome:
    """Heat reaches the bead through metal and through glue beside it: a quick part and a slow one, added."""
    tau, quick = d.between(0.2, 4.0), d.any(0.5, 0.7)

    def late(time: Array, T: Array, recording: int) -> Array:
        parts = (lagged(time, T, np.array([tau * factor])) for factor in (0.45, 2.0))
        return np.asarray(sum(share * part for share, part in zip((quick, 1.0 - quick), parts, strict=True)))

    return {'tau': tau, 'quick': quick}, lambda b: b.thermometer.append(late)


@fourth('thermocouple_gain', 'stem_in_rising_air')
def thermocouple_gain(d: Draw) -> Outcome:
    """The stem loses more than its share when hot, as free convection does: with the fourth root of the rise."""
    loss = d.between(0.015, 0.15)
    return {'gain': 1.0 - loss}, lambda b: b.thermometer.append(
        lambda time, T, recording: T * (1.0 - loss * (np.abs(T) / 40.0) ** 0.25)
    )


@fourth('temperature_offset', 'cold_junction')
def temperature_offset(d: Draw) -> Outcome:
    """The cold junction is wrong from the start, and a quarter more once the instrument's own heat has come to it."""
    offset, tau = d.between(0.3, 3.0) * d.rng.choice([-1.0, 1.0]), d.any(60.0, 150.0)
    return {'offset': offset, 'tau': tau}, lambda b: b.thermometer.append(
        lambda time, T, recording: T + offset * (1.0 - 0.25 * np.exp(-time / tau))
    )


@fourth('displacement_drift', 'sags_until_it_rests')
def displacement_drift(d: Draw) -> Outcome:
    """The laser sags evenly, until it meets something."""
    size, seed = d.between(0.15e-3, 1.5e-3), d.seed()

    def drift(time: Array, x: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        way = 1.3 * size * np.sign(rng.standard_normal())
        return x + way * np.minimum(time / (rng.uniform(0.5, 0.9) * time[-1]), 1.0)

    return {'size': size}, lambda b: b.ruler.append(drift)


@fourth('displacement_offset', 'either_side')
def displacement_offset(d: Draw) -> Outcome:
    """The zero is lost at each start, to either side."""
    offset, seed = d.between(0.5e-3, 8e-3), d.seed()

    def beside(time: Array, x: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        return x + offset * float(rng.choice([-1.0, 1.0]) * rng.uniform(0.7, 1.3))

    return {'offset': offset}, lambda b: b.ruler.append(beside)


@fourth('clock_skew', 'sent_in_blocks')
def clock_skew(d: Draw) -> Outcome:
    """The thermometer stamps as of when its clock was last set, which runs ever later until it is set again."""
    late, period, phase = d.between(0.06, 0.6), d.any(6.0, 15.0), d.any(0.0, 1.0)

    def stamped(time: Array, T: Array, recording: int) -> Array:
        since = (time / period + phase) % 1.0
        return np.interp(time - late * (0.5 + since), time, T)

    return {'delay': late, 'period': period}, lambda b: b.thermometer.append(stamped)


@fourth('current_gain', 'warming_shunt')
def current_gain(d: Draw) -> Outcome:
    """The shunt is wrong, and the more so the warmer the current has made it."""
    error = d.between(0.01, 0.08) * d.rng.choice([-1.0, 1.0])
    tau, cold = d.any(5.0, 15.0), d.any(0.5, 0.7)

    def reads(time: Array, i: Array, recording: int) -> Array:
        heat = lagged(time, np.minimum((np.maximum(i, 0.0) / 0.25) ** 2, 4.0), np.array([tau]))
        return i * (1.0 + error * (cold + (1.0 - cold) * heat))

    return {'error': error, 'tau': tau}, lambda b: b.meter.append(reads)


@fourth('thermocouple_pickup', 'rectified_ripple')
def thermocouple_pickup(d: Draw) -> Outcome:
    """The amplifier's input rectifies the ripple of the supply, which goes with the voltage: its square is read."""
    size = d.between(0.4, 3.0) * d.rng.choice([-1.0, 1.0])
    full = FULL_CURRENT * d.body.steady_resistance(HOT)
    return {'size': size}, lambda b: b.pickup.append(lambda time, i, v: size * (v / full) ** 2)


# --- in no catalogue ---


@effect('healing_coat', 'electrical', ('one_pole_of_power',), ('paper', 'hold', 'prbs'), listed=False)
def healing_coat(d: Draw) -> Outcome:
    """Grains of the coat weld while current flows and part again at rest: R remembers half a minute of current."""
    share, tau = d.between(0.006, 0.05), d.any(15.0, 45.0)
    return {'share': share, 'tau': tau}, lambda b: b.set(ageing=5, ageing_rate=share, ageing_tau=tau)


@effect('pressed_to_guide', 'thermal', ('linear_in_load',), ('load_steps_hot', 'hold_loads'), listed=False)
def pressed_to_guide(d: Draw) -> Outcome:
    """A load presses the muscle to its guide, which takes heat as contacts do, with the pressure (Cooper, Mikic and
    Yovanovich 1969)."""
    share = d.between(0.012, 0.12)
    return {'share': share}, lambda b: b.set(load_loss=share)


@effect('worked_soft', 'mechanical', ('motion_and_rest',), ('load_steps_cold', 'load_steps_hot', 'paper'), listed=False)
def worked_soft(d: Draw) -> Outcome:
    """Motion breaks up what holds the fibres of the yarn together, and rest restores it (Payne 1962, Mullins 1948): the
    spring is softer after each motion, for half a minute."""
    share, tau = d.between(0.01, 0.10), d.any(10.0, 30.0)
    return {'share': share, 'tau': tau}, lambda b: b.set(worked_soft=share, worked_tau=tau)


@effect('overloaded_turns', 'mechanical', ('highest_load_so_far',), ('load_steps_hot', 'hold_loads'), listed=False)
def overloaded_turns(d: Draw) -> Outcome:
    """The largest load so far untwists some turns, which pull no more until the muscle has rested: the stroke under a
    light load depends on what hung there before."""
    share = d.between(0.006, 0.08)  # per N
    return {'share': share}, lambda b: b.set(overload=share)


@effect('aliased_hum', 'sensor', ('sine',), ('paper', 'hold', 'staircase'), listed=False)
def aliased_hum(d: Draw) -> Outcome:
    """Hum of the mains that is sampled a little too slowly: the thermometer swings, whatever the muscle does."""
    size, period, seed = d.between(0.25, 2.0), d.any(3.0, 12.0), d.seed()

    def hum(time: Array, T: Array, recording: int) -> Array:
        phase = np.random.default_rng([seed, recording]).uniform(0.0, 2.0 * np.pi)
        return T + size * np.sin(2.0 * np.pi * time / period + phase)

    def change(b: Bench) -> None:
        b.thermometer.append(hum)

    return {'size': size, 'period': period}, change
