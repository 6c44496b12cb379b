"""Concealed faults of instruments and set-up: the decoys, which are no physics of the muscle."""

from collections.abc import Callable

import numpy as np
from numba import njit

from proof.truth.bench import Bench
from proof.truth.concealed import HOT, Draw, Outcome, effect
from proof.truth.plant import Array
from proof.truth.thermal import ornstein_uhlenbeck


@njit(cache=True)
def lagged(time: Array, T: Array, tau: Array) -> Array:
    """A chain of first-order lags; each input taken as straight between ticks."""
    y = T.copy()
    for pole in tau:
        state = y[0]
        before = y[0]
        for k in range(1, len(y)):
            h = time[k] - time[k - 1]
            keep = np.exp(-h / pole)
            slope = (y[k] - before) / h
            before = y[k]
            # the exact answer to a ramp
            state = y[k] - slope * pole + (state - (y[k] - slope * h) + slope * pole) * keep
            y[k] = state
    return y


@njit(cache=True)
def _bead(time: Array, T: Array, tau: float) -> Array:
    """Heat diffusing into a bead of five layers, read at its centre; tau is the delay of a slow ramp."""
    layers = np.full(5, T[0])
    y = np.empty_like(T)
    y[0] = T[0]
    pace = 12.0 / tau
    for k in range(1, len(T)):
        steps = 1 + int((time[k] - time[k - 1]) * pace * 4.0)
        h = (time[k] - time[k - 1]) / steps
        for s in range(steps):
            outer = T[k - 1] + (T[k] - T[k - 1]) * (s + 1) / steps
            for j in range(5):
                inner = layers[j + 1] if j < 4 else layers[4]
                old = layers[j]
                layers[j] += h * pace * ((outer - old) + (inner - old))
                outer = old
        y[k] = layers[4]
    return y


@njit(cache=True)
def _one_sided(time: Array, T: Array, warming: float, cooling: float) -> Array:
    """A first-order lag with another time constant while it warms than while it cools."""
    y = T.copy()
    for k in range(1, len(T)):
        at = (T[k] + T[k - 1]) / 2.0
        tau = warming if at > y[k - 1] else cooling
        y[k] = at + (y[k - 1] - at) * np.exp(-(time[k] - time[k - 1]) / tau)
    return y


@njit(cache=True)
def _charged(time: Array, u: Array, tau: float) -> Array:
    """A capacitor that was empty before the first tick, charged by a voltage that holds from its tick to the next."""
    y = np.zeros_like(u)
    for k in range(1, len(u)):
        y[k] = u[k - 1] + (y[k - 1] - u[k - 1]) * np.exp(-(time[k] - time[k - 1]) / tau)
    return y


@effect('thermocouple_lag', 'sensor', ('bead_and_stem', 'diffusion', 'loose_contact'), ('paper', 'prbs', 'staircase'))
def thermocouple_lag(d: Draw) -> Outcome:
    """The thermometer follows late: bead and stem, a bead that heat diffuses into, or one that cools later."""
    tau = d.between(0.2, 4.0)
    poles = tau * np.array([0.8, 0.2])

    def late(time: Array, T: Array, recording: int) -> Array:
        if d.form == 0:
            return lagged(time, T, poles)
        # a bead that is held loosely is heated by the coil around it and cooled by the air alone
        return _bead(time, T, tau * 0.8) if d.form == 1 else _one_sided(time, T, 0.7 * tau, 1.2 * tau)

    return {'tau': tau}, lambda b: b.thermometer.append(late)


@effect('thermocouple_gain', 'sensor', ('stem_fin', 'curved', 'wrong_type'), ('paper', 'hold', 'staircase'))
def thermocouple_gain(d: Draw) -> Outcome:
    """The stem pulls the bead towards the air, or the voltage is read by another type's table."""
    loss = d.between(0.015, 0.15)

    def cooler(time: Array, T: Array, recording: int) -> Array:
        if d.form == 0:
            return T * (1.0 - loss)
        if d.form == 1:
            return T * (1.0 - loss * (1.0 + 0.1 * np.tanh((T - 30.0) / 30.0)))
        return T * (1.0 - loss * (0.75 + 0.25 * T / 57.0))  # the tables part as a parabola

    return {'gain': 1.0 - loss}, lambda b: b.thermometer.append(cooler)


@effect('temperature_offset', 'sensor', ('constant', 'constant', 'each_time_another'), ('paper', 'rest', 'hold'))
def temperature_offset(d: Draw) -> Outcome:
    """The thermometer reads too much or too little, always as much or after each start by another amount."""
    offset = d.between(0.3, 3.0) * d.rng.choice([-1.0, 1.0])
    share = _starts(d)
    return {'offset': offset}, lambda b: b.thermometer.append(lambda time, T, recording: T + offset * share(recording))


def _starts(d: Draw) -> Callable[[int], float]:
    """How much of an offset a recording has: all of it; in the third form what it has after its own start."""
    if d.form < 2:
        return lambda recording: 1.0
    seed = d.seed()
    return lambda recording: float(np.random.default_rng([seed, recording]).uniform(0.5, 1.3))


