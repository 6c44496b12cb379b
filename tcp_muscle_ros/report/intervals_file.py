"""How well a muscle is known, written beside its parameter file: a parameter file itself holds only values.

What it holds and how it is read back: ``settings.intervals``.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from tcp_muscle_ros.settings.intervals import SCHEMA

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.fitting.calibration import Known


def write_intervals(path: str | Path, known: 'Known') -> None:
    """Write the intervals of a calibrated or improved muscle to ``path``, which is ``path_beside`` its file."""
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
            for e in known.estimates
        ],
        'coordinates': [{'name': u.name, 'log': u.log, 'spread': u.spread} for u in known.unknowns],
        'covariance': known.covariance.tolist(),
    }
    Path(path).write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')
