"""The intervals of a calibrated muscle, written beside its parameter file: a parameter file itself holds only values.

What it holds and how it is read back: ``settings.intervals``.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tcp_muscle_ros.settings.intervals import SCHEMA

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration


def write_intervals(path: str | Path, calibration: 'Calibration') -> None:
    """Write the intervals of a calibrated parameter file to ``path``, which is ``path_beside`` it."""
    fit = calibration.fit
    shared = [k for k, u in enumerate(fit.problem.unknowns) if u.recording is None]
    content = {
        'schema': SCHEMA,
        'parameters': [
            {
                'name': e.name,
                'recording': e.recording,
                'nominal': e.nominal,
                'value': e.value,
                'low': e.low,
                'high': e.high,
                'unit': e.unit,
                'fixed_by_data': e.fixed,
                'at_bound': e.at_bound,
                'trades_against': e.partner,
            }
            for e in (*calibration.estimates, *calibration.combinations)
        ],
        'coordinates': [
            {
                'name': fit.problem.unknowns[k].name,
                'log': fit.problem.unknowns[k].log,
                'spread': fit.problem.unknowns[k].spread,
            }
            for k in shared
        ],
        'covariance': fit.covariance[np.ix_(shared, shared)].tolist(),
    }
    Path(path).write_text(json.dumps(content, indent=1) + '\n')
