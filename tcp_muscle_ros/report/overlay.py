"""A bag that holds a recording and what models show under its inputs, in a namespace each."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tcp_muscle_ros.diagnosis.experiment import Experiment
from tcp_muscle_ros.diagnosis.replaying import Comparison
from tcp_muscle_ros.recording.bag_writer import write_recordings
from tcp_muscle_ros.recording.recording import Channel, Recording


def write_overlay(
    path: str | Path, experiment: Experiment, compared: Mapping[str, Comparison], name: str = 'predicted'
) -> None:
    """Write what was recorded under ``/recorded``, the predictions under ``/<name>``. BadInput if the bag exists."""
    write_overlays(path, experiment, {name: {channel: c.predicted for channel, c in compared.items()}})


def write_overlays(
    path: str | Path, experiment: Experiment, predictions: Mapping[str, Mapping[str, np.ndarray]]
) -> None:
    """Write what was recorded under ``/recorded`` and several predictions, each under its name."""
    imposed, observed = experiment.imposed, experiment.observed
    recorded = {
        imposed.kind: Channel(imposed.kind, imposed.time, imposed.drive, imposed.kind),
        **{name: Channel(name, o.time, o.value, name) for name, o in observed.items()},
    }
    parts = {'recorded': recorded}
    for label, predicted in predictions.items():
        parts[label] = {
            name: Channel(name, observed[name].time, values, f'{label}/{name}') for name, values in predicted.items()
        }
    write_recordings(
        path, {label: Recording(str(path), channels, 0, dict(experiment.known)) for label, channels in parts.items()}
    )
