"""What is said of physics that no catalogue holds: alone, beside a listed effect, and where there is none.

python -m proof.nameless --output DIR [--alone 120 --beside 60 --listed 60] [--document docs/nameless_table.md]

``alone``: muscles with one unlisted effect, of all forms that the generator has. ``beside``: one unlisted and one
listed effect. ``listed``: one listed effect in the sealed suite's form, which no law without a name should replace.
Each is recorded, diagnosed, and its muscle handed on to a recording that no method was given, as in proof.prove;
beside it stand the recalibrated muscle and the best listed effects (``whiteness_bic``). Goes on case by case where it
was stopped.
"""

import argparse
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from proof.answers import Answer, flagged, held_out_error, named, read_json, reported
from proof.cases import EXPRESSIBLE, PHYSICS, UNLISTED, in_turns
from proof.generate import generate
from proof.prove import DIAGNOSIS, Proof
from proof.rates import told
from proof.study import LEFT, REACH, add_page_arguments, made_by, say
from proof.tool import HELD_OUT, REPORT
from tcp_muscle_ros.diagnosis.observation.observe import MOST
from tcp_muscle_ros.process.threads import one_of_linear_algebra

ALONE, BESIDE, LISTED = 'alone', 'beside', 'listed'
GROUPS = (ALONE, BESIDE, LISTED)
COUNTS = {ALONE: 120, BESIDE: 60, LISTED: 60}
SUITE = {ALONE: 'varied', BESIDE: 'varied', LISTED: 'sealed'}  # of the forms that listed effects take
OLD = tuple(name for pool in UNLISTED[:3] for name in pool)  # the fourth is for the weights of probabilities alone
# Those that one continuous law at one stage, of one of the drivers that the package's free laws know, can be.
CONTINUOUS = (*EXPRESSIBLE, 'boiling_film', 'cubic_softening', 'slow_stroke', 'touching_rail')
OTHERS = ('recalibration', 'whiteness_bic')


def wanted(group: str, count: int, seed: int) -> list[tuple[str, str]]:
    """(kind, what) of each case of a group; every unlisted effect, and every listed one, as often as any other."""
    rng = np.random.default_rng([seed, GROUPS.index(group)])
    if group == ALONE:
        return [('unlisted', name) for name in in_turns(rng, (*OLD, *EXPRESSIBLE), count)]
    listed = in_turns(rng, PHYSICS, count)
    if group == LISTED:
        return [('single', name) for name in listed]
    return [('beside', f'{one}+{other}') for one, other in zip(listed, in_turns(rng, CONTINUOUS, count), strict=True)]


class Group:
    """The cases of one group in a folder."""

    def __init__(self, folder: Path, group: str, count: int, seed: int, jobs: int) -> None:
        self.group, self.count, self.seed = group, count, seed
        # No run for the record, whatever forms it takes: it is logged nowhere.
        self.proof = Proof('varied', count, seed, folder / group, jobs, MOST)

    def run(self) -> None:
        """Record, diagnose and compare what is not done."""
        self._write()
        self.proof.diagnose()
        self.proof.alternatives(OTHERS)

    def _write(self) -> None:
        proof, suite = self.proof, SUITE[self.group]
        if (proof.bags / 'SEAL').is_file():
            return
        for begun in (proof.bags, proof.unseen):  # and not finished: no seal
            shutil.rmtree(begun, ignore_errors=True)
        those = wanted(self.group, self.count, self.seed)
        generate(suite, self.count, self.seed, proof.bags, proof.labels, proof.jobs, proof.unseen, wanted=those)

    def answers(self) -> list[Answer]:
        """Those of the cases that are diagnosed and compared, or failed, of effects that can be seen."""
        suite, found, reports = read_json(self.proof.labels), [], self.proof.reports
        for label in suite['cases'][: self.proof.answered(DIAGNOSIS, *OTHERS)] if suite else ():
            errors = {name: read_json(reports / name / label['case'] / HELD_OUT) for name in (DIAGNOSIS, *OTHERS)}
            report = read_json(reports / DIAGNOSIS / label['case'] / REPORT)
            answer = Answer(label, report, errors[DIAGNOSIS], errors)
            if len(answer.truth) == len(label['effects']):
                found.append(answer)
        return found


def without_name(answer: Answer) -> list[dict[str, Any]]:
    """The findings that are laws without a name."""
    return [finding for finding in answer.findings if finding.get('unlisted')]


def nameless(answer: Answer) -> bool:
    """Is a law without a name among the findings?"""
    return bool(without_name(answer))


def said_unlisted(answer: Answer) -> bool:
    """Is it said that something is there which no name explains?"""
    return flagged(answer) or nameless(answer)


