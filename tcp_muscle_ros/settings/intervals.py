"""The intervals of a calibrated or improved muscle, beside its parameter file: muscles that it might be as well.

``MUSCLE.intervals.json`` holds the covariance of the fitted coordinates; ``report.intervals_file`` writes it.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import SPECIFICATIONS, Parameters

SCHEMA = 'tcp_muscle_ros/calibration-1'
_DRAWS = 40
_Told = TypeVar('_Told')


def path_beside(parameter_file: str | Path) -> Path:
    """Where the intervals of a parameter file are."""
    return Path(parameter_file).with_suffix('.intervals.json')


def variants(parameter_file: str | Path, parameters: Parameters, seed: int = 0) -> Mapping[int, Parameters] | None:
    """Muscles drawn from the intervals beside a parameter file; None where there are none. BadInput: damaged ones."""
    return _of(parameter_file, lambda content: _drawn(content, parameters, seed), 'replay without a band')


def unfixed(parameter_file: str | Path, name: str) -> bool:
    """Whether the intervals beside a parameter file say that the data did not fix a parameter; False where there are
    none. BadInput: damaged ones."""

    def told(content: Mapping[str, Any]) -> bool:
        return any(one['name'] == name and not one['fixed_by_data'] for one in content['parameters'])

    return bool(_of(parameter_file, told, 'take the parameters as they are'))


def _of(parameter_file: str | Path, told: Callable[[Mapping[str, Any]], _Told], without: str) -> _Told | None:
    """What the intervals beside a parameter file tell; None where there are none. ``without``: what is done then."""
    path = path_beside(parameter_file)
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
        return told(content) if content.get('schema') == SCHEMA else None
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError, np.linalg.LinAlgError):
        raise BadInput(f'{path}: damaged; calibrate or diagnose again, or remove it to {without}') from None


def _drawn(content: Mapping[str, Any], parameters: Parameters, seed: int) -> Mapping[int, Parameters]:
    covariance = np.array(content['covariance'], dtype=np.float64)
    draws = np.random.default_rng(seed).multivariate_normal(
        np.zeros(len(covariance)), covariance, _DRAWS, check_valid='ignore'
    )
    made = {}
    for k, draw in enumerate(draws):
        values = {}
        for coordinate, shift in zip(content['coordinates'], draw, strict=True):
            name = coordinate['name']
            row = SPECIFICATIONS[name]
            value = (
                parameters[name] * np.exp(shift)
                if coordinate['log']
                else parameters[name] + shift * coordinate['spread']
            )
            values[name] = float(np.clip(value, row.low, row.high))
        made[k] = parameters.replace(values)
    return made
