"""A bag that holds a recording and what models show under its inputs, in a namespace each."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Series
from tcp_muscle_ros.diagnosis.answer.replaying import Comparison
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.recording.bag_writer import write_recordings
from tcp_muscle_ros.recording.recording import Channel, Recording


def write_overlay(
    path: str | Path, experiment: Experiment, compared: Mapping[str, Comparison], name: str = 'predicted'
) -> None:
    """Write what was recorded under ``/recorded``, the predictions under ``/<name>``, and where there is a 90 % band
    its edges under ``/<name>_low`` and ``/<name>_high``. BadInput if the bag exists."""
    edges = {
        f'{name}_{side}': {channel: edge for channel, c in compared.items() if (edge := getattr(c, side)) is not None}
        for side in ('low', 'high')
    }
    predicted = {name: {channel: c.predicted for channel, c in compared.items()}}
    write_overlays(path, experiment, predicted | {label: found for label, found in edges.items() if found})


def write_overlays(
    path: str | Path, experiment: Experiment, predictions: Mapping[str, Mapping[str, np.ndarray]]
) -> None:
    """Write what was recorded under ``/recorded`` and several predictions, each under its name."""
    parts = {'recorded': _recorded(experiment)}
    for label, predicted in predictions.items():
        parts[label] = {
            name: Channel(name, experiment.observed[name].time, values, f'{label}/{name}')
            for name, values in predicted.items()
        }
    _write(path, parts, experiment)


def write_diagnosis_overlay(
    path: str | Path, experiments: Sequence[Experiment], series: Sequence[Sequence[Series]]
) -> None:
    """Write ``/recorded``, ``/before`` and ``/after``; of several recordings each below ``/recording_<n>``, from 1.

    ``series`` are those of the diagnosis, one sequence a recording; all recordings begin together.
    """
    parts: dict[str, Mapping[str, Channel]] = {}
    for k, experiment in enumerate(experiments):
        prefix = f'recording_{k + 1}/' if len(experiments) > 1 else ''
        found = series[k] if k < len(series) else ()
        parts[f'{prefix}recorded'] = _recorded(experiment)
        for label in ('before', 'after'):
            parts[f'{prefix}{label}'] = {
                s.channel: Channel(s.channel, s.time, getattr(s, label), f'{label}/{s.channel}') for s in found
            }
    _write(path, parts, experiments[0])


def _recorded(experiment: Experiment) -> dict[str, Channel]:
    imposed = experiment.imposed
    return {
        imposed.kind: Channel(imposed.kind, imposed.time, imposed.drive, imposed.kind),
        **{name: Channel(name, o.time, o.value, name) for name, o in experiment.observed.items()},
    }


def _write(path: str | Path, parts: Mapping[str, Mapping[str, Channel]], experiment: Experiment) -> None:
    write_recordings(
        path, {label: Recording(str(path), channels, 0, dict(experiment.known)) for label, channels in parts.items()}
    )
