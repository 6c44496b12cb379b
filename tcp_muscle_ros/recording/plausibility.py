"""Recordings that cannot be what they say they are: another unit, another channel, another sign, two clocks.

A model would fit such a recording somehow and give the misfit a name. What is found here can be mended by who recorded
it, so each finding is refused in one line that says how.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from tcp_muscle_ros.errors import BadInput, Option
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.inputs import changes, distance, drive_of, hold, stated_ambient
from tcp_muscle_ros.recording.recording import CHANNELS, Array, Channel, Recording
from tcp_muscle_ros.recording.signs import refuse_signs, turned
from tcp_muscle_ros.recording.units import UNITS, Unit, unit_of

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
USUAL = {
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
_NO_CURRENT, _A_VOLTAGE = 0.02, 0.1  # of the largest: no current, and a voltage
_MANY = 0.02  # share of the samples, and
_AT_LEAST = 5  # samples
ROOM = (278.0, 316.0)  # K: of where people work
_NO_SCALE = 15.0  # K: what rests nearer to its room is in no other scale
_LAGS = (1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 35.0, 60.0, 100.0)  # s
_COARSE = 20_000  # instants at which a recording is looked at for its heat
_FITS = 0.3  # of a channel's standard deviation, that a lag may leave
_STEEPEST = 0.02  # 1/K, of a resistance; nickel has 0.006
_SURE = 0.9  # of a correlation
_AT_ONCE = 0.35  # of a channel's span, between neighbours less than
_QUICK = 0.6  # s apart
_BEYOND_NOISE = 30.0  # usual steps that a span must have to be more than noise
_DENSER = 1.6  # times the usual rate, for
_OVERLAP = 1.0  # s


def outside(name: str, value: Array) -> Array:
    """The values of a channel (SI) that no muscle shows, where they are more than a few; else none."""
    low, high = PLAUSIBLE.get(name, (-np.inf, np.inf))
    found = value[(value < low) | (value > high)]
    few = found.size < min(_AT_LEAST, value.size) or found.size < _MANY * value.size
    return found[:0] if few else found


def not_across(voltage: Array, current: Array) -> str:
    """Why a voltage is not that across the muscle, by the currents that were read beside it; '' where it may be.

    A voltmeter that is not connected shows none while a current flows; a supply or a sensor shows one where none flows.
    Either may be in any unit, and NaN where nothing was read.
    """
    known = np.isfinite(voltage) & np.isfinite(current)
    shown, flowing = np.abs(voltage[known]), np.abs(current[known])
    if not np.any(shown):
        return 'it shows no voltage, though a current flows' if np.any(flowing) else ''
    none = flowing <= _NO_CURRENT * float(np.max(flowing))
    few = np.count_nonzero(none) < max(_AT_LEAST, _MANY * none.size)  # an ammeter that is a sample late
    if not few and float(np.median(shown[none])) > _A_VOLTAGE * float(np.max(shown)):
        return 'it shows a voltage where no current flows'
    return ''


def refuse_implausible(recording: Recording, ambient: float | None = None) -> None:
    """Raise BadInput for a recording that is surely not what its channels are called.

    ``ambient`` (K): what the user states of the room, where the recording does not.
    """
    if recording.broken:
        raise BadInput(f'{recording.path}: {recording.broken[0]}')
    for channel in recording.channels.values():
        _refuse_level(recording, channel)
    for channel in recording.channels.values():
        if CHANNELS[channel.name].role == 'output':
            _refuse_overlap(recording, channel)
    _refuse_scale(recording, ambient)
    _refuse_slope(recording)
    for name in ('temperature', 'displacement', 'force'):
        _refuse_leaps(recording, name)
    refuse_signs(recording)


@dataclass(frozen=True)
class Misread:
    """A channel whose values no muscle shows: they are in another unit than they were taken to be in, or another's."""

    channel: str
    typical: float  # in ``unit``
    unit: str  # that its numbers were taken to be in
    guesses: tuple[str, ...]  # the units in which they would be a muscle's; '...' where there are none

    def told(self, unit: str = '', channel: str = '') -> list[str | Option]:
        """What is wrong, and what mends it: by the options of who reads a bag, unless a wrong ``unit`` or a wrong
        ``channel`` is mended otherwise."""
        units = [part for guess in self.guesses for part in (' or ', options.this_unit(self.channel, guess))][1:]
        return [
            f'{self.channel} is about {self.typical:.4g} {self.unit}, which is no plausible value: '
            'if it is recorded in another unit, ',
            *([unit] if unit else ['say ', *units]),
            '; if it is something else that was recorded, ',
            *([channel] if channel else ['say ', options.some_channel(self.channel)]),
        ]