def in_stage(answer: Answer) -> bool:
    """Does what has no name stand in the stage of the effect that has none?"""
    stages = {e['stage'] for e in answer.label['effects'] if e['effect'] not in PHYSICS}
    left = (answer.report or {}).get('unexplained')
    return bool(stages & {*(f['stage'] for f in without_name(answer)), *([left.get('stage')] if left else [])})


def both_told(answer: Answer) -> bool:
    """Is the listed effect named and nothing else, and the rest in a law without a name?"""
    (listed,) = (e['effect'] for e in answer.label['effects'] if e['effect'] in PHYSICS)
    names = [finding for finding in answer.findings if not finding.get('unlisted')]
    return len(names) == 1 and listed in named(names[0]) and nameless(answer)


def closed(answer: Answer, way: str) -> float | None:
    """The share of the gap between the recalibrated muscle and the noise that a way closes on unseen data; None where
    there is hardly any. A way that failed closes nothing."""
    before, after = (held_out_error(answer, answer.limits[name]) for name in ('recalibration', way))
    if not before or before <= REACH:
        return None
    return 0.0 if after is None else (before - after) / (before - LEFT)


def document(groups: dict[str, list[Answer]], seed: int) -> str:
    """The tables as Markdown."""
    alone, beside, listed = (groups[group] for group in GROUPS)
    continuous = [a for a in alone if a.label['what'] in CONTINUOUS]
    lines = [
        '# Physics that no catalogue holds',
        '',
        f'{made_by("proof.nameless", seed)} Effects, instruments and recordings are those of the truth generator '
        '(`proof/truth/`). Cases',
        'count in which all that is concealed can be seen. Rates with their 95 % interval (Wilson).',
        '',
        '| | aim | reached |',
        '|---|---|---|',
        _row('an unlisted effect is flagged', '90 %', alone, said_unlisted),
        _row('a listed name is given instead', 'at most 25 %', reported(alone), lambda a: bool(a.physics)),
        _row('what has no name stands in the right stage', '80 %', alone, in_stage),
        _row(
            'with a listed effect beside it: that one named, the rest a law without a name', '60 %', beside, both_told
        ),
        _row(
            'a listed effect alone, in a form not tuned on: a law without a name',
            'at most 10 %',
            reported(listed),
            nameless,
        ),
        '',
        'On a recording that no method was given, over the effects that one continuous law can express: the share',
        'of the gap that is closed between the recalibrated muscle (0) and the noise of the instruments (1), where the',
        f'recalibrated muscle misses more than {REACH:g} times the noise.',
        '',
        '| | median | 10th percentile | of |',
        '|---|---|---|---|',
        '| aim | 0.85 | 0.50 | |',
        _gaps('diagnosis', continuous, DIAGNOSIS),
        _gaps('best listed effects (whiteness and BIC)', continuous, 'whiteness_bic'),
        '',
        '| concealed | cases | flagged | in its stage | a listed name instead | said |',
        '|---|---|---|---|---|---|',
    ]
    for name in (*OLD, *EXPRESSIBLE):
        mine = [a for a in alone if a.label['what'] == name]
        if mine:
            counts = [sum(test(a) for a in mine) for test in (said_unlisted, in_stage, lambda a: bool(a.physics))]
            said = ', '.join(sorted({f['effect'] for a in mine for f in a.findings}))
            lines.append(f'| {name} | {len(mine)} | {" | ".join(map(str, counts))} | {said or "no finding"} |')
    return '\n'.join(lines) + '\n'


def _row(name: str, aim: str, answers: Sequence[Answer], test: Callable[[Answer], bool]) -> str:
    return f'| {name} | {aim} | {told([test(a) for a in answers])} |'


def _gaps(name: str, answers: Sequence[Answer], way: str) -> str:
    found = [share for a in answers if (share := closed(a, way)) is not None]
    cells = f'{np.median(found):.2f} | {np.percentile(found, 10):.2f}' if found else '- | -'
    return f'| {name} | {cells} | {len(found)} |'


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.nameless', description=__doc__.splitlines()[0])
    parser.add_argument('--output', type=Path, required=True)
    parser.add_argument('--seed', type=int, default=23)
    parser.add_argument('--jobs', type=int, default=2)
    for group in GROUPS:
        parser.add_argument(f'--{group}', type=int, default=COUNTS[group], metavar='N', help='cases (%(default)s)')
    add_page_arguments(parser)
    chosen = parser.parse_args(arguments)
    one_of_linear_algebra()  # before the processes of the pool begin
    groups = [Group(chosen.output, group, getattr(chosen, group), chosen.seed, chosen.jobs) for group in GROUPS]
    for group in () if chosen.only_document else groups:
        group.run()
    say(document({group.group: group.answers() for group in groups}, chosen.seed), chosen.document)
    return 0


if __name__ == '__main__':
    sys.exit(main())
