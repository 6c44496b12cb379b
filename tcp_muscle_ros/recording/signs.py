"""Channels of the other sign: what counts length for contraction, compression for tension, or has its leads swapped."""

import numpy as np
from scipy.signal import lfilter

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.inputs import drive_of, hold
from tcp_muscle_ros.recording.recording import Array, Channel, Recording
from tcp_muscle_ros.recording.units import unit_of
from tcp_muscle_ros.recording.yaml_input import number_or_none

_AT_LEAST = 5  # samples
_IDLE = 0.02  # N, below which a load cell may hang unused
_ALIKE = 0.5  # share by which a force may differ from the load and be it
_SURE = 0.9  # of a correlation
_GRID_S = 0.25  # s, but no more than
_GRID_MOST = 2_000_000  # instants, of a recording of many days


def refuse_signs(recording: Recording) -> None:
    """BadInput for a force that pushes throughout; and for a stroke, a held force or a temperature that falls whenever
    the muscle is heated, the load being the same."""
    _refuse_push(recording)
    drive = drive_of(recording)
    if drive is None:
        return
    meant = {
        'displacement': ('counts contraction, positive when shorter', 'counts length'),
        'force': ('is tension, positive when it pulls', 'counts compression'),
    }
    for name, (what, otherwise) in meant.items():
        channel = recording.channels.get(name)
        if channel is not None and not _load_changes(recording) and _falls_when_heated(recording, channel, drive):
            raise BadInput(
                f'{recording.path}: {name} falls when the muscle is heated, but {what}: if {channel.topic} '
                f'{otherwise}, say ',
                options.this_unit(name, turned(recording.unit(name))),
            )
    channel = recording.channels.get('temperature')
    if channel is not None and _falls_when_heated(recording, channel, drive):
        raise BadInput(
            f'{recording.path}: temperature falls when the muscle is heated: are the leads of the thermocouple '
            f'swapped? If {channel.topic} carries something else, say ',
            options.some_channel('temperature'),
        )


def _refuse_push(recording: Recording) -> None:
    """A force that is negative throughout: no muscle pushes. Beside a known load it must be that load, turned: an idle
    load cell has some offset."""
    channel = recording.channels.get('force')
    if channel is None or len(channel) < _AT_LEAST or float(np.percentile(channel.value, 98.0)) > -_IDLE:
        return
    pull, load = -float(np.median(channel.value)), _known_load(recording)
    if load is not None and abs(pull - load) > _ALIKE * load:
        return
    unit = recording.unit('force')
    shown = unit_of(unit, 'force', recording.path).from_si(-pull)
    raise BadInput(
        f'{recording.path}: force is about {shown:.3g} {unit} throughout, but is tension, positive when it pulls: if '
        f'{channel.topic} counts compression, say ',
        options.this_unit('force', turned(unit)),
    )


def _known_load(recording: Recording) -> float | None:
    """The load (N) that was recorded or stated; None where there is none."""
    load = recording.channels.get('load')
    known = float(np.median(load.value)) if load is not None and len(load) else None
    if known is None:
        known = number_or_none(recording.known.get('load_n'))
    return known if known and known > 0.0 else None


def turned(unit: str) -> str:
    """The name of a unit with the other sign."""
    return unit[1:] if unit.startswith('-') else f'-{unit}'


def _load_changes(recording: Recording) -> bool:
    load = recording.channels.get('load')
    if load is None or not len(load):
        return False
    return bool(np.ptp(load.value) > 0.02 * max(float(np.max(np.abs(load.value))), 1e-9))


def _falls_when_heated(recording: Recording, channel: Channel, drive: Channel) -> bool:
    if len(channel) < 50 or np.ptp(channel.value) == 0.0:
        return False
    if channel.time[-1] - channel.time[0] < 10.0 or np.ptp(hold(drive, channel.time)) == 0.0:
        return False
    found = [_correlation(channel, warmth) for warmth in _warmths(recording, drive, channel)]
    return min(found) < -_SURE and max(found) < 0.5


def _correlation(channel: Channel, other: Array) -> float:
    if np.ptp(other) == 0.0:
        return 0.0
    with np.errstate(all='ignore'):  # of what hardly moves at all the squares may vanish
        return float(np.nan_to_num(np.corrcoef(channel.value, other)[0, 1]))


def _warmths(recording: Recording, drive: Channel, channel: Channel) -> list[Array]:
    """What a muscle's temperature is like at a channel's instants: as recorded, and the square of the input with lags
    of 3 to 40 s."""
    found, time = [], channel.time
    if channel.name != 'temperature' and 'temperature' in recording and len(recording['temperature']) > 20:
        found.append(np.interp(time, recording['temperature'].time, recording['temperature'].value))
    step = max(_GRID_S, float(time[-1] - time[0]) / _GRID_MOST)
    grid = np.arange(time[0], time[-1], step)
    heat = hold(drive, grid) ** (1 if drive.name.startswith('power') else 2)
    for lag in (3.0, 8.0, 20.0, 40.0):
        share = min(step / lag, 1.0)
        found.append(np.interp(time, grid, lfilter([share], [1.0, share - 1.0], heat)))
    return found
