"""Open the sealed labels and score the reports of a diagnosis against them.

python -m proof.score DIR REPORTS --labels LABELS [--beside DIR2] [--json FILE] [--log FILE]

DIR is what proof.generate wrote (its SEAL is checked), REPORTS has <case>/report.json in the schema of the diagnosis
and <case>/held_out.json, the free-run errors on recordings that were not given to it; DIR2 has the same of the
alternatives `recalibration` and `oracle`, between which the held-out gap lies. A case without a report is a failure
wherever something was to be found or said, and is not counted where restraint is asked. Every scoring of a sealed suite
is appended to the log.
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime, timezone
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from proof.answers import (
    Answer,
    both,
    covered,
    exact,
    flagged,
    gap_closed,
    in_first_set,
    left_over,
    matched,
    named,
    noise_ratios,
    read,
    reported,
    right,
    worse,
)
from proof.rates import wilson

LOG = Path(__file__).parent / 'sealed_runs.jsonl'
ALIKE = 0.85  # likeness from which a pair is taken as truly ambiguous
PEAKS = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, np.inf)  # bins of the power curve, in noise units
STRENGTHS = (-0.25, 0.0, 0.25, 0.5, 0.75, 1.001)  # and by strength: 0 is barely visible, 1 obvious
LEAST_NOISE, MOST_NOISE = 0.7, 1.5  # of the instrument's: what a stated noise may be


Row = dict[str, Any]


def rate(name: str, aim: str, answers: Iterable[Answer], hit: Callable[[Answer], bool]) -> Row:
    """A row of the table: how often, out of how many answers, with its interval."""
    return counted(name, aim, [hit(answer) for answer in answers])


def counted(name: str, aim: str, results: Sequence[bool]) -> Row:
    """A row of what is counted otherwise than by answers."""
    hits, n = sum(results), len(results)
    low, high = wilson(hits, n)
    return {'score': name, 'aim': aim, 'value': hits / n if n else None, 'hits': hits, 'n': n, 'low': low, 'high': high}


def number(name: str, aim: str, values: Sequence[float], summary: Callable[[Sequence[float]], float]) -> Row:
    """A row with a summary of numbers."""
    return {'score': name, 'aim': aim, 'value': float(summary(values)) if values else None, 'n': len(values)}


def scores(answers: Sequence[Answer]) -> list[Row]:
    """The figures that the diagnosis aims at."""
    of = {kind: [a for a in answers if a.label['kind'] == kind] for kind in ('single', 'double', 'triple')}
    nulls = [a for a in answers if a.label['kind'] == 'null']
    decoys = [a for a in answers if a.label['kind'] == 'decoy']
    unlisted = [a for a in answers if a.label['kind'] == 'unlisted' and a.truth]
    pairs = [a for a in answers if a.label['kind'] == 'ambiguous']
    alike = [a for a in pairs if a.truth and a.label['effects'][0]['visibility'].get('likeness', 0.0) >= ALIKE]
    seen = [a for a in of['single'] if a.truth]
    unseen = [a for a in of['single'] if not a.truth]
    two = [a for a in of['double'] if len(a.truth) == 2]
    three = [a for a in of['triple'] if len(a.truth) == 3]
    solved = [a for a in seen if in_first_set(a)]
    bench = [*seen, *two, *three]
    gaps = [g for a in bench if (g := gap_closed(a)) is not None]
    ratios = [r for a in bench if (r := left_over(a)) is not None]
    # not the decoys: a muscle without its sensor's fault is right, and further from a faulty recording
    muscles = [a for a in answers if a.label['kind'] != 'decoy' and a.held_out and a.limits['recalibration']]
    plain = [*nulls, *(a for a in decoys if a.label['what'] in ('wrong_parameters', 'coloured_noise')), *solved]
    return [
        rate('reports written', '100 %', answers, lambda a: a.report is not None),
        rate('false physics on nulls', '<= 2 %', reported(nulls), lambda a: bool(a.physics)),
        rate('nulls: any alarm (physics, sensor, unexplained)', '', reported(nulls), _alarm),
        rate('muscles as the lab says: match', '>= 95 %', _nulls(nulls, known=True), lambda a: a.verdict == 'match'),
        rate(
            'muscles with other parameters: wrong parameters',
            '>= 95 %',
            _nulls(nulls, known=False),
            lambda a: a.verdict == 'wrong_parameters',
        ),
        rate('decoys named as physics', '<= 3 %', reported(decoys), lambda a: bool(a.physics)),
        rate('verdict right on decoys', '', decoys, right),
        rate('stage right, singles', '>= 98 %', seen, lambda a: a.stage() in a.stages),
        rate('single named first', '>= 90 %', seen, lambda a: bool(a.findings) and a.findings[0]['effect'] in a.truth),
        rate('single in the reported set', '>= 97 %', seen, in_first_set),
        rate('single, nothing else named', '', seen, lambda a: matched(a.findings, a.truth)),
        number('mean size of the set', '<= 1.5', [len(named(a.findings[0])) for a in seen if a.findings], np.mean),
        rate('undetectable single: no false name', '', reported(unseen), lambda a: not a.physics or _true(a)),
        rate('two effects, exactly', '>= 75 %', two, exact),
        rate('two effects, as sets', '', two, lambda a: matched(a.findings, a.truth)),
        rate('two effects, one at least', '', two, lambda a: any(named(f) & set(a.truth) for f in a.findings)),
        rate('three effects, exactly', '', three, exact),
        rate('three effects, as sets', '', three, lambda a: matched(a.findings, a.truth)),
        rate('unlisted flagged', '>= 85 %', unlisted, flagged),
        rate('unlisted flagged in its stage', '', unlisted, lambda a: flagged(a) and _flag_stage(a) in a.stages),
        rate('unlisted given a false name', '', reported(unlisted), lambda a: bool(a.physics)),
        rate('ambiguous: both in the set', '', alike, both),
        rate('ambiguous: an experiment proposed', '', alike, lambda a: a.proposal is not None),
        number('held-out gap closed, median', '>= 0.95', gaps, np.median),
        number('held-out gap closed, 10th percentile', '>= 0.80', gaps, lambda v: float(np.percentile(v, 10))),
        number('held-out error left, of the recalibrated, median', '', ratios, np.median),
        rate('held-out error made worse by a tenth', '', muscles, worse),
        counted('90 % intervals that cover', '85 to 95 %', [i for a in answers for i in covered(a)]),
        counted('90 % intervals that cover, where the answer is right', '', [i for a in plain for i in covered(a)]),
        counted('noise as the instrument has it', '>= 95 %', _noise_held(answers)),
    ]


def _alarm(answer: Answer) -> bool:
    return bool(answer.findings) or flagged(answer)


def _nulls(nulls: Sequence[Answer], known: bool) -> list[Answer]:
    """Those whose parameter file has the muscle's own numbers, or those that are said to be the default one."""
    return [a for a in nulls if bool(a.label.get('nominal')) is known]