def misread(name: str, value: Array, taken_as: str = '') -> Misread | None:
    """Whether a channel's values (SI) are in another unit or another channel's; None where they are a muscle's.

    ``taken_as``: the unit in which its numbers were taken to be, where not the contract's.
    """
    beyond = outside(name, value)
    if not beyond.size:
        return None
    stated = unit_of(taken_as or CHANNELS[name].unit, UNITS[CHANNELS[name].unit].quantity, name)
    shown = stated.from_si(float(np.median(beyond)))
    guesses = _guesses(name, stated.from_si(value), stated)
    # A force in mN or in g is as likely; of the others the first is far more so.
    guesses = guesses if stated.quantity == 'force' else guesses[:1]
    return Misread(name, shown, stated.name, tuple(guesses) or ('...',))


def _guesses(name: str, raw: Array, stated: Unit) -> list[str]:
    """The units in which a channel's raw numbers would be a muscle's, the stated one being wrong."""
    low, high = USUAL[name]
    units = [stated, *(unit for unit in UNITS.values() if unit.name != stated.name.lstrip('-'))]
    if name in ('load', 'force', 'power') and float(np.mean(raw)) < 0.0:
        units = [replace(unit, name=turned(unit.name), scale=-unit.scale) for unit in units]
    found = []
    for unit in units:
        value = unit.to_si(raw)
        fits = low <= float(np.max(np.abs(value))) <= high and not outside(name, value).size
        if unit.quantity == stated.quantity and unit.name != stated.name and fits:
            found.append(unit.name)
    return found


def _refuse_level(recording: Recording, channel: Channel) -> None:
    found = misread(channel.name, channel.value, recording.unit(channel.name))
    if found is not None:
        raise BadInput(f'{recording.path}: ', *found.told())


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


def _refuse_scale(recording: Recording, ambient: float | None) -> None:
    """A thermometer whose room is no room, but would be one in the other scale."""
    drive, thermometer = drive_of(recording), recording.channels.get('temperature')
    said = recording.unit('temperature')
    if drive is None or thermometer is None or said not in ('degC', 'degF'):
        return
    rests = _rest(drive, thermometer)
    found = rests if rests is not None else resting_temperature(drive, thermometer)
    if found is None:
        return
    rest = float(np.mean(found))
    air = recording.channels.get('ambient')
    room = float(np.median(air.value)) if air is not None and len(air) else stated_ambient(recording, ambient)
    if room is not None and abs(rest - room) < _NO_SCALE:
        return
    _refuse_other_room(recording, rest)
    low, high = (room - 8.0, room + 8.0) if room is not None else ROOM
    celsius = UNITS['degC'].from_si(rest)
    if said == 'degC':
        meant, value, odd = 'degF', UNITS['degF'].to_si(celsius), min(found) > ROOM[1]
    else:
        meant, value, odd = 'degC', UNITS['degC'].to_si(UNITS['degF'].from_si(rest)), max(found) < ROOM[0]
    if odd and low <= value <= high:
        where = 'before it is heated' if rests is not None else 'where it cools down to'
        raise BadInput(
            f'{recording.path}: temperature rests at {UNITS[said].from_si(rest):.1f} {said} {where}, which in {meant} '
            f'would be a room of {UNITS["degC"].from_si(value):.1f} degC: recorded in {meant}, not {said}? Then say ',
            options.this_unit('temperature', meant),
            '; in a warm or cold chamber state ambient_temperature_c in ',
            options.PARAMS,
        )


