"""Does the loop find more than other recordings? ``investigate`` on muscles of the truth, beside three other ways.

python -m proof.investigated --muscles 60 --seed 25 --output DIR [--document docs/investigate_table.md]

Each muscle is investigated by the code of ``tcp_muscle investigate`` (its loop, first protocols, limits, diagnosis)
with a budget of 90 min of muscle time. Then the same muscle, new again, is recorded for as long as that took in three
other ways: ``passive`` (one cycle under one load over and over), ``random`` (protocols of the book drawn at random) and
``book`` (all of them in a fixed order). Goes on muscle by muscle where it was stopped, elsewhere too by the file of
``--results``; singles and pairs take turns, so that a part of the muscles is a fair table. The first
``--behind-nodes N`` are investigated by the command itself: real processes over DDS, in lockstep with
``proof.truth_node``.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from proof import alternatives
from proof.answers import Answer, exact, gap_closed, matched
from proof.cases import PHYSICS, Case, make_case, signals_of
from proof.generate import _plain, label, write_recording
from proof.protocols import experiment
from proof.prove import commit, machine
from proof.rates import told
from proof.tool import HELD_OUT, REPORT, diagnose_case, users_errors
from proof.truth import Experiment, observe
from proof.truth.body import weight
from proof.truth.plant import CURRENT
from tcp_muscle_ros.commands.exploring import first_protocols, further_protocols, kept_back_protocol, loads_about
from tcp_muscle_ros.commands.investigation import Budget, Investigation, Log, allowed_of
from tcp_muscle_ros.control.playing import Allowed
from tcp_muscle_ros.diagnosis.observation.observe import MOST
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import in_place_of
from tcp_muscle_ros.process.threads import one_of_linear_algebra
from tcp_muscle_ros.recording.protocol import Protocol, read_protocol
from tcp_muscle_ros.settings.operating import DEFAULT_SET
from tcp_muscle_ros.settings.parameter_file import read as read_parameters
from tcp_muscle_ros.settings.parameter_file import write as write_parameters

SUITE, RATE = 'varied', 20.0  # of the forms that effects take; Hz
BUDGET = Budget(duration=5400.0, runs=20, cycles=1000)
HOTTEST = 373.15  # K, by the model: as `run` has it where no driver says anything else
LOAD = weight(60.0)
OURS, WAYS = 'investigate', ('passive', 'random', 'book')
BOOK = (
    'paper', 'hold', 'staircase', 'load_steps_hot', 'prbs', 'rates', 'hold_loads', 'load_steps_cold', 'light_hot',
    'paper_heavy', 'repeat', 'rest', 'rates_light', 'paper_light',
)  # fmt: skip
LIMITS = ('recalibration', 'oracle')
SHORTEST = 60.0  # s, of a recording
MOST_DRAWS = 50


def drawn(seed: int, number: int) -> tuple[Case, dict[str, Any]]:
    """Muscle of this number with its label: singles have even numbers, pairs odd ones.

    Every effect can be seen in the recordings of the book: what nothing shows nobody can name.
    """
    kind, round_, place = ('double' if number % 2 else 'single'), *divmod(number // 2, len(PHYSICS))
    what = '' if number % 2 else str(np.random.default_rng([seed, round_]).permutation(PHYSICS)[place])
    for further in range(MOST_DRAWS):
        case = make_case(SUITE, seed, number + 1000 * further, kind, what)
        case.lab = replace(case.lab, rate=RATE, kind=CURRENT)
        case.channels = ('temperature', 'resistance', 'displacement')
        case.experiments = [experiment(case.lab, name, case.rng(700)) for name in BOOK]
        said = label(case, signals_of(case))
        if all(effect['visibility']['detectable'] for effect in said['effects']):
            return case, said
    raise SystemExit(f'muscle {number} ({kind} {what}): none of {MOST_DRAWS} draws can be seen')


@dataclass
class Bench:
    """A muscle that is recorded run by run, and wears on the way."""

    case: Case
    folder: Path  # of CASE/recording_0, recording_1, ...
    dose: float = 0.0
    count: int = 0

    def record(self, done: Experiment, folder: Path | None = None) -> Path:
        """One more run; its bag."""
        signals = observe(self.case.bench, done, self.count, self.dose)
        bag = write_recording(self.case, self.count, done, signals, folder or self.folder)
        self.dose, self.count = signals.dose, self.count + 1
        return bag


@dataclass
class Plant:
    """The muscle as an investigation plays protocols on it; the run that is kept back goes to ``unseen``."""

    bench: Bench
    unseen: Path

    def record(self, protocol: Path, bag: Path) -> Sequence[Path]:
        """As ``tcp_muscle run``: the room is the lab's, whatever the protocol believes."""
        done = as_experiment(read_protocol(protocol), self.bench.case.lab.ambient)
        return (self.bench.record(done, self.unseen if bag.name == 'kept_back' else None),)


