"""What the thermometer of a machine reads of the room, while nothing has warmed the machine yet."""

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Parameters

_STEADY = 1.0 / 3.0  # of what the room may be off


def room_read(experiment: Experiment, muscle: Parameters, within: float) -> float | None:
    """The room (K) as the machine's thermometer read it before the drive came on, less what the muscle's sensors add.

    None where there is no thermometer, where the rest is shorter than the machine takes to cool, or where it was not
    steady to a third of ``within`` (K), for it then began warm.
    """
    model, still = experiment.model, float(experiment.imposed.ambient[0])
    seen = experiment.observed.get(model.gauge)
    if seen is None or not seen.time.size:
        return None
    shown = experiment.predict(muscle, still)[model.gauge]
    warmed = np.flatnonzero(np.abs(shown - shown[0]) > model.channels[model.gauge].wander)
    resting = int(warmed[0]) if warmed.size else seen.time.size
    half = resting // 2
    if half == 0 or seen.time[resting - 1] - experiment.imposed.time[0] < model.time_constant(muscle):
        return None
    off = seen.value - shown
    first, second = float(np.mean(off[:half])), float(np.mean(off[half:resting]))
    return still + second if abs(second - first) < _STEADY * within else None
