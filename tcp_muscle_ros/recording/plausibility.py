"""Recordings that cannot be what they say they are: another unit, another channel, another sign, two clocks.

A model would fit such a recording somehow and give the misfit a name. What is found here can be mended by who recorded
it, so each finding is refused in one line that says how.
"""

import numpy as np
from scipy.signal import lfilter

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES, Array, Channel, Recording
from tcp_muscle_ros.recording.units import UNITS
from tcp_muscle_ros.recording.yaml_input import as_number

# SI values that a muscle's channel has on a bench, (low, high): beyond, it is in another unit, or another channel.
PLAUSIBLE = {
    'current': (-5.0, 5.0),
    'power': (-1.0, 100.0),
    'voltage': (-60.0, 60.0),
    'load': (0.0, 200.0),
    'ambient': (250.0, 330.0),
    'temperature': (250.0, 500.0),
    'resistance': (0.05, 10e3),
    'displacement': (-0.5, 0.5),
    'displacement_setpoint': (-0.5, 0.5),
    'force': (-50.0, 200.0),
}
# The largest value (SI) of a channel on most benches, by which a unit is guessed.
_USUAL = {
    'current': (0.02, 3.0),
    'power': (0.05, 50.0),
    'voltage': (0.2, 48.0),
    'load': (0.02, 50.0),
    'ambient': (278.0, 313.0),
    'temperature': (290.0, 430.0),
    'resistance': (0.5, 500.0),
    'displacement': (3e-4, 0.1),
    'displacement_setpoint': (3e-4, 0.1),
    'force': (0.02, 50.0),
}
_MANY = 0.02  # share of the samples, and
_AT_LEAST = 5  # samples
_KELVIN = 273.15
_ROOM = (278.0, 316.0)  # K
_STEEPEST = 0.02  # 1/K, of a resistance; nickel has 0.006
_SURE = 0.9  # of a correlation
_AT_ONCE = 0.35  # of a channel's span, between neighbours less than
_QUICK = 0.6  # s apart
_BEYOND_NOISE = 30.0  # usual steps that a span must have to be more than noise
_DENSER = 1.6  # times the usual rate, for
_OVERLAP = 1.0  # s
_GRID_S = 0.25  # s, but no more than
_GRID_MOST = 2_000_000  # instants, of a recording of many days


def outside(name: str, value: Array) -> Array:
    """The values of a channel (SI) that no muscle shows, where they are more than a few; else none."""
    low, high = PLAUSIBLE.get(name, (-np.inf, np.inf))
    found = value[(value < low) | (value > high)]
    few = found.size < min(_AT_LEAST, value.size) or found.size < _MANY * value.size
    return found[:0] if few else found


def refuse_implausible(recording: Recording, ambient: float | None = None) -> None:
    """Raise BadInput for a recording that is surely not what its channels are called.

    ``ambient`` (K): what the user states of the room, where the recording does not.
    """
    for channel in recording.channels.values():
        _refuse_level(recording, channel)
    for channel in recording.channels.values():
        if CHANNELS[channel.name].role == 'output':
            _refuse_overlap(recording, channel)
    _refuse_scale(recording, ambient)
    _refuse_slope(recording)
    for name in ('temperature', 'displacement', 'force'):
        _refuse_leaps(recording, name)
    _refuse_sign(recording)


def unit_sentence(name: str, value: Array) -> str | None:
    """That a channel's values (SI) are in another unit or another channel's; None where they are a muscle's."""
    beyond = outside(name, value)
    if not beyond.size:
        return None
    kind = CHANNELS[name]
    shown = UNITS[kind.unit].from_si(float(np.median(beyond)))
    guess = _guess(name, value)
    unit = f'--unit {name}={guess}' if guess else f'--unit {name}=...'
    return (
        f'{name} is about {shown:.4g} {kind.unit}, which no muscle shows: if it is recorded in another unit, '
        f'say {unit}; if the topic carries something else, say --channel {name}=TOPIC'
    )


def _guess(name: str, value: Array) -> str | None:
    """The unit in which a channel's raw numbers would be a muscle's, the contract's unit being wrong."""
    stated = UNITS[CHANNELS[name].unit]
    low, high = _USUAL[name]
    raw = stated.from_si(value)
    for unit in UNITS.values():
        if unit.quantity == stated.quantity and low <= float(np.max(np.abs(unit.to_si(raw)))) <= high:
            return unit.name
    return None


