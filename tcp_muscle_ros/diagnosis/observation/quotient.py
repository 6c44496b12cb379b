"""A resistance that was not recorded, but the voltage and the current that show it.

Their quotient is as noisy as the current is small: V/I errs by the noise of V - R I, over I. Where hardly any current
flows it is the noise of two instruments, one over the other, whatever the muscle is.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tcp_muscle_ros.diagnosis.observation.input_noise import quiet, which_is_held
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.inputs import changes, distance, hold
from tcp_muscle_ros.recording.recording import Channel

_LEAST_SENSE_CURRENT = 1e-3  # A: resistance from voltage and current needs a current
_KNOWN = 0.03  # of the resistance: a reading that errs by more is left out
_EXACT = 1e-3  # of the resistance: what the scales of two good instruments leave unsure
_HIGH = 0.5  # of the largest current: so much is always a reading
_TINY = 1e-12  # ohm
_FEW = 0.1  # of the other's stamps: of more, the nearest is not far, and few samples are left between two edges
_PLAIN = 0.01  # of the largest value: less is noise, or how a muscle that warms moves a reading
_MOST = 0.7  # of the stamps
_ALIKE = 0.5  # of a step's share: so far a resistance may have changed, or noise be in it
_AT_EDGE = 0.99  # sampling periods


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
    voltage, current = beside(voltage, current)
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


def beside(voltage: Channel, current: Channel) -> tuple[Channel, Channel]:
    """Voltage and current as two instruments sample them: one that was logged only where it changes holds until its
    next stamp, at those of the other.

    Which of two levels a sample taken at an edge shows no stamp says: it is left out.
    """
    if _logged_by_changes(current, voltage):
        return _held_beside(current, voltage)
    if _logged_by_changes(voltage, current):
        through, across = _held_beside(voltage, current)
        # Where a current is held, the voltage changes with the resistance: few stamps are a slow voltmeter's.
        if which_is_held((through, across)) == 1:
            return across, through
    return voltage, current


def _held_beside(seldom: Channel, often: Channel) -> tuple[Channel, Channel]:
    """The channel that was sampled, where it is sure which level it shows, and what of the other one held then."""
    period = float(np.median(np.diff(often.time)))
    sure = distance(often.time, changes(seldom)) > _AT_EDGE * period
    sampled = replace(often, time=often.time[sure], value=often.value[sure])
    return sampled, replace(seldom, time=sampled.time, value=hold(seldom, sampled.time))


def _logged_by_changes(seldom: Channel, often: Channel) -> bool:
    """Whether a channel was logged where it changes, beside one that was sampled: its few stamps are steps, and there
    the other steps by the same share. A slow instrument reads its noise, and steps some time after the other."""
    step, level = np.diff(seldom.value), np.abs(seldom.value)
    plain = np.abs(step) > _PLAIN * np.max(level, initial=0.0)
    if len(seldom) > _FEW * len(often) or np.count_nonzero(plain) < _MOST * np.count_nonzero(step):
        return False
    first = np.searchsorted(often.time, seldom.time[1:])  # of the other's samples, at or after each stamp
    told = np.flatnonzero(plain & (first > 1) & (first < len(often) - 1))
    before, after = often.value[first[told] - 2], often.value[first[told] + 1]
    noise = _PLAIN * np.max(np.abs(often.value), initial=_TINY)
    share = step[told] / (level[told] + level[told + 1])
    seen = (after - before) / np.maximum(np.abs(before) + np.abs(after), noise)
    alike = np.abs(seen - share) < _ALIKE * np.abs(share)
    return bool(np.any(alike) and np.mean(alike) >= _MOST)


def nearest_reading(channel: Channel, time: Array) -> Array:
    """The reading nearest to each instant: those of one tick arrive in any order."""
    return channel.value[np.searchsorted(0.5 * (channel.time[1:] + channel.time[:-1]), time)]
