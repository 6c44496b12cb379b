"""Replay: drive the model with recorded inputs, free-run, and compare each channel."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array

_BAND = (5.0, 95.0)  # percentiles
_FIRST = 20  # readings


@dataclass(frozen=True)
class Comparison:
    """One channel: predictions (SI) at the recorded stamps and how far they are from what was recorded.

    ``nrmse`` is ``rmse`` over the recorded peak to peak; ``bias`` the mean of recorded minus predicted. ``low`` and
    ``high`` bound the 90 % band that the parameters' intervals give, where they are known.
    """

    time: Array
    recorded: Array
    predicted: Array
    rmse: float
    nrmse: float
    bias: float
    low: Array | None = None
    high: Array | None = None


def start_temperature(experiment: Experiment, parameters: Parameters) -> float:
    """The fibre's temperature (K) at the start, from the first readings of the thermometer; without one, the ambient.

    Of the ambient, the first reading, and the mean of what was read before the drive came on, the one from which the
    model comes closest to the first readings.
    """
    ambient = float(experiment.imposed.ambient[0])
    observed = experiment.observed.get('temperature')
    if observed is None:
        return ambient
    on = np.flatnonzero(experiment.imposed.drive != 0.0)
    until = float(experiment.imposed.time[on[0]]) if on.size else float(experiment.imposed.time[-1])
    still = observed.value[observed.time <= until][:_FIRST]
    starts = [ambient, float(observed.value[0]), float(np.mean(still)) if still.size else ambient]

    beginning = experiment.until(float(observed.time[:_FIRST][-1]))

    def error(start: float) -> float:
        shown = beginning.predict(parameters, start)['temperature']
        return float(np.sum((shown - observed.value[:_FIRST]) ** 2))

    return min(starts, key=error)


class ReplayedErrors:
    """Root mean square errors (SI) by channel of one muscle's replays of several recordings together."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self._squares: dict[str, list[float]] = {}

    def add(self, experiment: Experiment) -> None:
        """Replay one more recording."""
        start = start_temperature(experiment, self.parameters)
        for name, observed in experiment.observed.items():  # one at a time: they may be long
            outputs = experiment.outputs(self.parameters, start, only=(name,))
            error = np.interp(observed.time, outputs.time, getattr(outputs, name))
            del outputs
            error -= observed.value
            entry = self._squares.setdefault(name, [0.0, 0.0])
            entry[0] += float(error @ error)
            entry[1] += error.size

    def rmse(self) -> dict[str, float]:
        """Of all that was replayed."""
        return {name: float(np.sqrt(total / count)) for name, (total, count) in self._squares.items()}


def replay(
    experiment: Experiment, parameters: Parameters, variants: Mapping[int, Parameters] | None = None
) -> dict[str, Comparison]:
    """Compare every recorded output with the model's free run under the recorded inputs.

    ``variants``: other muscles within the parameters' intervals; their spread is the band.
    """
    start = start_temperature(experiment, parameters)
    predicted = experiment.predict(parameters, start)
    spread = [experiment.predict(muscle, start) for muscle in (variants or {}).values()]
    found = {}
    for name, observed in experiment.observed.items():
        error = observed.value - predicted[name]
        rmse = float(np.sqrt(np.mean(error**2)))
        span = float(np.ptp(observed.value))
        band = np.percentile([p[name] for p in spread], _BAND, axis=0) if spread else (None, None)
        found[name] = Comparison(
            observed.time,
            observed.value,
            predicted[name],
            rmse,
            rmse / span if span > 0.0 else float('inf'),
            float(np.mean(error)),
            band[0],
            band[1],
        )
    return found
