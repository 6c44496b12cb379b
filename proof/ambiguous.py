"""Do the proposed experiments decide? Each is run on the truth of its case, and the case diagnosed again with it.

Two questions are asked. Of the cases whose pair truly cannot be told apart, whose report has the true effect in a set
of several and proposes an experiment: is it resolved, so that the true effect is named first and its partner is no
longer in the set? And of all cases in which an experiment is proposed: does it tell the two effects apart as often as
it promises?
"""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from proof.answers import Answer, named
from proof.extend import extend
from proof.rates import wilson
from proof.score import ALIKE

REPORT, PROTOCOL = 'report.json', 'next_protocol.yaml'


def asked(answer: Answer) -> bool:
    """Is there a question that the proposed experiment can settle?"""
    label = answer.label
    if label['kind'] != 'ambiguous' or not answer.truth or answer.proposal is None:
        return False
    alike = label['effects'][0]['visibility'].get('likeness', 0.0) >= ALIKE
    sets = [named(finding) for finding in answer.findings]
    return alike and any(answer.truth[0] in s and len(s) > 1 for s in sets)


def add_recording(case: str, cases: Path, reports: Path, labels: Path, output: Path) -> Path:
    """Copy a case and record the experiment that its report proposes; the new folder."""
    folder = output / case
    if folder.is_dir():
        shutil.rmtree(folder)
    shutil.copytree(cases / case, folder)
    extend(output, case, reports / case / PROTOCOL, labels)
    return folder


def resolved(answer: Answer, after: dict[str, Any] | None) -> bool:
    """Is the true effect named first now, and not together with its partner?"""
    findings = (after or {}).get('findings') or []
    if not findings or findings[0]['effect'] != answer.truth[0]:
        return False
    return answer.label['partner'] not in named(findings[0])


def told_apart(pair: Sequence[str], after: dict[str, Any] | None) -> bool:
    """Is no finding left that could be either? A case that was not answered any more is not decided."""
    return after is not None and not any(set(pair) <= named(finding) for finding in after.get('findings') or [])


def promises(answers: Sequence[Answer], reports: Path) -> list[dict[str, Any]]:
    """Of each proposed experiment, what it promised and what it did: whether the two it should tell apart are told
    apart, whether one of them is the muscle's, and if so whether that one is left."""
    rows = []
    for answer in answers:
        if answer.proposal is None:
            continue
        pair, after = list(answer.proposal['separates']), _after(answer, reports)
        told = told_apart(pair, after)
        true = [effect for effect in pair if effect in answer.truth]
        left = set().union(*(named(finding) for finding in (after or {}).get('findings') or []))
        rows.append({
            'case': answer.label['case'],
            'separates': pair,
            'promised': float(answer.proposal['power']),
            'told_apart': told,
            'concealed': true,
            'right': bool(true) and told and set(true) <= left,
        })  # fmt: skip
    return rows


def _after(answer: Answer, reports: Path) -> dict[str, Any] | None:
    """The report with the experiment."""
    path = reports / answer.label['case'] / REPORT
    return dict(json.loads(path.read_text(encoding='utf-8'))) if path.is_file() else None


def summary(answers: list[Answer], reports: Path) -> dict[str, Any]:
    """The rate of decisions, and what each case said before and after."""
    rows = []
    for answer in answers:
        name = answer.label['case']
        after, proposal = _after(answer, reports), answer.proposal or {}
        rows.append({
            'case': name,
            'effect': answer.truth[0],
            'partner': answer.label['partner'],
            'before': [sorted(named(f)) for f in answer.findings],
            'experiment': proposal.get('name'),
            'separates': proposal.get('separates'),
            'power': proposal.get('power'),
            'after': [[f['effect'], *f['indistinguishable_from']] for f in (after or {}).get('findings') or []],
            'resolved': resolved(answer, after),
        })  # fmt: skip
    hits, n = sum(row['resolved'] for row in rows), len(rows)
    low, high = wilson(hits, n)
    rate = {'value': hits / n if n else None, 'hits': hits, 'n': n, 'low': low, 'high': high, 'aim': '>= 90 %'}
    return {'score': 'proposed experiments that decide', **rate, 'cases': rows}
