"""The loop of ``tcp_muscle investigate``: record the first protocols, diagnose all so far, record what is proposed.

Once there is an answer, further protocols ask the same in another way; it counts if they do not change it.

Every step that is done is a line of DIR/log.jsonl; what is not in it was not done, and is done again after a kill -9.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from tcp_muscle_ros.commands.run import Overheated
from tcp_muscle_ros.commands.run_log import path_of
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import set_aside
from tcp_muscle_ros.recording.protocol import Protocol as Played
from tcp_muscle_ros.recording.protocol import Ramp, read_protocol
from tcp_muscle_ros.recording.units import UNITS

if TYPE_CHECKING:
    from tcp_muscle_ros.control.playing import Allowed
    from tcp_muscle_ros.muscle import Parameters

_GENTLER = 0.9  # times the current, again and again, until a protocol is allowed
_GENTLEST = 0.3
_OFTEN = 2  # that a proposed experiment is played
_MATCHES = ('match', 'wrong_parameters')
_ANSWER = ('named', 'verdict', 'unexplained')


class Plant(Protocol):
    """Whatever a protocol can be played on."""

    def record(self, protocol: Path, bag: Path) -> Sequence[Path]:
        """Play a protocol and record it; returns the bags. BadInput where it cannot, KeyboardInterrupt when asked."""


@dataclass(frozen=True)
class Budget:
    """What may be spent: ``duration`` s of muscle time, ``runs``, ``cycles`` of heating; the kept-back run counts."""

    duration: float
    runs: int
    cycles: int


def allowed_of(protocol: Played, model: Parameters, allowed: Allowed) -> Played:
    """The protocol with as much of its current as is allowed. BadInput where less than a third would be."""
    from tcp_muscle_ros.control.playing import refuse_beyond

    tried = 0
    while True:
        weaker = gentler(protocol, tried)
        try:
            refuse_beyond(weaker, model, allowed)
        except BadInput:
            tried += 1
            if _GENTLER**tried < _GENTLEST:
                raise
        else:
            return weaker


def gentler(protocol: Played, times: int) -> Played:
    """The protocol with nine tenths of its current, so many times."""
    share = _GENTLER**times
    segments = tuple(
        replace(one, value=Ramp(share * one.value.start, share * one.value.end)) for one in protocol.segments
    )
    return replace(protocol, segments=segments)


def cycles_of(protocol: Played) -> int:
    """How often a protocol begins to heat."""
    drive = protocol.sampled().drive
    return int(((drive[1:] > 0.0) & (drive[:-1] <= 0.0)).sum() + (drive[0] > 0.0))


def render(protocol: Played) -> str:
    """A protocol as its YAML file."""
    celsius = UNITS['degC'].from_si

    def ramp(given: Ramp) -> str:
        return f'{given.start!r}' if given.start == given.end else f'[{given.start!r}, {given.end!r}]'

    lines = [f'rate_hz: {protocol.rate_hz!r}', f'input: {protocol.kind}', f'end: {protocol.end}']
    lines += [f'load_n: {protocol.load!r}', f'ambient_c: {celsius(protocol.ambient):.9g}', f'repeat: {protocol.repeat}']
    lines += [f'{name}: {value!r}' for name, value in protocol.end_options.items()]
    lines.append('segments:')
    for one in protocol.segments:
        keys = [f'duration_s: {one.duration!r}', f'value: {ramp(one.value)}']
        keys += [f'load_n: {ramp(one.load)}'] if one.load else []
        keys += [f'ambient_c: {ramp(Ramp(*(round(celsius(t), 9) for t in one.ambient)))}'] if one.ambient else []
        lines.append(f'  - {{{", ".join(keys)}}}')
    return '\n'.join(lines) + '\n'


def _mark(protocol: Played) -> str:
    """What tells a protocol from others; the room is as it was found, each time a little otherwise."""
    return sha256(render(replace(protocol, ambient=0.0)).encode()).hexdigest()[:16]


def decided(report: Mapping[str, Any]) -> str:
    """Why a report needs no further experiment, '' where it does."""
    if report['unexplained'] is None and report['verdict'] in _MATCHES and report['next_experiment'] is None:
        return 'the model explains everything'
    single = bool(report['findings']) and all(one['singled_out'] for one in report['findings'])
    if report['unexplained'] is None and single:
        return 'every finding is singled out, and nothing is left unexplained'
    return '' if report['next_experiment'] is not None else 'no experiment is known that would decide more'


def _same_answer(before: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    """Whether two diagnoses say the same, as far as the earlier one is known: what is named, whether the model holds,
    and whether something is left unexplained."""

    def said(step: Mapping[str, Any]) -> dict[str, Any]:
        holds = {'verdict': step['verdict'] in _MATCHES or step['verdict']} if 'verdict' in step else {}
        return {name: step[name] for name in _ANSWER if name in step} | holds

    return all(said(now).get(name) == value for name, value in said(before).items())


class Log:
    """DIR/log.jsonl: one JSON object a step, written through to the disk before the next begins."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / 'log.jsonl'
        self.steps: list[dict[str, Any]] = []
        if self._path.is_file():
            self.steps = [json.loads(line) for line in self._path.read_text(encoding='utf-8').splitlines()]

    def add(self, step: str, **what: object) -> None:
        """A step that is done."""
        self.steps.append({'step': step, **what})
        text = ''.join(json.dumps(one) + '\n' for one in self.steps)
        draft = self._path.with_suffix('.draft')
        with draft.open('w', encoding='utf-8') as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(self._path)

    def of(self, step: str) -> list[dict[str, Any]]:
        """The steps of this kind, oldest first."""
        return [one for one in self.steps if one['step'] == step]

    def ended(self, budget: Budget) -> bool:
        """Whether nothing more is to be recorded: it has its answer, or spent a budget that this is no larger than."""
        ends = [one for one in self.steps if one['step'] in ('end', 'more_budget')]
        if not ends or ends[-1]['step'] == 'more_budget':
            return False
        spent = ends[-1].get('spent')
        return spent is None or all(now <= then for now, then in zip(astuple(budget), spent, strict=True))


