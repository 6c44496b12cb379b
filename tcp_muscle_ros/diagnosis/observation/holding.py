"""What held the end of a muscle in a recording: a load, a wall or a spring; and the load itself."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.observation.blocks import STEPS_APART
from tcp_muscle_ros.diagnosis.observation.imposed import Holding
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.inputs import changes, hold
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.recording.yaml_input import number_or_none

_BEYOND_NOISE, _CONSTANT = 8.0, 2.0  # of the noise of a force: a step of it, and what a constant one may scatter by
_MANY = 20  # samples that a weight hangs for, at least in the median
_SAME, _SCATTERS = 0.05, 12.0  # of the largest force, and of its noise: within so much it does not change
_AT_ONCE, _OFTEN = 0.1, 1.0  # s: first messages come within so much; a load that is told as often has a rhythm
_RESTS = 5  # values of a force that tell what pulls
_TELLS = 0.02  # of the largest force, by which a load cell may be off


@dataclass(frozen=True)
class Conditions:
    """What a recording may not say itself (SI): used where no channel and no known fact does."""

    load: float | None = None
    ambient: float | None = None
    end: str | None = None
    held_length: float = 0.0
    spring_rate: float = 0.0
    spring_rest_length: float = 0.0


def holding_of(
    recording: Recording, observed: Mapping[str, Channel], conditions: Conditions, notes: list[str], off: float = 0.0
) -> tuple[Holding, Channel | float, str | None]:
    """What holds the end, the load (a channel or a constant), and the output that thereby became an input; ``off`` (s):
    until when the drive is off at first."""
    known = recording.known
    stated = known.get('end') if isinstance(known.get('end'), str) else conditions.end
    end = str(stated) if stated else _guess_end(observed, recording.channels.get('load'))
    load: Channel | float
    used = None
    of_run = number_or_none(known.get('load_n'))
    constant = of_run if of_run is not None else conditions.load
    if 'load' in recording and len(recording['load']):
        force = observed.get('force') if end == 'load' else None
        if force is not None and _in_steps(force, recording['load']):
            load = Channel('load', force.time, force.value, force.topic)  # stamped with its ticks, as a message is not
        else:
            load = _from_the_start(recording['load'], of_run, conditions.load, force)
        used = 'force' if end == 'load' else None
    elif end == 'load' and 'force' in observed:
        load, used = observed['force'], 'force'  # the force at a loaded end is the load
        if np.ptp(load.value) <= 0.02 * max(float(np.median(load.value)), 1e-9):
            load = float(np.median(load.value))
        else:
            load = _levels(load)
    elif constant is not None:
        load = constant
    else:
        load = _pretension(observed, off)
        at_rest = ', the tension before the drive comes on' if load else ''
        notes.append(f'no load was recorded or stated: taken as {load:.3g} N{at_rest}; state load_n in --params')
    if end == 'blocked' and 'displacement' in observed:
        used = 'displacement'
    first = _first(load) if isinstance(load, Channel) else load
    rate = number_or_none(known.get('spring_rate_n_per_m')) or conditions.spring_rate
    if end == 'spring' and not rate:
        rate = _spring_rate(observed, recording.path)
        notes.append(f'spring rate {rate:.3g} N/m taken from force against displacement')
    start = of_run if of_run is not None else max(first, 0.0)
    return (
        Holding(
            end,
            start,
            number_or_none(known.get('held_length_m')) or conditions.held_length,
            rate,
            number_or_none(known.get('spring_rest_length_m')) or conditions.spring_rest_length,
        ),
        load,
        used,
    )


def _at_first(load: Channel) -> float:
    """Within which time (s) a load comes that is there from the start: in the rhythm in which it is told."""
    spacing = float(np.median(np.diff(load.time))) if len(load) > _RESTS else _AT_ONCE
    return spacing if spacing <= _OFTEN else _AT_ONCE


def _pretension(observed: Mapping[str, Channel], off: float) -> float:
    """What pulls at a held end until the drive comes on, where a force shows it beyond its noise; else 0."""
    force = observed.get('force')
    if force is None:
        return 0.0
    rests = force.value[force.time < off]
    if rests.size < _RESTS:
        return 0.0
    tension = float(np.median(rests))
    return tension if tension > _BEYOND_NOISE * white_sigma(force.value) else 0.0


def _first(load: Channel) -> float:
    """What pulls at the start: a measured force is noisy, a load is told as often as it changes."""
    return float(np.median(load.value[:5])) if load.name == 'force' else float(load.value[0])


def _levels(force: Channel) -> Channel:
    """A force that weights make, constant between few steps: as it was written down, or as it was measured, without its
    noise; else as it is."""
    told = np.append(0, np.flatnonzero(np.diff(force.value)) + 1)
    seldom = told.size * STEPS_APART < force.time[-1] - force.time[0]
    # Of two levels the step looks like the resolution of a load cell, which goes back and forth.
    if seldom and np.median(np.diff(told, append=force.time.size)) >= _MANY:
        return Channel('load', force.time[told], force.value[told], force.topic)
    noise = white_sigma(force.value)
    steps = np.flatnonzero(np.abs(np.diff(force.value)) > _BEYOND_NOISE * noise) + 1
    if noise == 0.0 or steps.size * STEPS_APART > force.time[-1] - force.time[0]:
        return force
    segments = np.split(force.value, steps)
    levels = np.array([float(np.median(part)) for part in segments])
    left = np.concatenate([part - level for part, level in zip(segments, levels, strict=True)])
    if float(np.sqrt(np.mean(left**2))) > _CONSTANT * noise:
        return force
    return Channel('load', force.time[np.append(0, steps)], levels, force.topic)


def _in_steps(force: Channel, load: Channel) -> bool:
    """Whether a force is the load itself, without noise: constant but for about as many steps as were told."""
    return bool(np.count_nonzero(np.diff(force.value)) <= 2 * (1 + changes(load).size))


def _from_the_start(load: Channel, stated: float | None, usual: float | None, force: Channel | None) -> Channel:
    """The load with what pulled before it was first said: the load that is stated of this run, else the force at the
    loaded end, else the ``usual`` load; that not where it is only the first message that comes a little later."""
    first = float(load.time[0])
    if stated is None and force is not None and np.any(force.time < first):
        stated = float(np.median(force.value[force.time < first]))
    if stated is None and first > _at_first(load):
        stated = usual
    if first <= 0.0 or stated is None:
        return load
    return Channel(load.name, np.append(0.0, load.time), np.append(max(stated, 0.0), load.value), load.topic)


def _guess_end(observed: Mapping[str, Channel], load: Channel | None) -> str:
    """A force that changes is a held end's, unless it is the load; beside a displacement that changes with it, a
    spring's."""
    if 'force' not in observed:
        return 'load'
    force, noise = observed['force'].value, white_sigma(observed['force'].value)
    largest = float(np.max(np.abs(force)))
    if np.ptp(force) <= max(_SAME * largest, _SCATTERS * noise):
        return 'load'
    if load is not None and len(load):
        apart = float(np.median(np.abs(force - hold(load, observed['force'].time))))
        if apart <= max(_TELLS * largest, noise):
            return 'load'
    if 'displacement' not in observed or np.ptp(observed['displacement'].value) < 1e-5:
        return 'blocked'
    at = observed['displacement']
    f = np.interp(at.time, observed['force'].time, force)
    correlation = float(np.corrcoef(f, at.value)[0, 1])
    return 'spring' if correlation > 0.98 else 'load'


def _spring_rate(observed: Mapping[str, Channel], path: str) -> float:
    if not {'force', 'displacement'} <= set(observed):
        raise BadInput(
            f"{path}: end 'spring' without a rate: state spring_rate_n_per_m, or record force and displacement"
        )
    at = observed['displacement']
    f = np.interp(at.time, observed['force'].time, observed['force'].value)
    return float(max(np.polyfit(at.value, f, 1)[0], 1e-3))
