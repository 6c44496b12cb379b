"""Make a recording ready for the model."""

from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.observation.blocks import averaged, changes, coarsened, hold, instants_of, switches
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.holding import Conditions, holding_of, number
from tcp_muscle_ros.diagnosis.observation.imposed import FOLLOWS_SETPOINT, Imposed
from tcp_muscle_ros.diagnosis.observation.input_noise import held, quiet, still_air
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import KINDS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import CHANNELS, OUTPUTS, Channel, Recording, shared

_LEAST_SENSE_CURRENT = 1e-3  # A: resistance from voltage and current needs a current
_SELDOM = 0.01  # of the samples: an input that changes no more often is constant between its steps


def prepare(
    recording: Recording, nominal: Parameters, conditions: Conditions | None = None, most: int | None = None
) -> Experiment:
    """Make a recording ready for the model.

    Args:
        recording: channels in SI.
        nominal: the muscle as assumed; gives the ambient (T0) where nothing else does.
        conditions: what the user states about the run.
        most: the largest number of observations a channel; longer ones are averaged in blocks.

    Raises:
        BadInput: no input, no output, or fewer than two samples of them.
    """
    conditions = conditions or Conditions()
    notes: list[str] = list(recording.notes)
    kind, drive = _held(recording, *_drive(recording))
    observed = {name: recording[name] for name in OUTPUTS if name in recording and len(recording[name]) > 1}
    if 'resistance' not in observed and {'voltage', 'current'} <= set(recording.channels):
        derived = _resistance(recording)
        if derived is not None:
            observed['resistance'] = derived
            notes.append('resistance was derived as voltage over current')
    holding, load, used = holding_of(recording, observed, conditions, notes)
    if used is not None:
        observed.pop(used, None)
    if not observed:
        raise BadInput(
            f'{recording.path}: nothing to compare: expected at least one of {", ".join(OUTPUTS)} beside {kind}'
        )
    known = dict(recording.known)
    if len(recording.channels.get('displacement_setpoint', ())):
        known[FOLLOWS_SETPOINT] = True
    else:  # a controller imposes what it makes of the noise of its sensor
        drive, noise = quiet(drive)
        if noise:
            notes.append(
                f'the noise of the {kind} was averaged out between its steps: {noise:.2g} {CHANNELS[kind].unit}'
            )
    if kind == 'power':  # what a wattmeter reads below zero is its noise
        drive = replace(drive, value=np.maximum(drive.value, 0.0))
    ambient, unsure = recording.channels.get('ambient'), 0.0
    if ambient is not None:
        ambient, unsure = still_air(ambient)
    still = number(recording.known.get('ambient_c'), 273.15)
    if still is None:
        still = conditions.ambient if conditions.ambient is not None else nominal['T0']
    between, lost = switches(drive)
    drive = coarsened(drive, most, 1.0 if kind == 'power' else 2.0)
    load = coarsened(load, most, 1.0)
    start = max(float(drive.time[0]), 0.0)
    end = max(float(channel.time[-1]) for channel in observed.values())
    blocks: dict[str, Observed] = {}
    for name, channel in observed.items():
        made = averaged(channel, drive, load, most, start)
        blocks[name] = replace(made, time=shared(made.time, (other.time for other in blocks.values())))
    grid = instants_of([channel.time for channel in blocks.values()], drive, load, start, end)
    between, lost = (found[(found[:, 0] >= start) & (found[:, 1] <= end)] for found in (between, lost))
    imposed = Imposed(
        kind,
        grid,
        hold(drive, grid),
        np.maximum(hold(load, grid), 0.0) if isinstance(load, Channel) else np.full(grid.size, load),
        hold(ambient, grid) if ambient is not None and len(ambient) else np.full(grid.size, still),
        between,
        lost,
        unsure,
    )
    return Experiment(recording.path, imposed, holding, blocks, known, tuple(notes))


def _drive(recording: Recording) -> tuple[str, Channel]:
    """The input that was applied; the commanded one where the applied was not recorded."""
    for suffix in ('', '_command'):
        for kind in KINDS:
            name = f'{kind}{suffix}'
            if name in recording and len(recording[name]) > 0:
                return kind, recording[name]
    raise BadInput(
        f'{recording.path}: no input recorded: expected a channel current, power or voltage '
        '(name one with --channel current=TOPIC)'
    )


def _held(recording: Recording, kind: str, current: Channel) -> tuple[str, Channel]:
    """The input that the source holds: where it holds a power or a voltage, the current changes with the resistance
    between two samples too."""
    voltage = recording.channels.get('voltage')
    if kind != 'current' or current.name != 'current' or voltage is None or len(voltage) < 2:
        return kind, current
    if changes(current).size <= _SELDOM * len(current):
        return kind, current
    power = Channel('power', current.time, current.value * _beside(voltage, current.time), current.topic)
    found = (current, power, voltage)
    chosen = found[held(found)]
    return chosen.name, chosen


def _resistance(recording: Recording) -> Channel | None:
    current, voltage = recording['current'], recording['voltage']
    i = _beside(current, voltage.time)
    flows = np.abs(i) > _LEAST_SENSE_CURRENT
    if flows.sum() < 2:
        return None
    return Channel(
        'resistance', voltage.time[flows], voltage.value[flows] / i[flows], f'{voltage.topic}/{current.topic}'
    )


def _beside(channel: Channel, time: Array) -> Array:
    """The reading nearest to each instant: those of one tick arrive in any order."""
    return channel.value[np.searchsorted(0.5 * (channel.time[1:] + channel.time[:-1]), time)]
