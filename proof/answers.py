"""One case of a suite: its label, what was reported for it, and what of that is right."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

REACH = 1.1  # the recalibrated error must be so much larger than the oracle's for a gap to be there
NO_LIMIT = {'recalibration': None, 'oracle': None}
# What shares a parameter with another one, whose truth is then not what the label has. The first two are concealed: the
# generator takes theirs out of the muscle's hA. The others are laws without a name: each is fixed but for a constant.
SHARING = {
    'radiation': {'hA'}, 'touching_rail': {'hA'},
    'free_conductance': {'hA'}, 'free_surroundings': {'hA'}, 'free_capacity': {'C'}, 'free_resistance': {'R0', 'a_R'},
    'free_stiffness': {'k0'}, 'free_stroke': {'H0', 'B'}, 'free_slow_state': {'H0', 'B'},
}  # fmt: skip


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


def reported(answers: Sequence[Answer]) -> list[Answer]:
    """Those with a report: where restraint is asked, silence is no proof of it."""
    return [answer for answer in answers if answer.report is not None]


def in_first_set(answer: Answer) -> bool:
    """Is the one true effect among those that the first finding stands for?"""
    return bool(answer.findings) and answer.truth[0] in named(answer.findings[0])


def left_over(answer: Answer) -> float | None:
    """The held-out error as a share of the recalibrated one, where there is a gap; without an answer all is left."""
    found, after = gap(answer), held_out_error(answer, answer.held_out)
    if not found:
        return None
    return 1.0 if after is None else after / found[0]


def worse(answer: Answer) -> bool:
    """Is the muscle further from unseen recordings than before?"""
    before, after = (held_out_error(answer, e) for e in (answer.limits['recalibration'], answer.held_out))
    return bool(before and after and after > REACH * before)


def right(answer: Answer) -> bool:
    """Is the verdict one of those that hold? A fault that leaves no trace may be passed over."""
    quiet = () if answer.truth or answer.label['what'] == 'wrong_parameters' else ('match', 'wrong_parameters')
    return answer.verdict in (*answer.label['verdicts'], *quiet)


def exact(answer: Answer) -> bool:
    """Are just the true effects named?"""
    return sorted(str(finding['effect']) for finding in answer.findings) == sorted(answer.truth)


def covered(answer: Answer) -> list[bool]:
    """For each parameter that truth and report share and the data fix: is it within its interval?"""
    found, effects = [], [*answer.label['effects'], *(f for f in answer.findings if f.get('unlisted'))]
    other = set().union(*(SHARING.get(e['effect'], set()) for e in effects))  # means another thing there than here
    for name, entry in ((answer.report or {}).get('calibration') or {}).items():
        true = answer.label['parameters'].get(name)
        if true is None or name in other or not entry.get('fixed_by_data', True):
            continue
        if entry.get('low') is not None and entry.get('high') is not None:
            found.append(bool(entry['low'] <= true <= entry['high']))
    return found


def noise_ratios(answer: Answer) -> list[float]:
    """Of each channel: the reported standard deviation of its noise over the one that its instrument has."""
    stated, true = (answer.report or {}).get('noise') or {}, answer.label['noise']
    return [float(stated[name]) / true[name] for name in stated if name in true]


def flagged(answer: Answer) -> bool:
    """Does the report say that something remains which no name explains?"""
    return answer.verdict == 'unexplained' or bool((answer.report or {}).get('unexplained'))


def both(answer: Answer) -> bool:
    """Is the pair reported as a pair?"""
    pair = {answer.label['effects'][0]['effect'], answer.label['partner']}
    return any(pair <= named(finding) for finding in answer.findings)