def _true(answer: Answer) -> bool:
    return answer.label['effects'][0]['effect'] in {n for f in answer.findings for n in named(f)}


def _noise_held(answers: Sequence[Answer]) -> list[bool]:
    """Is it neither a misfit that was taken for noise nor less than there is? Where noise wanders slowly by far the
    most of it is the instrument's wander, and not asked."""
    asked = [a for a in answers if a.label['what'] != 'coloured_noise']
    return [LEAST_NOISE <= ratio <= MOST_NOISE for a in asked for ratio in noise_ratios(a)]


def _flag_stage(answer: Answer) -> str:
    return str(((answer.report or {}).get('unexplained') or {}).get('stage'))


def power_curve(answers: Sequence[Answer]) -> list[Row]:
    """Singles by how far they stand out of the noise after a refit: their strongest 10 s, in noise units."""
    return _curve(answers, 'peak', PEAKS, lambda answer: answer.peak)


def strength_curve(answers: Sequence[Answer]) -> list[Row]:
    """Singles by the strength with which they were concealed, 0 barely visible, 1 obvious."""
    return _curve(answers, 'strength', STRENGTHS, lambda answer: float(answer.label['effects'][0]['strength']))


def _curve(answers: Sequence[Answer], by: str, edges: Sequence[float], of: Callable[[Answer], float]) -> list[Row]:
    singles = [a for a in answers if a.label['kind'] == 'single']
    rows = []
    for low, high in pairwise(edges):
        here = [a for a in singles if low <= of(a) < high]
        name = [a.label['effects'][0]['effect'] for a in here]
        first = sum(bool(a.findings) and a.findings[0]['effect'] == n for a, n in zip(here, name, strict=True))
        within = sum(bool(a.findings) and n in named(a.findings[0]) for a, n in zip(here, name, strict=True))
        anything = sum(bool(a.physics) or flagged(a) for a in here)
        rows.append({
            by: f'{low:g} to {high:.3g}' if np.isfinite(high) else f'over {low:g}',
            'centre': float(np.median([of(a) for a in here])) if here else None,
            'n': len(here), 'first': first, 'in_set': within, 'anything': anything,
            'first_interval': wilson(first, len(here)),
        })  # fmt: skip
    return rows


def confusions(answers: Sequence[Answer]) -> list[Row]:
    """Per effect: how often first, in the set, and what was said instead."""
    rows = []
    singles = [a for a in answers if a.label['kind'] in ('single', 'unlisted') and a.truth]
    for effect in sorted({a.truth[0] for a in singles}):
        here = [a for a in singles if a.truth == [effect]]
        said = [a.findings[0]['effect'] if a.findings else a.verdict for a in here]
        rows.append({
            'effect': effect,
            'n': len(here),
            'first': said.count(effect),
            'in_set': sum(bool(a.findings) and effect in named(a.findings[0]) for a in here),
            'instead': dict(Counter(s for s in said if s != effect)),
        })  # fmt: skip
    return rows


