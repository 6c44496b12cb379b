"""What the viewer of a report draws: all recordings, each channel as recorded and from the models, as data in the page.

Values are as people read them, in single precision, base64. However many recordings there are, the page stays small:
long series are thinned, equally.
"""

import json
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Series
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, SHOWN, shown
from tcp_muscle_ros.report.telling import compared, shaded, telling_channel, telling_recording, thin

MOST_VALUES = 400_000  # of all series together: 2 MB in the page
_CURVES = 4  # of a channel: time, recorded, two models at most
_LABELS = {**CHANNEL_AXIS, 'displacement': 'stroke: displacement (mm)'}  # both words stand in the page


def viewer_data(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """The content of the viewer, None where nothing was recorded that could be drawn."""
    if not diagnosis.series or not any(diagnosis.series):
        return None
    count = _CURVES * sum(len(series) for series in diagnosis.series) + 2 * len(diagnosis.drive)
    most = max(MOST_VALUES // max(count, 1), 2)
    first = telling_channel(diagnosis)
    return {
        'models': [model.label for model in compared(diagnosis)],
        'start': telling_recording(diagnosis),
        'recordings': [_recording(diagnosis, k, first, most) for k in range(len(diagnosis.series))],
    }


def embedded(data: dict[str, Any]) -> str:
    """As JSON that can stand in a page."""
    return json.dumps(data, separators=(',', ':'), allow_nan=False).replace('<', '\\u003c')


def _recording(diagnosis: Diagnosis, k: int, first: str, most: int) -> dict[str, Any]:
    series = sorted(diagnosis.series[k], key=lambda s: s.channel != first)  # what shows most comes first
    path = diagnosis.recordings[k].path if k < len(diagnosis.recordings) else ''
    found: dict[str, Any] = {
        'name': Path(path).name or f'recording {k + 1}',
        'channels': [_channel(diagnosis, s, most) for s in series],
        'shaded': shaded(diagnosis, k),
        'shadedChannel': diagnosis.location.channel if diagnosis.location else None,
    }
    if k < len(diagnosis.drive):
        kind, time, value = diagnosis.drive[k]
        few = _steps(value, most)
        found['drive'] = {'label': CHANNEL_AXIS[kind], 'time': _packed(time[few]), 'value': _packed(value[few])}
    return found


def _channel(diagnosis: Diagnosis, s: Series, most: int) -> dict[str, Any]:
    few = thin(s.time.size, most)
    noise = diagnosis.noise.get(s.channel, float('nan'))
    unit, factor = SHOWN[s.channel]
    return {
        'channel': s.channel,
        'label': _LABELS[s.channel],
        'unit': unit,
        'noise': noise * factor if np.isfinite(noise) else None,
        'time': _packed(s.time[few]),
        'recorded': _packed(shown(s.channel, s.recorded[few])),
        'models': [_packed(shown(s.channel, model.of(s)[few])) for model in compared(diagnosis)],
    }


def _steps(value: Array, most: int) -> Array:
    """Places of an input's steps and ends, thinned."""
    changed = np.flatnonzero(np.diff(value)) + 1
    kept = np.unique(np.concatenate([[0], changed, [value.size - 1]]))
    return np.asarray(kept[thin(kept.size, most)])


def _packed(value: Array) -> str:
    return b64encode(np.ascontiguousarray(value, dtype='<f4').tobytes()).decode('ascii')
