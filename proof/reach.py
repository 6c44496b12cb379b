"""How far a law without a name reaches: unlisted muscles, diagnosed up to one current and load, run at others.

python -m proof.reach --output DIR [--document docs/reach_table.md]

The muscles are those of proof.written and the unlisted effects of the generator's development suites; none is of the
sealed one. Each is diagnosed from three recordings and run, as its improved.yaml says, on recordings that no method was
given: within the range of those, and a fifth beyond it in current, in load, and in both. Beside it stand the
recalibrated muscle and the best listed effects (``whiteness_bic``). Goes on case by case where it was stopped.
"""

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from proof.alternatives import whiteness_bic
from proof.answers import read_json
from proof.cases import EXPRESSIBLE, Case
from proof.generate import write_recording
from proof.study import LEFT, REACH, add_page_arguments, made_by, say
from proof.tool import QUICK, bags, diagnose_case, errors, experiments_of, improved, replay
from proof.tool import Case as Given
from proof.truth import observe
from proof.written import case_of, case_with, unseen, written
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.process.threads import one_of_linear_algebra

PLACES = ('within', 'current', 'load', 'both')
WAYS = ('recalibration', 'whiteness_bic', 'diagnosis')
# Of the unlisted effects those that one continuous law at one stage can be, and none of the sealed suite.
GENERATORS = ('slow_stroke', 'touching_rail', *EXPRESSIBLE)
MOST = 500  # samples of a channel
OWN = (('threshold', 'loss'), ('square', 'soft'), ('exponential', 'capacity'), ('saturation', 'free'))


def cases(seed: int) -> list[Case]:
    """A muscle of each law in OWN, and one with each unlisted effect."""
    rng = np.random.default_rng(seed)
    own = [case_of(written(form, table, rng), seed + k) for k, (form, table) in enumerate(OWN)]
    return [*own, *(case_with(name, seed) for name in GENERATORS)]


def record(case: Case, folder: Path) -> None:
    """Its recordings, in ``folder``/seen, and by place those that no method is given."""
    for k, experiment in enumerate(case.experiments):
        write_recording(case, k, experiment, observe(case.bench, experiment, k), folder / 'seen')
    for k, (place, experiment) in enumerate(unseen(case.lab, case.rng(900)).items()):
        write_recording(case, 10 + k, experiment, observe(case.bench, experiment, 10 + k), folder / place)


def missed(case: Case, runs: Mapping[str, Experiment], muscle: Parameters) -> dict[str, tuple[float, float]]:
    """By place: how a muscle misses what it was not given (root mean square over the channels, in noises), and which
    share of the time it says that it is outside what it was made from."""
    found: dict[str, tuple[float, float]] = {}
    for place, experiment in runs.items():
        run = replay(experiment, muscle)
        shares = [error / case.noise[name].sigma for name, error in errors([run]).items()]
        found[place] = float(np.sqrt(np.mean(np.square(shares)))), float(np.mean(~run.outputs.in_domain))
    return found


def judged(case: Case, folder: Path) -> dict[str, Any]:
    """A case from its recordings to what each way misses."""
    begun = time.monotonic()
    found = diagnose_case(folder / 'seen' / case.name, folder / 'reports', MOST)
    took = time.monotonic() - begun
    given = Given(folder / 'seen' / case.name)
    label: dict[str, Any] = {'effects': []}
    muscles = {
        'recalibration': given.calibration.parameters,
        'whiteness_bic': whiteness_bic(given, label).muscle,
        'diagnosis': improved(folder / 'reports' / case.name),
    }
    runs = {place: experiments_of(folder / place / case.name, given.nominal, QUICK)[0] for place in PLACES}
    return {
        'case': case.name,
        'said': [finding.effect for finding in found.findings],
        'improved': list(muscles['diagnosis'].effects),
        'seconds': round(took, 1),
        'missed': {way: missed(case, runs, muscle) for way, muscle in muscles.items()},
    }