def decoy_verdicts(answers: Sequence[Answer]) -> list[Row]:
    """Per decoy: the verdicts and the physics that was named."""
    rows = []
    decoys = [a for a in answers if a.label['kind'] == 'decoy']
    for what in sorted({a.label['what'] for a in decoys}):
        here = [a for a in decoys if a.label['what'] == what]
        rows.append({
            'decoy': what,
            'n': len(here),
            'verdicts': dict(Counter(a.verdict for a in here)),
            'physics': dict(Counter(f['effect'] for a in here for f in a.physics)),
        })  # fmt: skip
    return rows


def tables(answers: Sequence[Answer]) -> dict[str, Any]:
    """Everything that is told of one way to answer."""
    gaps = [(a.label['case'], g) for a in answers if a.label['kind'] in ('single', 'double', 'triple')
            and len(a.truth) == len(a.label['effects']) and (g := gap_closed(a)) is not None]  # fmt: skip
    return {
        'cases': len(answers),
        'scores': scores(answers),
        'power_curve': power_curve(answers),
        'strength_curve': strength_curve(answers),
        'confusions': confusions(answers),
        'decoys': decoy_verdicts(answers),
        'gaps': dict(gaps),
    }


def brief(result: Mapping[str, Any]) -> dict[str, Any]:
    """Value and number of each score."""
    return {row['score']: [row['value'], row['n']] for row in result['scores']}


def note(path: Path, event: str, **what: Any) -> None:
    """Append to the log of sealed suites."""
    entry = {'date': datetime.now(timezone.utc).isoformat(timespec='seconds'), 'event': event, **what}
    with path.open('a', encoding='utf-8') as log:
        log.write(json.dumps(entry) + '\n')


def text(result: Mapping[str, Any]) -> str:
    """All tables as text."""
    lines = [table(result['scores'])]
    for by, key in (
        ('their strongest 10 s after a refit, in noise units', 'power_curve'),
        ('strength', 'strength_curve'),
    ):
        lines.append(f'\nsingles by {by}: first / in set / anything of n')
        for row in result[key]:
            label = row.get('peak') or row.get('strength')
            lines.append(f'  {label:>14s}  {row["first"]:3d} / {row["in_set"]:3d} / {row["anything"]:3d} of {row["n"]}')
    lines.append('\nper effect: first / in set of n, said instead')
    lines += [
        f'  {row["effect"]:22s} {row["first"]:3d} / {row["in_set"]:3d} of {row["n"]:<4d} {row["instead"] or ""}'
        for row in result['confusions']
    ]
    lines.append('\ndecoys: verdicts, physics named')
    lines += [f'  {row["decoy"]:22s} {row["verdicts"]} {row["physics"] or ""}' for row in result['decoys']]
    return '\n'.join(lines)


def table(rows: Sequence[Row]) -> str:
    """The scores as text."""
    lines = []
    for row in rows:
        if row.get('hits') is not None and row.get('n'):
            value = f'{100 * row["value"]:5.1f} %  [{100 * row["low"]:.1f}, {100 * row["high"]:.1f}]'
            count = f'{row["hits"]}/{row["n"]}'
        else:
            value, count = ('-' if row['value'] is None else f'{row["value"]:.3f}'), str(row['n'])
        lines.append(f'{row["score"]:48s} {value:24s} {count:>8s}   {row["aim"]}')
    return '\n'.join(lines)


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.score', description=__doc__.splitlines()[0])
    parser.add_argument('directory', type=Path)
    parser.add_argument('reports', type=Path)
    parser.add_argument('--labels', type=Path, required=True)
    parser.add_argument('--beside', type=Path, help='where the reports of recalibration and oracle are')
    parser.add_argument('--json', type=Path, help='write all tables here')
    parser.add_argument('--log', type=Path, default=LOG, help='where a scoring of a sealed suite is noted')
    chosen = parser.parse_args(arguments)
    head, answers = read(chosen.directory, chosen.reports, chosen.labels, chosen.beside)
    result = {**head, **tables(answers)}
    print(f'suite {head["suite"]}, seed {head["seed"]}, {len(answers)} cases, seal {head["seal"][:16]}')
    print(text(result))
    if chosen.json:
        chosen.json.write_text(json.dumps(result, indent=1) + '\n', encoding='utf-8')
    if head['suite'] == 'sealed':
        note(chosen.log, 'scored', **head, cases=len(answers), scores=brief(result))
    return 0


if __name__ == '__main__':
    sys.exit(main())
