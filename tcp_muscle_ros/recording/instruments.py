"""Faults of instruments that show in one recording, without a model of the muscle. Each is named, none is mended.

What two instruments share without a third to tell (voltage and current both 7 % high, and no power recorded) does not
show, nor does a channel that is late: heat is late too. One that is ahead of its cause is of another clock.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.recording.inputs import SAME_INSTANT, drive_of, hold
from tcp_muscle_ros.recording.plausibility import USUAL
from tcp_muscle_ros.recording.recording import CHANNELS, Array, Channel, Recording

_ENOUGH = 200  # samples of a channel that is looked at
_HELD = 0.05  # share of samples that repeat the one before
_STUCK = 9  # samples
_PLAINLY = 6.0  # times the least step of a channel: it moves on plainly from one sample to the next
_REPEATS, _REPEATED = 5, 0.1  # repeats between two plain steps the same way, and their share of such places
_WRITTEN, _SOONER = 10, 0.05  # places at which it moves on, and the share of values that last less, at most
_TURNS = 0.4  # share of samples at which noise turns, at least
_ALIKE = 0.9  # of the others differ from each other: no quantisation repeats them
_LINE = 10.0  # times the typical line of a spectrum and those on both sides, in each quarter: a tone
_CLIPPED = 1.5  # standard deviations of the typical second difference: beyond, as of jumps, it counts no more
_ASIDE = (3, 6)  # lines beside one that a tone in it does not reach
_SLOWEST_TONE = 0.5  # Hz
_TURNS_OF_A_TONE = 4.0  # at least, in each quarter of the recording: less is how the muscle warms
_DRIVEN = 10.0  # times the typical line of the drive's spectrum: then the tone is the drive's
_SWITCHES = 3  # at least, at which a channel steps by the same as far as its scatter tells
_ALIKE_STEPS, _BY_CHANCE = 1.4, 1e-3  # two steps differ by no more than this factor; how often others are as large
_SURE = 5.0  # standard errors
ROUNDED = 1e-9  # of a channel's largest value: less is the last bit of a number, and no instrument's
_OFF = 0.03  # of a power or resistance, by which instruments contradict each other
_LEADS = np.arange(0.25, 5.01, 0.25)  # s, by which a channel may be ahead
_LEAST_GRID = 0.25  # s
_MOST = 20_000  # instants of that grid
_APART = 0.2  # of its largest value, between the two levels of a drive: less is how coarse an ammeter is
_AT_A_LEVEL, _NEAR = 0.9, 0.2  # share of samples at one of the two, to within so much of what is between them
_CYCLES, _CYCLE = 20, 6  # on and off again at least so often, usually within so many samples
_SLOWER = 1.5  # periods of the quickest output: a drive that has fewer samples was told when it changed
_REST, _RESTING = 30.0, 10  # s before the drive comes on, in which at least so many samples show a channel at rest
_LEFT, _MOVED = 0.02, 3  # of its motion, by which it has left it; samples in which it then moves on
_BETTER, _EVIDENCE = 0.8, 60.0  # of the squares left over, and half of log likelihood ratio, that a lead must reach


def instrument_faults(recording: Recording) -> Iterator[tuple[str, str, str]]:
    """(channel, kind, sentence) of each fault that shows."""
    drive = drive_of(recording)
    for channel in recording.channels.values():
        if CHANNELS[channel.name].role != 'output' or len(channel) < _ENOUGH:
            continue
        yield from _held_samples(channel)
        yield from _tone(channel, drive)
        if drive is not None and len(drive) > 1 and channel.name in ('temperature', 'displacement', 'force'):
            first = list(_moves_first(channel, drive))  # the drive's switches are not its own then
            steps = [] if first else list(_steps_at_switches(recording, channel, drive))
            yield from steps or list(_ahead(channel, drive)) or first  # a step, too, is sooner than heat
    yield from _contradictions(recording)
    if drive is not None and len(drive) >= _ENOUGH:
        yield from _undersampled(drive, recording)


def _undersampled(drive: Channel, recording: Recording) -> Iterator[tuple[str, str, str]]:
    """A drive that goes to and fro between two levels about as often as it is read, as a fast PWM does: how long each
    level held cannot be told. Noise, ramps and waves do not stay at two levels."""
    period = float(np.median(np.diff(drive.time)))
    outputs = [c for c in recording.channels.values() if CHANNELS[c.name].role == 'output' and len(c) >= _ENOUGH]
    if not outputs or period > _SLOWER * min(float(np.median(np.diff(c.time))) for c in outputs):
        return
    low, high = float(np.min(drive.value)), float(np.max(drive.value))
    largest = max(abs(low), abs(high))
    if largest < USUAL[drive.name.removesuffix('_command')][0] or high - low < _APART * largest:
        return
    share = (drive.value - low) / (high - low)
    if np.mean(np.minimum(share, 1.0 - share) <= _NEAR) < _AT_A_LEVEL:
        return
    cycle = np.diff(np.flatnonzero((share[:-1] < 0.5) & (share[1:] >= 0.5)))
    if cycle.size < _CYCLES or np.median(cycle) > _CYCLE:
        return
    held = 0.5 * float(np.mean(cycle[cycle <= _CYCLE]))
    told = f'{drive.name}: switches so often that it is read only {held:.1f} times at a level (a PWM?)'
    yield (
        drive.name,
        'undersampled',
        f'{told}: what it was between is not known; record the mean power, or read it more often',
    )


def _held_samples(channel: Channel) -> Iterator[tuple[str, str, str]]:
    """Samples that repeat the one before to the last bit, where no two others are alike."""
    repeats = np.diff(channel.value) == 0.0
    stuck = np.convolve(repeats, np.ones(_STUCK), 'same') >= _STUCK - 1  # for long: a dead sensor's, not a logger's
    share = float(np.mean(repeats & ~stuck))
    others = channel.value[np.append(True, ~repeats)]
    turns = np.sign(np.diff(others))  # an encoder at rest repeats too: only noise turns at nearly each sample
    noisy = others.size > 20 and float(np.mean(turns[1:] * turns[:-1] < 0.0)) > _TURNS
    told = f'{channel.name}: {100 * share:.0f} % of its samples repeat the one before to the last bit'
    if times := _times_written(channel.value):
        told = f'{channel.name}: each of its values stands there {times} times, also while it moves on'
        yield channel.name, 'held', f'{told}: the logger holds a value until the next comes'
    elif share > _HELD and noisy and np.unique(others).size > _ALIKE * others.size:
        yield channel.name, 'held', f'{told}, though no others are alike: the logger holds a value until the next comes'
    elif _repeats_while_it_moves(channel.value):
        yield channel.name, 'held', f'{told}, also while it moves on: the logger holds a value until the next comes'


def _times_written(value: Array) -> int:
    """How often each value was written while a channel moves on, as where it is slower than its logger; 0: not so.

    That is how many samples are alike between two plain steps the same way. What sticks, or is read coarsely beside how
    fast it moves, rests for as long as it likes, and its values change sooner elsewhere.
    """
    changes = np.flatnonzero(np.diff(value))
    if changes.size < 3:
        return 0
    step, lasts = np.diff(value)[changes], np.diff(changes)
    least = float(np.min(np.abs(step)))
    plain = (step[:-1] * step[1:] > 0.0) & (np.minimum(np.abs(step[:-1]), np.abs(step[1:])) >= _PLAINLY * least)
    times = int(np.median(lasts[plain])) if np.count_nonzero(plain) >= _WRITTEN else 0
    as_often = float(np.mean(lasts[plain] == times)) > 0.5 if times > 1 else False
    return times if as_often and float(np.mean(lasts < times - 1)) < _SOONER else 0


def _repeats_while_it_moves(value: Array) -> bool:
    """Whether single samples repeat the one before between two plain steps the same way.

    What rests, or is read coarsely beside how fast it moves, repeats for longer or in small steps.
    """
    step = np.diff(value)
    least = float(np.min(np.abs(step[step != 0.0]), initial=np.inf))
    before, after = step[:-2], step[2:]
    moves = (before * after > 0.0) & (np.minimum(np.abs(before), np.abs(after)) >= _PLAINLY * least)
    between = np.abs(step[1:-1][moves])
    repeats = int(np.count_nonzero(between == 0.0))
    nearly = int(np.count_nonzero((between > 0.0) & (between < 2.5 * least)))
    # Noise that is read coarsely is by chance nearly the same as often as it is the same, to one step and to two.
    return repeats >= max(_REPEATS, nearly) and repeats >= _REPEATED * between.size


def _tone(channel: Channel, drive: Channel | None) -> Iterator[tuple[str, str, str]]:
    """A line of the spectrum that stands out in every quarter of the recording."""
    period = float(np.median(np.diff(channel.time)))
    if np.percentile(np.diff(channel.time), 95.0) > 1.5 * period:
        return
    size = channel.value.size // 4
    frequency: Array = np.asarray(np.fft.rfftfreq(size - 2, period), dtype=np.float64)
    lines = [_spectrum(channel.value[k * size : (k + 1) * size]) for k in range(4)]
    least = _rounding_lines(channel.value, frequency * period, size - 2)
    out = np.min([line / np.maximum(_about(line), least) for line in lines], axis=0)
    out[frequency < max(_SLOWEST_TONE, _TURNS_OF_A_TONE / (size * period))] = 0.0
    k = int(np.argmax(out))
    if out[k] >= _LINE and drive is not None and len(drive) > 1:
        given = hold(drive, channel.time[: 4 * size]).reshape(4, size)[1]
        k = _not_driven(out, given, drive.name.startswith('power'))
    if out[k] < _LINE:
        return
    told = f'{channel.name}: a tone of {frequency[k]:.3g} Hz throughout: vibration, mains hum or a loop that rings'
    yield channel.name, 'tone', told


def _not_driven(out: Array, given: Array, is_heat: bool) -> int:
    """The line that stands out most of those that are not the muscle's own response to what is given.

    Heat goes as the square of a current or voltage: a sine through zero heats at twice its frequency. Where the line
    that stands out most is the drive's, so may all be that the drive or its square has, and the multiples of its own.
    """
    causes = [_spectrum(each) for each in ([given] if is_heat else [given, given**2])]
    k = int(np.argmax(out))
    beside = [float(cause[max(k - 1, 0) : k + 2].max() / np.median(cause)) for cause in causes]
    if max(beside) <= _DRIVEN:
        return k
    lines, reach = np.arange(out.size), _ASIDE[0] - 1
    first = max(int(np.argmax(causes[0])), 1)
    own = np.abs(lines - first * np.round(lines / first)) <= np.maximum(0.5 * lines / first, reach)
    for cause in causes:
        stands_out = cause > _DRIVEN * _about(cause)
        own |= np.convolve(stands_out, np.ones(2 * reach + 1), 'same') > 0.0
    return int(np.argmax(np.where(own, 0.0, out)))


def _spectrum(value: Array) -> Array:
    """Power of the second differences, by line; a jump, which has all lines, counts as what is usual."""
    bend = np.diff(value, 2)
    usual = _CLIPPED * 1.4826 * float(np.median(np.abs(bend)))
    if usual > 0.0:
        bend = np.clip(bend, -usual, usual)
    return np.asarray(np.abs(np.fft.rfft(bend * np.hanning(bend.size))) ** 2 + 1e-300)


def _about(line: Array) -> Array:
    """What each line must stand out of: the typical line, and those on either side of it. A smooth curve's spectrum
    falls steeply, and its lowest lines are far above the typical one without being a tone."""
    near, far = _ASIDE
    padded = np.pad(line, far, mode='reflect')
    beside = np.lib.stride_tricks.sliding_window_view(padded, far - near + 1)
    below, above = np.median(beside[: line.size], axis=1), np.median(beside[-line.size :], axis=1)
    return np.asarray(np.maximum(np.maximum(below, above), max(float(np.median(line[1:])), 1e-300)))


def _rounding_lines(value: Array, cycles: Array, size: int) -> Array:
    """Power that a tone as small as the values' rounding has in each line; ``cycles`` a sample."""
    amplitude = ROUNDED * float(np.max(np.abs(value)))
    return np.asarray((amplitude * (2.0 * np.sin(np.pi * cycles)) ** 2 * size / 4.0) ** 2 / _LINE + 1e-300)