def as_experiment(protocol: Protocol, ambient: float) -> Experiment:
    """A protocol as it is done to the truth; ``ambient`` degC."""
    sampled = protocol.sampled()
    return Experiment('run', sampled.time, sampled.drive, CURRENT, sampled.load, ambient, protocol.end == 'blocked')


class Muscle:
    """All that is done to one muscle, in a folder; ``result.json`` there says what is done already."""

    def __init__(
        self, folder: Path, seed: int, number: int, behind_node: bool = False, known: Mapping[str, Any] | None = None
    ) -> None:
        self.folder, self.seed, self.number, self.behind_node = folder, seed, number, behind_node
        place = folder / 'result.json'
        found: dict[str, Any] = _json(place) if place.is_file() else deepcopy(dict(known or {}))
        self.result = {'seed': seed, 'revision': 'unknown', **found} if found else {}

    @cached_property
    def _drawn(self) -> tuple[Case, dict[str, Any]]:
        return drawn(self.seed, self.number)

    def run(self, ways: Sequence[str]) -> None:
        """The investigation and these ways, as far as they are not done; what a stopped run left begun is removed."""
        if not self.result:
            shutil.rmtree(self.folder, ignore_errors=True)
            (self.folder / 'unseen').mkdir(parents=True)
            self._timed(OURS, self._investigated)
        if not (self.folder / 'unseen').is_dir():  # investigated elsewhere, where the run that was kept back is
            return
        for way in ways:
            if way not in self.result['ways']:
                self._timed(way, lambda way=way: self._recorded(way))  # type: ignore[misc]

    def _timed(self, way: str, work: Callable[[], None]) -> None:
        begun = sum(os.times()[:4])  # with the processes that it starts
        work()
        self.result['ways'][way]['seconds'] = sum(os.times()[:4]) - begun
        with in_place_of(self.folder / 'result.json') as draft:
            draft.write_text(json.dumps(self.result, default=_plain) + '\n', encoding='utf-8')

    def _investigated(self) -> None:
        case, said = self._drawn
        self.result = {'seed': self.seed, 'number': self.number, 'revision': commit(), 'label': said, 'ways': {}}
        (self._investigate_behind_node if self.behind_node else self._investigate)(case)
        reports = self.folder / 'reports'
        problem = alternatives.run(self.folder / OURS / case.name, reports, said, self.folder / 'unseen', LIMITS)
        if problem:
            raise RuntimeError(problem)
        self.result['limits'] = {name: _json(reports / name / case.name / HELD_OUT) for name in LIMITS}

    def _recorded(self, way: str) -> None:
        shutil.rmtree(self.folder / way, ignore_errors=True)
        steps = self.result['ways'][OURS]['steps']
        self._record(way, self._drawn[0], float(sum(step['duration_s'] for step in steps if step['step'] == 'run')))
        if not self._guarded(way, lambda: self._diagnosed(way)):
            self.result['ways'][way] = {}
        shutil.rmtree(self.folder / way)

    def _guarded(self, way: str, work: Callable[[], None]) -> bool:
        try:
            work()
        except (BadInput, ArithmeticError, ValueError, RuntimeError) as error:  # counts as a muscle without an answer
            print(f'muscle {self.number}, {way}: {type(error).__name__}: {error}', file=sys.stderr)
            return False
        return True

    def _investigate(self, case: Case) -> None:
        model, home = read_parameters(DEFAULT_SET).parameters, self.folder / OURS
        top, room = case.lab.top, case.lab.ambient + 273.15
        allowed = Allowed(current=top, temperature=HOTTEST)

        loads = loads_about(LOAD, ())
        rounds = [first_protocols(top, loads, LOAD, room), *further_protocols(top, loads, LOAD, room)]

        def diagnose(_: Sequence[Path], report: Path) -> Mapping[str, Any]:
            diagnose_case(home / case.name, report, MOST)
            content = dict(_json(report / case.name / REPORT))
            if content['next_experiment']:
                proposed = content['next_experiment']
                content['next_experiment'] = {**proposed, 'protocol': f'{case.name}/{proposed["protocol"]}'}
            return content

        loop = Investigation(
            home,
            Plant(Bench(case, home), home / 'kept'),
            diagnose,
            [[allowed_of(one, model, allowed) for one in those] for those in rounds],
            allowed_of(kept_back_protocol(top, LOAD, room), model, allowed),
            lambda protocol: allowed_of(protocol, model, allowed),
            BUDGET,
            lambda sentence: print(f'  {sentence}', flush=True),
        )
        answered = self._guarded(OURS, loop.run)
        steps = loop.log.steps
        for bag in (home / 'kept' / case.name).glob('recording_*'):
            (self.folder / 'unseen' / case.name).mkdir(exist_ok=True)
            bag.rename(self.folder / 'unseen' / case.name / 'recording_0')
        if answered:
            self._take(OURS, loop.last_report / case.name)
            self.result['ways'][OURS] |= {'why': loop.log.of('end')[-1]['why'], 'steps': steps}
        else:
            self.result['ways'][OURS] = {'steps': steps}

    def _investigate_behind_node(self, case: Case) -> None:
        """``tcp_muscle investigate`` over DDS; its bags go where the others' are."""
        home, folder = self.folder / OURS, self.folder / 'command'
        answered = self._guarded(OURS, lambda: investigate_by_command(case, self.seed, self.number, folder))
        steps = Log(folder).steps
        if not any(step['step'] == 'kept_back' for step in steps):
            raise SystemExit(f'muscle {self.number}: the investigation did not come to its end, see above')
        for place, wanted in ((home, 'run'), (self.folder / 'unseen', 'kept_back')):
            (place / case.name).mkdir(parents=True)
            bags = [folder / bag for step in steps if step['step'] == wanted for bag in step['bags']]
            for k, bag in enumerate(bags):
                (place / case.name / f'recording_{k}').symlink_to(bag.resolve())
        if answered:
            self._take(OURS, folder / 'report')
            why = next(step['why'] for step in steps if step['step'] == 'end')
            self.result['ways'][OURS] |= {'why': why, 'steps': steps, 'behind_node': True}
        else:
            self.result['ways'][OURS] = {'steps': steps, 'behind_node': True}

    def _record(self, way: str, case: Case, duration: float) -> None:
        """A new muscle is recorded for ``duration`` s."""
        bench, k, random = Bench(case, self.folder / way), 0, case.rng(800)
        while duration >= SHORTEST:
            same = case.rng(801)  # everyday: the same load and current each time
            name = {'passive': 'repeat', 'random': str(random.choice(BOOK)), 'book': BOOK[k % len(BOOK)]}[way]
            done = experiment(case.lab, name, same if way == 'passive' else random)
            kept = done.time <= duration
            done = replace(done, time=done.time[kept], drive=done.drive[kept], load=done.load[kept])
            bench.record(done)
            duration, k = duration - float(done.time[-1]), k + 1

    def _diagnosed(self, way: str) -> None:
        reports = self.folder / 'reports' / way
        diagnose_case(self.folder / way / self._drawn[0].name, reports, MOST)
        self._take(way, reports / self._drawn[0].name)

    def _take(self, way: str, report: Path) -> None:
        """What a report says, and how well its muscle predicts the run that was kept back."""
        unseen = self.folder / 'unseen' / self._drawn[0].name
        content = _json(report / REPORT)
        kept = ('verdict', 'headline', 'findings', 'unexplained')
        self.result['ways'][way] = {
            'report': {name: content[name] for name in kept},
            'held_out': users_errors(report, unseen),
        }


