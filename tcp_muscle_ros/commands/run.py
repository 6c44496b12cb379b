"""``tcp_muscle run PROTOCOL.yaml --output BAG``: a protocol on the muscle that answers on the topics, recorded.

A protocol whose loads a person hangs is played in parts, each a bag of its own: BAG/part_1, BAG/part_2 and so on.
``BAG.run.json`` beside it (``run_log.py``) says which parts are done, and how late the commands were.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tcp_muscle_ros.commands.exit_codes import DONE, INTERRUPTED
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.commands.record import add_topic_argument
from tcp_muscle_ros.control.safety import celsius
from tcp_muscle_ros.errors import BadInput, needs_ros
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.commands.run_log import RunLog
    from tcp_muscle_ros.control.playing import Allowed, Part
    from tcp_muscle_ros.muscle import Parameters
    from tcp_muscle_ros.nodes.runner import Answer, Runner
    from tcp_muscle_ros.recording.protocol import Protocol
    from tcp_muscle_ros.settings.rig import RigLimits


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``run``."""
    parser.add_argument('protocol', metavar='PROTOCOL.yaml', help='the protocol to play')
    add_parameter_argument(parser)
    parser.add_argument(
        '--output', required=True, metavar='BAG', help='a new bag, or a folder with a bag for each part of the protocol'
    )
    parser.add_argument('--resume', action='store_true', help='continue with the first part that is not done')
    add_force_argument(parser)
    add_topic_argument(parser)
    add_rig_arguments(parser)