def _switches(drive: Channel) -> tuple[Array, Array]:
    """When the drive switches (s), and in which direction."""
    step = np.diff(drive.value)
    at = np.flatnonzero(np.abs(step) > 0.3 * float(np.ptp(drive.value)))
    return drive.time[1:][at], np.sign(step[at])


def _steps_at_switches(recording: Recording, channel: Channel, drive: Channel) -> Iterator[tuple[str, str, str]]:
    """A step from one sample to the next whenever the drive switches, which heat cannot make."""
    at, direction = _switches(drive)
    load = recording.channels.get('load')
    if load is not None and len(load) > 1:
        changed = load.time[1:][np.diff(load.value) != 0.0]
        free = np.array([not np.any(np.abs(changed - t) < 1.0) for t in at], dtype=bool)
        at, direction = at[free], direction[free]
    k = np.searchsorted(channel.time, at - SAME_INSTANT)
    inside = (k > 4) & (k < len(channel) - 5)
    k, direction = k[inside], direction[inside]
    if k.size < _SWITCHES:
        yield from _steps_alike(channel, drive, k, direction)
        return
    # The lines through four samples before and after, where they should meet: half a sample before the first after.
    before = channel.value[k[:, None] + np.arange(-4, 0)] @ _read_at(np.arange(-4, 0))
    after = channel.value[k[:, None] + np.arange(0, 4)] @ _read_at(np.arange(0, 4))
    near = (after - before) * direction
    usual = float(np.median(np.abs(np.diff(channel.value, 2)))) / 0.6745 / np.sqrt(6.0)
    size, scatter = float(np.median(near)), max(usual * 2.0, float(np.median(np.abs(near - np.median(near)))))
    bend = float(
        np.median(np.abs(channel.value[k + 3] - channel.value[k] - channel.value[k - 1] + channel.value[k - 4]))
    )
    rounding = ROUNDED * float(np.max(np.abs(channel.value)))
    if abs(size) > _SURE * scatter / np.sqrt(k.size) and abs(size) > max(3.0 * usual, bend, rounding):
        yield _responds(channel, drive, size, k.size)


