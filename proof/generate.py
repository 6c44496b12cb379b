"""Write a suite of cases as bags, and its labels, sealed, beside them.

python -m proof.generate --suite development --cases 40 --seed 1 --output DIR

DIR/<case>/recording_<k>/ are rosbag2 bags, DIR/<case>/parameters.yaml the nominal parameters where a case has any.
Labels are not in DIR: they go to DIR.labels.json (or --labels), whose SHA-256 is printed and stored in DIR/SEAL.
"""

import argparse
import hashlib
import json
import shutil
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from proof.cases import SUITES, Case, composition, make_case
from proof.recordings import START_NS, instrument, write
from proof.truth import Bench, Signals, observe


def signals_of(case: Case, bench: Bench | None = None) -> list[Signals]:
    """What ideal instruments would have shown in each recording of a case."""
    signals, dose = [], 0.0
    for k, experiment in enumerate(case.experiments):
        signals.append(observe(bench or case.bench, experiment, k, dose))
        dose = signals[-1].dose
    return signals


def write_case(case: Case, directory: Path) -> dict[str, Any]:
    """Write the recordings of a case; its label."""
    signals = signals_of(case)
    folder = directory / case.name
    folder.mkdir(parents=True)
    start_ns = START_NS + case.seed[-1] * 86_400_000_000_000
    for k, (experiment, signal) in enumerate(zip(case.experiments, signals, strict=True)):
        rng = case.rng(k)
        channels = [c for c in case.channels if not (experiment.blocked and c == 'displacement')]
        if experiment.blocked:
            channels.append('force')
        found = instrument(signal, experiment, case.noise, channels, rng)
        variance = round(case.noise['temperature'].sigma ** 2, 3)
        write(folder / f'recording_{k}', experiment, found, variance, start_ns + k * 3_600_000_000_000, rng)
    if case.nominal:
        lines = ['/**:', '  ros__parameters:', *(f'    {name}: {value!r}' for name, value in case.nominal.items())]
        (folder / 'parameters.yaml').write_text('\n'.join(lines) + '\n', encoding='utf-8')
    return label(case, signals)


def label(case: Case, signals: list[Signals]) -> dict[str, Any]:
    """What is true of a case."""
    body = case.lab.body
    return {
        'case': case.name,
        'kind': case.kind,
        'effects': [
            {'effect': c.effect, 'stage': c.stage, 'form': c.form, 'strength': c.strength, 'values': c.values}
            for c in case.concealed
        ],
        'verdicts': list(case.verdicts),
        'partner': case.partner,
        'nominal': case.nominal,
        'parameters': {name: getattr(body, name) for name in ('R0', 'a_R', 'C', 'hA', 'k0', 'H0', 'B')},
        'ambient': case.lab.ambient,
        'experiments': [experiment.name for experiment in case.experiments],
        'hottest': max(float(signal.fibre.max()) for signal in signals),
    }


def _one(numbered: tuple[int, tuple[str, str]], suite: str, seed: int, directory: Path) -> dict[str, Any]:
    number, (kind, what) = numbered
    return write_case(make_case(suite, seed, number, kind, what), directory)


def generate(suite: str, cases: int, seed: int, directory: Path, labels: Path, jobs: int = 2) -> str:
    """Write a suite; the SHA-256 of its labels."""
    if directory.exists():
        shutil.rmtree(directory)
    directory.mkdir(parents=True)
    wanted = list(enumerate(composition(suite, cases, seed)))
    work = partial(_one, suite=suite, seed=seed, directory=directory)
    if jobs == 1:
        found = [work(item) for item in wanted]
    else:
        with ProcessPoolExecutor(jobs, mp_context=get_context('spawn')) as pool:
            found = list(pool.map(work, wanted, chunksize=2))
    text = json.dumps({'suite': suite, 'seed': seed, 'cases': found}, indent=1, default=_plain)
    labels.write_text(text + '\n', encoding='utf-8')
    seal = hashlib.sha256(labels.read_bytes()).hexdigest()
    (directory / 'SEAL').write_text(f'{seal}  labels of the suite {suite}, {len(found)} cases\n', encoding='utf-8')
    return seal


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f'no JSON for {type(value).__name__}')


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.generate', description=__doc__.splitlines()[0])
    parser.add_argument('--suite', choices=list(SUITES), default='development')
    parser.add_argument('--cases', type=int, default=0, help='how many; 0 = the full suite')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--output', type=Path, required=True)
    parser.add_argument('--labels', type=Path, help='default: OUTPUT.labels.json')
    parser.add_argument('--jobs', type=int, default=2)
    chosen = parser.parse_args(arguments)
    labels = chosen.labels or chosen.output.with_name(chosen.output.name + '.labels.json')
    start = time.perf_counter()
    seal = generate(chosen.suite, chosen.cases, chosen.seed, chosen.output, labels, chosen.jobs)
    print(f'SHA-256 of the labels: {seal}')
    print(f'cases in {chosen.output}, labels in {labels}, {time.perf_counter() - start:.1f} s')
    return 0


if __name__ == '__main__':
    sys.exit(main())
