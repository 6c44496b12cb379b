"""Write a suite of cases as bags, and its labels, sealed, beside them.

python -m proof.generate --suite development --cases 40 --seed 1 --output DIR
python -m proof.generate --suite varied --kinds double triple --seed 2 --output DIR    (cases of these kinds alone)

DIR/<case>/recording_<k>/ are rosbag2 bags, DIR/<case>/parameters.yaml the nominal parameters where a case has any.
Labels are not in DIR: they go to DIR.labels.json (or --labels), whose SHA-256 is printed and stored in DIR/SEAL.
"""

import argparse
import hashlib
import json
import shutil
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from proof.cases import BASE, FULL, SUITES, Case, composition, make_case, signals_of
from proof.protocols import unseen
from proof.recordings import INPUTS, START_NS, instrument, write
from proof.truth import Experiment, Signals, observe
from proof.visibility import visibility


def write_recording(
    case: Case, k: int, experiment: Experiment, signal: Signals, directory: Path, every: float = 0.0
) -> Path:
    """Write recording number k of a case as a bag; the input as a logger shows it that samples ``every`` so many s."""
    rng = case.rng(k)
    channels = [c for c in case.channels if not (experiment.blocked and c == 'displacement')]
    if experiment.blocked:
        channels.append('force')
    found = instrument(signal, experiment, case.noise, channels, rng)
    if every:
        where, values = found[INPUTS[experiment.kind]]
        first = int(case.rng(800 + k).integers(1, 1 + round(every * case.lab.rate)))
        sampled = np.concatenate([[0], np.arange(first, where.size, round(every * case.lab.rate))])
        found[INPUTS[experiment.kind]] = where[sampled], values[sampled]
    variance = round(case.noise['temperature'].sigma ** 2, 3)
    start_ns = START_NS + case.seed[-1] * 86_400_000_000_000 + k * 3_600_000_000_000  # a case a day, one an hour
    path = directory / case.name / f'recording_{k}'
    write(path, experiment, found, variance, start_ns, rng)
    return path


def write_case(case: Case, directory: Path, held_out: Path | None = None, every: float = 0.0) -> dict[str, Any]:
    """Write the recordings of a case, one more into held_out where that is wanted; its label."""
    signals = signals_of(case)
    folder = directory / case.name
    folder.mkdir(parents=True)
    for k, (done, signal) in enumerate(zip(case.experiments, signals, strict=True)):
        write_recording(case, k, done, signal, directory, every)
    if held_out:
        (held_out / case.name).mkdir(parents=True)
        k = len(case.experiments)
        further = unseen(case.lab, case.experiments, case.rng(900))
        write_recording(case, k, further, observe(case.bench, further, k, signals[-1].dose), held_out, every)
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
        'what': case.what,
        'number': case.seed[-1],
        'effects': [
            {
                'effect': c.effect,
                'stage': c.stage,
                'form': c.form,
                'strength': c.strength,
                'values': c.values,
                'visibility': seen,
            }
            for c, seen in zip(case.concealed, visibility(case, signals), strict=True)
        ],
        'verdicts': list(case.verdicts),
        'partner': case.partner,
        'nominal': case.nominal,
        'parameters': {name: getattr(body, name) for name in BASE},
        'ambient': case.lab.ambient,
        'noise': {name: case.noise[name].sigma for name in case.channels},
        'experiments': [experiment.name for experiment in case.experiments],
        'hottest': max(float(signal.fibre.max()) for signal in signals),
    }


def _one(
    numbered: tuple[int, tuple[str, str]],
    suite: str,
    seed: int,
    directory: Path,
    held_out: Path | None,
    every: float,
) -> dict[str, Any]:
    number, (kind, what) = numbered
    return write_case(make_case(suite, seed, number, kind, what), directory, held_out, every)


def generate(
    suite: str,
    cases: int,
    seed: int,
    directory: Path,
    labels: Path,
    jobs: int = 2,
    held_out: Path | None = None,
    kinds: Sequence[str] = tuple(FULL),
    every: float = 0.0,
    wanted: Sequence[tuple[str, str]] = (),
) -> str:
    """Write a suite, or the cases ``wanted`` (kind and what) in its forms; the SHA-256 of its labels."""
    for folder in (directory, held_out):
        if folder and (folder.is_dir() and not (folder / 'SEAL').is_file() and any(folder.iterdir())):
            raise SystemExit(f'{folder}: not empty and not a suite: choose another place')
        if folder and folder.exists():
            shutil.rmtree(folder)
    directory.mkdir(parents=True)
    numbered = list(enumerate(wanted or composition(suite, cases, seed, kinds)))
    work = partial(_one, suite=suite, seed=seed, directory=directory, held_out=held_out, every=every)
    if jobs == 1:
        found = [work(item) for item in numbered]
    else:
        with ProcessPoolExecutor(jobs, mp_context=get_context('spawn')) as pool:
            found = list(pool.map(work, numbered, chunksize=2))
    text = json.dumps({'suite': suite, 'seed': seed, 'cases': found}, indent=1, default=_plain)
    labels.write_text(text + '\n', encoding='utf-8')
    seal = hashlib.sha256(labels.read_bytes()).hexdigest()
    for folder in (directory, held_out):
        if folder:
            line = f'{seal}  labels of the suite {suite}, {len(found)} cases\n'
            (folder / 'SEAL').write_text(line, encoding='utf-8')
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
    parser.add_argument('--kinds', nargs='+', choices=list(FULL), default=list(FULL), help='of these kinds alone')
    parser.add_argument('--input-every', type=float, default=0.0, help='s; as a logger shows it. 0 = every switch')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--output', type=Path, required=True)
    parser.add_argument('--labels', type=Path, help='default: OUTPUT.labels.json')
    parser.add_argument('--held-out', type=Path, help='for one more recording of each case')
    parser.add_argument('--jobs', type=int, default=2)
    chosen = parser.parse_args(arguments)
    labels = chosen.labels or chosen.output.with_name(chosen.output.name + '.labels.json')
    start = time.perf_counter()
    seal = generate(
        chosen.suite,
        chosen.cases,
        chosen.seed,
        chosen.output,
        labels,
        chosen.jobs,
        chosen.held_out,
        chosen.kinds,
        chosen.input_every,
    )
    print(f'SHA-256 of the labels: {seal}')
    print(f'cases in {chosen.output}, labels in {labels}, {time.perf_counter() - start:.1f} s')
    return 0


if __name__ == '__main__':
    sys.exit(main())
