"""``tcp_muscle simulate PROTOCOL.yaml [--params P.yaml] --output BAG``: a protocol offline, to a bag."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from tcp_muscle_ros.commands.domain import Domain
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.commands.sensing import Sensing
    from tcp_muscle_ros.muscle import Outputs
    from tcp_muscle_ros.recording.protocol import Protocol, Sampled
    from tcp_muscle_ros.recording.recording import Recording
    from tcp_muscle_ros.settings.parameter_file import ParameterFile

_PIECE = 50_000  # ticks that are simulated and written at once: a long protocol takes no more memory than a short one


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``simulate``."""
    parser.add_argument('protocol', metavar='PROTOCOL.yaml', help='the protocol to simulate')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='BAG', help='a new bag (rosbag2, MCAP)')
    parser.add_argument(
        '--rig',
        metavar='RIG.yaml',
        help='record what these instruments show (default: the rig_file of --params, if any)',
    )
    add_force_argument(parser)
    parser.add_argument(
        '--seed', type=int, metavar='N', help="seed of the sensors' noise (default: that of --params, else 0)"
    )


class Admitted(NamedTuple):
    """What a simulation needs, once all of it is known to be good."""

    output: Path
    file: ParameterFile
    protocol: Protocol
    held: dict[str, float]
    seed: int


def admit(args: argparse.Namespace) -> Admitted:
    """All that can be refused before anything is simulated."""
    from tcp_muscle_ros.commands.domain import refuse_what_no_node_takes
    from tcp_muscle_ros.files.outputs import refuse_among, writable_folder
    from tcp_muscle_ros.recording.protocol import END_OPTIONS, read_protocol
    from tcp_muscle_ros.settings.parameter_file import read
    from tcp_muscle_ros.settings.rig import on_rig, read_rig

    refuse_among(args.output, [args.protocol, args.params, *([args.rig] if args.rig else [])])
    output = writable_folder(args.output, force=args.force)
    if args.seed is not None and args.seed < 0:
        raise BadInput(f'--seed {args.seed}: expected a whole number of 0 or more')
    file = read(args.params)
    if rig := args.rig or file.text('rig_file'):
        file = replace(file, parameters=on_rig(file.parameters, read_rig(rig)))
    protocol = read_protocol(args.protocol)
    refuse_what_no_node_takes(args.protocol, protocol)
    # The protocol says how the end is held; what it leaves open, the parameter file may say.
    held = {name: protocol.end_options.get(name, file.number(name)) for name in END_OPTIONS}
    return Admitted(output, file, protocol, held, int(file.number('seed')) if args.seed is None else args.seed)


def _print_note(text: str) -> None:
    print(f'note: {text}')


def run(args: argparse.Namespace, tell: Callable[[str], None] = _print_note) -> int:
    """Simulate and write; sensor noise, quantisation and lag as the parameter file says. ``tell``: what takes notes."""
    from tcp_muscle_ros.commands.domain import Domain
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.files.outputs import in_place_of
    from tcp_muscle_ros.process.compiling import tell_of_compiling
    from tcp_muscle_ros.recording.bag_writer import write_pieces
    from tcp_muscle_ros.settings.parameter_file import given_names, idle

    tell_of_compiling()
    admitted = admit(args)
    domain = Domain(admitted.file.parameters['H0'])
    with Progress('simulating') as progress, in_place_of(admitted.output) as draft:
        write_pieces(draft, _recordings(admitted, domain, progress))
    protocol = admitted.protocol
    print(f'{admitted.output}: {protocol.duration:g} s at {protocol.rate_hz:g} Hz; {domain.summary}')
    muscle = admitted.file.parameters
    for note in (*idle(given_names(muscle), muscle.effects), *domain.notes()):
        tell(note)
    return 0


def _recordings(admitted: Admitted, domain: Domain, progress: Progress) -> Iterator[Recording]:
    """What is recorded, piece by piece."""
    from tcp_muscle_ros.commands.sensing import Sensing
    from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, simulate_on

    output, file, protocol, held, seed = admitted
    sensing = Sensing(file, seed)
    start = file.operating.get('initial_temperature_c')
    muscle: Muscle | None = None
    for sampled in protocol.pieces(_PIECE):
        first = muscle is None
        if muscle is None:
            muscle = Muscle(
                file.parameters,
                end=protocol.end,
                load=float(sampled.load[0]),
                held_length=held['held_length_m'],
                spring_rate=held['spring_rate_n_per_m'],
                spring_rest_length=held['spring_rest_length_m'],
                ambient=float(sampled.ambient[0]),
                temperature=float(start) + ZERO_CELSIUS if isinstance(start, int | float) else None,
            )
            known = {'end': protocol.end, 'load_n': float(sampled.load[0])} | {k: v for k, v in held.items() if v}
        outputs = simulate_on(
            muscle, sampled.time, sampled.drive, kind=sampled.kind, load=sampled.load, ambient=sampled.ambient
        )
        domain.look(outputs)
        yield _recording(
            str(output), sampled, outputs, sensing, file.number('min_sense_current_a'), known, skip=not first
        )
        progress.tell(f'{sampled.time[-1]:.0f} of {protocol.duration:.0f} s')


def _recording(
    name: str,
    sampled: Sampled,
    outputs: Outputs,
    sensing: Sensing,
    least_current: float,
    known: dict[str, object],
    *,
    skip: bool,
) -> Recording:
    """One piece as it is recorded. ``skip``: its first instant was in the piece before."""
    import numpy as np

    from tcp_muscle_ros.recording.recording import Channel, Recording

    kept = slice(1 if skip else 0, None)
    outputs = outputs.between(kept)
    values = {
        'current': outputs.current,
        'voltage': outputs.voltage,
        'load': sampled.load[kept],
        'ambient': sampled.ambient[kept],
        **sensing.sensed(outputs),
    }
    if sampled.kind == 'power':
        values['power'] = outputs.power
    shown = np.abs(outputs.current) >= least_current
    channels = {
        name: Channel(name, outputs.time[shown], value[shown], name)
        if name == 'resistance'
        else Channel(name, outputs.time, value, name)
        for name, value in values.items()
    }
    return Recording(name, channels, 0, known)
