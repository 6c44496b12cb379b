"""What the evidence of a model tells beside forward selection: a study of single effects and of muscles that lack none.

python -m proof.evidence RUN [RUN ...]             how often the true effect is first, by evidence and by selection
python -m proof.evidence RUN [RUN ...] --document  the table to docs/evidence.md

A RUN is a folder of ./scripts/prove after its phases `generate` and `diagnose`. For each case with one effect or none,
the candidates of the first step are refitted under one noise. Their evidence is that of Laplace: the likelihood at the
best fit, times the share of the prior's volume that the data leave. What is done stands in RUN/evidence and is not done
again.
"""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np

from proof.probability import answered
from proof.rates import wilson
from proof.tool import Case, bags
from tcp_muscle_ros.diagnosis.diagnose import skipped
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.room import as_well_as_read
from tcp_muscle_ros.diagnosis.fitting.weighing import robust_noise, settle_noise, structures, with_noise
from tcp_muscle_ros.diagnosis.observation.observe import MOST, prepared
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import LISTED
from tcp_muscle_ros.process.threads import one_of_linear_algebra
from tcp_muscle_ros.recording.bag import read_bag

PAGE = Path(__file__).parents[1] / 'docs' / 'evidence.md'
KINDS = ('single', 'null')
# What the evidence must do to take the place of forward selection: row of the table -> aim.
AIMS = {
    'the true effect is first, by evidence': 0.90,
    'the true effect is ahead of none, by evidence': 0.98,
    'none is ahead of every effect where none is missing, by evidence': 0.98,
}


def log_evidence(fitted: Fit) -> float:
    """Of a model, but for a constant of the data: minus half the objective and half the log of the volume that is left
    of the prior's (Laplace; MacKay 2003, chapter 28)."""
    spreads = fitted.problem.spreads()
    left = (fitted.jacobian.T @ fitted.jacobian) * np.outer(spreads, spreads) + np.eye(spreads.size)
    return float(-0.5 * fitted.objective - 0.5 * np.linalg.slogdet(left)[1])


def contest(folder: Path) -> dict[str, Any]:
    """The log evidence of each candidate of the first step, by effect, and without any (``none``)."""
    nominal = Case(folder).file
    _, experiments = prepared([read_bag(str(path)) for path in bags(folder)], nominal, MOST)
    fitted = as_well_as_read(in_turn(calibrate(experiments, nominal.parameters).fit))
    base, _ = settle_noise(fitted)
    ranked, _ = screen(base, [e for e in LISTED if e not in skipped(experiments)])
    rivals = rivals_for(base, ranked, None) if ranked else []
    if not rivals:
        return {'none': log_evidence(base), 'effects': {}}
    noise = robust_noise(rivals[0].fit, structures(rivals[0].fit))
    effects = {r.effect: log_evidence(with_noise(r.fit, noise)) for r in rivals}
    return {'none': log_evidence(with_noise(base, noise)), 'effects': effects}


def contests(run: Path) -> list[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """(label, contest) of each case with one effect that can be seen, or none.

    Raises:
        BadInput: no labels, or no reports.
    """
    found = []
    wanted = [
        (label, report['findings'])
        for label, report in answered(run)
        if label['kind'] in KINDS and all(effect['visibility']['detectable'] for effect in label['effects'])
    ]
    for k, (label, findings) in enumerate(wanted):
        path = run / 'evidence' / f'{label["case"]}.json'
        if not path.is_file():
            print(f'\r{run.name}: {k + 1} of {len(wanted)} ', end='', file=sys.stderr, flush=True)
            path.parent.mkdir(exist_ok=True)
            path.write_text(json.dumps(contest(run / 'cases' / label['case'])) + '\n', encoding='utf-8')
        named = [finding['effect'] for finding in findings]
        found.append((label, json.loads(path.read_text(encoding='utf-8')) | {'named': named}))
    return found


def rates(found: Sequence[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> dict[str, list[bool]]:
    """What held in each case, by row of the table."""
    rows: dict[str, list[bool]] = {}
    for label, one in found:
        effects, none = one['effects'], one['none']
        if label['kind'] == 'null':
            ahead = all(none > value for value in effects.values())
            rows.setdefault('none is ahead of every effect where none is missing, by evidence', []).append(ahead)
            rows.setdefault('nothing is named where none is missing, by selection', []).append(not one['named'])
            continue
        (true,) = [effect['effect'] for effect in label['effects']]
        first = max(effects, key=lambda effect: effects[effect], default='')
        rows.setdefault('the true effect is among those refitted', []).append(true in effects)
        rows.setdefault('the true effect is first, by evidence', []).append(first == true)
        rows.setdefault('the true effect is ahead of none, by evidence', []).append(effects.get(true, -np.inf) > none)
        rows.setdefault('the true effect is first, by selection', []).append(one['named'][:1] == [true])
    return rows


def text(rows: Mapping[str, Sequence[bool]]) -> str:
    """The table, in Markdown."""
    lines = ['| what | cases | share | 95 % interval | aim |', '|---|---|---|---|---|']
    for name in sorted(rows):
        hits, n = sum(rows[name]), len(rows[name])
        low, high = wilson(hits, n)
        aim = f'{AIMS[name]:.2f}' if name in AIMS else ''
        lines.append(f'| {name} | {n} | {hits / n:.2f} | {low:.2f} to {high:.2f} | {aim} |')
    return '\n'.join(lines)


_PAGE = """\
# Forward selection compared with evidence

A diagnosis names effects by forward selection: the candidate that fits best is compared with the others and tested on
unseen data, by the rules of `config/policy.yaml`. The alternative is to compare models by their evidence: the
probability of the recordings under a model, averaged over the prior of its parameters. The table compares both on the
same cases, each with one concealed effect or none. The candidates are those of the first step of the search.

{table}

Evidence uses no unseen data and no rule for errors of form. It assumes that one of the models is exactly true, and none
is: the concealed effects have other forms than the listed ones. So it finds an effect where none is missing more often
than selection does, and more often prefers a wrong effect that is flexible enough to fit. The diagnosis therefore uses
forward selection.

Runs: {runs}, {today}. Made by `python -m proof.evidence {command} --document`.
"""


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.evidence', description=__doc__.splitlines()[0])
    parser.add_argument('runs', nargs='+', type=Path, help='folders of ./scripts/prove')
    parser.add_argument('--document', action='store_true', help='docs/evidence.md')
    chosen = parser.parse_args(arguments)
    one_of_linear_algebra()
    try:
        table = text(rates([one for run in chosen.runs for one in contests(run)]))
    except BadInput as mistake:
        print(f'proof.evidence: {mistake}', file=sys.stderr)
        return 2
    print(table)
    if chosen.document:
        runs, today = [run.name for run in chosen.runs], datetime.now(timezone.utc).date().isoformat()
        page = _PAGE.format(table=table, runs=' and '.join(runs), today=today, command=' '.join(map(str, chosen.runs)))
        PAGE.write_text(page, encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
