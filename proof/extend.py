"""Run a proposed experiment on the truth of a case and add the recording to its bags.

python -m proof.extend DIR CASE PROTOCOL.yaml --labels LABELS

The protocol is the contract's: rate_hz, input, end, repeat, and segments of duration_s, value or [start, end], load_n.
The room is as warm as ambient_c of the first segment says, else as it was.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from proof.cases import Case, make_case, signals_of
from proof.generate import write_recording
from proof.truth import Experiment, observe
from proof.truth.plant import CURRENT, POWER, VOLTAGE

KINDS = {'current': CURRENT, 'power': POWER, 'voltage': VOLTAGE}


def as_experiment(protocol: dict[str, Any], case: Case) -> Experiment:
    """The experiment of a protocol file; the load stays as it was where a segment does not say."""
    rate = float(protocol.get('rate_hz', case.lab.rate))
    load = float(case.experiments[0].load[0])
    ambient = float(protocol['segments'][0].get('ambient_c', case.lab.ambient))
    drive, loads = [], []
    for segment in list(protocol['segments']) * int(protocol.get('repeat', 1)):
        n = max(1, round(float(segment['duration_s']) * rate))
        value = segment['value']
        start, end = (value[0], value[1]) if isinstance(value, list) else (value, value)
        load = float(segment.get('load_n', load))
        drive.append(np.linspace(float(start), float(end), n))
        loads.append(np.full(n, load))
    rows = np.concatenate(drive)
    return Experiment(
        'proposed',
        np.arange(len(rows)) / rate,
        rows,
        KINDS[str(protocol.get('input', 'current'))],
        np.concatenate(loads),
        ambient,
        protocol.get('end', 'load') == 'blocked',
    )


def extend(directory: Path, name: str, protocol: Path, labels: Path) -> Path:
    """The new bag, of a muscle that has worn in the recordings of its case."""
    suite = json.loads(labels.read_text(encoding='utf-8'))
    label = next(entry for entry in suite['cases'] if entry['case'] == name)
    case = make_case(suite['suite'], suite['seed'], label['number'], label['kind'], label['what'])
    experiment = as_experiment(yaml.safe_load(protocol.read_text(encoding='utf-8')), case)
    k = len(list((directory / name).glob('recording_*')))
    dose = signals_of(case)[-1].dose
    case.experiments.append(experiment)
    return write_recording(case, k, experiment, observe(case.bench, experiment, k, dose), directory)


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.extend', description=__doc__.splitlines()[0])
    parser.add_argument('directory', type=Path)
    parser.add_argument('case')
    parser.add_argument('protocol', type=Path)
    parser.add_argument('--labels', type=Path, required=True)
    chosen = parser.parse_args(arguments)
    print(extend(chosen.directory, chosen.case, chosen.protocol, chosen.labels))
    return 0


if __name__ == '__main__':
    sys.exit(main())
