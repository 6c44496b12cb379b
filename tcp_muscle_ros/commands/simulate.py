"""``tcp_muscle simulate PROTOCOL.yaml [--params P.yaml] --output BAG``: a protocol offline, to a bag."""

from __future__ import annotations

import argparse

from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``simulate``."""
    parser.add_argument('protocol', metavar='PROTOCOL.yaml', help='what is done to the muscle')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='BAG', help='a new bag (rosbag2, MCAP)')
    add_force_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Simulate and write; sensor noise, quantisation and lag as the parameter file says."""
    import numpy as np

    from tcp_muscle_ros.commands.sensing import sensed
    from tcp_muscle_ros.files.outputs import in_place_of, refuse_among, writable_folder
    from tcp_muscle_ros.muscle import ZERO_CELSIUS, simulate
    from tcp_muscle_ros.muscle.mechanical import DOMAIN_HIGH, DOMAIN_LOW
    from tcp_muscle_ros.recording.bag_writer import write_recording
    from tcp_muscle_ros.recording.protocol import END_OPTIONS, read_protocol
    from tcp_muscle_ros.recording.recording import Channel, Recording
    from tcp_muscle_ros.settings.parameter_file import read

    refuse_among(args.output, [args.protocol, args.params])
    output = writable_folder(args.output, force=args.force)
    file = read(args.params)
    protocol = read_protocol(args.protocol)
    sampled = protocol.sampled()
    # The protocol says how the end is held; what it leaves open, the parameter file may say.
    held = {name: protocol.end_options.get(name, file.number(name)) for name in END_OPTIONS}
    start = file.operating.get('initial_temperature_c')
    outputs = simulate(
        file.parameters,
        sampled.time,
        sampled.drive,
        kind=sampled.kind,
        load=sampled.load,
        ambient=sampled.ambient,
        end=protocol.end,
        temperature=float(start) + ZERO_CELSIUS if isinstance(start, int | float) else None,
        held_length=held['held_length_m'],
        spring_rate=held['spring_rate_n_per_m'],
        spring_rest_length=held['spring_rest_length_m'],
    )
    shown = np.abs(outputs.current) >= file.number('min_sense_current_a')
    values = {
        'current': outputs.current,
        'voltage': outputs.voltage,
        'load': sampled.load,
        'ambient': sampled.ambient,
        **sensed(outputs, file),
    }
    if sampled.kind == 'power':
        values['power'] = outputs.power
    channels = {
        name: Channel(name, sampled.time[shown], value[shown], name)
        if name == 'resistance'
        else Channel(name, sampled.time, value, name)
        for name, value in values.items()
    }
    known: dict[str, object] = {'end': protocol.end, 'load_n': float(sampled.load[0])}
    known |= {name: value for name, value in held.items() if value}
    with in_place_of(output) as draft:
        write_recording(draft, Recording(str(output), channels, 0, known))
    hot = float(outputs.fibre_temperature.max()) - ZERO_CELSIUS
    print(
        f'{output}: {protocol.duration:g} s at {protocol.rate_hz:g} Hz; hottest {hot:.1f} degC, '
        f'largest contraction {1e3 * float(outputs.displacement.max()):.2f} mm'
    )
    in_range = (outputs.fibre_temperature >= DOMAIN_LOW) & (outputs.fibre_temperature <= DOMAIN_HIGH)
    beyond = float(np.mean(in_range & ~outputs.in_domain))
    if beyond:
        print(f'note: {100 * beyond:.0f} % of the time a free law is asked beyond its table, where it goes on straight')
    outside = float(np.mean(~in_range))
    if outside:
        print(
            f'note: {100 * outside:.0f} % of the time the fibre is outside 0 to 120 degC, where the model is not valid'
        )
    return 0
