"""How far the form of a model that does not quite fit moves its parameters.

Least squares takes what it leaves for noise. What a wrong form leaves returns in the same state of the muscle, cycle
after cycle, and so does its pull on the parameters. The sandwich of Huber (1967) and White (1980), with residuals
summed over such clusters (Liang & Zeger 1986), counts it.
"""

from collections.abc import Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Outputs
from tcp_muscle_ros.muscle.arrays import Array

_LEVELS = 4  # of temperature, warming and cooling
_STRETCH = 25.0  # s
_FEW = 8  # clusters: fewer say too little


def clusters(experiments: Sequence[Experiment], outputs: Sequence[Outputs]) -> tuple[Array, Array]:
    """Labels of all residuals, recording after recording, channel after channel, with one of no data (-1) at the end.

    The first by channel and state (temperature, warming or cooling), shared by all recordings; the second by channel
    and stretch of time.
    """
    levels = [getattr(o, e.model.state) for e, o in zip(experiments, outputs, strict=True)]
    hot = np.quantile(np.concatenate(levels), np.linspace(0.0, 1.0, _LEVELS + 1)[1:-1])
    channels = sorted({name for e in experiments for name in e.observed})
    states, stretches, used = [], [], 0
    for experiment, out, level in zip(experiments, outputs, levels, strict=True):
        cooling = np.gradient(level, out.time) < 0.0
        state = np.searchsorted(hot, level) + _LEVELS * cooling
        for name, observed in experiment.observed.items():
            at = np.clip(np.searchsorted(out.time, observed.time), 0, out.time.size - 1)
            states.append(state[at] + 2 * _LEVELS * channels.index(name))
            stretch = np.floor((observed.time - observed.time[0]) / _STRETCH).astype(int)
            stretches.append(used + stretch)
            used += int(stretch[-1]) + 1
        states.append(np.array([-1]))
        stretches.append(np.array([-1]))
    return np.concatenate(states), np.concatenate(stretches)


def inflation(covariance: Array, jacobian: Array, residual: Array, labels: Sequence[Array]) -> Array:
    """By how much the standard deviation of each unknown grows, shape (n,): 1 where clusters pull as noise does."""
    usual = np.maximum(np.diag(covariance), 1e-300)
    most = np.ones(usual.size)
    pull = jacobian * residual[:, None]
    for label in labels:
        data = label >= 0
        names, place = np.unique(label[data], return_inverse=True)
        if names.size < _FEW:
            continue
        scores = np.zeros((names.size, usual.size))
        np.add.at(scores, place, pull[data])
        moved = scores @ covariance
        variance = names.size / (names.size - 1.0) * np.sum(moved**2, axis=0)
        most = np.maximum(most, np.sqrt(variance / usual))
    return most
