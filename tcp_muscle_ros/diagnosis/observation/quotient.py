"""A resistance that was not recorded, but the voltage and the current that show it.

Their quotient is as noisy as the current is small: V/I errs by the noise of V - R I, over I. Where hardly any current
flows it is the noise of two instruments, one over the other, whatever the muscle is.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tcp_muscle_ros.diagnosis.observation.input_noise import quiet
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import Channel

_LEAST_SENSE_CURRENT = 1e-3  # A: resistance from voltage and current needs a current
_KNOWN = 0.03  # of the resistance: a reading that errs by more is left out
_EXACT = 1e-3  # of the resistance: what the scales of two good instruments leave unsure
_HIGH = 0.5  # of the largest current: so much is always a reading
_TINY = 1e-12  # ohm


class Quotient(NamedTuple):
    """``ohms``: voltage over current; ``steady``: what each reading weighs beside a usual one, by its noise.

    ``least``: the smallest current (A) at which it is known, where noise hides it at smaller ones, else 0.
    """

    ohms: Channel
    steady: Channel
    least: float


def quotient(voltage: Channel, current: Channel, name: str) -> Quotient | None:
    """Voltage over current, as a channel of this name, where the two tell it; None where they hardly ever do.

    The noise is that of V - R I, in which what the source really imposed on both cancels: a controller's ripple hides
    nothing. A source may ripple with its current: a small current, as one that only senses, has the noise of small
    ones. Which current is small, its mean says: what chance lets in would be biased.
    """
    read = nearest_reading(current, voltage.time)
    flowing = np.abs(nearest_reading(quiet(current)[0], voltage.time))
    enough = np.minimum(np.abs(read), flowing) > _LEAST_SENSE_CURRENT
    if np.count_nonzero(enough) < 2:
        return None
    half = _HIGH * float(np.max(flowing[enough]))
    high = flowing >= half
    typical = float(np.median(voltage.value[high & enough] / read[high & enough]))
    error = voltage.value - typical * read
    small, large = white_sigma(error[~high]), white_sigma(error[high])
    least = min(small / max(_KNOWN * abs(typical), _TINY), half)
    known = enough & (flowing >= least)
    if np.count_nonzero(known) < 2:
        return None
    hidden = ~known & (np.abs(read) > _LEAST_SENSE_CURRENT)
    topics = f'{voltage.topic}/{current.topic}'
    ohms = Channel(name, voltage.time[known], voltage.value[known] / read[known], topics)
    errs = np.hypot(np.where(high, large, small)[known] / flowing[known], _EXACT * typical)
    usual = max(float(np.median(errs)), _TINY)
    steady = replace(ohms, value=usual / np.maximum(errs, usual))
    return Quotient(ohms, steady, least if np.any(hidden) else 0.0)


def nearest_reading(channel: Channel, time: Array) -> Array:
    """The reading nearest to each instant: those of one tick arrive in any order."""
    return channel.value[np.searchsorted(0.5 * (channel.time[1:] + channel.time[:-1]), time)]