def closed(result: dict[str, Any], way: str, place: str) -> float | None:
    """The share of the gap that a way closes, from the recalibrated muscle to the noise; None where there is none."""
    before, after = (result['missed'][name][place][0] for name in ('recalibration', way))
    return min((before - after) / (before - LEFT), 1.0) if before > REACH else None


def document(results: Sequence[dict[str, Any]], wanted: int, seed: int) -> str:
    """The tables as Markdown, of those that were ``wanted``."""
    tables = [r for r in results if any(name.startswith('free_') for name in r['improved'])]
    lines = [
        '# How far a law without a name reaches',
        '',
        f'{made_by("proof.reach", seed)} Muscles with one law that is in no catalogue, by the truth',
        'generator: of a known form (`proof/written.py`), and the unlisted effects of its development suites that one',
        'continuous law can be. Each is diagnosed from three recordings and run as `improved.yaml` says on recordings',
        'that were not given: within the range of currents and loads, and a fifth beyond it in current, in load, and',
        'in both. Told is the share of the gap that is closed between the recalibrated muscle (0; negative: worse)',
        f'and the noise of single readings (1), where the recalibrated muscle misses more than {REACH:g} noises. A law',
        'that is used beyond its table goes on in a straight line, and `replay` and `simulate` say so.',
        '',
        '| | within | current | load | both | not worse than recalibration, of all places |',
        '|---|---|---|---|---|---|',
        _medians('median, where a table is handed on', tables, 'diagnosis'),
        _medians('the same muscles, best listed effects', tables, 'whiteness_bic'),
        _medians('median of all', results, 'diagnosis'),
        _medians('best listed effects of all', results, 'whiteness_bic'),
        '',
        '| concealed | said | handed on | within | current | load | both | outside its range, current |',
        '|---|---|---|---|---|---|---|---|',
    ]
    for r in results:
        cells = ' | '.join(_cell(r, place) for place in PLACES)
        outside = 100.0 * r['missed']['diagnosis']['current'][1]
        said, on = (', '.join(names) or 'nothing' for names in (r['said'], r['improved']))
        lines.append(f'| {r["case"]} | {said} | {on} | {cells} | {outside:.0f} % of the time |')
    run = f'The first {len(results)} of {wanted} muscles were run.'
    return '\n'.join([*lines, '', f'In a cell: diagnosis (best listed effects). -: no gap. {run}', ''])


def _medians(name: str, results: Sequence[dict[str, Any]], way: str) -> str:
    shares = {place: [s for r in results if (s := closed(r, way, place)) is not None] for place in PLACES}
    cells = [f'{np.median(found):.2f} of {len(found)}' if found else '-' for found in shares.values()]
    every = [s for found in shares.values() for s in found]
    return f'| {name} | {" | ".join(cells)} | {sum(s >= -0.05 for s in every)} of {len(every)} |'


def _cell(result: dict[str, Any], place: str) -> str:
    mine, listed = (closed(result, way, place) for way in ('diagnosis', 'whiteness_bic'))
    return '-' if mine is None or listed is None else f'{mine:.2f} ({listed:.2f})'


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.reach', description=__doc__.splitlines()[0])
    parser.add_argument('--output', type=Path, required=True)
    parser.add_argument('--seed', type=int, default=2304)
    add_page_arguments(parser)
    chosen = parser.parse_args(arguments)
    one_of_linear_algebra()
    results = []
    muscles = cases(chosen.seed)
    for case in muscles:
        folder = chosen.output / case.name
        done = read_json(folder / 'result.json')
        if done is None and chosen.only_document:
            continue
        if done is None:
            if not bags(folder / 'seen' / case.name):
                record(case, folder)
            done = judged(case, folder)
            (folder / 'result.json').write_text(json.dumps(done) + '\n', encoding='utf-8')
            print(json.dumps(done), flush=True)
        results.append(done)
    say(document(results, len(muscles), chosen.seed), chosen.document)
    return 0


if __name__ == '__main__':
    sys.exit(main())
