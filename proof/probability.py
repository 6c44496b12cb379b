"""Are the stated probabilities right? And the weights that make them so.

python -m proof.probability RUN [RUN ...]                 a table of what was stated and how often it was right
python -m proof.probability RUN [RUN ...] --fit           the weights that these runs ask for, judged on cases left out
python -m proof.probability RUN [RUN ...] --rescale       those of the last fit, scaled and shifted as these runs ask
python -m proof.probability RUN [RUN ...] --fit --write   and written to config/policy.yaml (--rescale too)
python -m proof.probability RUN [RUN ...] --document      docs/probabilities.md and its figure
python -m proof.probability RUN [RUN ...] --restated ...  as the weights in force state what an earlier diagnosis found

A RUN is a folder of ./scripts/prove after its phases `generate` and `diagnose`. A finding is right where its effect is
among those that were concealed; a law without a name, where an effect that is not listed was concealed in its stage. A
verdict that names nothing is right where nothing was concealed that could be seen; `unexplained`, where anything was.
Weights are never fitted to a sealed suite. The suite `outside` is there for them: the diagnosis was tuned on the forms
of `development` and `varied`, so what it says of these is right more often than elsewhere.
"""

import argparse
import json
import re
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize

from proof.prove import DIAGNOSIS
from proof.rates import wilson
from proof.tool import REPORT
from tcp_muscle_ros.diagnosis.answer.probability import NAMELESS, TERMS, probability
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files import yaml_text
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.process.threads import one_of_linear_algebra
from tcp_muscle_ros.report.style import AFTER, OTHER, canvas
from tcp_muscle_ros.settings.policy import FITTED, ODDS, SHIPPED, shipped

ROOT = Path(__file__).parents[1]
PAGE, FIGURE = ROOT / 'docs' / 'probabilities.md', ROOT / 'docs' / 'images' / 'probabilities.png'
_RIDGE = 1.0  # of the weights but the constant: a prior of standard deviation 1
_PARTS = 10  # of the cases, each judged by the weights of the others
_BINS = 8  # of equal count
_NEAR = 1e-4  # to 0 and 1, for the log score
_THEN = '; scaled on '  # between what weights were fitted on and what they were scaled on


@dataclass(frozen=True)
class Judged:
    """One finding of one case: what was stated, what it was made from, and whether it is right."""

    case: str
    effect: str
    stated: float
    evidence: Mapping[str, float]
    right: bool