def _refuse_level(recording: Recording, channel: Channel) -> None:
    told = unit_sentence(channel.name, channel.value)
    if told:
        raise BadInput(f'{recording.path}: {told}')


def _refuse_overlap(recording: Recording, channel: Channel) -> None:
    """Two samples a period over seconds: the clock was set back, or two recordings were merged."""
    time = channel.time
    if time.size < 50:
        return
    period = float(np.median(np.diff(time)))
    window = max(_OVERLAP, 10.0 * period)
    count = np.searchsorted(time, time + window) - np.arange(time.size)
    dense = np.flatnonzero(count > _DENSER * window / period)
    if not dense.size:
        return
    start = int(dense[0])
    last = int(dense[np.append(np.flatnonzero(np.diff(dense) > 1), dense.size - 1)[0]])  # of the first such stretch
    steps = np.diff(channel.value[start : last + int(count[last])])
    usual = float(np.median(np.abs(np.diff(channel.value))))
    if float(np.median(np.abs(steps))) > 3.0 * usual:  # it alternates between two strands
        raise BadInput(
            f'{recording.path}: from {time[start]:.1f} s on, {channel.name} alternates between two courses: the clock '
            'was set back while recording, or two recordings were merged; cut it there'
        )


def drive_of(recording: Recording) -> Channel | None:
    """The recorded input, the applied one before the commanded."""
    for suffix in ('', '_command'):
        for name in DRIVES:
            channel = recording.channels.get(f'{name}{suffix}')
            if channel is not None and len(channel):
                return channel
    return None


def distance(time: Array, events: Array) -> Array:
    """How far (s) each instant is from the nearest of the events, which are in order; inf without any."""
    if not events.size:
        return np.full(time.size, np.inf)
    after = np.searchsorted(events, time)
    before = np.abs(time - events[np.maximum(after - 1, 0)])
    return np.minimum(before, np.abs(events[np.minimum(after, events.size - 1)] - time))


def held(channel: Channel, time: Array) -> Array:
    """The value of an input that holds at each instant (s)."""
    at = np.searchsorted(channel.time, time + 1e-9, side='right') - 1
    return channel.value[np.maximum(at, 0)]