def _refuse_other_room(recording: Recording, rest: float) -> None:
    """A thermometer of the room that would agree with the muscle at rest, were it in the other scale."""
    air, said = recording.channels.get('ambient'), recording.unit('ambient')
    meant = {'degC': 'degF', 'degF': 'degC'}.get(said)
    if air is None or not len(air) or meant is None or not ROOM[0] <= rest <= ROOM[1]:
        return
    shown = UNITS[said].from_si(float(np.median(air.value)))
    if abs(UNITS[meant].to_si(shown) - rest) <= 8.0:
        raise BadInput(
            f'{recording.path}: ambient is about {shown:.1f} {said}, but temperature rests at '
            f'{UNITS["degC"].from_si(rest):.1f} degC: if ambient is recorded in {meant}, say ',
            options.this_unit('ambient', meant),
        )


def _rest(drive: Channel, thermometer: Channel) -> tuple[float, float] | None:
    """The temperature (K) before anything is heated, twice; None where nothing rests."""
    off = np.abs(hold(drive, thermometer.time)) <= 0.1 * float(np.max(np.abs(drive.value)))
    still = thermometer.value[: int(np.argmin(off)) if not off.all() else off.size]
    if still.size < _AT_LEAST:
        return None
    third = max(still.size // 3, 1)
    if abs(float(np.median(still[-third:]) - np.median(still[:third]))) > 3.0:
        return None  # still cooling from before
    rest = float(np.median(still))
    return rest, rest


def resting_temperature(drive: Channel, thermometer: Channel) -> tuple[float, float] | None:
    """Between which temperatures (K) the thermometer would rest without heat, from how it is heated and cools.

    A first-order lag of the heat with its start, fitted at each of several time constants; those that fit nearly as
    well as the best give the range. None where no lag fits, or the heat hardly changes.
    """
    time, value = thermometer.time, thermometer.value
    if time.size < 50 or np.ptp(value) == 0.0:
        return None
    step = max((time[-1] - time[0]) / _COARSE, 1e-3)
    grid = np.arange(time[0], time[-1] + step, step)
    heat = hold(drive, grid) ** (1 if drive.name.startswith('power') else 2)
    if np.ptp(heat) < 0.3 * float(np.max(np.abs(heat), initial=0.0)) or not np.any(heat):
        return None
    found = []
    for lag in _LAGS:
        share = 1.0 - np.exp(-step / lag)
        warm = np.interp(time, grid, lfilter([0.0, share], [1.0, share - 1.0], heat))
        columns = np.column_stack([np.ones(time.size), warm / max(float(np.max(np.abs(warm))), 1e-300)])
        columns = np.column_stack([columns, np.exp(-(time - time[0]) / lag)])
        solved = np.linalg.lstsq(columns, value, rcond=1e-6)[0]
        left = float(np.std(value - columns @ solved))
        found.append((left, float(solved[0]), float(solved[1])))
    best = min(found)[0]
    near = [rest for left, rest, rise in found if left <= 1.5 * best and rise > 0.0]
    if not near or best > _FITS * float(np.std(value)):
        return None
    return min(near), max(near)


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
    beside = temperature - temperature.mean()
    slope = float(beside @ resistance / (beside @ beside)) / float(np.median(np.abs(resistance)))
    if slope > _STEEPEST and float(np.corrcoef(temperature, resistance)[0, 1]) > _SURE:
        raise BadInput(
            f'{recording.path}: resistance rises by {100 * slope:.0f} % a kelvin, a metal by about 0.4 %: are '
            f'{T.topic} and {R.topic} swapped (',
            options.these_channels({'temperature': R.topic, 'resistance': T.topic}),
            '), or in another unit?',
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
        leap &= distance(channel.time[1:], changes(load)) > 1.0
    after = np.flatnonzero(leap)
    stays = [k for k in after if k + 3 < len(step) and np.abs(step[k + 1 : k + 4]).max() < 0.1 * span]
    if len(stays) >= 3:  # one may be a slip, or the seam of two runs
        raise BadInput(
            f'{recording.path}: {name} jumps by up to {np.abs(step[stays]).max() / span:.0%} of its range within a '
            f'sample, {len(stays)} times, but heat takes seconds: does {channel.topic} carry an input? Say '
            'which is which with ',
            options.some_channel(name),
        )
