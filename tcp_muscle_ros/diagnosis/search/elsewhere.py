"""What a table does where nobody recorded: under other loads and a weaker drive than those that it was fitted to."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment

_WEAKER = (1.0, 0.7)  # of the drive
_FURTHER = 6.0  # times what it changes in the recordings, or their noise


def as_small_elsewhere(better: Fit, plain: Fit) -> bool:
    """Whether a table changes what nobody recorded by not much more than what was: the same drive and a weaker one,
    under one load throughout.

    A table that makes up for little in the recordings by a great deal between them is no law, whatever unseen parts of
    the same recordings say.
    """
    here = {name: noise.sigma for name, noise in better.problem.noise.items()}
    recorded = better.problem.followed
    for experiment in recorded:
        for name, size in _changes(experiment, better, plain):
            here[name] = max(here[name], size)
    return all(
        size <= _FURTHER * here[name]
        for experiment in _others(recorded)
        for name, size in _changes(experiment, better, plain)
    )


def _others(recorded: tuple[Experiment, ...]) -> Iterator[Experiment]:
    """Each recording under the least, the middle and the largest load of all, throughout; and with a weaker drive."""
    low, high = min(float(e.imposed.load.min()) for e in recorded), max(float(e.imposed.load.max()) for e in recorded)
    for experiment in recorded:
        for share in _WEAKER:
            for load in {low, 0.5 * (low + high), high}:
                imposed = experiment.imposed
                imposed = replace(imposed, drive=share * imposed.drive, load=np.full(imposed.load.size, load))
                yield replace(experiment, imposed=imposed, holding=replace(experiment.holding, starting_load=load))


def _changes(experiment: Experiment, better: Fit, plain: Fit) -> Iterator[tuple[str, float]]:
    """By how much two models differ, by channel: root mean square, SI."""
    shown, without = (experiment.predict(fitted.muscle) for fitted in (better, plain))
    for name, with_table in shown.items():
        change = with_table - without[name]
        if experiment.model.channels[name].floating:
            change = change - np.mean(change)
        yield name, float(np.sqrt(np.mean(change**2)))
