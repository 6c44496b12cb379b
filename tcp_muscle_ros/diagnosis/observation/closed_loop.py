"""Whether a recording was made by a controller: its current then answers the displacement."""

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import FOLLOWS_SETPOINT
from tcp_muscle_ros.muscle.arrays import Array

_LEVELS = 50  # of the drive; with fewer, somebody switched it
_ANSWERS = -0.2  # correlation of how drive and displacement bend: a controller takes back what its sensor adds
_RESTS, _ENDS = 0.3, 0.01  # of what is between the ends of the drive's span; of that span
_DUST = 1e-6
_CLIPPED = 3.0  # medians: edges must not speak for all


def is_closed_loop(experiment: Experiment) -> bool:
    """A drive with many levels, where a setpoint was recorded, or where it falls as the displacement's noise rises.

    A sine or a chirp that a generator plays knows nothing of the sensor's noise. A controller changes its drive all the
    time, but at the ends of its range: a ramp in many steps does not.
    """
    drive, seen = experiment.imposed.drive, experiment.observed.get(experiment.model.motion)
    if np.unique(np.round(drive, 6)).size <= _LEVELS:
        return False
    if experiment.known.get(FOLLOWS_SETPOINT) is True:
        return True
    if seen is None or seen.time.size < _LEVELS:
        return False
    played = _means(experiment.imposed.time, drive, seen.time)
    between = np.abs(played - 0.5 * (drive.max() + drive.min())) < (0.5 - _ENDS) * np.ptp(drive)
    rests = np.abs(np.diff(played)) < _DUST * np.ptp(drive)
    if np.count_nonzero(rests & between[1:]) > _RESTS * np.count_nonzero(between[1:]):
        return False
    one, two = (_clipped(np.diff(values, 2)) for values in (played, seen.value))
    power = float(np.sqrt((one @ one) * (two @ two)))
    return power > 0.0 and float(one @ two) / power < _ANSWERS


def _means(time: Array, held: Array, about: Array) -> Array:
    """Means of what is held between ``time`` over the blocks about each of these instants."""
    sums = np.concatenate([[0.0], np.cumsum(held[:-1] * np.diff(time))])
    edges = np.concatenate([[about[0]], 0.5 * (about[1:] + about[:-1]), [about[-1]]])
    return np.asarray(np.diff(np.interp(edges, time, sums)) / np.maximum(np.diff(edges), 1e-12))


def _clipped(values: Array) -> Array:
    centred = values - np.median(values)
    most = _CLIPPED * float(np.median(np.abs(centred)))
    return np.asarray(np.clip(centred, -most, most))