def _steps_alike(
    channel: Channel, drive: Channel, k: NDArray[np.int_], direction: Array
) -> Iterator[tuple[str, str, str]]:
    """The same at two switches, up at one and down at the other: both by nearly the same, and by more than at the
    samples beside them and than nearly all other samples are. A motion that begins or turns at a switch goes on."""
    if k.size < _SWITCHES - 1:
        return
    step = np.diff(channel.value)  # from the sample before the k-th to it: its place is k - 1
    about = np.arange(1, step.size - 2)
    steps, stands_out = {}, {}
    for way in (1.0, -1.0):
        steps[way] = way * step[about]
        stands_out[way] = steps[way] - np.maximum(np.max([way * step[about + n] for n in (-1, 1, 2)], axis=0), 0.0)
    apart = np.min(np.abs(about[:, None] + 1 - k), axis=1) > 1
    others = np.maximum(stands_out[1.0], stands_out[-1.0])[apart]
    usual = max(float(np.median(np.abs(np.diff(step)))), ROUNDED * float(np.max(np.abs(channel.value))))
    for sign in (1.0, -1.0):
        # The motion that begins or turns in between is within each of these steps: all of its speed, or none.
        most, least = (
            np.array([of[sign * way][n - 2] for n, way in zip(k, direction, strict=True)]) for of in (steps, stands_out)
        )
        chance = (1.0 + np.count_nonzero(others >= least.min())) / others.size
        alike = least.max() < _ALIKE_STEPS * most.min()
        if least.min() > _SURE * usual and alike and chance**k.size < _BY_CHANCE:
            yield _responds(channel, drive, 0.5 * sign * float(least.max() + most.min()), k.size)


