"""What is in a recording, as text."""

import numpy as np

from tcp_muscle_ros.recording.checks import check
from tcp_muscle_ros.recording.recording import CHANNELS, Channel, Recording
from tcp_muscle_ros.recording.units import UNITS

_HEADS = ('channel', 'topic', 'samples', 'rate', 'from', 'to', 'unit', 'kind')


def described(recording: Recording) -> str:
    """Duration, a row a channel (samples, usual rate, smallest and largest value), what is known, what is wrong."""
    lines = [f'{recording.path}: {recording.duration:.6g} s, {len(recording.channels)} channels']
    rows = [_HEADS, *map(_row, recording.channels.values())]
    widths = [max(len(row[k]) for row in rows) for k in range(len(_HEADS))]
    lines += ['  ' + '  '.join(map(str.ljust, row, widths)).rstrip() for row in rows]
    lines += [f'  known: {key} = {value}' for key, value in recording.known.items()]
    lines += [f'  note: {note}' for note in recording.notes]
    lines += [f'  check: {issue.sentence}' for issue in check(recording)]
    return '\n'.join(lines)


def _row(channel: Channel) -> tuple[str, ...]:
    kind = CHANNELS[channel.name]
    name, unit = channel.name, kind.unit
    if not len(channel):
        return name, channel.topic, '0', '', '', '', unit, kind.role
    low, high = (UNITS[unit].from_si(float(edge)) for edge in (np.min(channel.value), np.max(channel.value)))
    step = float(np.median(np.diff(channel.time))) if len(channel) > 1 else 0.0
    rate = f'{1.0 / step:.4g} Hz' if step > 0.0 else ''
    return name, channel.topic, str(len(channel)), rate, f'{low:.4g}', f'{high:.4g}', unit, kind.role
