"""Open the sealed labels and score the reports of a diagnosis against them.

python -m proof.score DIR REPORTS --labels LABELS [--beside DIR2] [--json FILE] [--log FILE]

DIR is what proof.generate wrote (its SEAL is checked), REPORTS has <case>/report.json in the schema of the diagnosis
and <case>/held_out.json, the free-run errors on recordings that were not given to it; DIR2 has the same of the
alternatives `recalibration` and `oracle`, between which the held-out gap lies. A case without a report is a failure
wherever something was to be found, and does not count as silence on a null or a decoy. Every scoring of a sealed suite
is appended to the log.
"""

import argparse
import hashlib
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

LOG = Path(__file__).parent / 'sealed_runs.jsonl'
ALIKE = 0.85  # likeness from which a pair is taken as truly ambiguous
PEAKS = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, np.inf)  # bins of the power curve, in noise units
STRENGTHS = (-0.25, 0.0, 0.25, 0.5, 0.75, 1.001)  # and by strength: 0 is barely visible, 1 obvious
REACH = 1.1  # the recalibrated error must be so much larger than the oracle's for a gap to be there
LEAST_NOISE, MOST_NOISE = 0.7, 1.5  # of the instrument's: what a stated noise may be
NO_LIMIT = {'recalibration': None, 'oracle': None}