@effect('displacement_drift', 'sensor', ('warming_up', 'wandering', 'settling_bracket'), ('paper', 'hold', 'rest'))
def displacement_drift(d: Draw) -> Outcome:
    """The laser drifts: as it warms up, at random, or as its bracket settles, with the square root of time."""
    size, seed = d.between(0.15e-3, 1.5e-3), d.seed()
    tau = d.any(120.0, 400.0)

    def drift(time: Array, x: Array, recording: int) -> Array:
        rng = np.random.default_rng([seed, recording])
        if d.form == 0:
            return x + size * np.sign(rng.standard_normal()) * (1.0 - np.exp(-time / tau)) / (
                1.0 - np.exp(-200.0 / tau)
            )
        if d.form == 2:
            return x + size * np.sign(rng.standard_normal()) * np.sqrt(time / 200.0)
        wander = ornstein_uhlenbeck(rng, time, tau)
        return x + size * (wander - wander[0]) * 0.7

    return {'size': size}, lambda b: b.ruler.append(drift)


@effect('displacement_offset', 'sensor', ('constant', 'constant', 'each_time_another'), ('paper', 'hold'))
def displacement_offset(d: Draw) -> Outcome:
    """The zero of the laser is not the rest, always by as much or after each start by another amount."""
    offset = d.between(0.5e-3, 8e-3) * d.rng.choice([-1.0, 1.0])
    share = _starts(d)
    return {'offset': offset}, lambda b: b.ruler.append(lambda time, x, recording: x + offset * share(recording))


@effect('clock_skew', 'sensor', ('late_thermometer', 'late_laser_drifting', 'slow_thermometer'), ('paper', 'prbs'))
def clock_skew(d: Draw) -> Outcome:
    """One channel is stamped late, or its clock runs at another pace."""
    late = d.between(0.06, 0.6)

    def change(b: Bench) -> None:
        if d.form == 0:
            b.delay['temperature'] = late
        elif d.form == 2:  # later and later
            b.delay['temperature'] = 0.3 * late
            b.stretch['temperature'] = 1.4 * late / 300.0
        else:
            b.delay['displacement'] = 0.7 * late
            b.stretch['displacement'] = 0.3 * late / 300.0

    return {'delay': late}, change


@effect('current_gain', 'sensor', ('gain', 'gain_and_dead_band', 'grows_with_level'), ('paper', 'hold'))
def current_gain(d: Draw) -> Outcome:
    """The ammeter reads a few per cent wrong, in the third form the less so the less flows."""
    error = d.between(0.01, 0.08) * d.rng.choice([-1.0, 1.0])
    zero = 0.0005 if d.form == 1 else 0.0

    def reads(time: Array, i: Array, recording: int) -> Array:
        if d.form == 2:
            return i * (1.0 + error * np.minimum(np.maximum(i, 0.0) / 0.2, 2.0) ** 0.3)
        return np.where(i > 0.0, i * (1.0 + error) + zero, i)

    return {'error': error}, lambda b: b.meter.append(reads)


FULL_CURRENT = 0.27  # A, where the size of a pickup is quoted, at HOT


@effect(
    'thermocouple_pickup', 'sensor', ('bridging_bead', 'floating_bead', 'ground_loop'), ('paper', 'prbs', 'staircase')
)
def thermocouple_pickup(d: Draw) -> Outcome:
    """The bead has contact with the wire and reads volts of the muscle as kelvin, either way round.

    Type K gives 41 uV/K (NIST ITS-90), a hundred-thousandth of the 4 V across the muscle. A bead that bridges some of
    the wire has 0.06 to 0.5 milliohm in common with it: what it reads too much goes with the current alone. A bead that
    floats charges the filter before its amplifier (R C_C to ground in figure 29 of the AD8494 to AD8497 data sheet; R
    is a lacquer's here) up to where the wire is, a share of i R(T), of which 85 to 110 dB of common-mode rejection
    leave K. An earthed amplifier on the supply's ground has all of the supply's voltage, leads and all, common to both
    legs, and the closer to the end of its range the less of it the amplifier rejects.
    """
    size = d.between(0.4, 3.0) * d.rng.choice([-1.0, 1.0])
    full = FULL_CURRENT * d.body.steady_resistance(HOT)
    tau = d.any(0.1, 0.3)
    leads, bend = d.any(0.2, 1.0), d.any(0.1, 0.35)  # ohm; share of the whole that is no longer linear

    def picked_up(time: Array, i: Array, v: Array) -> Array:
        if d.form == 0:
            return size * i / FULL_CURRENT
        if d.form == 1:
            return size * _charged(time, v / full, tau)
        u = (v + leads * i) / (full + leads * FULL_CURRENT)
        return size * u * (1.0 - bend + bend * u**2)

    return {'size': size}, lambda b: b.pickup.append(picked_up)