def add_rig_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what says which muscle and what the rig can do."""
    parser.add_argument('--namespace', default='', metavar='NS', help="where the muscle's topics are (default: /)")
    parser.add_argument('--rig', metavar='RIG.yaml', help='what the rig can do: largest current, loads, ...')
    parser.add_argument('--yes', action='store_true', help='the rig changes the loads: do not ask a person')


class Overheated(BadInput):
    """A run that ended because the muscle was as hot as it may be: one with less current may be played."""


class Admitted(NamedTuple):
    """What a run needs, once all of it is known to be good."""

    protocol: Protocol
    model: Parameters
    output: Path
    limits: RigLimits | None
    doubt: str


def admit(args: argparse.Namespace) -> Admitted:
    """All that can be refused before anything is asked of a muscle."""
    from tcp_muscle_ros.commands.domain import refuse_what_no_node_takes
    from tcp_muscle_ros.commands.run_log import admit_output
    from tcp_muscle_ros.files.outputs import refuse_among
    from tcp_muscle_ros.recording.protocol import read_protocol
    from tcp_muscle_ros.settings.parameter_file import read

    output = Path(args.output)
    refuse_among(output, [args.protocol, args.params, *([args.rig] if args.rig else [])])
    model, limits, protocol = read(args.params).parameters, rig_limits(args.rig), read_protocol(args.protocol)
    refuse_what_no_node_takes(args.protocol, protocol)
    admit_output(output, protocol, resume=args.resume, force=args.force)
    _foreseen(protocol, model, limits, by_person=not args.yes)
    return Admitted(protocol, model, output, limits, doubt_of(args.params))


def run(args: argparse.Namespace) -> int:
    """Play and record; 130 where it was interrupted."""
    from tcp_muscle_ros.process.compiling import tell_of_compiling

    tell_of_compiling()
    protocol, model, output, limits, doubt = admit(args)
    if doubt:
        print(f'warning: {doubt}', flush=True)
    played = play(
        protocol,
        model,
        output,
        limits=limits,
        namespace=args.namespace,
        ask=None if args.yes else input,
        resume=args.resume,
        force=args.force,
        topics=args.topic,
        known={'protocol': Path(args.protocol).name},
        doubt=doubt,
    )
    return INTERRUPTED if played.interrupted else DONE


def doubt_of(params: str) -> str:
    """Why the temperatures that a parameter file foretells vouch for nothing, '' where nothing says so. BadInput."""
    from tcp_muscle_ros.settings.intervals import unfixed

    if not unfixed(params, 'hA'):
        return ''
    return (
        f'{params}: its recordings did not fix hA, so the muscle may become far hotter than this model predicts; ask '
        f'for no more than they held, or watch a thermometer'
    )


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
    force: bool = False,
    topics: Sequence[str] = (),
    known: dict[str, object] | None = None,
    doubt: str = '',
    say: Callable[[str], None] = lambda sentence: print(sentence, flush=True),
) -> Outcome:
    """Play a protocol on the muscle that answers under ``namespace`` and record it.

    Args:
        protocol: what is done.
        model: the muscle as it is believed to be: foresees how hot it becomes.
        output: the bag, or the folder of the parts' bags.
        limits, namespace: what the rig can do, beside the driver's own limits; of the muscle's topics.
        ask: how a person is asked to change the load; None where the rig does it.
        resume: parts that ``OUTPUT.run.json`` calls complete are not played again.
        force: a run that is there already goes once this one is complete.
        topics, known: recorded beside those of the muscle; kept in the bags.
        doubt: why nobody knows how hot it becomes, '' where the model does.
        say: told of the progress.
    Raises BadInput: nothing may be played, or something ended it; the sentence says what and when.
    """
    from tcp_muscle_ros.commands.run_log import RunLog, admit_output
    from tcp_muscle_ros.control.playing import refuse_beyond

    by_person = ask is not None and _by_person(limits)
    before = admit_output(output, protocol, resume=resume, force=force)
    todo, hottest = _foreseen(protocol, model, limits, by_person)
    log = RunLog(output, protocol, len(todo), before)
    if log.done(len(todo)):
        say(f'{output}: all of it is done already')
        return Outcome(log.bags(), False, log.punctual)
    interrupted = False
    try:
        with _muscle(namespace, protocol.kind, limits, say, topics) as runner:
            refuse_beyond(protocol, model, allowed_by(limits, answer := runner.answer()))
            say(f'{answer.name or "a muscle"} answers; {doubt or f"the model predicts at most {celsius(hottest)}"}')
            asked = [part.number for part in todo if by_person and _needs_person(part, todo, protocol)]
            for part in (part for part in todo if not log.done(part.number)):
                runner.hang(float(part.load[0]), ask if part.number in asked else None)
                runner.wait_until_cold(protocol.ambient, model['C'] / model['hA'])
                say(f'part {part.number} of {len(todo)}: {part.time[-1]:g} s')
                interrupted = _play_part(runner, part, log, _known(protocol, part, known))
                if interrupted:
                    break
    except KeyboardInterrupt:
        interrupted = True
    finally:
        if kept := log.end():
            say(f'{kept}: what was there before; it is removed once the run is complete (--resume)')
    say(f'{output}: {_ended(log, interrupted)}')
    return Outcome(log.bags(), interrupted, log.punctual)


def _ended(log: RunLog, interrupted: bool) -> str:
    """How a run ended, and how punctual its commands were, if there were any."""
    if interrupted and not log.played:
        return 'interrupted before anything was played; no bag was written'
    return f'{"interrupted, 0 A" if interrupted else "done"}; {100.0 * log.punctual:.1f} % within 2 ms of due'


def _play_part(runner: Runner, part: Part, log: RunLog, known: dict[str, object]) -> bool:
    """Play and record one part; whether a signal ended it. BadInput where something else did."""
    played = runner.play(part, log.begin(part.number), known)
    log.write(part.number, played)
    if played.stopped and not runner.asked:
        kind = Overheated if played.overheated else BadInput
        raise kind(f'stopped, 0 A: {played.stopped}; {log.bag(part.number)} is complete up to then')
    return runner.asked


def _foreseen(
    protocol: Protocol, model: Parameters, limits: RigLimits | None, by_person: bool
) -> tuple[list[Part], float]:
    """The parts, and the hottest that the model foresees, K. BadInput where the rig does not allow it."""
    from tcp_muscle_ros.control.playing import parts, refuse_beyond

    todo = parts(protocol, by_person and _by_person(limits))
    return todo, refuse_beyond(protocol, model, allowed_by(limits, None))


def _by_person(limits: RigLimits | None) -> bool:
    return limits is None or limits.by_person


def _hottest(limits: RigLimits | None) -> float:
    return allowed_by(limits, None).temperature


@contextmanager
def _muscle(
    namespace: str, kind: str, limits: RigLimits | None, say: Callable[[str], None], topics: Sequence[str] = ()
) -> Iterator[Runner]:
    """What plays on the muscle that answers there. BadInput where none does: it says where there are others."""
    with ExitStack() as ending:
        runner = _runner_class()(namespace, kind, _hottest(limits), say, topics)
        try:
            ending.enter_context(runner)
        except BadInput as mistake:
            from tcp_muscle_ros.nodes.elsewhere import look_elsewhere

            raise BadInput(f'{mistake}{look_elsewhere(namespace)}') from None
        yield runner


def _runner_class() -> type[Runner]:
    """What plays, needing ROS 2."""
    try:
        from tcp_muscle_ros.nodes.runner import Runner
    except ImportError as error:
        raise needs_ros(error) from None
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


def driver_allows(limits: RigLimits | None, namespace: str, kind: str, say: Callable[[str], None]) -> Allowed:
    """What rig and driver allow of a command (current, power or voltage) to the muscle that answers there. BadInput
    where none does."""
    with _muscle(namespace, kind, limits, say) as runner:
        return allowed_by(limits, runner.answer())


def _known(protocol: Protocol, part: Part, more: dict[str, object] | None) -> dict[str, object]:
    return {
        'end': protocol.end,
        'load_n': float(part.load[0]),
        'part': part.number,
        **protocol.end_options,
        **(more or {}),
    }
