"""What a diagnosis has to be better than: other ways to answer the same cases, scored by the same proof.score.

Each begins from the same calibrated muscle, at as many samples a channel as the diagnosis has. `recalibration` stops
there; `whiteness_bic` adds effects of the catalogue while a criterion for white noise falls; `sparse_regression` fits a
library of terms to the residual; `black_box` corrects the outputs freely and names nothing; `oracle` refits the true
effects, and alone reads the labels.

python -m proof.alternatives DIR REPORTS --labels LABELS [--held-out DIR2] [--only NAME] [--samples N]
"""

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from proof.tool import (
    HELD_OUT,
    QUICK,
    REPORT,
    Case,
    Replayed,
    errors,
    experiments_of,
    guarded,
    replay,
    write_muscle,
)
from tcp_muscle_ros.diagnosis.answer.improved import physics_only
from tcp_muscle_ros.diagnosis.fitting.calibration import left_over_noise
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.model.tcp_muscle import STROKE
from tcp_muscle_ros.diagnosis.observation.observe import MOST
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, Screen
from tcp_muscle_ros.diagnosis.search.refitting import grow
from tcp_muscle_ros.muscle import EFFECTS, Parameters
from tcp_muscle_ros.report.report_json import IMPROVED

# By channel, what is to be added to the prediction of a free run (SI).
Correction = Callable[[Replayed], dict[str, np.ndarray]]
Label = dict[str, Any]


@dataclass(frozen=True)
class Outcome:
    """What an alternative ends with: what it names, strongest first, the muscle, and what it adds to its outputs."""

    named: tuple[str, ...]
    muscle: Parameters
    correction: Correction | None = None
    unexplained: bool = False

    def report(self) -> dict[str, Any]:
        """In the schema of the diagnosis, as far as the scores read it."""
        findings = [{'effect': n, 'stage': EFFECTS[n].stage, 'indistinguishable_from': []} for n in self.named]
        stages = {EFFECTS[n].stage for n in self.named}
        verdict = 'unexplained' if self.unexplained else 'wrong_parameters'
        if stages:
            verdict = 'missing_physics' if stages != {'sensor'} else 'sensor_or_setup'
        return {
            'schema': 'tcp_muscle_ros/diagnosis-2',
            'verdict': verdict,
            'findings': sorted(findings, key=lambda f: f['stage'] == 'sensor'),
            'unexplained': {'stage': None} if self.unexplained else None,
        }


def recalibration(case: Case, label: Label) -> Outcome:
    """The paper's parameters and nothing else."""
    return Outcome((), case.calibration.parameters)


def oracle(case: Case, label: Label) -> Outcome:
    """The true effects in the catalogue's form, refitted; those that no catalogue holds stay out."""
    fitted = case.calibration.fit
    true = [e['effect'] for e in label['effects'] if e['effect'] in EFFECTS]
    for effect in true:
        fitted = grow(fitted, start_of(fitted, effect), rounds=15)
    for _ in range(2 if true else 0):
        fitted = fit(fitted.problem.with_noise(left_over_noise(fitted)), fitted.z, rounds=10, tolerance=1e-5)
    return Outcome(tuple(true), physics_only(fitted.muscle))


def start_of(fitted: Fit, effect: str) -> Candidate:
    """Where to start the refit of an effect: the best of its variants in linear approximation."""
    found = Screen.of(fitted).candidates(effect)
    return max(found, key=lambda candidate: candidate.worth(fitted.problem.policy.per_parameter))


def whiteness_bic(case: Case, label: Label) -> Outcome:
    """See proof.whiteness."""
    from proof.whiteness import select

    named, fitted, white = select(case)
    return Outcome(named, physics_only(fitted.muscle), unexplained=not white)


def sparse_regression(case: Case, label: Label) -> Outcome:
    """See proof.sparse."""
    from proof.sparse import regress

    named, correction = regress(case)
    return Outcome(named, case.calibration.parameters, correction)


def black_box(case: Case, label: Label) -> Outcome:
    """See proof.black_box."""
    from proof.black_box import learn

    return Outcome((), case.calibration.parameters, learn(case))


RUNNERS: dict[str, Callable[[Case, Label], Outcome]] = {
    function.__name__: function for function in (oracle, recalibration, whiteness_bic, sparse_regression, black_box)
}  # the limits of the held-out gap first


def corrected(replayed: Replayed, correction: Correction) -> Replayed:
    """The free run with a correction added; a zero that floats is found anew."""
    added = correction(replayed)
    left = {}
    for name, was in replayed.left.items():
        now = was - added.get(name, 0.0)
        left[name] = now - now.mean() if name in STROKE else now
    return Replayed(replayed.experiment, replayed.outputs, left)


def answered(out: Path, most: int) -> bool:
    """Whether an answer is there, of so many samples as all methods of this run have."""
    report = out / REPORT
    return report.is_file() and json.loads(report.read_text(encoding='utf-8')).get('samples') == most


def run(
    folder: Path,
    reports: Path,
    label: Label,
    held_out: Path | None = None,
    names: Sequence[str] = tuple(RUNNERS),
    most: int = MOST,
) -> str | None:
    """Run alternatives on one case: REPORTS/<name>/<case>/{report.json, improved.yaml, held_out.json}.

    One that fails keeps no other from being run. What failed, in one line; None where nothing did.
    """
    case = Case(folder, most)
    unseen = cache(lambda: experiments_of(held_out / case.name, case.nominal, QUICK) if held_out else [])

    def answer(name: str, out: Path) -> None:
        out.mkdir(parents=True, exist_ok=True)
        outcome = RUNNERS[name](case, label)
        write_muscle(out / IMPROVED, outcome.muscle)
        runs = [replay(experiment, outcome.muscle, case.experiments) for experiment in unseen()]
        if outcome.correction:
            runs = [corrected(one, outcome.correction) for one in runs]
        if runs:
            (out / HELD_OUT).write_text(json.dumps(errors(runs)) + '\n', encoding='utf-8')
        report = outcome.report() | {'samples': most}
        (out / REPORT).write_text(json.dumps(report, indent=1) + '\n', encoding='utf-8')

    folders = {name: reports / name / case.name for name in names}
    left = {name: out for name, out in folders.items() if not answered(out, most)}
    found = [guarded(f'{case.name}, {name}', out, partial(answer, name, out)) for name, out in left.items()]
    return '; '.join(problem for problem in found if problem) or None


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.alternatives', description=__doc__.splitlines()[0])
    parser.add_argument('directory', type=Path)
    parser.add_argument('reports', type=Path)
    parser.add_argument('--labels', type=Path, required=True)
    parser.add_argument('--held-out', type=Path)
    parser.add_argument('--only', choices=list(RUNNERS), action='append')
    parser.add_argument('--samples', type=int, default=MOST, help='observations a channel (%(default)s)')
    chosen = parser.parse_args(arguments)
    for label in json.loads(chosen.labels.read_text(encoding='utf-8'))['cases']:
        names = chosen.only or tuple(RUNNERS)
        problem = run(chosen.directory / label['case'], chosen.reports, label, chosen.held_out, names, chosen.samples)
        if problem:
            print(problem, file=sys.stderr)
    return 0


if __name__ == '__main__':
    sys.exit(main())