def _responds(channel: Channel, drive: Channel, size: float, switches: int) -> tuple[str, str, str]:
    """A channel that steps at the switches of the drive, by so much (SI) where it comes on."""
    factor, unit = {'temperature': (1.0, 'K'), 'displacement': (1e3, 'mm'), 'force': (1.0, 'N')}[channel.name]
    told = f'{channel.name}: steps by {size * factor:+.3g} {unit} at each of {switches} switches of the {drive.name}'
    return channel.name, 'switch', f'{told}, faster than heat: the instrument responds to the {drive.name}'


def _read_at(places: NDArray[np.int_], at: float = -0.5) -> Array:
    """What each of some samples weighs in the straight line through them, read at a place between samples."""
    columns = np.column_stack([np.ones(places.size), places])
    return np.asarray(np.array([1.0, at]) @ np.linalg.pinv(columns))


def _ahead(channel: Channel, drive: Channel) -> Iterator[tuple[str, str, str]]:
    """A channel that follows the heat best if read as so much ahead of it, and by far worse at any delay."""
    span = float(channel.time[-1] - channel.time[0])
    step = max(float(np.median(np.diff(channel.time))), _LEAST_GRID, span / _MOST)
    grid = np.arange(channel.time[0], channel.time[-1], step)
    if grid.size < _ENOUGH // 2:
        return
    given = hold(drive, drive.time)  # relative to the largest, whose square might be no number
    heat = (given / max(float(np.max(np.abs(given))), 1e-300)) ** (1 if drive.name.startswith('power') else 2)
    total = np.append(0.0, np.cumsum(heat[:-1] * np.diff(drive.time)))
    value = np.interp(grid, channel.time, channel.value)

    def left_over(lead: float) -> float:
        brought = np.diff(np.interp(grid + lead, drive.time, total))
        columns = np.column_stack([value[:-1], brought, np.ones(brought.size)])
        solved = np.linalg.lstsq(columns, np.diff(value), rcond=None)[0]
        return float(np.sum((np.diff(value) - columns @ solved) ** 2))

    late = min(left_over(-lead) for lead in (0.0, *_LEADS))
    early = {float(lead): left_over(float(lead)) for lead in _LEADS if lead > 2.0 * step}
    lead = min(early, key=early.__getitem__, default=0.0)
    if not lead or late <= 0.0 or early[lead] > _BETTER * late:
        return
    if 0.5 * grid.size * np.log(late / max(early[lead], 1e-300)) > _EVIDENCE:
        told = f'{channel.name}: moves {lead:.3g} s before the {drive.name} that moves it: their clocks differ'
        yield channel.name, 'clock', told


