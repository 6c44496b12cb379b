"""What of a recorded input is the noise of the instrument that recorded it.

A muscle is driven by what was imposed, not by what an ammeter or a room's thermometer read of it. Their noise, taken
for heat, makes the model's temperature wander by some thousandths of a kelvin, which a stroke of a millimetre a kelvin
shows and which no sensor's noise explains. Between its steps an input is constant, or smooth, as far as its noise
tells.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import UnivariateSpline
from scipy.signal import savgol_filter

from tcp_muscle_ros.diagnosis.observation.scatter import quantum, sigma_of_bends
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import Channel

_MOST = 0.01  # of the span: more may be what was really imposed
_FEWEST, _STUCK = 50, 10  # samples: of fewer nothing is said; of no noise, if they are all the same
_FLIPS = 0.6  # of the second differences' signs: 0.73 of white noise, 0 of what is smooth
_FLICKERS = 4  # digits of a second difference, that are noise and no step
_STEP = 6.0  # standard deviations from one sample to the next
_SCATTER = 1.5  # of the noise: more about its mean is not constant
_PARTS, _SURE = 8, 4.0  # of a constant stretch, whose means differ by no more standard deviations
_WIDTHS = (9, 17, 33, 65, 129, 257)  # samples over which what is not constant is averaged, by cubics
_AVERAGED = 1.5  # times the noise over the root of that many samples: what is left in the middle of a cubic
_STEADIER, _DUST = 0.2, 1e-6  # so much smaller a share of changes is no chance; and of the span: no change
_COARSEST = 0.3  # K, of a thermometer's steps; larger ones are the room's
_UNSURE = 0.3  # of the noise and the steps, that a smooth course does not tell
_ALIKE = 3.0  # standard deviations: by more a wider mean differs from a narrower one where the input bends


def noise_of(channel: Channel) -> float:
    """Standard deviation of an input's white noise from one sample to the next; 0 where there is none to see.

    What stays exactly the same is no instrument's reading: a command, or nothing at all. The larger of all readings'
    and the high ones': a power's grows with it.
    """
    value = channel.value
    begins = np.concatenate([[True], np.diff(value) != 0.0]) if value.size else np.zeros(0, dtype=bool)
    lasts = np.diff(np.append(np.flatnonzero(begins), value.size))
    if np.count_nonzero(lasts < _STUCK) < _FEWEST:
        return 0.0
    read = np.repeat(lasts < _STUCK, lasts)
    bend, seen = np.diff(value, 2), read[2:] & read[1:-1] & read[:-2]
    high = np.abs(value[1:-1]) >= 0.5 * np.max(np.abs(value), initial=0.0)
    digit = quantum(value)
    return max(_white(bend[seen], digit), _white(bend[seen & high], digit))


def _white(bend: Array, digit: float) -> float:
    """Standard deviation of the white noise that has these second differences; 0 where they are not of such.

    An ammeter whose last ``digit`` flickers mostly reads the same: what it changes by is counted, and that alone.
    """
    if bend.size < _FEWEST:
        return 0.0
    if np.median(np.abs(bend)) > 2.0 * digit:
        return sigma_of_bends(bend) if np.mean(bend[1:] * bend[:-1] < 0.0) > _FLIPS else 0.0
    small = np.abs(bend) < (_FLICKERS + 0.5) * digit
    changes = np.abs(bend) > 0.5 * digit
    pairs = (small & changes)[1:] & (small & changes)[:-1]
    if np.count_nonzero(pairs) < _FEWEST or np.mean((bend[1:] * bend[:-1])[pairs] < 0.0) <= _FLIPS:
        return 0.0
    return max(float(np.sqrt(np.mean(bend[small] ** 2) / 6.0)), digit / float(np.sqrt(12.0)))


def quiet(channel: Channel) -> tuple[Channel, float]:
    """An input without the noise of its instrument, and the standard deviation of that; 0 where it is as it was.

    Noise beyond a hundredth of its span may have been imposed.
    """
    sigma = noise_of(channel)
    if not 0.0 < sigma <= _MOST * float(np.ptp(channel.value)):
        return channel, 0.0
    steps = np.flatnonzero(np.abs(np.diff(channel.value)) > _STEP * np.sqrt(2.0) * sigma) + 1
    parts = [_quiet(part, sigma) for part in np.split(channel.value, steps)]
    return replace(channel, value=np.concatenate(parts)), sigma


def still_air(channel: Channel) -> tuple[Channel, float]:
    """A room's temperature as smooth as the noise and the steps of its thermometer allow, and how sure it is then (K).

    Air that the thermometer reads to a tenth of a kelvin does not change by tenths.
    """
    step, sigma = quantum(channel.value), noise_of(channel)
    if 0.0 < step <= _COARSEST:  # the median of such second differences is a step, or none
        sigma = max(step / np.sqrt(12.0), float(np.sqrt(np.mean(np.diff(channel.value, 2) ** 2) / 6.0)))
    if sigma == 0.0:
        return channel, 0.0
    spline = UnivariateSpline(channel.time, channel.value, s=channel.value.size * sigma**2)
    return replace(channel, value=np.asarray(spline(channel.time))), _UNSURE * sigma


def which_is_held(candidates: Sequence[Channel]) -> int:
    """Which of several readings of one input the source holds: the first, unless another is constant between its steps
    where that is not.

    Shares of the samples are compared: a reading that was logged more seldom changes more seldom, whatever it is.
    """
    levels = [_share_of_changes(quiet(channel)[0].value) for channel in candidates]
    best = int(np.argmin(levels))
    return best if levels[best] < _STEADIER * levels[0] else 0


def _share_of_changes(value: Array) -> float:
    """From how many of its samples to the next a reading changes, as a share of them."""
    changed = np.abs(np.diff(value)) > _DUST * np.ptp(value)
    return float(np.count_nonzero(changed)) / max(value.size - 1, 1)


def _quiet(part: Array, sigma: float) -> Array:
    """Of a stretch without a step: its mean, if it is constant, else means as wide as it is a cubic."""
    if part.size < 3:
        return part
    if _constant(part, sigma):
        return np.full(part.size, np.mean(part))
    found, left, follows = part, sigma, np.ones(part.size, dtype=bool)
    for wider in _WIDTHS:
        if wider > part.size:
            break
        mean = savgol_filter(part, wider, 3)
        follows &= np.abs(mean - found) <= _ALIKE * left
        found, left = np.where(follows, mean, found), _AVERAGED * sigma / np.sqrt(wider)
    return found


def _constant(part: Array, sigma: float) -> bool:
    """Whether a stretch is nothing but its mean and the noise, in all of its parts."""
    if float(np.std(part)) > _SCATTER * sigma:
        return False
    parts = np.array_split(part, min(_PARTS, part.size))
    return all(abs(np.mean(p) - np.mean(part)) <= _SURE * sigma / np.sqrt(p.size) for p in parts)
