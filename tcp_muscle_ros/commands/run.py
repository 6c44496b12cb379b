"""``tcp_muscle run PROTOCOL.yaml --output BAG``: a protocol on the muscle that answers on the topics, recorded.

A protocol whose loads a person hangs is played in parts, each a bag of its own: BAG/part_1, BAG/part_2 and so on.
``BAG.run.json`` beside it says which parts are done, and how late the commands were.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.errors import BadInput

if TYPE_CHECKING:
    from tcp_muscle_ros.control.playing import Allowed, Part
    from tcp_muscle_ros.muscle import Parameters
    from tcp_muscle_ros.nodes.runner import Answer, Played, Runner
    from tcp_muscle_ros.recording.protocol import Protocol
    from tcp_muscle_ros.settings.rig import RigLimits

SCHEMA = 'tcp_muscle_ros/run-1'
_INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``run``."""
    parser.add_argument('protocol', metavar='PROTOCOL.yaml', help='the protocol to play')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='BAG', help='a new bag, or a folder of bags, one a part')
    parser.add_argument('--resume', action='store_true', help='continue with the first part that is not done')
    add_rig_arguments(parser)


def add_rig_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what says which muscle and what the rig can do."""
    parser.add_argument('--namespace', default='', metavar='NS', help="where the muscle's topics are (default: /)")
    parser.add_argument('--rig', metavar='RIG.yaml', help='what the rig can do: largest current, loads, ...')
    parser.add_argument('--yes', action='store_true', help='the rig changes the loads: do not ask a person')


def run(args: argparse.Namespace) -> int:
    """Play and record; 130 where it was interrupted."""
    from tcp_muscle_ros.recording.protocol import read_protocol
    from tcp_muscle_ros.settings.parameter_file import read

    protocol, model = read_protocol(args.protocol), read(args.params).parameters
    played = play(
        protocol,
        model,
        Path(args.output),
        limits=rig_limits(args.rig),
        namespace=args.namespace,
        ask=None if args.yes else input,
        resume=args.resume,
        known={'protocol': Path(args.protocol).name},
    )
    return _INTERRUPTED if played.interrupted else 0


def rig_limits(rig: str | None) -> RigLimits | None:
    """What ``--rig`` says that the rig can do. Raises BadInput."""
    from tcp_muscle_ros.settings.rig import read_rig

    return read_rig(rig).limits if rig else None


@dataclass(frozen=True)
class Outcome:
    """The bags of a run, whether a signal ended it, and the share of its commands that were within 2 ms of due."""

    bags: tuple[Path, ...]
    interrupted: bool
    punctual: float


def play(
    protocol: Protocol,
    model: Parameters,
    output: Path,
    *,
    limits: RigLimits | None = None,
    namespace: str = '',
    ask: Callable[[str], str] | None = None,
    resume: bool = False,
    known: dict[str, object] | None = None,
    say: Callable[[str], None] = lambda sentence: print(sentence, flush=True),
) -> Outcome:
    """Play a protocol on the muscle that answers under ``namespace`` and record it.

    Args:
        protocol: what is done.
        model: the muscle as it is believed to be: foresees how hot it becomes.
        output: the bag, or the folder of the parts' bags.
        limits: what the rig can do; the driver's own limits hold beside them.
        namespace: of the muscle's topics.
        ask: how a person is asked to change the load; None where the rig does it.
        resume: parts that ``OUTPUT.run.json`` calls complete are not played again.
        known: kept in the bags.
        say: told of the progress.

    Raises:
        BadInput: nothing may be played, or something ended it: the sentence says what and when.
    """
    from tcp_muscle_ros.control.playing import parts, refuse_beyond
    from tcp_muscle_ros.files.outputs import writable_folder

    by_person = ask is not None and (limits is None or limits.by_person)
    todo = parts(protocol, by_person)
    log = _Log(output, protocol, len(todo), resume)
    if not resume:
        writable_folder(output)
    allowed = allowed_by(limits, None)
    hottest = refuse_beyond(protocol, model, allowed)  # before anything is asked of a muscle
    if log.done(len(todo)):
        say(f'{output}: all of it is done already')
        return Outcome(log.bags(), False, log.punctual)
    interrupted = False
    try:
        with _runner_class()(namespace, protocol.kind, allowed.temperature, say) as runner:
            refuse_beyond(protocol, model, allowed_by(limits, answer := runner.answer()))
            say(f'{answer.name or "a muscle"} answers; the model foresees at most {hottest - 273.15:.1f} degC')
            for part in todo:
                if not (interrupted or log.done(part.number)):
                    runner.hang(float(part.load[0]), ask if by_person and _needs_person(part, todo, protocol) else None)
                    runner.wait_until_cold(protocol.ambient, model['C'] / model['hA'])
                    say(f'part {part.number} of {len(todo)}: {part.time[-1]:g} s')
                    played = runner.play(part, log.begin(part.number), _known(protocol, part, known))
                    log.write(part.number, played)
                    if played.stopped and not runner.asked:
                        raise BadInput(f'stopped, 0 A: {played.stopped}; {log.bag(part.number)} is complete up to then')
                    interrupted = runner.asked
    except KeyboardInterrupt:
        interrupted = True
    say(f'{output}: {"interrupted, 0 A" if interrupted else "done"}; {100.0 * log.punctual:.1f} % within 2 ms of due')
    return Outcome(log.bags(), interrupted, log.punctual)


def _runner_class() -> type[Runner]:
    """What plays, needing ROS 2."""
    try:
        from tcp_muscle_ros.nodes.runner import Runner
    except ImportError as error:
        raise BadInput(
            f"needs ROS 2's rclpy ({error}); source a ROS 2 or install this package with its extra [ros]"
        ) from None
    return Runner


def _needs_person(part: Part, todo: list[Part], protocol: Protocol) -> bool:
    """The starting load hangs already where the protocol does not change it."""
    from tcp_muscle_ros.control.playing import SAME_LOAD

    return len(todo) > 1 or abs(float(part.load[0]) - protocol.load) > SAME_LOAD * protocol.load


def allowed_by(limits: RigLimits | None, answer: Answer | None) -> Allowed:
    """What rig and driver allow: the stricter of both."""
    from tcp_muscle_ros.control.playing import Allowed
    from tcp_muscle_ros.settings.rig import RigLimits

    rig = limits or RigLimits(largest_current=float('inf'), held_end=True, longest_run=float('inf'))
    current, its = rig.largest_current, 'rig.yaml'
    temperature, whose = rig.highest_temperature, 'rig.yaml' if limits else 'the usual derating temperature'
    if answer and answer.current_limit is not None and answer.current_limit < current:
        current, its = answer.current_limit, answer.name
    if answer and answer.derate_temperature is not None and (answer.derate_temperature < temperature or not limits):
        temperature, whose = answer.derate_temperature, f'{answer.name}, from where it derates'
    return Allowed(
        current=current,
        temperature=temperature,
        loads=rig.loads,
        duration=rig.longest_run,
        held_end=rig.held_end,
        current_limit_of=its,
        temperature_limit_of=whose,
    )


def _known(protocol: Protocol, part: Part, more: dict[str, object] | None) -> dict[str, object]:
    return {
        'end': protocol.end,
        'load_n': float(part.load[0]),
        'part': part.number,
        **protocol.end_options,
        **(more or {}),
    }


class _Log:
    """``OUTPUT.run.json``: what is done of a run. A part whose bag is there without being done is set aside."""

    def __init__(self, output: Path, protocol: Protocol, count: int, resume: bool) -> None:
        self._output, self._count = output, count
        self._path = output.with_name(output.name + '.run.json')
        print_of = repr(protocol)
        self._content: dict[str, Any] = {'schema': SCHEMA, 'protocol': print_of, 'parts': {}}
        if resume:
            if not self._path.is_file():
                raise BadInput(f'--resume: {self._path} does not exist; expected that of a run that was stopped')
            try:
                before = json.loads(self._path.read_text())
                same = before['schema'] == SCHEMA and before['protocol'] == print_of
            except (OSError, ValueError, KeyError, TypeError):
                raise BadInput(f'--resume: {self._path} is no log of a run') from None
            if not same:
                raise BadInput(f'--resume: {self._path} is of another protocol; expected the one that was stopped')
            self._content = before

    def bag(self, number: int) -> Path:
        """Where a part is recorded."""
        return self._output if self._count == 1 else self._output / f'part_{number}'

    def bags(self) -> tuple[Path, ...]:
        """Those that are done."""
        return tuple(self.bag(k) for k in range(1, self._count + 1) if self._part(k).get('complete'))

    def _part(self, number: int) -> dict[str, Any]:
        found: dict[str, Any] = self._content['parts'].get(str(number), {})
        return found

    def done(self, number: int) -> bool:
        """Whether a part, and all before it, is complete."""
        return all(self._part(k).get('complete') for k in range(1, number + 1))

    def begin(self, number: int) -> Path:
        """Make room for a part: what a stopped run left of it is renamed. Says in the log that it is begun."""
        bag, tries = self.bag(number), 1
        while bag.exists() and (aside := bag.with_name(f'{bag.name}_stopped_{tries}')).exists():
            tries += 1
        if bag.exists():
            bag.rename(aside)
        self._content['parts'][str(number)] = {'complete': False}
        self._save()
        return bag

    def write(self, number: int, played: Played) -> None:
        """A part has been played, to its end or not."""
        late = sorted(played.lateness) or [0.0]
        self._content['parts'][str(number)] = {
            'complete': not played.stopped,
            'stopped': played.stopped,
            'commands': len(played.lateness),
            'within_2_ms': sum(one <= 2e-3 for one in late) / len(late),
            'lateness_s': {'p50': late[len(late) // 2], 'p99': late[int(0.99 * (len(late) - 1))], 'max': late[-1]},
        }
        self._save()

    def _save(self) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        draft = self._path.with_name('.' + self._path.name)
        draft.write_text(json.dumps(self._content, indent=1) + '\n')
        draft.replace(self._path)

    @property
    def punctual(self) -> float:
        """The share of the commands that were within 2 ms of due."""
        played = [part for part in self._content['parts'].values() if part.get('commands')]
        count = sum(part['commands'] for part in played)
        return float(sum(part['commands'] * part['within_2_ms'] for part in played) / count) if count else 1.0