def investigate_by_command(case: Case, seed: int, number: int, folder: Path, *more: str) -> None:
    """``tcp_muscle investigate`` of a muscle behind a node in lockstep, into a folder; ``more`` of its arguments.

    RuntimeError where either process fails.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    params, rig = folder.with_name('lab.yaml'), folder.with_name('rig.yaml')
    write_parameters(
        params,
        read_parameters(DEFAULT_SET).parameters,
        operating={'load_n': LOAD, 'ambient_temperature_c': case.lab.ambient},
    )
    limits = f'largest_current_a: {case.lab.top}, highest_temperature_c: {HOTTEST - 273.15:g}, loads_by: rig'
    rig.write_text(f'limits: {{{limits}}}\n', encoding='utf-8')
    local = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': str(1 + os.getpid() % 50)}
    environment = {**local, **os.environ}
    node = [sys.executable, '-m', 'proof.truth_node', '--seed', str(seed), '--muscle', str(number)]
    command = [sys.executable, '-m', 'tcp_muscle_ros.tool', 'investigate', '--output', str(folder)]
    command += ['--params', str(params), '--rig', str(rig), '--minutes', str(BUDGET.duration / 60.0)]
    command += ['--runs', str(BUDGET.runs), '--cycles', str(BUDGET.cycles), *more]
    with subprocess.Popen(node, stdout=subprocess.PIPE, text=True, env=environment) as truth:
        try:
            assert truth.stdout is not None
            if truth.stdout.readline() != 'ready\n':
                raise RuntimeError('the node of the muscle does not start')
            done = subprocess.run(command, env=environment, check=False)
        finally:
            truth.terminate()
    if done.returncode:
        raise RuntimeError(f'tcp_muscle investigate ended with {done.returncode}')


def _json(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text(encoding='utf-8'))
    return content


def earlier(file: Path | None, seed: int) -> dict[int, dict[str, Any]]:
    """The results of a seed that a file has, by the number of the muscle; none where there is no file yet."""
    if file is None or not file.is_file():
        return {}
    lines = file.read_text(encoding='utf-8').split('\n')
    results = map(json.loads, lines[:-1])  # what was being written when it was killed has no end
    return {r['number']: r for r in results if r['seed'] == seed}


def keep(result: Mapping[str, Any], file: Path) -> None:
    """Write a result at the end of a file."""
    there = file.read_text(encoding='utf-8') if file.is_file() else ''
    with in_place_of(file) as draft:
        draft.write_text(there[: there.rfind('\n') + 1] + json.dumps(result, default=_plain) + '\n', encoding='utf-8')


def answer(result: Mapping[str, Any], way: str) -> Answer:
    """A result as the scores of the proof take it."""
    found = result['ways'][way]
    return Answer(result['label'], found.get('report'), found.get('held_out'), result['limits'])


def document(results: Sequence[Mapping[str, Any]], command: str) -> str:
    """The table as Markdown."""
    kinds = {'single': 'singles', 'double': 'pairs'}
    counts = {kind: sum(r['label']['kind'] == kind for r in results) for kind in kinds}
    ours = [r['ways'][OURS] for r in results]
    spent = [sum(s['duration_s'] for s in one['steps'] if s['step'] in ('run', 'kept_back')) / 60.0 for one in ours]
    seconds = float(np.median([one['seconds'] for one in ours]))
    lines = [
        '# What investigate finds, beside other recordings',
        '',
        f'Made by `{command}` on {date.today()},',
        f'revision {", ".join(dict.fromkeys(r["revision"] for r in results))}, on {machine()}:',
        f'{counts["single"]} muscles with one concealed effect, {counts["double"]} with two; '
        f'an investigation took {seconds:.0f} s of processor time (median).',
        '',
        'Muscles, instruments (noise, quantisation, losses; 20 Hz) and effects are those of the truth generator',
        f"(`proof/truth/`, suite `{SUITE}`). Every effect can be seen in the book's recordings. Each muscle is",
        'investigated with a budget of 90 min of muscle time '
        f'(spent: median {np.median(spent):.0f} min, at most {max(spent):.0f}).',
        'Then the same muscle, new again, is recorded for as long in each of the other ways, and diagnosed once.',
        '',
        '| recorded | singles exactly | pairs exactly | singles, as sets | pairs, as sets '
        '| kept-back error closed, median (p10) |',
        '|---|---|---|---|---|---|',
    ]
    same = [r for r in results if all(way in r['ways'] for way in WAYS)]
    rows = [(way, way, same or [r for r in results if way in r['ways']]) for way in WAYS]
    if 0 < len(same) < len(results):
        rows.append((OURS, f'{OURS}, the same {len(same)} muscles', same))
    rows.append((OURS, OURS, results))
    for way, said, those in rows:
        answers = [answer(r, way) for r in those]
        if not answers:
            continue
        cells = [
            told([test(a) for a in answers if a.label['kind'] == kind])
            for test in (exact, lambda a: matched(a.findings, a.truth))
            for kind in kinds
        ]
        gaps = [g for a in answers if (g := gap_closed(a)) is not None]
        closed = f'{np.median(gaps):.2f} ({np.percentile(gaps, 10):.2f}), of {len(gaps)}' if gaps else '-'
        lines.append(f'| {said} | {" | ".join(cells)} | {closed} |')
    lines += ['', '*Exactly*: the true effects are named first and nothing else is. *As sets*: each true effect is']
    lines += ['among those that one finding cannot be told from. Rates with their 95 % interval (Wilson). The error']
    lines += ['closed: 0 is the recalibrated muscle, 1 one that is told the true effects (docs/proof.md).', '']
    lines += ['| | concealed | named by investigate | runs | min | ended because |', '|---|---|---|---|---|---|']
    lines += [_row(r, minutes) for r, minutes in zip(results, spent, strict=True)]
    return '\n'.join(lines) + '\n'


def _row(result: Mapping[str, Any], minutes: float) -> str:
    said, found = answer(result, OURS), result['ways'][OURS]
    names = [' or '.join([f['effect'], *f['indistinguishable_from']]) for f in said.findings]
    runs = sum(s['step'] == 'run' for s in found['steps'])
    mark = 'yes' if exact(said) else 'no'
    return (
        f'| {mark} | {", ".join(said.truth)} | {", ".join(names) or said.verdict.replace("_", " ")} | {runs} '
        f'| {minutes:.0f} | {found.get("why", "no answer")} |'
    )


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.investigated', description=__doc__.splitlines()[0])
    parser.add_argument('--muscles', type=int, default=60)
    parser.add_argument('--seed', type=int, default=25)
    parser.add_argument('--output', type=Path, required=True)
    parser.add_argument('--results', type=Path, help='a file with the results so far, to which new ones are added')
    parser.add_argument('--document', type=Path, help='write the table of what is done so far')
    parser.add_argument('--ways', nargs='*', choices=WAYS, default=WAYS, help='that are recorded beside it (all)')
    parser.add_argument('--behind-nodes', type=int, default=0, metavar='N', help='the first N by the command, over DDS')
    parser.add_argument('--only-document', action='store_true', help='investigate nothing more')
    chosen = parser.parse_args(arguments)
    one_of_linear_algebra()
    known = earlier(chosen.results, chosen.seed)
    results = []
    for number in range(chosen.muscles):
        behind = number < chosen.behind_nodes
        folder = chosen.output / f'muscle_{number:02d}'
        muscle = Muscle(folder, chosen.seed, number, behind, known.get(number))
        if chosen.only_document and not muscle.result:
            continue
        if not chosen.only_document:
            print(f'muscle {number}', flush=True)
            muscle.run(chosen.ways)
        results.append(muscle.result)
        if chosen.results and muscle.result != known.get(number):
            keep(muscle.result, chosen.results)
        said = answer(results[-1], OURS)
        named = [finding['effect'] for finding in said.findings]
        print(f'muscle {number}: {said.truth}, named {named}: {"exactly" if exact(said) else "no"}', flush=True)
    if chosen.document and results:
        command = f'python -m proof.investigated --muscles {chosen.muscles} --seed {chosen.seed}'
        command += f' --behind-nodes {chosen.behind_nodes}' if chosen.behind_nodes else ''
        chosen.document.write_text(document(results, command), encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
