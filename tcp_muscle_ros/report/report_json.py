"""``report.json``: a diagnosis as data for programs; its schema is ``diagnosis.schema.json`` beside this file.

SI, but absolute temperatures in degC as in parameter files; every parameter says its unit. A number that does not
exist is ``null``. Recordings are counted from 1.
"""

import json
from collections.abc import Mapping
from importlib import resources
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import (
    Change,
    ChannelFit,
    Diagnosis,
    Finding,
    FreeLaw,
    InWords,
    Proposal,
    RecordingSummary,
    Run,
    Sticking,
    Value,
)
from tcp_muscle_ros.diagnosis.search.location import Location, Unexplained
from tcp_muscle_ros.muscle import SPECIFICATIONS
from tcp_muscle_ros.report.words import at_edge, driver_range, own_parameters

SCHEMA = 'tcp_muscle_ros/diagnosis-2'
PROTOCOL, IMPROVED, RIG = 'next_protocol.yaml', 'improved.yaml', 'rig.yaml'
_DIGITS = 9  # significant: enough to replay to the same figures, few enough to read


def as_data(diagnosis: Diagnosis) -> dict[str, Any]:
    """The content of ``report.json``."""
    d = diagnosis
    return _json(
        {
            'schema': SCHEMA,
            'partial': d.partial,
            'headline': d.headline,
            'recordings': [_recording(r) for r in d.recordings],
            'noise': d.noise,
            'repeatability': {name: d.repeatability.get(name) for name in d.noise},
            'runs': [_run(r) for r in d.runs],
            'sticking': d.sticking and _sticking(d.sticking),
            'verdict': d.verdict,
            'verdict_probability': d.verdict_probability,
            'calibration': {name: _value(at_edge(name, v)) for name, v in {**d.calibration, **d.sensors}.items()},
            'sensors': sorted(d.sensors),
            'location': d.location and _location(d.location),
            'findings': [_finding(f) for f in d.findings],
            'fit': {channel: _fit(f) for channel, f in d.fit.items()},
            'ranking': [
                {'effect': r.effect, 'stage': r.stage, 'gain': r.gain, 'refitted': r.refitted} for r in d.ranking
            ],
            'not_testable': [{'effect': n.effect, 'why': n.why} for n in d.not_testable],
            'unexplained': d.unexplained and _unexplained(d.unexplained),
            'doubtful': [
                {'effect': one.effect, 'probability': one.probability, 'evidence': dict(one.evidence)}
                for one in d.doubtful
            ],
            'next_experiment': d.next_experiment and _proposal(d.next_experiment),
            'would_help': d.would_help,
            'improved_parameters': IMPROVED,
            'notes': d.notes,
            'seconds': d.seconds,
        }
    )


def write_json(path: str | Path, diagnosis: Diagnosis) -> None:
    """Write ``report.json``."""
    text = json.dumps(as_data(diagnosis), indent=1, ensure_ascii=False, allow_nan=False)
    Path(path).write_text(text + '\n', encoding='utf-8')


def schema() -> dict[str, Any]:
    """The JSON Schema of ``report.json``, as shipped."""
    text = resources.files('tcp_muscle_ros.report').joinpath('diagnosis.schema.json').read_text(encoding='utf-8')
    found: dict[str, Any] = json.loads(text)
    return found


def _recording(r: RecordingSummary) -> dict[str, object]:
    return {
        'path': r.path,
        'duration_s': r.duration,
        'rate_hz': r.rate,
        'channels': r.channels,
        'issues': r.issues,
    }


def _run(r: Run) -> dict[str, object]:
    return {
        'path': r.name,
        'protocol': r.protocol,
        'gain': r.gain,
        'time_constant_s': r.time_constant,
        'rmse_of_peak': r.error,
    }


def _sticking(s: Sticking) -> dict[str, object]:
    return {
        'channel': s.channel,
        'recordings': s.recordings,
        'rests_s': s.rests,
        'jumps': s.jumps,
        'parameters': {name: {'value': v, 'unit': SPECIFICATIONS[name].unit} for name, v in s.values.items()},
        'alike_jumps': s.alike_jumps,
        'alike_rests': s.alike_rests,
    }