def answered(run: Path) -> Iterator[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """(label, report) of each case of a run that was diagnosed.

    Raises:
        BadInput: there are no labels.
    """
    labels = run / 'labels.json'
    if not labels.is_file():
        raise BadInput(f'{run}: no labels.json; expected a folder of ./scripts/prove')
    for label in json.loads(labels.read_text(encoding='utf-8'))['cases']:
        report = run / 'reports' / DIAGNOSIS / label['case'] / REPORT
        if report.is_file():
            yield label, json.loads(report.read_text(encoding='utf-8'))


def read_run(run: Path, doubtful: bool = False) -> list[Judged]:
    """All findings of a run; and what was found and not named (``doubtful``), without which weights would be fitted to
    what earlier weights let through.

    Raises:
        BadInput: there are no labels, no reports, or reports without evidence; or the suite is sealed and unopened.
    """
    found, reports = [], 0
    for label, report in answered(run):
        reports += 1
        judged = [*report['findings'], *(report.get('doubtful', ()) if doubtful else ())]
        found += [_judged(f'{run.name}/{label["case"]}', label, finding) for finding in judged]
    if not reports:
        raise BadInput(f'{run}: nothing was diagnosed; expected reports in reports/diagnosis (--phase diagnose)')
    return found


def _judged(case: str, label: Mapping[str, Any], finding: Mapping[str, Any]) -> Judged:
    evidence = finding.get('evidence')
    if not evidence:
        raise BadInput(f'{case}: its report does not say what its probabilities are made from; diagnose it again')
    concealed, named = {effect['effect'] for effect in label['effects']}, EFFECTS[finding['effect']]
    right = named.name in concealed
    if named.free is not None:
        right = label['kind'] == 'unlisted' and named.stage in {effect['stage'] for effect in label['effects']}
    return Judged(case, finding['effect'], float(finding['probability']), evidence, right)


def fitted(judged: Sequence[Judged]) -> dict[str, float]:
    """The weights that make what was found most probable, with a prior that keeps them small."""
    columns = np.array([[one.evidence[name] for name in TERMS] for one in judged])
    sign = np.where([one.right for one in judged], 1.0, -1.0)

    def loss(weights: np.ndarray) -> float:
        odds = columns @ weights
        return float(np.sum(np.logaddexp(0.0, -sign * odds)) + 0.5 * _RIDGE * np.sum(weights[1:] ** 2))

    best = minimize(loss, np.zeros(len(TERMS)), method='L-BFGS-B').x
    return {name: round(float(weight), 2) for name, weight in zip(TERMS, best, strict=True)}


def rescaled(judged: Sequence[Judged], before: Mapping[str, float]) -> dict[str, float]:
    """The weights ``before`` with their log odds scaled and shifted as these findings ask (Platt 1999).

    Two numbers, for a suite has too few findings for all the weights: fitted to the same ones these foretell findings
    that were left out worse than a constant does.
    """
    odds = np.array([sum(before[name] * one.evidence[name] for name in TERMS) for one in judged])
    sign = np.where([one.right for one in judged], 1.0, -1.0)

    def loss(change: np.ndarray) -> float:
        return float(np.sum(np.logaddexp(0.0, -sign * (change[0] * odds + change[1])))) + 0.5 * (change[0] - 1.0) ** 2

    scale, shift = minimize(loss, np.array([1.0, 0.0]), method='L-BFGS-B').x
    return {name: round(float(scale * before[name] + shift * (name == 'constant')), 2) for name in TERMS}


def verdicts(runs: Sequence[Path]) -> dict[str, tuple[int, int]]:
    """Of each verdict that names nothing: how often it was right, and how often it was given."""
    given = {name: [0, 0] for name in NAMELESS}
    for label, report in (one for run in runs for one in answered(run)):
        if (verdict := str(report['verdict'])) in given:
            seen = [effect['visibility']['detectable'] for effect in label['effects']]
            given[verdict][0] += bool(seen) if verdict == 'unexplained' else not any(seen)
            given[verdict][1] += 1
    return {name: (right, count) for name, (right, count) in given.items()}


def odds_of(counts: Mapping[str, tuple[int, int]]) -> dict[str, float]:
    """Their log odds by the rule of succession (Laplace), which no count makes certain."""
    return {name: round(float(np.log((right + 1) / (n - right + 1))), 2) for name, (right, n) in counts.items()}


Weigh = Callable[[Sequence[Judged]], dict[str, float]]


def left_out(judged: Sequence[Judged], weigh: Weigh = fitted, seed: int = 0) -> list[float]:
    """The probability of each finding by weights that were fitted to other cases."""
    cases = sorted({one.case for one in judged})
    parts = np.array_split(np.random.default_rng(seed).permutation(len(cases)), _PARTS)
    owner = {cases[k]: part for part, members in enumerate(parts) for k in members}
    weights = [weigh([one for one in judged if owner[one.case] != part]) for part in range(_PARTS)]
    return [probability(one.evidence, weights[owner[one.case]]) for one in judged]


@dataclass(frozen=True)
class Bin:
    """Findings of about one probability: its mean, how many there are, and how many are right."""

    stated: float
    count: int
    right: int


def bins(stated: Sequence[float], right: Sequence[bool]) -> list[Bin]:
    """Of equal count, by what was stated."""
    order = np.argsort(stated, kind='stable')
    parts = [part for part in np.array_split(order, min(_BINS, len(order))) if part.size]
    return [
        Bin(float(np.mean(np.array(stated)[part])), int(part.size), int(np.array(right)[part].sum())) for part in parts
    ]


def scores(stated: Sequence[float], right: Sequence[bool]) -> dict[str, float]:
    """What tells whether probabilities are right: see ``text`` for what each means."""
    p, true = np.array(stated), np.array(right, dtype=bool)
    rate, sure = float(true.mean()), p >= 0.99
    return {
        'findings': float(p.size),
        'right': rate,
        'calibration error': sum(b.count * abs(b.stated - b.right / b.count) for b in bins(stated, right)) / p.size,
        'log score': _log_score(p, true),
        'log score of a constant': _log_score(np.full(p.size, rate), true),
        'at 0.99 or above': float(sure.sum()),
        'false of these': float((~true[sure]).sum()),
        'right ones at 0.95 or above': float(np.mean(p[true] >= 0.95)) if true.any() else float('nan'),
    }


def _log_score(p: np.ndarray, true: np.ndarray) -> float:
    p = np.clip(p, _NEAR, 1.0 - _NEAR)
    return float(-np.mean(np.where(true, np.log(p), np.log(1.0 - p))))


def verdict_table(counts: Mapping[str, tuple[int, int]]) -> str:
    """How often verdicts that name nothing were right, in Markdown."""
    lines = ['| verdict | given | right | share | 95 % interval |', '|---|---|---|---|---|']
    for name, (right, n) in counts.items():
        low, high = wilson(right, n)
        lines.append(f'| `{name}` | {n} | {right} | {right / max(n, 1):.2f} | {low:.2f} to {high:.2f} |')
    return '\n'.join(lines)


def text(stated: Sequence[float], right: Sequence[bool]) -> str:
    """Both tables, in Markdown."""
    lines = ['| stated (mean) | findings | right | share | 95 % interval |', '|---|---|---|---|---|']
    for b in bins(stated, right):
        low, high = wilson(b.right, b.count)
        lines.append(f'| {b.stated:.2f} | {b.count} | {b.right} | {b.right / b.count:.2f} | {low:.2f} to {high:.2f} |')
    lines += ['', '| score | value |', '|---|---|']
    return '\n'.join([*lines, *(f'| {name} | {value:.3g} |' for name, value in scores(stated, right).items())])


def draw(stated: Sequence[float], right: Sequence[bool], path: Path) -> None:
    """The reliability diagram: how often findings were right, over what was stated."""
    figure, (axes,) = canvas(1, width=6.0, height=5.0)
    found = bins(stated, right)
    x, y = [b.stated for b in found], [b.right / b.count for b in found]
    ends = [wilson(b.right, b.count) for b in found]
    below, above = ([abs(y[k] - pair[side]) for k, pair in enumerate(ends)] for side in (0, 1))
    axes.plot([0, 1], [0, 1], color=OTHER, lw=1.0, label='as stated')
    axes.errorbar(x, y, [below, above], fmt='o', color=AFTER, capsize=3, label='findings, with 95 % intervals')
    axes.set(xlim=(0, 1.02), ylim=(0, 1.02), xlabel='probability stated in the report', ylabel='share that is right')
    axes.legend(loc='upper left', frameon=False)
    figure.savefig(path, dpi=110)


def last_fit(path: Path) -> tuple[dict[str, float], str]:
    """The weights of the policy's file before they were scaled, and what they were fitted on."""
    content: Any = yaml_text.parse(path.read_text(encoding='utf-8'))
    return content[ODDS][FITTED], content[ODDS]['set_by'].split(_THEN)[0]


def told(runs: Sequence[Path]) -> str:
    """The runs, with how many of their cases were diagnosed, and the day."""
    each = []
    for run in runs:
        cases = json.loads((run / 'labels.json').read_text(encoding='utf-8'))['cases']
        each.append(f'{run.name} ({sum(1 for _ in answered(run))} of {len(cases)} cases)')
    return f'{", ".join(each)}; ./scripts/calibrate, {datetime.now(timezone.utc).date().isoformat()}'


def write_weights(weights: Mapping[str, float], fit: Mapping[str, float], by: str, path: Path) -> None:
    """The weights in the policy's file, with those of the ``fit`` that they were scaled from, and what they are set
    ``by``. They are its last entry; all else stays as it is written."""
    value, before = (''.join(f'    {name}: {weight}\n' for name, weight in of.items()) for of in (weights, fit))
    why = textwrap.fill(by, 118, initial_indent='    ', subsequent_indent='    ', break_on_hyphens=False)
    new = re.sub(
        rf'(?<=\n{ODDS}:\n  value:\n)(?:    .*\n)+((?:  .*\n)*?)  set_by: >-\n(?:    .*\n)+  {FITTED}:\n(?:    .*\n)+$',
        lambda match: f'{value}{match.group(1)}  set_by: >-\n{why}\n  {FITTED}:\n{before}',
        path.read_text(encoding='utf-8'),
    )
    path.write_text(new, encoding='utf-8')


def document(
    judged: Sequence[Judged], runs: Sequence[str], counts: Mapping[str, tuple[int, int]], restated: bool = False
) -> str:
    """The page."""
    stated, right = [one.stated for one in judged], [one.right for one in judged]
    wrong = [one for one in judged if not one.right and one.stated >= 0.9]
    named = ', '.join(f'{one.effect} {one.stated:.2f}' for one in sorted(wrong, key=lambda one: -one.stated)) or 'none'
    today = datetime.now(timezone.utc).date().isoformat()
    return _PAGE.format(
        runs=' and '.join(runs),
        today=today,
        table=text(stated, right),
        verdicts=verdict_table(counts),
        wrong=named,
        restated=' --restated' * restated,
        command=' '.join(f'build/proof/{run}' for run in runs),
    )


_PAGE = """\
# Are the stated probabilities right?

Each finding states a probability: that the effect is there. It is computed from how far the other candidates are
behind, how far the strength is from zero, how much of the misfit the effect removes, whether a parameter is at the end
of its range, and how many recordings there are. The weight of each was fitted to muscles whose physics is known, and
scaled on muscles with forms of their physics on which nothing was tuned (`config/policy.yaml`, entry `odds`;
`./scripts/calibrate`). The runs below are of other muscles, which were not used for either. They state what the
weights said when they were diagnosed; [the history](proof_history.md) says when these were scaled. If the
probabilities are right, nine of ten findings with 0.9 are right.

![Share of findings that are right, over the probability stated](images/probabilities.png)

Runs: {runs}, {today}. In bins of equal count:

{table}

The calibration error is the mean difference between the stated probability and the share that was right. A smaller log
score is better. Wrong at 0.9 or above: {wrong}.

A finding is right where its effect was concealed in the muscle. A law without a name is right where an effect that is
not listed was concealed in its stage.

A verdict that names something is as probable as that one of its findings is there. One that names nothing states how
often such a verdict was right on the muscles that the weights were scaled on. `match` and `wrong_parameters` are right
where nothing was concealed that could be seen; `unexplained`, where anything was. On the runs above:

{verdicts}

Made by `python -m proof.probability {command}{restated} --document`, from the folders of `./scripts/prove`.
"""


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.probability', description=__doc__.splitlines()[0])
    parser.add_argument('runs', nargs='+', type=Path, help='folders of ./scripts/prove')
    parser.add_argument('--fit', action='store_true', help='weights for these runs, judged on cases left out')
    parser.add_argument('--rescale', action='store_true', help='the weights of the last fit, scaled and shifted')
    parser.add_argument('--write', action='store_true', help='with --fit or --rescale: to config/policy.yaml')
    parser.add_argument('--restated', action='store_true', help='by the weights in force, from the evidence')
    parser.add_argument('--document', action='store_true', help='docs/probabilities.md and its figure')
    chosen = parser.parse_args(arguments)
    one_of_linear_algebra()
    runs = [run.name for run in chosen.runs]
    fits = chosen.fit or chosen.rescale
    fit, fitted_on = last_fit(SHIPPED)
    weigh: Weigh = partial(rescaled, before=fit) if chosen.rescale else fitted
    try:
        if fits and any(name.startswith('sealed') for name in runs):
            raise BadInput('--fit: weights are never fitted to a sealed suite; expected outside, development or varied')
        judged = [one for run in chosen.runs for one in read_run(run, doubtful=fits)]
    except BadInput as mistake:
        print(f'proof.probability: {mistake}', file=sys.stderr)
        return 2
    if chosen.restated:
        judged = [replace(one, stated=round(probability(one.evidence, shipped().odds), 9)) for one in judged]
    right, counts = [one.right for one in judged], verdicts(chosen.runs)
    print(text(left_out(judged, weigh) if fits else [one.stated for one in judged], right))
    print('\n' + verdict_table(counts))
    if fits:
        weights = weigh(judged) | odds_of(counts)
        print('\n' + '\n'.join(f'{name}: {weight}' for name, weight in weights.items()))
        if chosen.write:
            by = f'{fitted_on}{_THEN}' if chosen.rescale else 'fitted on '
            fit = fit if chosen.rescale else {name: weights[name] for name in TERMS}
            write_weights(weights, fit, by + told(chosen.runs), SHIPPED)
    if chosen.document:
        PAGE.write_text(document(judged, runs, counts, chosen.restated), encoding='utf-8')
        draw([one.stated for one in judged], right, FIGURE)
    return 0


if __name__ == '__main__':
    sys.exit(main())