def _moves_first(channel: Channel, drive: Channel) -> Iterator[tuple[str, str, str]]:
    """A channel that leaves its rest before the drive first comes on, and goes on as it does when it is on."""
    on = np.flatnonzero(drive.value > 0.3 * float(np.max(drive.value)))
    if not on.size or on[0] == 0:
        return
    came, period = float(drive.time[on[0]]), float(np.median(np.diff(channel.time)))
    before = channel.time < came - max(SAME_INSTANT, 0.1 * period)
    resting = before & (channel.time < came - _LEADS[-1]) & (channel.time > came - _REST)
    after = channel.value[(channel.time >= came) & (channel.time < came + _LEADS[-1])]
    if np.count_nonzero(resting) < _RESTING or after.size < 2:
        return
    rest = float(np.median(channel.value[resting]))
    way = (channel.value - rest) * np.sign(after[-1] - rest)
    scatter = max(float(np.std(way[resting])), float(np.max(np.abs(way[resting]))) / _SURE)
    out = way > max(_SURE * scatter, _LEFT * float(np.ptp(channel.value)))
    inside = np.flatnonzero(before)
    still = inside[~out[inside]]
    first = int(still[-1]) + 1  # from there on it is out throughout
    lead, rising = came - float(channel.time[first]), np.diff(way[first : inside[-1] + 1])
    if inside[-1] - first >= _MOVED and lead > 2.0 * period and float(np.mean(rising >= 0.0)) > _ALIKE:
        told = f'{channel.name}: moves at least {lead:.2g} s before the {drive.name} that moves it: their clocks differ'
        yield channel.name, 'clock', told


def _contradictions(recording: Recording) -> Iterator[tuple[str, str, str]]:
    """A power that is not voltage times current, a resistance that is not their quotient."""
    if not {'voltage', 'current'} <= {name for name, c in recording.channels.items() if len(c) > 1}:
        return
    current = recording['current']
    voltage = np.interp(current.time, recording['voltage'].time, recording['voltage'].value)
    flows = np.abs(current.value) > 0.3 * float(np.max(np.abs(current.value), initial=0.0))
    if np.count_nonzero(flows) < 20:
        return
    made = {'power': voltage[flows] * current.value[flows], 'resistance': voltage[flows] / current.value[flows]}
    for name, value in made.items():
        channel = recording.channels.get(name)
        if channel is None or len(channel) < 2:
            continue
        there = hold(channel, current.time[flows])
        share = float(np.median(value / np.where(there == 0.0, np.inf, there))) - 1.0
        if abs(share) > _OFF:
            sign = 'times' if name == 'power' else 'over'
            told = f'{name}: voltage {sign} current differs from it by {100 * share:+.1f} %: an instrument is wrong'
            # Of a duty d the means are d U and d I, and the mean power is d U I: more than their product.
            means = ', or these are means of a PWM' if name == 'power' and share < 0.0 else ''
            yield name, 'contradiction', f'{told}{means}'
