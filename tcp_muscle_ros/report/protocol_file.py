"""What a diagnosis hands on as files: ``next_protocol.yaml`` to run next, ``improved.yaml`` to simulate with."""

from collections.abc import Callable, Mapping
from math import floor
from pathlib import Path
from textwrap import wrap

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Proposal, Value
from tcp_muscle_ros.diagnosis.answer.improved import operating_with_room, physics_only
from tcp_muscle_ros.diagnosis.observation.imposed import Holding
from tcp_muscle_ros.muscle import SPECIFICATIONS, ZERO_CELSIUS, Parameters
from tcp_muscle_ros.report.words import at_edge, chance, interval_text, plain
from tcp_muscle_ros.settings.parameter_file import Value as Setting
from tcp_muscle_ros.settings.parameter_file import describe, number_text, write

_WIDTH = 110  # of comments


def write_protocol(path: str | Path, proposal: Proposal, holding: Holding | None = None) -> None:
    """Write a proposed experiment in the format that ``simulate`` and ``recording.protocol`` read.

    ``holding``: what held the muscle in the recordings; gives the spring or the held length of such an end.
    """
    Path(path).write_text(render_protocol(proposal, holding), encoding='utf-8')


def render_protocol(proposal: Proposal, holding: Holding | None = None) -> str:
    """The text that ``write_protocol`` writes."""
    first, second = proposal.separates
    total = proposal.duration
    head = [
        f'{plain(proposal.name)}: {total:.0f} s that separate {plain(first)} from {plain(second)}',
        f'Expected to decide with probability {chance(proposal.power)}. {proposal.reason}',
        'Record it and diagnose it together with the recordings so far.',
    ]
    lines = [f'# {line}' for said in head for line in wrap(said, _WIDTH)]
    lines += [
        f'rate_hz: {number_text(proposal.rate)}',
        f'input: {proposal.kind}',
        f'end: {proposal.end}',
        *_end_options(proposal.end, holding),
        *_room(proposal.ambient),
        f'load_n: {_short(proposal.steps[0].load)}  # the starting load: displacement is zero under it',
        f'repeat: {proposal.repeat}',
        'segments:',
    ]
    lines += [
        f'  - {{duration_s: {_short(step.duration)}, value: {_current(step.current)}, load_n: {_short(step.load)}}}'
        for step in proposal.steps
    ]
    return '\n'.join(lines) + '\n'


def _end_options(end: str, holding: Holding | None) -> list[str]:
    if holding is None or end == 'load':
        return []
    options = {'held_length_m': holding.held_length}
    if end == 'spring':
        options = {'spring_rate_n_per_m': holding.spring_rate, 'spring_rest_length_m': holding.spring_rest_length}
    return [f'{name}: {_short(value)}' for name, value in options.items()]


def _room(ambient: float | None) -> list[str]:
    if ambient is None:
        return []
    return [
        f'ambient_c: {number_text(floor(1e3 * (ambient - ZERO_CELSIUS)) / 1e3)}  # the room that it was planned for'
    ]


def _current(value: float) -> str:
    """Rounded down: above what the rig allows it would be refused."""
    rounded = float(f'{value:.6g}')
    return number_text(rounded if rounded <= value else float(f'{value * (1.0 - 5e-6):.6g}'))


def _short(value: float) -> str:
    return number_text(float(f'{value:.6g}'))


def write_improved(path: str | Path, diagnosis: Diagnosis, operating: Mapping[str, Setting] | None = None) -> None:
    """Write the muscle that sim_node and replay should use from now on, its intervals as comments.

    ``operating``: what else stood in the parameter file that the diagnosis began with, written as it was, but for the
    ambient temperature: that is the recordings', where they share one.
    """
    muscle = physics_only(diagnosis.improved)
    recordings = len(diagnosis.recordings)
    heading = [
        f'A muscle improved by tcp_muscle diagnose from {recordings} recording{"s" if recordings != 1 else ""}.',
        f'Verdict: {plain(diagnosis.verdict)}. {diagnosis.headline}',
        'Intervals are 90 %. What sensors do is in rig.yaml, the start of each recording in report.json.',
    ]
    if diagnosis.partial:
        heading.insert(1, 'The diagnosis was interrupted: these values are what was known by then.')
    folded = [line for said in heading for line in wrap(said, _WIDTH)]
    write(
        path, muscle, operating=operating_with_room(diagnosis, operating), heading=folded, note=_note(diagnosis, muscle)
    )


def _note(diagnosis: Diagnosis, muscle: Parameters) -> Callable[[str], str]:
    """The comment behind each parameter: its interval where the data gave one."""
    fitted: dict[str, Value] = dict(diagnosis.calibration)
    for finding in diagnosis.findings:
        prefix = f'{finding.effect}.'
        fitted |= {prefix + name.removeprefix(prefix): value for name, value in finding.parameters.items()}

    def note(name: str) -> str:
        value = fitted.get(name)
        if f'{name} [1]' in diagnosis.calibration:  # each recording has its own
            return f'{SPECIFICATIONS[name].edge_unit}; {SPECIFICATIONS[name].meaning}; mean of the recordings'
        if value is None or SPECIFICATIONS[name].choices:
            return describe(name)
        row = SPECIFICATIONS[name]
        said = f'{row.edge_unit}; {row.meaning}'
        if not value.fixed:
            return f'{said}; not fixed by the data'
        if not value.low <= muscle[name] <= value.high:  # refitted since; its interval would speak of another value
            return f'{said}; fitted'
        bound = ', at its bound' if value.at_bound else ''
        return f'{said}; 90 %: {interval_text(at_edge(name, value))}{bound}'

    return note
