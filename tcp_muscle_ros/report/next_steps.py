"""What to do after a diagnosis: commands that can be pasted, with the paths that were diagnosed."""

import shlex
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.report.report_json import IMPROVED, PROTOCOL, RIG
from tcp_muscle_ros.report.words import chance, plain

_NEXT = 'next_recording'


@dataclass(frozen=True)
class Asked:
    """What was asked for: bags, parameter file (or the name of a shipped set), the options by which bags were read,
    the folder that the report will have, and what was known of the rig.

    ``separate``: parameters that each recording had for itself; ``namespace`` of the muscle, and ``topics`` beside
    those of a muscle, from which a channel was taken.
    """

    bags: tuple[str, ...]
    params: str
    folder: str
    options: tuple[str, ...] = ()
    rig: str = ''
    separate: tuple[str, ...] = ()
    namespace: str = ''
    topics: tuple[str, ...] = ()

    @property
    def reading(self) -> tuple[str, ...]:
        """The same with absolute paths, so that the commands work from anywhere."""
        return tuple(str(Path(bag).absolute()) for bag in self.bags)

    def made(self, name: str) -> str:
        """The path of something in the report."""
        return str(Path(self.folder).absolute() / name)

    @property
    def given(self) -> str:
        """The parameters that were given: an absolute path, or a name."""
        return str(Path(self.params).absolute()) if Path(self.params).exists() else self.params


@dataclass(frozen=True)
class Step:
    """One thing to do, and the commands that do it."""

    what: str
    commands: tuple[str, ...] = ()


def steps(diagnosis: Diagnosis, asked: Asked | None) -> list[Step]:
    """What to do next, the most useful first. Without ``asked`` nobody knows the paths: what to do is said alone."""
    if diagnosis.verdict == 'insufficient_data':
        return [_record_more(asked)]
    found = [_compare(asked)]  # it needs nothing but what is there
    if diagnosis.findings:
        found.append(Step('Check on the rig what is said at each finding below, before you believe it.'))
    if diagnosis.verdict == 'not_repeatable':
        found.append(Step('Find out why runs of one protocol differ: clamps, slack, the room, the specimen.'))
    if diagnosis.verdict == 'unexplained':
        when = 'at the shaded times' if diagnosis.location is not None and diagnosis.location.intervals else 'again'
        acts = 'something acts there that is not a listed effect' if diagnosis.tried else 'no listed effect was tried'
        found.append(Step(f'Look at the rig {when}: {acts}.'))
    if diagnosis.next_experiment is not None:
        found.append(_decide(diagnosis, asked))
    elif diagnosis.would_help:
        found.append(Step('No planned experiment is likely to decide. ' + _listed(diagnosis.would_help)))
    found.append(_simulate(asked))
    return found


def _record_more(asked: Asked | None) -> Step:
    what = 'Record again, with an input that switches several times and every sensor that you have.'
    if asked is None:
        return Step(what)
    return Step(what, (_command('tcp_muscle', 'record', '--output', 'new_recording', '--duration', '300'),))


def _decide(diagnosis: Diagnosis, asked: Asked | None) -> Step:
    proposal = diagnosis.next_experiment
    assert proposal is not None
    first, second = (plain(name) for name in proposal.separates)
    length = proposal.duration
    what = (
        f'Do the experiment that tells {first} from {second} with probability {chance(proposal.power)} '
        f'({plain(proposal.name)}, {length:.0f} s), and diagnose it together with these recordings.'
    )
    if asked is None:
        return Step(what)
    known = ('--rig', str(Path(asked.rig).absolute())) if asked.rig else ()
    under = ('--namespace', asked.namespace) if asked.namespace else ()
    made = ('--params', asked.made(IMPROVED), '--output', _NEXT)
    run = _command('tcp_muscle', 'run', asked.made(PROTOCOL), *made, *known, *under, *_each('--topic', asked.topics))
    # Where a person hangs the loads it is played in parts, a bag each.
    in_parts = diagnosis.rig.limits.by_person and len({step.load for step in proposal.steps}) > 1
    bags = f'{_NEXT}/part_*' if in_parts else _NEXT
    options = (*known, *_each('--separate', asked.separate), *asked.options)
    again = _joined('--params', asked.given, '--output', asked.made('').rstrip('/') + '_2', *options)
    return Step(what, (run, f'{_command("tcp_muscle", "diagnose", *asked.reading)} {bags} {again}'))


def _compare(asked: Asked | None) -> Step:
    what = 'See the improved muscle beside a recording.'
    if asked is None:
        return Step(what)
    figure = ('--figure', f'{Path(asked.bags[0]).name}_improved.png')
    made = ('--params', asked.made(IMPROVED), '--rig', asked.made(RIG))
    return Step(what, (_command('tcp_muscle', 'replay', asked.reading[0], *made, *figure, *asked.options),))


def _simulate(asked: Asked | None) -> Step:
    what = 'Simulate with the improved muscle.'
    if asked is None:
        return Step(what)
    return Step(what, (_command('sim_node', '--ros-args', '--params-file', asked.made(IMPROVED)),))


def _listed(sentences: Sequence[str]) -> str:
    return 'It would help to record ' + '; or '.join(sentences) + '.'


def _command(program: str, *words: str) -> str:
    """A command line. In a ROS workspace the programs of a package are not on PATH; `ros2 run` finds them."""
    in_workspace = shutil.which(program) is None and shutil.which('ros2') is not None
    begin = ('ros2', 'run', 'tcp_muscle_ros') if in_workspace else ()
    return shlex.join((*begin, program, *words))


def _each(option: str, values: Sequence[str]) -> tuple[str, ...]:
    return tuple(word for value in values for word in (option, value))


def _joined(*words: str) -> str:
    return shlex.join(words)