def wilson(hits: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % interval of a rate."""
    if n == 0:
        return 0.0, 1.0
    p = hits / n
    centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    return float(max(0.0, centre - half)), float(min(1.0, centre + half))


def told(results: Sequence[bool]) -> str:
    """How often, out of how many, with its interval, in words."""
    low, high = wilson(sum(results), len(results))
    return f'{sum(results)}/{len(results)} ({100 * low:.0f} to {100 * high:.0f} %)' if results else '-'


@dataclass(frozen=True)
class Answer:
    """A label and what was reported for it."""

    label: dict[str, Any]
    report: dict[str, Any] | None
    held_out: dict[str, float] | None = None  # root mean square by channel, SI
    limits: Mapping[str, dict[str, float] | None] = field(default_factory=lambda: NO_LIMIT)

    @property
    def verdict(self) -> str:
        """As reported."""
        return str((self.report or {}).get('verdict', 'no report'))

    @property
    def findings(self) -> list[dict[str, Any]]:
        """All of them, strongest first."""
        return list((self.report or {}).get('findings') or [])

    @property
    def proposal(self) -> dict[str, Any] | None:
        """The experiment that the report proposes."""
        return (self.report or {}).get('next_experiment') or None

    @property
    def physics(self) -> list[dict[str, Any]]:
        """Those that name physics of the muscle, not a fault of the set-up, nor a law without a name."""
        return [f for f in self.findings if f.get('stage') != 'sensor' and not f.get('unlisted')]

    @property
    def truth(self) -> list[str]:
        """The effects that are there and can be seen."""
        return [e['effect'] for e in self.label['effects'] if e['visibility']['detectable']]

    @property
    def peak(self) -> float:
        """The strongest 10 s of the weakest effect, in noise units."""
        return min((max(e['visibility']['peak'].values()) for e in self.label['effects']), default=0.0)

    @property
    def stages(self) -> set[str]:
        """The true ones."""
        return {e['stage'] for e in self.label['effects']}

    def stage(self) -> str:
        """The stage that the report points to first."""
        if self.findings:
            return str(self.findings[0].get('stage'))
        location = (self.report or {}).get('location') or (self.report or {}).get('unexplained') or {}
        return str(location.get('stage'))


def named(finding: dict[str, Any]) -> set[str]:
    """The set that a finding stands for."""
    return {str(finding.get('effect')), *(str(n) for n in finding.get('indistinguishable_from') or [])}


def matched(findings: Sequence[dict[str, Any]], truth: Sequence[str]) -> bool:
    """Is there exactly one finding for each true effect, each true effect in the set of its own finding?"""
    if len(findings) != len(truth):
        return False
    if not truth:
        return True
    return any(
        matched([*findings[:k], *findings[k + 1 :]], truth[1:])
        for k, finding in enumerate(findings)
        if truth[0] in named(finding)
    )


def held_out_error(answer: Answer, errors: Mapping[str, float] | None) -> float | None:
    """One number for the free run on unseen recordings: root mean square over the channels, in noise units."""
    noise = answer.label['noise']
    shares = [errors[name] / noise[name] for name in errors if name in noise] if errors else []
    return float(np.sqrt(np.mean(np.square(shares)))) if shares else None


def gap(answer: Answer) -> tuple[float, float] | None:
    """The held-out errors of the recalibrated muscle and of the oracle, where effects were there to be gained."""
    before, best = (held_out_error(answer, answer.limits[name]) for name in ('recalibration', 'oracle'))
    return (before, best) if before and best and before > REACH * best else None


def gap_closed(answer: Answer) -> float | None:
    """How far the improved muscle went from the recalibrated one to the oracle; without a report nowhere."""
    found = gap(answer)
    if not found:
        return None
    before, best = found
    after = held_out_error(answer, answer.held_out)
    return 0.0 if after is None else (before - after) / (before - best)


def read(
    directory: Path, reports: Path, labels: Path, beside: Path | None = None
) -> tuple[dict[str, Any], list[Answer]]:
    """The labels, if they are those that were sealed, with the reports. beside: the folder of the alternatives."""
    seal = (directory / 'SEAL').read_text(encoding='utf-8').split()[0]
    found = hashlib.sha256(labels.read_bytes()).hexdigest()
    if found != seal:
        raise SystemExit(f'{labels}: SHA-256 {found} is not that of {directory / "SEAL"}: {seal}')
    suite = json.loads(labels.read_text(encoding='utf-8'))
    answers = []
    for label in suite['cases']:
        name = label['case']
        limits = {k: read_json(beside / k / name / 'held_out.json') if beside else None for k in NO_LIMIT}
        report = read_json(reports / name / 'report.json')
        answers.append(Answer(label, report, read_json(reports / name / 'held_out.json'), limits))
    return {'suite': suite['suite'], 'seed': suite['seed'], 'seal': seal}, answers


def read_json(path: Path) -> dict[str, Any] | None:
    """What a file has; None where there is none."""
    return json.loads(path.read_text(encoding='utf-8')) if path.is_file() else None


Row = dict[str, Any]


def rate(name: str, aim: str, answers: Iterable[Answer], hit: Callable[[Answer], bool]) -> Row:
    """A row of the table: how often, out of how many, with its interval."""
    results = [hit(answer) for answer in answers]
    hits, n = sum(results), len(results)
    low, high = wilson(hits, n)
    return {'score': name, 'aim': aim, 'value': hits / n if n else None, 'hits': hits, 'n': n, 'low': low, 'high': high}


def number(name: str, aim: str, values: Sequence[float], summary: Callable[[Sequence[float]], float]) -> Row:
    """A row with a summary of numbers."""
    return {'score': name, 'aim': aim, 'value': float(summary(values)) if values else None, 'n': len(values)}


def scores(answers: Sequence[Answer]) -> list[Row]:
    """The figures that the diagnosis aims at."""
    of = {kind: [a for a in answers if a.label['kind'] == kind] for kind in ('single', 'double', 'triple')}
    nulls = [a for a in answers if a.label['kind'] == 'null' and a.report]  # silence is no proof of restraint
    decoys = [a for a in answers if a.label['kind'] == 'decoy' and a.report]
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
    inside = [i for a in plain for i in covered(a)]
    return [
        rate('reports written', '100 %', answers, lambda a: a.report is not None),
        rate('false physics on nulls', '<= 2 %', nulls, lambda a: bool(a.physics)),
        rate('nulls: any alarm (physics, sensor, unexplained)', '', nulls, lambda a: bool(a.findings) or flagged(a)),
        rate('muscles as the lab says: match', '>= 95 %', _nulls(nulls, known=True), lambda a: a.verdict == 'match'),
        rate(
            'muscles with other parameters: wrong parameters',
            '>= 95 %',
            _nulls(nulls, known=False),
            lambda a: a.verdict == 'wrong_parameters',
        ),
        rate('decoys named as physics', '<= 3 %', decoys, lambda a: bool(a.physics)),
        rate('verdict right on decoys', '', decoys, right),
        rate('stage right, singles', '>= 98 %', seen, lambda a: a.stage() in a.stages),
        rate('single named first', '>= 90 %', seen, lambda a: bool(a.findings) and a.findings[0]['effect'] in a.truth),
        rate('single in the reported set', '>= 97 %', seen, in_first_set),
        rate('single, nothing else named', '', seen, lambda a: matched(a.findings, a.truth)),
        number('mean size of the set', '<= 1.5', [len(named(a.findings[0])) for a in seen if a.findings], np.mean),
        rate('undetectable single: no false name', '', unseen, lambda a: not a.physics or _true(a)),
        rate('two effects, exactly', '>= 75 %', two, exact),
        rate('two effects, as sets', '', two, lambda a: matched(a.findings, a.truth)),
        rate('two effects, one at least', '', two, lambda a: any(named(f) & set(a.truth) for f in a.findings)),
        rate('three effects, exactly', '', three, exact),
        rate('three effects, as sets', '', three, lambda a: matched(a.findings, a.truth)),
        rate('unlisted flagged', '>= 85 %', unlisted, flagged),
        rate('unlisted flagged in its stage', '', unlisted, lambda a: flagged(a) and _flag_stage(a) in a.stages),
        rate('unlisted given a false name', '', unlisted, lambda a: bool(a.physics)),
        rate('ambiguous: both in the set', '', alike, both),
        rate('ambiguous: an experiment proposed', '', alike, lambda a: a.proposal is not None),
        number('held-out gap closed, median', '>= 0.95', gaps, np.median),
        number('held-out gap closed, 10th percentile', '>= 0.80', gaps, lambda v: float(np.percentile(v, 10))),
        number('held-out error left, of the recalibrated, median', '', ratios, np.median),
        rate('held-out error made worse by a tenth', '', muscles, worse),
        {**rate('90 % intervals that cover', '85 to 95 %', [], lambda a: True), **_count(inside)},
        {**rate('noise as the instrument has it', '>= 95 %', [], lambda a: True), **_count(_noise_held(answers))},
    ]


def in_first_set(answer: Answer) -> bool:
    """Is the one true effect among those that the first finding stands for?"""
    return bool(answer.findings) and answer.truth[0] in named(answer.findings[0])


def left_over(answer: Answer) -> float | None:
    """The held-out error as a share of the recalibrated one, where there is a gap."""
    found, after = gap(answer), held_out_error(answer, answer.held_out)
    return after / found[0] if found and after is not None else None


def worse(answer: Answer) -> bool:
    """Is the muscle further from unseen recordings than before?"""
    before, after = (held_out_error(answer, e) for e in (answer.limits['recalibration'], answer.held_out))
    return bool(before and after and after > REACH * before)


def _nulls(nulls: Sequence[Answer], known: bool) -> list[Answer]:
    """Those whose parameter file has the muscle's own numbers, or those that are said to be the default one."""
    return [a for a in nulls if bool(a.label.get('nominal')) is known]


def right(answer: Answer) -> bool:
    """Is the verdict one of those that hold? A fault that leaves no trace may be passed over."""
    quiet = () if answer.truth or answer.label['what'] == 'wrong_parameters' else ('match', 'wrong_parameters')
    return answer.verdict in (*answer.label['verdicts'], *quiet)


def exact(answer: Answer) -> bool:
    """Are just the true effects named?"""
    return sorted(str(finding['effect']) for finding in answer.findings) == sorted(answer.truth)


def _true(answer: Answer) -> bool:
    return answer.label['effects'][0]['effect'] in {n for f in answer.findings for n in named(f)}


def _count(inside: Sequence[bool]) -> Row:
    low, high = wilson(sum(inside), len(inside))
    return {
        'value': sum(inside) / len(inside) if inside else None, 'hits': sum(inside), 'n': len(inside),
        'low': low, 'high': high,
    }  # fmt: skip


def covered(answer: Answer) -> list[bool]:
    """For each parameter that truth and report share and the data fix: is it within its interval?"""
    found = []
    for name, entry in ((answer.report or {}).get('calibration') or {}).items():
        true = answer.label['parameters'].get(name)
        if true is None or not entry.get('fixed_by_data', True):
            continue
        if entry.get('low') is not None and entry.get('high') is not None:
            found.append(bool(entry['low'] <= true <= entry['high']))
    return found


def noise_ratios(answer: Answer) -> list[float]:
    """Of each channel: the reported standard deviation of its noise over the one that its instrument has."""
    stated, true = (answer.report or {}).get('noise') or {}, answer.label['noise']
    return [float(stated[name]) / true[name] for name in stated if name in true]


def _noise_held(answers: Sequence[Answer]) -> list[bool]:
    """Is it neither a misfit that was taken for noise nor less than there is? Where noise wanders slowly by far the
    most of it is the instrument's wander, and not asked."""
    asked = [a for a in answers if a.label['what'] != 'coloured_noise']
    return [LEAST_NOISE <= ratio <= MOST_NOISE for a in asked for ratio in noise_ratios(a)]


def flagged(answer: Answer) -> bool:
    """Does the report say that something remains which no name explains?"""
    return answer.verdict == 'unexplained' or bool((answer.report or {}).get('unexplained'))


def _flag_stage(answer: Answer) -> str:
    return str(((answer.report or {}).get('unexplained') or {}).get('stage'))


def both(answer: Answer) -> bool:
    """Is the pair reported as a pair?"""
    pair = {answer.label['effects'][0]['effect'], answer.label['partner']}
    return any(pair <= named(finding) for finding in answer.findings)


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