class Investigation:
    """One investigation in a folder.

    Args:
        folder: where everything is kept.
        plant: what is investigated.
        diagnose: writes the report on these bags to this folder, and returns its content.
        rounds: of protocols. The first is recorded before anything is diagnosed, as far as the budget goes; the next
            once there is an answer; each further one where the answer has changed since.
        kept_back: that of the run that no diagnosis sees.
        admit: a protocol as the rig allows it; BadInput where it does not.
        budget: what may be spent.
        say: told of every step.
    """

    def __init__(
        self,
        folder: Path,
        plant: Plant,
        diagnose: Callable[[Sequence[Path], Path], Mapping[str, Any]],
        rounds: Sequence[Sequence[Played]],
        kept_back: Played,
        admit: Callable[[Played], Played],
        budget: Budget,
        say: Callable[[str], None],
    ) -> None:
        self._folder, self._plant, self._diagnose = folder, plant, diagnose
        self._rounds, self._kept_back = rounds, kept_back
        self._admit, self._budget, self._say = admit, budget, say
        for name in ('protocols', 'runs', 'reports'):
            (folder / name).mkdir(parents=True, exist_ok=True)
        self.log = Log(folder)

    def run(self) -> None:
        """Go on from where the log ends, to the end; where a budget was that, with a larger one further."""
        if self.log.of('end') and not self.log.ended(self._budget):
            self.log.add('more_budget')
        while not self.log.ended(self._budget):
            runs, reports = self.log.of('run'), self.log.of('diagnosis')
            protocol = self._unrecorded()
            if protocol is not None:
                self._record('run', f'run_{len(runs) + 1}', protocol)
            elif not reports or reports[-1]['runs'] < len(runs):
                self._report(len(runs))
            elif reports[-1]['decided']:
                self._ask_again(reports[-1], reports[-1]['decided'])
            else:
                self._propose(len(runs) + 1, reports[-1])
        while not self.log.of('kept_back'):
            self._record('kept_back', 'kept_back', self._kept_back)

    def _unrecorded(self) -> Played | None:
        """The next protocol of this round; None where all are recorded, or the budget ends."""
        begun = max((k for k, one in enumerate(self.log.steps) if one['step'] == 'ask_again'), default=-1)
        recent = [one['step'] for one in self.log.steps[begun + 1 :]]
        planned = self._rounds[len(self.log.of('ask_again'))]
        count = recent.count('run')
        if 'diagnosis' in recent or count >= len(planned):
            return None
        spent = self._beyond(planned[count])
        if spent and not self.log.of('run'):
            raise BadInput(f'{spent} before anything is recorded: a first run and one that is kept back need more')
        return None if spent else planned[count]

    def _ask_again(self, last: Mapping[str, Any], why: str) -> None:
        """Begin the next round; or the end, where the answer has stood one, or no more can be recorded. ``why``: what
        makes the last diagnosis an answer."""
        asked = self.log.of('ask_again')
        further = self._rounds[len(asked) + 1 :]
        runs = last['runs'] - asked[-1]['runs'] if asked else 0
        if asked and not runs:
            self._end(why, of_budget=True)  # the budget is smaller than when it was asked again
        elif asked and _same_answer(asked[-1], last):
            self._end(f'{why}, and {runs} further runs say the same')
        elif not further or self._beyond(further[0][0]):
            self._end(why, of_budget=bool(further))
        else:
            self._say('that is an answer: does it stand in further runs?')
            self.log.add('ask_again', runs=last['runs'], **{name: last[name] for name in _ANSWER if name in last})

    def _propose(self, number: int, last: Mapping[str, Any]) -> None:
        """The experiment that the last diagnosis proposes, or the end."""
        try:
            protocol = self._admit(read_protocol(self._folder / last['report'] / last['protocol']))
        except BadInput as error:
            self._end(f'the rig does not allow the proposed experiment: {error}')
            return
        spent = self._beyond(protocol)
        if spent:
            self._end(spent, of_budget=True)
        elif self._played(protocol) >= _OFTEN:
            self._ask_again(last, f'the proposed experiment was played {_OFTEN} times, and decides no more')
        else:
            self._record('run', f'run_{number}', protocol)

    def _played(self, protocol: Played) -> int:
        """How often this protocol was played."""
        wanted = _mark(protocol)
        return sum(self._asked(run) == wanted for run in self.log.of('run'))

    def _asked(self, run: Mapping[str, Any]) -> str:
        """Which protocol a run was to be, with however much less current it was played."""
        return run.get('asked') or _mark(read_protocol(self._folder / 'protocols' / f'{run["name"]}.yaml'))

    def _beyond(self, protocol: Played) -> str:
        """Which budget a protocol would pass, beside the run that is to be kept back; '' where none."""
        runs, budget = self.log.of('run'), self._budget
        planned = (protocol, self._kept_back)
        played = [*runs, *self.log.of('overheated')]
        seconds = sum(one['duration_s'] for one in played) + sum(one.duration for one in planned)
        if seconds > budget.duration:
            return f'the budget of {budget.duration / 60:.0f} min is spent'
        if len(runs) + len(planned) > budget.runs:
            return f'the budget of {budget.runs} runs is spent'
        if sum(one['cycles'] for one in played) + sum(cycles_of(one) for one in planned) > budget.cycles:
            return f'the budget of {budget.cycles} cycles is spent'
        return ''

    def _record(self, step: str, name: str, protocol: Played) -> None:
        """Record a run; one that overheats counts as played, and is played again with less current the next time."""
        asked = _mark(protocol)
        stops = sum(one['asked'] == asked for one in self.log.of('overheated'))
        protocol = gentler(protocol, stops)
        path, bag = self._folder / 'protocols' / f'{name}.yaml', self._folder / 'runs' / name
        path.write_text(render(protocol), encoding='utf-8')
        set_aside(path_of(bag), 'stopped')
        set_aside(bag, 'stopped')  # what is left of a run that was not finished
        self._say(f'{name}: {protocol.duration:.0f} s')
        spent = {'asked': asked, 'duration_s': protocol.duration, 'cycles': cycles_of(protocol)}
        try:
            bags = self._plant.record(path, bag)
        except Overheated as stop:
            self.log.add('overheated', name=name, **spent)
            if _GENTLER ** (stops + 1) < _GENTLEST:
                raise
            self._say(f'{name}: {stop}; again with {100 * _GENTLER:.0f} % of that current')
            return
        kept = [str(one.relative_to(self._folder)) for one in bags]
        self.log.add(step, name=name, bags=kept, **spent)

    def _report(self, number: int) -> None:
        report = self._folder / 'reports' / f'report_{number}'
        if report.exists():  # of a process that was killed before it could say that it was done
            shutil.rmtree(report)
        content = self._diagnose(self.bags, report)
        proposed = content['next_experiment'] or {}
        self._say(f'report_{number}: {content["headline"]}')
        self.log.add(
            'diagnosis',
            report=str(report.relative_to(self._folder)),
            runs=number,
            verdict=content['verdict'],
            headline=content['headline'],
            protocol=proposed.get('protocol'),
            named=sorted(finding['effect'] for finding in content['findings']),
            unexplained=content['unexplained'] is not None,
            decided=decided(content),
        )

    def _end(self, why: str, *, of_budget: bool = False) -> None:
        self._say(f'ended: {why}')
        self.log.add('end', why=why, spent=astuple(self._budget) if of_budget else None)

    @property
    def bags(self) -> list[Path]:
        """All that a diagnosis may see."""
        return [self._folder / bag for run in self.log.of('run') for bag in run['bags']]

    @property
    def kept_back(self) -> list[Path]:
        """What no diagnosis has seen."""
        return [self._folder / bag for run in self.log.of('kept_back') for bag in run['bags']]

    @property
    def last_report(self) -> Path:
        """The folder of the report over all runs."""
        return self._folder / str(self.log.of('diagnosis')[-1]['report'])