def _refuse_scale(recording: Recording, ambient: float | None) -> None:
    """A thermometer that rests where no room is, but would be in one in the other scale."""
    drive, thermometer = drive_of(recording), recording.channels.get('temperature')
    if drive is None or thermometer is None:
        return
    off = np.abs(held(drive, thermometer.time)) <= 0.1 * float(np.max(np.abs(drive.value)))
    still = thermometer.value[: int(np.argmin(off)) if not off.all() else off.size]
    if still.size < _AT_LEAST:
        return
    third = max(still.size // 3, 1)
    rest = float(np.median(still))
    if abs(float(np.median(still[-third:]) - np.median(still[:third]))) > 3.0:
        return  # still cooling from before
    room = _stated_room(recording, ambient)
    celsius = rest - _KELVIN
    if room is not None and abs(rest - room) < 15.0:
        return
    low, high = (room - 8.0, room + 8.0) if room is not None else _ROOM
    for said, meant, value, odd in (
        ('degC', 'degF', (celsius - 32.0) / 1.8 + _KELVIN, rest > _ROOM[1]),
        ('degF', 'degC', celsius * 1.8 + 32.0 + _KELVIN, rest < _ROOM[0]),
    ):
        if odd and low <= value <= high:
            raise BadInput(
                f'{recording.path}: temperature rests at {celsius:.1f} degC before it is heated, which in {meant} '
                f'would be a room of {value - _KELVIN:.1f} degC: recorded in {meant}, not {said}? Then say '
                f'--unit temperature={meant}; in a warm or cold chamber state ambient_temperature_c in --params'
            )


def _stated_room(recording: Recording, ambient: float | None) -> float | None:
    channel = recording.channels.get('ambient')
    if channel is not None and len(channel):
        return float(np.median(channel.value))
    try:
        return as_number(recording.known.get('ambient_c'), '') + _KELVIN
    except BadInput:  # it does not say, or only in words
        return ambient


def _refuse_slope(recording: Recording) -> None:
    """A resistance that follows the temperature far more steeply than any conductor's."""
    if not {'temperature', 'resistance'} <= set(recording.channels):
        return
    R, T = recording['resistance'], recording['temperature']
    if len(R) < 20 or len(T) < 20:
        return
    after = np.clip(np.searchsorted(T.time, R.time), 1, len(T) - 1)
    together = np.minimum(np.abs(T.time[after] - R.time), np.abs(R.time - T.time[after - 1])) < _QUICK
    temperature, resistance = np.interp(R.time, T.time, T.value)[together], R.value[together]
    if temperature.size < 20 or np.ptp(temperature) == 0.0 or np.ptp(resistance) == 0.0:
        return
    slope = float(np.polyfit(temperature, resistance, 1)[0]) / float(np.median(np.abs(resistance)))
    if slope > _STEEPEST and float(np.corrcoef(temperature, resistance)[0, 1]) > _SURE:
        raise BadInput(
            f'{recording.path}: resistance rises by {100 * slope:.0f} % a kelvin, a metal by about 0.4 %: are '
            f'{T.topic} and {R.topic} swapped (--channel temperature={R.topic} --channel resistance={T.topic}), or in '
            'another unit?'
        )


def _refuse_leaps(recording: Recording, name: str) -> None:
    """An output that follows at once, again and again, although heat takes seconds: it is an input's record."""
    channel = recording.channels.get(name)
    drive = drive_of(recording)
    if channel is None or drive is None or len(channel) < 20 or (name == 'force' and 'displacement' in recording):
        return
    step, span = np.diff(channel.value), float(np.ptp(channel.value))
    if span < _BEYOND_NOISE * float(np.median(np.abs(step))):
        return
    leap = (np.abs(step) > _AT_ONCE * span) & (np.diff(channel.time) < _QUICK)
    load = recording.channels.get('load')
    if load is not None and len(load) and name != 'temperature':
        changed = load.time[1:][np.diff(load.value) != 0.0]
        leap &= distance(channel.time[1:], changed) > 1.0
    after = np.flatnonzero(leap)
    stays = [k for k in after if k + 3 < len(step) and np.abs(step[k + 1 : k + 4]).max() < 0.1 * span]
    if len(stays) >= 3:  # one may be a slip, or the seam of two runs
        raise BadInput(
            f'{recording.path}: {name} leaps by up to {np.abs(step[stays]).max() / span:.0%} of its range within a '
            f'sample, {len(stays)} times, but heat takes seconds: does {channel.topic} carry an input? Say which topic '
            f'is which with --channel {name}=TOPIC'
        )


def _refuse_sign(recording: Recording) -> None:
    """A displacement that falls whenever the muscle is heated, the load being the same."""
    drive, stroke = drive_of(recording), recording.channels.get('displacement')
    if drive is None or stroke is None or len(stroke) < 50 or np.ptp(stroke.value) == 0.0:
        return
    load = recording.channels.get('load')
    if load is not None and len(load) and np.ptp(load.value) > 0.02 * max(float(np.max(np.abs(load.value))), 1e-9):
        return
    if stroke.time[-1] - stroke.time[0] < 10.0 or np.ptp(held(drive, stroke.time)) == 0.0:
        return
    found = [_correlation(stroke, warmth) for warmth in _warmths(recording, drive, stroke.time)]
    if min(found) < -_SURE and max(found) < 0.5:
        unit = CHANNELS['displacement'].unit
        raise BadInput(
            f'{recording.path}: displacement falls when the muscle is heated, but counts contraction, positive when '
            f'shorter: if {stroke.topic} counts length, say --unit displacement=-{unit}'
        )


def _correlation(channel: Channel, other: Array) -> float:
    return float(np.corrcoef(channel.value, other)[0, 1]) if np.ptp(other) > 0.0 else 0.0


def _warmths(recording: Recording, drive: Channel, time: Array) -> list[Array]:
    """What a muscle's temperature is like: as recorded, and the square of the input with lags of 3 to 40 s."""
    found = []
    if 'temperature' in recording and len(recording['temperature']) > 20:
        found.append(np.interp(time, recording['temperature'].time, recording['temperature'].value))
    step = max(_GRID_S, float(time[-1] - time[0]) / _GRID_MOST)
    grid = np.arange(time[0], time[-1], step)
    heat = held(drive, grid) ** (1 if drive.name.startswith('power') else 2)
    for lag in (3.0, 8.0, 20.0, 40.0):
        share = min(step / lag, 1.0)
        found.append(np.interp(time, grid, lfilter([share], [1.0, share - 1.0], heat)))
    return found