def _value(v: Value) -> dict[str, object]:
    return {
        'nominal': v.nominal,
        'value': v.value,
        'low': v.low,
        'high': v.high,
        'unit': v.unit,
        'fixed_by_data': v.fixed,
        'at_bound': v.at_bound,
    }


def _location(where: Location) -> dict[str, object]:
    drivers = []
    for driver in where.drivers:
        low, high, unit = driver_range(driver)
        drivers.append({'variable': driver.variable, 'low': low, 'high': high, 'unit': unit, 'share': driver.share})
    return {
        'stage': where.stage,
        'channel': where.channel,
        'phase': where.phases,
        'drivers': drivers,
        'intervals_s': [_interval(found) for found in where.intervals],
        'size': where.size,
        'mean': where.mean,
    }


def _finding(f: Finding) -> dict[str, object]:
    return {
        'effect': f.effect,
        'stage': f.stage,
        'sentence': f.sentence,
        'equation': f.equation,
        'parameters': {name: _value(v) for name, v in own_parameters(f).items()},
        'probability': f.probability,
        'singled_out': f.singled_out,
        'indistinguishable_from': f.indistinguishable_from,
        'cluster': [{'effect': m.effect, 'stage': m.stage, 'probability': m.probability} for m in f.cluster],
        'improvement': {channel: _change(c) for channel, c in f.improvement.items()},
        'gain': f.gain,
        'evidence': dict(f.evidence),
        'unlisted': f.unlisted and _free_law(f.stage, f.unlisted),
    }


def _change(c: Change) -> dict[str, object]:
    return {'rmse_without': c.before, 'rmse_with': c.after}


def _free_law(stage: str, law: FreeLaw) -> dict[str, object]:
    curve = {name: getattr(law, name).tolist() for name in ('at', 'value', 'low', 'high')}
    return {
        'stage': stage,
        'driver': law.driver,
        'unit': law.unit,
        'curve': curve,
        'nearest': law.nearest,
        'nearest_share': law.nearest_share,
        'in_words': law.in_words and _in_words(law.in_words),
    }


def _in_words(said: InWords) -> dict[str, object]:
    return {
        'form': said.form,
        'sentence': said.sentence,
        'equation': said.equation,
        'parameters': {name: {'value': value, 'unit': unit} for name, (value, unit) in said.parameters.items()},
        'as_well': said.as_well,
        'curve': said.value.tolist(),
    }


def _interval(found: tuple[int, float, float]) -> tuple[int, float, float]:
    """Recording, start, end, the recordings counted from 1."""
    return found[0] + 1, found[1], found[2]


def _fit(f: ChannelFit) -> dict[str, object]:
    return {
        'rmse_nominal': f.nominal,
        'rmse_calibrated': f.calibrated,
        'rmse_improved': f.improved,
        'rmse_fitted': f.fitted,
        'noise': f.noise,
        'held_out': f.held_out and _change(f.held_out),
    }


def _unexplained(u: Unexplained) -> dict[str, object]:
    low, high, unit = driver_range(u)
    return {
        'stage': u.stage,
        'channel': u.channel,
        'share': u.share,
        'driver': u.driver,
        'low': low,
        'high': high,
        'unit': unit,
        'interval_s': _interval(u.interval),
    }


def _proposal(p: Proposal) -> dict[str, object]:
    return {
        'separates': p.separates,
        'protocol': PROTOCOL,
        'power': p.power,
        'name': p.name,
        'reason': p.reason,
        'duration_s': p.duration,
    }


def _json(content: Any) -> Any:
    """Only what JSON has: no numpy, no tuples, no NaN."""
    if isinstance(content, Mapping):
        return {str(key): _json(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_json(value) for value in content]
    if isinstance(content, bool | np.bool_):
        return bool(content)
    if isinstance(content, int | np.integer):
        return int(content)
    if isinstance(content, float | np.floating):
        return float(f'{content:.{_DIGITS}g}') if isfinite(content) else None
    return content
